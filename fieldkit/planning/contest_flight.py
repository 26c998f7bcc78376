"""A contest flight as judged: two timers, eggs, disqualification, whole feet.

Timers, eggs and disqualification are extra columns of a flight table: `timer_1_s`, `timer_2_s`, `eggs`, `disqualified`;
the tags `cracked_egg`, `damaged` and `disqualified` have the same meaning.

Source: the rules of the seasons, as the files in `fieldkit/data/seasons` name them.
"""

import math
from decimal import ROUND_HALF_UP, Decimal

from fieldkit.errors import BadValue
from fieldkit.flight import Flight
from fieldkit.flight.further import TIMERS, text_under
from fieldkit.flight.judged import read_eggs, read_timer
from fieldkit.importing.tables.flight_headings import plain
from fieldkit.units import FOOT

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
    try:
        time = read_timer(_cell(flight, name))
    except BadValue as error:
        raise BadValue(f"{name}: {error}") from error
    return None if time is None else Decimal(f"{time:.10g}")


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
    without their condition does not mean that, nor does a text of an older ledger that cannot be read."""
    try:
        eggs = read_eggs(text)
    except BadValue:
        return f"eggs: {text[:30]}"
    if eggs is None:
        return ""
    if eggs.intact is None:
        return f"eggs: {text[:30]}, which does not say intact or cracked"
    if not eggs.intact:
        return f"eggs: {text[:30]}"
    return "" if eggs.count is None or eggs.count >= wanted else f"eggs: {text[:30]}, {wanted} needed"
