"""A flight beside the others of its rocket in words: by how much it missed, what most likely went wrong, and why."""

from collections.abc import Iterator, Sequence
from math import expm1
from shlex import quote

from fieldkit.flight import BY_NAME, Flight
from fieldkit.flight.short_name import flight_label, has_derived_id, short_name
from fieldkit.flight.unit_slips import UnitSlip, unit_slip
from fieldkit.forecast.one_offs import FlightBesideOthers, PossibleCause, farthest
from fieldkit.model.causes import CAUSES
from fieldkit.quantities import in_system, percent

CLEAR = 1.5
"""A readout departs clearly from this many standard deviations on. [1]"""
MIN_LIKELY_FRACTION = 0.5
"""A cause is called the most likely from this fraction of the probability of all causes on. [1]"""
MAX_CAUSES = 3
"""Maximum number of causes to list. [1]"""
WORTH_SAYING = 0.2
"""Probability of being a one-off from which a flight that is not singled out gets more than its miss. [1]"""
MORE_OR_LESS = {
    "burn_time": ("long", "short"),
    "coast_to_apogee": ("long", "short"),
    "apogee_to_eject": ("late", "early"),
}
"""Readouts in seconds, and the words for more and for less."""


IMPOSSIBLE_SD = 0.05
"""Standard deviation of the log ratio of a readout that no fit uses to the simulated one, about that of devices. [1]"""


def why(one: FlightBesideOthers, system: str = "SI") -> str:
    """What is known about a flight in a few sentences, in the units of a system."""
    return " ".join([_beside(one), *_impossible(one, system)])


def _impossible(one: FlightBesideOthers, system: str) -> Iterator[str]:
    """A sentence for each reason why readouts of a flight cannot be measurements."""
    slips, titles = _impossible_slips(one), dict[str, list[str]]()
    for name, found in one.impossible.items():
        meant = f"; perhaps {slips[name].words}" if name in slips else ""
        titles.setdefault(in_system(found.reason, system) + meant, []).append(BY_NAME[name].title.lower())
    for reason, own in titles.items():
        yield f"Its {' and '.join(own)} {'is' if len(own) == 1 else 'are'} excluded from every fit: {reason}."


def _impossible_slips(one: FlightBesideOthers) -> dict[str, UnitSlip]:
    """Units that explain readouts that cannot be measurements."""
    found = {name: _slip(one, name, each.log_ratio, IMPOSSIBLE_SD) for name, each in one.impossible.items()}
    return {name: slip for name, slip in found.items() if slip is not None}


def _slip(one: FlightBesideOthers, name: str, log_ratio: float, sd: float) -> UnitSlip | None:
    """The units that explain a readout of a flight; None if none do, or if it has no such readout."""
    value = one.flight.number(name)
    return unit_slip(BY_NAME[name], value, log_ratio, sd) if value else None


def _misread_slip(one: FlightBesideOthers) -> tuple[str, UnitSlip] | None:
    """The readout of a flight that is probably misread and the units that explain it, if any do."""
    if not one.singled_out or one.causes[0].cause != "misread":
        return None
    name = farthest(one.departures)
    slip = _slip(one, name, *one.departures[name])
    return None if slip is None else (name, slip)


def _beside(one: FlightBesideOthers) -> str:
    """How a flight compares with the others."""
    name = _name(one.flight)
    flew = _flew(one)
    if not one.departures:
        return f"{name} has no readouts to compare."
    if one.probability < WORTH_SAYING:
        return f"{name} {flew}, within the scatter of its rocket."
    if not one.singled_out:
        return f"{name} {flew}: scatter, or with a chance of {percent(one.probability)} {_listed(one.causes)}."
    return f"{name} {flew}. {_cause(one)}."


def _name(flight: Flight) -> str:
    """The flight at the start of a sentence; by its motor if it has neither an id of its own nor a date."""
    if not has_derived_id(flight):
        return flight_label(flight.flight_id).capitalize()
    if flight.date_time is not None or not flight.motor:
        return short_name(flight)
    return f"The flight on {flight.motor}"


