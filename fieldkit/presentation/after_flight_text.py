"""How a flight did compared with its forecast, in words: for the app's notice and the command line."""

from collections.abc import Iterator

from fieldkit.flight import BY_NAME
from fieldkit.planning.quantiles import Three
from fieldkit.presentation.one_off_text import one_off_lines, why
from fieldkit.quantities import measure, number
from fieldkit.services.after_flight import Outcome
from fieldkit.services.next_suggestion import Suggestion

APOGEE = BY_NAME["apogee"]
VISIBLE_CD_CHANGE = 0.005
"""Minimum change of Cd to mention: half of the last digit shown. [1]"""
VISIBLE_NARROWING = 0.005
"""Minimum fraction by which an interval narrows to mention: half a percent, as shown. [1]"""


def outcome_lines(found: Outcome, system: str) -> Iterator[str]:
    """Forecast against flown, what the flight changed in Cd, and the next forecast, a sentence each."""
    flown = found.flight.apogee
    if flown is not None and found.miss is not None:
        way = "high" if found.miss >= 0 else "low"
        where = "inside" if found.inside else "OUTSIDE"
        source = "Forecast" if found.kept else "Forecast without it"
        yield (
            f"{source} {_interval(found.forecast, system)}; flown {measure(APOGEE, flown, system)}: "
            f"{measure(APOGEE, abs(found.miss), system)} {way}, {where} the 90% interval."
        )
    if found.beside is not None:
        yield from one_off_lines([found.beside], system)
    before, after = found.cd
    if _visible(before, after):
        yield f"Next Cd {after:.2f}, before {before:.2f}."
    yield f"Next on {found.flight.motor}: {_interval(found.next_flight, system)}."


def outcome_facts(found: Outcome, system: str) -> Iterator[tuple[str, str]]:
    """The same as names and values, one per line."""
    source = "Forecast" if found.kept else "Without it"
    yield source, _interval(found.forecast, system)
    if found.miss is not None:
        way = "high" if found.miss >= 0 else "low"
        where = "inside" if found.inside else "OUTSIDE"
        yield "Miss", f"{measure(APOGEE, abs(found.miss), system)} {way}, {where} the 90% interval"
    if found.beside is not None and found.beside.singled_out:
        yield "Cause", why(found.beside, system)
    before, after = found.cd
    yield "Next Cd", f"{before:.2f} is now {after:.2f}" if _visible(before, after) else f"{after:.2f}, unchanged"
    yield "Next", f"{_interval(found.next_flight, system)} on {found.flight.motor}"


def _visible(before: float, after: float) -> bool:
    """Whether a change of Cd is large enough to mention and shows in two decimals."""
    return abs(after - before) >= VISIBLE_CD_CHANGE and f"{before:.2f}" != f"{after:.2f}"


def suggestion_line(found: Suggestion, system: str) -> str:
    """What to do next, in a sentence with the key to press."""
    if found.kind == "loop":
        return (
            f"{found.outside} of the last {found.forecasts} flights ended outside their interval: "
            "5 looks for the effect that is missing."
        )
    if found.kind == "motor" and found.apogee is not None:
        target = measure(APOGEE, found.target, system)
        interval = _interval(found.apogee, system)
        return f"{found.motor}, {interval}: of motors that pass the checks nearest to {target}. f to choose a motor."
    if found.narrows < VISIBLE_NARROWING:
        return "More such flights hardly narrow the interval: it is flight-to-flight variation. f to plan the next one."
    return f"One more flight on {found.motor} narrows the interval by {found.narrows:.0%}. f to save its forecast."


def apogee_question(expected: Three, apogee: float, system: str) -> str:
    """The question before an implausible apogee [m] is saved, in the units of a system."""
    return (
        f"The apogee is {measure(APOGEE, apogee, system)}. This flight was expected to reach "
        f"{_interval(expected, system)}.\nSave it as it is?"
    )


def _interval(interval: Three, system: str) -> str:
    low, middle, high = interval
    return f"{measure(APOGEE, middle, system)} ({number(APOGEE, low, system)} to {number(APOGEE, high, system)})"
