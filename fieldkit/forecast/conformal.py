"""Intervals corrected by how earlier ones fared: a flyer's own flights, forecast before they flew, say how wide.

A forecast's interval is stretched (or drawn together) about its median, in the logarithm, by what would have put
nine in ten of the earlier flights inside of theirs. If the next flight is like the earlier ones, nine in ten of
the corrected intervals hold it, whatever the model got wrong (Vovk, Gammerman and Shafer, Algorithmic Learning in
a Random World, 2005; with every earlier forecast made from what was known then, as here, it is the online form).
"""

from collections.abc import Mapping, Sequence
from math import ceil, log

MIN_FORECASTS_TO_CORRECT = 20
"""Earlier forecasts from which on intervals are corrected: with fewer, the widest of them would decide. [1]"""
LEVEL = 0.9
"""Nominal coverage of an interval. [1]"""


def surprise(flown: float, interval: Sequence[float]) -> float:
    """How far out a flown apogee lies: 0 at the median, 1 at the near end of the 90 % interval, by ratio. [1]

    `interval` is the forecast's 5, 50 and 95 % quantile [m]. inf if the interval has no width.
    """
    p05, p50, p95 = interval
    if not min(flown, p05, p50, p95) > 0:
        return float("inf")
    width = log(p95 / p50) if flown >= p50 else log(p05 / p50)
    return abs(log(flown / p50) / width) if width else float("inf")


def stretch(surprises: Sequence[float]) -> float | None:
    """By what to multiply the width of the next interval, or None while there are too few flights. [1]"""
    count = len(surprises)
    if count < MIN_FORECASTS_TO_CORRECT:
        return None
    factor = sorted(surprises)[ceil((count + 1) * LEVEL) - 1]
    return factor if factor < float("inf") else None


def stretched(interval: Sequence[float], factor: float) -> tuple[float, float, float]:
    """The 5, 50 and 95 % quantile of a forecast whose interval is stretched about its median. [m]"""
    p05, p50, p95 = interval
    if not p50 > 0:
        return p05, p50, p95
    return p50 * (p05 / p50) ** factor, p50, p50 * (p95 / p50) ** factor


def saved_surprises(saved: Sequence[Mapping[str, object]]) -> list[float]:
    """Surprises of the forecasts saved in a ledger, one for each flight: the last that was made."""
    last = {(one["rocket"], one["flight_id"]): one for one in saved if "flown_m" in one}
    found = []
    for one in last.values():
        flown, interval = one["flown_m"], one["interval_m"]
        if isinstance(flown, float) and isinstance(interval, list):
            found.append(surprise(flown, interval))
    return found
