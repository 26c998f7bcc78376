"""Contents of files before they are stored: as text, and as JSON under the keys of the contract."""

from collections.abc import Iterator
from typing import TYPE_CHECKING, Any

from fieldkit import units
from fieldkit.analysis.labels import figure_text
from fieldkit.flight import BY_NAME, FIGURES_BY_NAME
from fieldkit.flight.event_names import event_title
from fieldkit.flight.further import names_a_device, names_a_lot
from fieldkit.importing.recognize import parsers
from fieldkit.presentation.home_text import sparkline
from fieldkit.quantities import ShownUnits, counted, in_system, measure, number, rounded, spelled, unit_of, with_sd
from fieldkit.safe_text import printable
from fieldkit.services.imports.view import EventView, FileView, FlightView, ReadoutView

if TYPE_CHECKING:
    from fieldkit.analysis.whole_flight import FlightCurve
    from fieldkit.importing.tables.columns_read import ColumnRead

PLOT_WIDTH = 60
"""Width of a text plot. [character]"""
MOST_FLIGHTS = 20
"""Maximum number of flights of a table that are printed; the JSON has all of them."""
MAX_TEXTS = 8
"""Maximum number of columns of a table that a line names. [1]"""


def document(files: tuple[FileView, ...]) -> dict[str, Any]:
    """The document of `inspect --json`."""
    return {"files": [_file(one) for one in files]}


def receipts(files: tuple[FileView, ...]) -> list[dict[str, Any]]:
    """The entry of each file in `import --json`: its format, its apogees, the apogee alone if it has one flight, and
    notes."""
    return [
        {
            "file": one.file,
            "format": one.format,
            "apogee_m": _rounded(one.apogees[0]) if len(one.apogees) == 1 else None,
            "apogees_m": [_rounded(apogee) for apogee in one.apogees],
            "notes": list(one.notes),
        }
        for one in files
    ]


def _file(one: FileView) -> dict[str, Any]:
    """One file; readouts and events of its first flight, or else simulation, are also at the top level."""
    flights, simulations = ([_flight(flight) for flight in part] for part in (one.flights, one.simulations))
    first: dict[str, Any] = next(iter([*flights, *simulations]), {"readouts": {}, "events": []})
    return {
        "file": one.file,
        "format": one.format,
        "title": one.title,
        "why": one.why,
        "columns": [
            {"name": c.name, "channel": c.channel or None, "unit": spelled(c.unit) or None, "source": c.source}
            for c in one.columns
        ],
        "rows": one.rows,
        "dropped": one.dropped,
        "readouts": first["readouts"],
        "events": first["events"],
        "flights": flights,
        "simulations": simulations,
        "notes": list(one.notes),
        "would_store": len(one.flights),
    }


def _flight(one: FlightView) -> dict[str, Any]:
    return {
        "flight_id": one.flight.flight_id,
        "readouts": {name: _readout(name, readout) for name, readout in one.readouts.items()},
        "events": [_event(event) for event in one.events],
        "curve": _curve(one.curve),
    }


def _curve(one: "FlightCurve | None") -> dict[str, Any] | None:
    """The whole flight for a plot, from lift-off."""
    if one is None:
        return None
    channels = {"time_s": one.time, "height_m": one.height, "speed_mps": one.speed, "accel_mps2": one.acceleration}
    return {name: [round(float(value), 3) for value in values] for name, values in channels.items()}


def _readout(name: str, one: ReadoutView) -> dict[str, Any]:
    return {
        "value": _rounded(one.value),
        "sd": None if one.sd is None else float(f"{one.sd:.3g}"),
        "unit": FIGURES_BY_NAME[name].unit,
        "sensor": one.sensor,
        "stated": one.stated,
    }


def _event(one: EventView) -> dict[str, Any]:
    return {
        "name": one.name,
        "time_s": _rounded(one.time),
        "altitude_m": None if one.altitude is None else round(one.altitude, 2),
        "sensor": one.sensor,
    }


def _rounded(value: float) -> float:
    return round(value, 4)


def in_a_line(one: FileView, system: str = "SI") -> str:
    """A file in one line, with its format and its apogee: `f6.pf2: PerfectFlite .pf2, apogee 245.4 m`; of a flight
    table also the columns of which only the text is stored."""
    parser = parsers().get(one.format)
    of_flights = parser is not None and parser.maps == "flights"
    texts = [column.name for column in one.columns if column.source == "text" and not _meaning(column.name)]
    texts = texts if of_flights else []
    stored = f"; stored as text: {', '.join(map(printable, texts[:MAX_TEXTS]))}" if texts else ""
    more = f" and {len(texts) - MAX_TEXTS} more" if len(texts) > MAX_TEXTS else ""
    return f"{one.file}: {one.title}{_apogees(one, ShownUnits(system))}{stored}{more}"


