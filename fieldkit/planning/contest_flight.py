"""A contest flight as judged: two timers, eggs, disqualification, whole feet.

Timers, eggs and disqualification are extra columns of a flight table: `timer_1_s`, `timer_2_s`, `eggs`, `disqualified`;
the tags `cracked_egg`, `damaged` and `disqualified` have the same meaning.

Source: the rules of the seasons, as the files in `fieldkit/data/seasons` name them.
"""

import math
import re
from decimal import ROUND_HALF_UP, Decimal, InvalidOperation

from fieldkit.errors import BadValue
from fieldkit.flight import Flight
from fieldkit.flight.further import TIMERS, text_under
from fieldkit.importing.tables.flight_headings import plain
from fieldkit.units import FOOT

WHOLE_EGGS = ("intact", "whole", "ok", "okay", "uncracked", "unbroken", "good", "fine", "survived", "not cracked")
"""Texts in the column `eggs` that mean intact eggs, also after `all`, `eggs`, or their number as in `2 intact`."""
EGG_COUNTS = {"one": 1, "two": 2, "both": 2, "three": 3}
"""Numbers of eggs that are written as words. [1]"""
_BARE_COUNT = re.compile(r"(?:\d{1,2}|" + "|".join(EGG_COUNTS) + r")(?:\s+eggs?)?")
"""A count of eggs without their condition."""
_COUNTED_EGGS = re.compile(r"(?:(all|\d{1,2}|" + "|".join(EGG_COUNTS) + r")\s+)?(?:eggs?\s+)?(.*)", re.DOTALL)
NO_SCORE_TAGS = {"cracked_egg": "a cracked egg", "damaged": "a damaged rocket", "disqualified": "disqualified"}
"""Tags of a flight without a score, with the reason."""
NOT_TRUE = ("", "no", "n", "false", "f", "0", "-", "none")


def judged_duration(flight: Flight) -> float | None:
    """The official duration: the mean of two timers to 0.01 s, with .005 rounded up; the only timer if the other
    failed; else the duration of the flight. Raises BadValue. [s]"""
    times = [time for name in TIMERS if (time := _time(flight, name)) is not None]
    if not times:
        return flight.duration
    mean = sum(times, Decimal(0)) / len(times)
    return float(mean.quantize(Decimal("0.01"), ROUND_HALF_UP))


def _cell(flight: Flight, name: str) -> str:
    """The text of an extra column, however its heading is written: `Eggs`, `Timer 1 (s)`; empty if there is none."""
    return text_under(flight, lambda heading: plain(heading) == name)


def _time(flight: Flight, name: str) -> Decimal | None:
    text = _cell(flight, name).replace(",", ".")
    if not text:
        return None
    try:
        time = Decimal(text)
    except InvalidOperation:
        time = Decimal("NaN")
    if not time.is_finite() or not 0 < time < 10000:
        raise BadValue(f"{name}: found {text[:20]!r}, expected seconds such as 38.42")
    return time


def whole_feet(apogee: float) -> float:
    """The reading of an altimeter that displays whole feet, for an apogee [m]; halves round up. [ft]"""
    return math.floor(apogee / FOOT + 0.5 + 1e-9)


def why_no_score(flight: Flight, eggs: int | None = None) -> str:
    """Why a flight has no score in a season with this number of eggs, if known; empty if it has one. It counts as an
    attempt in either case."""
    for tag, why in NO_SCORE_TAGS.items():
        if tag in flight.tags:
            return why
    if why := _why_not_whole(_cell(flight, "eggs"), eggs or 1):
        return why
    if _cell(flight, "disqualified").casefold() not in NOT_TRUE:
        return "disqualified"
    return "no altitude" if flight.apogee is None else ""


def _why_not_whole(text: str, wanted: int) -> str:
    """Why a text about the eggs does not mean that all are intact; empty if it does, or if it is empty itself. A count
    without their condition does not mean that."""
    if text in ("", "-"):
        return ""
    found = _COUNTED_EGGS.fullmatch(text.casefold())
    if _BARE_COUNT.fullmatch(text.casefold()):
        return f"eggs: {text[:30]}, which does not say intact or cracked"
    if found is None or found[2] not in WHOLE_EGGS:
        return f"eggs: {text[:30]}"
    number = found[1]
    counted = None if number in (None, "all") else EGG_COUNTS.get(number) or int(number)
    if counted is not None and counted < wanted:
        return f"eggs: {text[:30]}, {wanted} needed"
    return ""
