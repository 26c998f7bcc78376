"""Facts of a flight or a forecast as lines, in the flyer's units."""

from collections.abc import Iterable, Sequence

from rich.cells import cell_len
from textual.content import Content

from fieldkit.flight import BY_NAME, CONDITIONS, KNOWN_TAGS, READOUTS, SETUP, Column, Flight
from fieldkit.importing.manual_entry import answer_text
from fieldkit.presentation import logged
from fieldkit.quantities import measure
from fieldkit.safe_text import printable
from fieldkit.tui.widgets.hanging import Hanging

Pairs = Sequence[tuple[str, str]]
Styled = list[str | tuple[str, str]]
"""Texts, some with their style, from which a `Content` is assembled."""


def lines(heading: str, pairs: Pairs, width: int = 0) -> Hanging:
    """A heading and `name value` lines, without empty values; values are never interpreted as markup. `width` is that
    of the names [cell], 0 for the longest."""
    known = [(printable(name), printable(value)) for name, value in pairs if value]
    width = width or max((cell_len(name) for name, _ in known), default=0)
    made = [(0, Content.assemble((printable(heading), "b $primary")))] if heading else []
    for name, value in known:
        lead = f"{name}{' ' * (width - cell_len(name))}  " if name else ""
        line = Content.assemble((lead, "$text-muted"), (value, "b"))
        made.append((width + 2 if cell_len(name) <= width else 2, line))
    return Hanging(tuple(made))


def columns(flight: Flight, wanted: Iterable[Column], system: str) -> list[tuple[str, str]]:
    """Titles and values of the recorded columns."""
    return [(c.title, measure(c, flight.number(c.name), system)) for c in wanted if flight.number(c.name) is not None]


def readouts(flight: Flight, system: str) -> list[tuple[str, str]]:
    """The ten readouts in the altimeter's order, with a dash for missing ones."""
    return [(c.title, logged.readout(flight, c, system) or "–") for c in READOUTS]


def circumstances(flight: Flight, system: str) -> list[tuple[str, str]]:
    """Recorded setup and conditions, site, notes and log."""
    texts = [("Site", flight.site), ("Notes", flight.notes), ("Log", flight.log)]
    return columns(flight, (*SETUP, *CONDITIONS), system) + [(n, v) for n, v in texts if v]


def heading(flight: Flight, id: str) -> str:
    """A flight in a line: `2 · Astra A · F24-4W · 2026-05-01 10:30`."""
    rocket = " ".join(part for part in (flight.rocket, flight.config) if part)
    parts = (id.removeprefix(f"{flight.rocket}/"), rocket, flight.motor, answer_text(flight, "date_time"))
    return printable(" · ".join(part for part in parts if part))


def tags(flight: Flight) -> list[tuple[str, str]]:
    """The tags of a flight and what each means."""
    return [(tag, KNOWN_TAGS.get(tag, "your own; the flight is still used in the model")) for tag in flight.tags]


def apogee(flight: Flight, system: str) -> str:
    """The apogee of a flight; a dash if it was not recorded."""
    return measure(APOGEE, flight.apogee, system) or "–"


def as_text(title: str, pairs: Pairs) -> str:
    """A title and `name value` lines as plain text, to be copied."""
    known = [(name, value) for name, value in pairs if value]
    width = max((len(name) for name, _ in known), default=0)
    return "\n".join([title, *(f"{name:{width}}  {value}" for name, value in known)])


APOGEE = BY_NAME["apogee"]
"""The column that most of the app is about."""
DRY_MASS, DIAMETER, ELEVATION = (BY_NAME[name] for name in ("dry_mass", "diameter", "site_elevation"))