def _flew(one: FlightBesideOthers) -> str:
    """`flew 20% low`; of a flight without an apogee, that it has readouts."""
    if "apogee" not in one.departures:
        return "has no apogee"
    share = abs(one.miss) / one.forecast
    way = "low" if one.miss < 0 else "high"
    return f"flew {share:.0%} {way}" if round(share, 2) else "flew as forecast"


def _cause(one: FlightBesideOthers) -> str:
    """The most likely cause with what speaks for it, or the possible ones with what would distinguish them."""
    first = one.causes[0]
    shown = ", ".join(_signs(one))
    if first.probability >= MIN_LIKELY_FRACTION * one.probability:
        slip = _misread_slip(one)
        perhaps = f", perhaps {slip[1].words}" if slip is not None else ""
        likely = f"Most likely {_named(one, first)} ({percent(first.probability)}){perhaps}"
        return f"{likely}: {shown}" if shown else likely
    several = f"Possible: {_listed(one.causes)}"
    if set(one.departures) == {"apogee"}:
        return f"{several}; the apogee alone does not decide, top speed and coast time would"
    return f"{several}: {shown}" if shown else several


def _named(one: FlightBesideOthers, cause: PossibleCause) -> str:
    """The cause in words; of a misread readout, which one."""
    if cause.cause != "misread":
        return CAUSES[cause.cause].title
    return f"a misread {_title(one, farthest(one.departures))}"


def _title(one: FlightBesideOthers, name: str) -> str:
    """The name of a readout that departs, of a speed that follows from the average acceleration that of the latter."""
    if name == "top_speed" and one.flight.top_speed is None:
        name = "avg_accel"
    return BY_NAME[name].title.lower()


def _listed(causes: Sequence[PossibleCause]) -> str:
    """`an arc (31%), extra drag (29%) or a weak motor (20%)`."""
    some = [f"{CAUSES[one.cause].title} ({percent(one.probability)})" for one in causes[:MAX_CAUSES]]
    return some[0] if len(some) == 1 else f"{', '.join(some[:-1])} or {some[-1]}"


def _signs(one: FlightBesideOthers) -> Iterator[str]:
    """The readouts beside the apogee that depart clearly, and speed and coast if they are as usual."""
    for name, (miss, sd) in one.departures.items():
        if name == "apogee":
            continue
        title = _title(one, name).replace("coast to apogee", "coast").replace("apogee to ejection", "ejection")
        if abs(miss) < CLEAR * sd:
            if name in ("top_speed", "coast_to_apogee"):
                yield f"{title} as usual"
            continue
        more, less = MORE_OR_LESS.get(name, ("high", "low"))
        word = more if miss > 0 else less
        value = one.flight.number(name)
        if name == "apogee_to_eject":
            yield f"{title} {abs(miss):.1f} s {word}"
        elif name in MORE_OR_LESS and value is not None:
            yield f"{title} {abs(value * expm1(-miss)):.1f} s {word}"
        else:
            yield f"{title} {abs(expm1(miss)):.0%} {word}"


def likely_cause(one: FlightBesideOthers) -> tuple[str, str]:
    """The most probable cause of a flight in words, and the tag for it; empty if nothing is known of it."""
    if not one.causes:
        return "", ""
    cause = CAUSES[one.causes[0].cause]
    return cause.title, cause.tag


def one_off_lines(found: Sequence[FlightBesideOthers], system: str = "SI") -> Iterator[str]:
    """A line for every flight that is singled out or has a readout in the wrong unit, and the command that corrects or
    tags it."""
    for one in found:
        edits = {name: slip.typed for name, slip in _impossible_slips(one).items()}
        if (slip := _misread_slip(one)) is not None:
            edits[slip[0]] = slip[1].typed
        if not one.flight.clean or not (one.singled_out or edits):
            continue
        yield why(one, system)
        name = quote(one.flight.flight_id)
        if edits:
            yield f"If that is so: `fieldkit edit {name} {' '.join(f'{key}={text}' for key, text in edits.items())}`."
        elif one.suggested_tags:
            yield f"If that is so: `fieldkit tag {name} {one.suggested_tags[0]}`."
