"""Intervals corrected by the results of the flyer's earlier forecasts.

The interval of a forecast is stretched or narrowed around its median, in the logarithm, by the factor that would have
put 90% of the earlier flights inside their intervals. If flights are exchangeable, 90% of the corrected intervals
contain the flight, even if the model is wrong (Vovk, Gammerman and Shafer, Algorithmic Learning in a Random World,
2005, in the online form, because every earlier forecast used only what was known then).
"""

from collections.abc import Mapping, Sequence
from math import ceil, log

MIN_FORECASTS_TO_CORRECT = 20
"""Minimum number of earlier forecasts for a correction: with fewer, the largest surprise would determine it. [1]"""
LEVEL = 0.9
"""Nominal coverage of an interval. [1]"""


def surprise(flown: float, interval: Sequence[float]) -> float:
    """The distance of a flown apogee from the median, as a log ratio in units of the half interval on its side: 1 at
    the end of the 90% interval. [1]

    `interval` is the forecast's 5, 50 and 95% quantiles [m]. inf if the interval has no width.
    """
    p05, p50, p95 = interval
    if not min(flown, p05, p50, p95) > 0:
        return float("inf")
    width = log(p95 / p50) if flown >= p50 else log(p05 / p50)
    return abs(log(flown / p50) / width) if width else float("inf")


def stretch(surprises: Sequence[float]) -> float | None:
    """The factor on the width of the next interval; None if there are too few flights. [1]"""
    count = len(surprises)
    if count < MIN_FORECASTS_TO_CORRECT:
        return None
    factor = sorted(surprises)[ceil((count + 1) * LEVEL) - 1]
    return factor if factor < float("inf") else None


def stretched(interval: Sequence[float], factor: float) -> tuple[float, float, float]:
    """The 5, 50 and 95% quantiles of a forecast with its interval stretched around its median. [m]"""
    p05, p50, p95 = interval
    if not p50 > 0:
        return p05, p50, p95
    return p50 * (p05 / p50) ** factor, p50, p50 * (p95 / p50) ** factor


def saved_surprises(saved: Sequence[Mapping[str, object]]) -> list[float]:
    """Surprises of the forecasts saved in a ledger, one for each flight, from its latest forecast. [1]"""
    last = {(one["rocket"], one["flight_id"]): one for one in saved if "flown_m" in one}
    found = []
    for one in last.values():
        flown, interval = one["flown_m"], one["interval_m"]
        if isinstance(flown, float) and isinstance(interval, list):
            found.append(surprise(flown, interval))
    return found
