"""Intervals corrected by the results of the flyer's earlier forecasts.

The interval of a forecast is stretched or narrowed around its median, in the logarithm, by the factor that would have
put 90% of the earlier flights inside their intervals. If flights are exchangeable, 90% of the corrected intervals
contain the flight, even if the model is wrong (Vovk, Gammerman and Shafer, Algorithmic Learning in a Random World,
2005, in the online form, because every earlier forecast used only what was known then).
"""

from collections.abc import Mapping, Sequence
from math import ceil, log
from typing import Any

MIN_FORECASTS_TO_CORRECT = 20
"""Minimum number of earlier forecasts for a correction: with fewer, the largest surprise would determine it. [1]"""
LEVEL = 0.9
"""Nominal coverage of an interval. [1]"""
MIN_FORECASTS_TO_NARROW = 100
"""Minimum number of earlier forecasts for an interval to become narrower. Of fewer, the quantile that would narrow it
has an error as large as the narrowing, and an interval that is too narrow costs more than one that is too wide. [1]"""
MAX_STRETCH = 10.0
"""Largest factor: flights ten half intervals from the median are a fault in their records, and a larger factor would
soon make an apogee infinite. [1]"""
MAX_SAVED = 1e6
"""Magnitude of a number saved with a forecast, an apogee [m] or a log score [nat], above which it is damaged."""


def surprise(flown: float, interval: Sequence[float]) -> float:
    """The distance of a flown apogee from the median, as a log ratio in units of the half interval on its side: 1 at
    the end of the 90% interval. [1]

    `interval` is the forecast's 5, 50 and 95% quantiles [m]. Infinity if the interval has no width on that side, or a
    number is not above zero.
    """
    p05, p50, p95 = interval
    if not min(flown, p05, p50, p95) > 0:
        return float("inf")
    width = log(p95 if flown >= p50 else p05) - log(p50)  # a ratio of absurd numbers would overflow
    return abs((log(flown) - log(p50)) / width) if width else float("inf")


def stretch(surprises: Sequence[float]) -> float | None:
    """The factor on the width of the next interval, at least 1 until `MIN_FORECASTS_TO_NARROW`; None if there are too
    few flights. [1]"""
    count = len(surprises)
    if count < MIN_FORECASTS_TO_CORRECT:
        return None
    factor = sorted(surprises)[ceil((count + 1) * LEVEL) - 1]
    if not factor < float("inf"):
        return None
    return min(factor if count >= MIN_FORECASTS_TO_NARROW else max(factor, 1.0), MAX_STRETCH)


def stretched(interval: Sequence[float], factor: float) -> tuple[float, float, float]:
    """The 5, 50 and 95% quantiles of a forecast with its interval stretched around its median. [m]"""
    p05, p50, p95 = interval
    if not p50 > 0:
        return p05, p50, p95
    return p50 * (p05 / p50) ** factor, p50, p50 * (p95 / p50) ** factor


def are_numbers(saved: object, count: int) -> bool:
    """Whether a saved value is a list of this many numbers of a plausible size."""
    if not isinstance(saved, list) or len(saved) != count:
        return False
    return all(isinstance(one, float | int) and abs(one) < MAX_SAVED for one in saved)


def is_result(saved: Mapping[str, Any]) -> bool:
    """Whether a prediction saved in a ledger is a forecast of a flown flight and complete: any program may have written
    it."""
    named = all(isinstance(saved.get(name), str) for name in ("rocket", "flight_id"))
    return named and are_numbers([saved.get("flown_m")], 1) and are_numbers(saved.get("interval_m"), 3)


def saved_surprises(saved: Sequence[Mapping[str, Any]]) -> list[float]:
    """Surprises of the forecasts saved in a ledger, one for each flight, from its latest forecast. [1]"""
    last = {(one["rocket"], one["flight_id"]): one for one in saved if is_result(one)}
    return [surprise(one["flown_m"], one["interval_m"]) for one in last.values()]