def _apogees(one: FileView, shown: ShownUnits) -> str:
    """The apogee of a file's flight; for several flights, the lowest and the highest."""
    found, count = [f.flight.apogee for f in one.shown if f.flight.apogee is not None], len(one.shown)
    flights = (
        ", simulation"
        if one.simulations and not one.flights
        else ""
        if count == 1
        else ", no flight"
        if not count
        else f", {counted(count, 'flight')}"
    )
    if not found:
        return flights + (", no apogee" if count else "")
    low, high = min(found), max(found)
    if len(found) == 1:
        return f"{flights}, apogee {shown.length(low, 1)}"
    return f"{flights}, apogees {shown.length(low, 1).split()[0]} to {shown.length(high, 1)}"


def lines(one: FileView, system: str = "SI") -> Iterator[str]:
    """A file in full: why it was read in this format, its columns, its flights with readouts and events, and notes, in
    the units of a system."""
    yield f"{one.file}"
    yield f"  format    {one.title} ({one.format}): {one.why}"
    yield f"  rows      {one.rows} used, {one.dropped} dropped"
    for place, column in enumerate(one.columns):
        yield f"  {'columns' if not place else '':10}{_column(column)}"
    for flight in one.shown[:MOST_FLIGHTS]:
        yield f"  {'states' if flight.simulated else 'flight':9} {flight.flight.flight_id}"
        yield from _readout_lines(flight, system)
        yield from _event_lines(flight, ShownUnits(system))
        yield from _plot_lines(flight.curve, system)
    if len(one.shown) > MOST_FLIGHTS:
        yield f"  and {counted(len(one.shown) - MOST_FLIGHTS, 'more flight')}; --json lists them all"
    for note in one.notes:
        yield f"  note      {in_system(note, system)}"
    count = len(one.flights)
    yield f"  would import {counted(count, 'flight')}, {one.rejected} rejected"


def _column(one: "ColumnRead") -> str:
    if one.source == "text":
        return f"{one.name} -> {_meaning(one.name) or 'not used'}, stored as text"
    meant = one.channel.replace("_", " ") or "not used as a channel"
    unit = f" [{spelled(one.unit)}]" if one.unit else ""
    return f"{one.name}{unit} -> {meant}, {one.source}"


def _meaning(name: str) -> str:
    """What a column that is stored as text is used for; empty if for nothing."""
    return "lot of the motor" if names_a_lot(name) else "altimeter" if names_a_device(name) else ""


def _readout_lines(flight: FlightView, system: str) -> Iterator[str]:
    for name, readout in flight.readouts.items():
        column = FIGURES_BY_NAME[name]
        own, scale = (units.unit(column.quantity, unit) for unit in (column.unit, unit_of(column, system)))
        unit = spelled(unit_of(column, system))
        value = scale.from_si(own.to_si(readout.value))
        sd = scale.difference_from_si(own.difference_to_si(readout.sd or 0.0))
        by_device = (
            "" if readout.stated is None else f"   device: {rounded(scale.from_si(own.to_si(readout.stated)))} {unit}"
        )
        yield f"    {column.title:22}{f'{with_sd(value, sd)} {unit}':22}{readout.sensor:11}{by_device}".rstrip()
        if name == "apogee" and flight.recorded and (true := flight.recorded.true_apogee):
            yield f"      {'true height':20}{figure_text(name, true.value, true.sd, system):22}by {true.source}"


def _plot_lines(curve: "FlightCurve | None", system: str) -> Iterator[str]:
    """Height, speed and acceleration of the whole flight as rows of bars, with the times of events below."""
    if curve is None:
        return
    first, last = float(curve.time[0]), float(curve.time[-1])
    even = [first + (last - first) * (cell + 0.5) / PLOT_WIDTH for cell in range(PLOT_WIDTH)]
    rows = list(zip(*map(curve.at, even), strict=True))
    columns = (BY_NAME["apogee"], BY_NAME["top_speed"], BY_NAME["peak_accel"])
    for title, column, values in zip(("height", "speed", "accel"), columns, rows, strict=True):
        ends = f"{number(column, min(values), system)} to {measure(column, max(values), system)}"
        yield f"    {title:9}{sparkline(values, PLOT_WIDTH)} {ends}"
    marks = [" "] * PLOT_WIDTH
    for name, moment in curve.events.items():
        if first <= moment <= last:
            marks[min(int(PLOT_WIDTH * (moment - first) / (last - first)), PLOT_WIDTH - 1)] = name[0].upper()
    zero = "from lift-off" if curve.from_liftoff else "on the log's clock"
    yield f"    {'events':9}{''.join(marks)} T{first:+.0f} to T{last:+.0f} s, {zero}"


def _event_lines(flight: FlightView, shown: ShownUnits) -> Iterator[str]:
    for event in flight.events:
        height = "" if event.altitude is None else shown.length(event.altitude, 1)
        yield f"    {event_title(event.name):12} T{event.time:+9.2f} s {height:>12}   {event.sensor}"
