"""The Loop page before a search: what would be compared, the flown apogees, and the effects that would be tried."""

from collections.abc import Sequence
from typing import Any

from textual.content import Content

from fieldkit import units
from fieldkit.flight import CONDITIONS, READOUTS, Flight
from fieldkit.quantities import spelled, unit_of
from fieldkit.tui.widgets import cards
from fieldkit.tui.widgets.hanging import Hanging, stacked


def before_search(about: str, flights: Sequence[Flight]) -> Hanging:
    """What a search does, and which flights of the rocket, readouts and conditions it would compare."""
    used = [flight for flight in flights if flight.clean and flight.readouts()]
    names = [*READOUTS, *CONDITIONS]
    counts = {one.title: sum(flight.number(one.name) is not None for flight in used) for one in names}
    pairs = [
        ("flights", f"{len(used)} of {len(flights)}: with readouts, without an anomaly tag"),
        ("motors", ", ".join(dict.fromkeys(flight.motor for flight in used if flight.motor))),
        ("configurations", ", ".join(dict.fromkeys(flight.config for flight in used if flight.config))),
        ("recorded", ", ".join(f"{title.lower()} {count}" for title, count in counts.items() if count)),
        ("not recorded", ", ".join(title.lower() for title, count in counts.items() if not count)),
    ]
    return stacked(
        [Hanging(((0, Content(about)),)), cards.lines("What would be compared", [one for one in pairs if one[1]], 16)]
    )


def effects_before(about: str, tried: Sequence[tuple[str, str]]) -> Hanging:
    """What a fingerprint is, and each effect that a search would try, with what it does to a flight."""
    return stacked([Hanging(((0, Content(about)),)), cards.lines("What a search tries", tried, 26)])


def flown_apogees(flights: Sequence[Flight], system: str) -> tuple[list[tuple[float, float]], str]:
    """The apogee of each flight that a search would compare, by its place among all flights of the rocket from 1, and
    the unit of a system in which it is given."""
    name = unit_of(cards.APOGEE, system)
    unit = units.unit(cards.APOGEE.quantity, name)
    known = [
        (float(place), unit.from_si(flight.apogee))
        for place, flight in enumerate(flights, 1)
        if flight.clean and flight.apogee is not None
    ]
    return known, spelled(name)


def draw_apogees(points: Sequence[tuple[float, float]], unit: str, plt: Any, ink: Any) -> None:
    """Draw apogees against the flight."""
    across, up = zip(*points, strict=True)
    plt.scatter(across, up, marker="●", color=ink.mark)
    plt.ylabel(unit)
