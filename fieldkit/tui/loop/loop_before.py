"""The Loop page before a search: what would be compared, the flown apogees, and the effects that would be tried."""

from collections.abc import Callable, Sequence
from functools import partial

import numpy as np
from textual.content import Content

from fieldkit.flight import CONDITIONS, READOUTS, Flight
from fieldkit.messages import message, of_unit
from fieldkit.physics.effect import Effect
from fieldkit.quantities import in_system, spelled, unit_of
from fieldkit.tui.setup.setup_card import draw_apogees
from fieldkit.tui.widgets import cards
from fieldkit.tui.widgets.hanging import Hanging, stacked

RARE_SDS = 2.0
"""Standard deviations of a prior that an effect rarely exceeds. [1]"""


def before_search(about: str, flights: Sequence[Flight], motors: Sequence[str]) -> Hanging:
    """What a search does, and which flights of the rocket, readouts and conditions it would compare."""
    used = [flight for flight in flights if flight.clean and flight.readouts()]
    names = [*READOUTS, *CONDITIONS]
    counts = {one.title: sum(flight.number(one.name) is not None for flight in used) for one in names}
    pairs = [
        ("flights", f"{len(used)} of {len(flights)}: with readouts, without an anomaly tag"),
        ("motors", ", ".join(motors)),
        ("configurations", ", ".join(dict.fromkeys(flight.config for flight in used if flight.config))),
        ("recorded", ", ".join(f"{title.lower()} {count}" for title, count in counts.items() if count)),
        ("not recorded", ", ".join(title.lower() for title, count in counts.items() if not count)),
    ]
    return stacked(
        [Hanging(((0, Content(about)),)), cards.lines("What would be compared", [one for one in pairs if one[1]], 16)]
    )


def effects_before(about: str, tried: Sequence[Effect]) -> Hanging:
    """What a fingerprint is, and each effect that a search would try, with what it does to a flight."""
    pairs = [(effect.title, effect.explains) for effect in tried]
    return stacked([Hanging(((0, Content(about)),)), cards.lines("What a search tries", pairs, 26)])


def rows_before(tried: Sequence[Effect], system: str) -> dict[str, tuple[str, ...]]:
    """A row for each effect that a search would try, by its title: the title, and how large it may be in the units of a
    system."""
    return {effect.title: (effect.title, _size(effect, system)) for effect in tried}


def _size(effect: Effect, system: str) -> str:
    """The strength that an effect rarely exceeds by its prior: `10% of the height`."""
    prior = effect.prior
    ends = np.clip([prior.mean - RARE_SDS * prior.sd, prior.mean + RARE_SDS * prior.sd], prior.low, prior.high)
    largest = float(np.max(np.abs(effect.strength(ends))))
    whole = effect.unit.removeprefix("fraction ")
    if whole != effect.unit:
        return f"{largest:.0%} {whole}"
    return in_system(message(of_unit(largest, effect.unit)), system)


def explained_before(effect: Effect) -> Content:
    """What an effect does to a flight, and what to fly or record to recognize it."""
    explained = f"{effect.explains[:1].upper()}{effect.explains[1:]}."
    return Content.assemble((effect.title, "b $primary"), f"\n{explained}\ntest     {effect.tell_apart}")


def flown_apogees(flights: Sequence[Flight], system: str) -> tuple[str, Callable[..., None] | None]:
    """The apogees of all flights of a rocket in the order flown, as a caption and a drawing; no drawing of fewer than
    two."""
    known = [flight for flight in flights if flight.apogee is not None]
    unit = spelled(unit_of(cards.APOGEE, system))
    caption = f"Apogee [{unit}], flight by flight; ✗ tagged. After S: flown minus forecast, against a column (v)"
    return caption, partial(draw_apogees, known, None, system) if len(known) > 1 else None
