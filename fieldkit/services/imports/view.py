"""A file as it was read for an import: the same for a preview and for the receipt.

Numbers are in the units of their columns, as in the flight table.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

from fieldkit import units
from fieldkit.analysis import columns
from fieldkit.analysis.labels import sensor_of
from fieldkit.analysis.whole_flight import flight_curve
from fieldkit.flight import MEASURED, TWO_DEVICES, Column, Flight
from fieldkit.importing.reading import ImportedFile

if TYPE_CHECKING:
    from fieldkit.analysis import Recorded
    from fieldkit.analysis.whole_flight import FlightCurve
    from fieldkit.importing.tables.columns_read import ColumnRead


@dataclass(frozen=True, slots=True)
class ReadoutView:
    """A readout that would be stored: value, standard deviation, source, and the device's own value."""

    value: float
    sd: float | None
    sensor: str
    stated: float | None


@dataclass(frozen=True, slots=True)
class EventView:
    """An event, seconds from lift-off (on the log's own clock if lift-off is unknown), and its height."""

    name: str
    time: float
    altitude: float | None
    sensor: str


@dataclass(frozen=True, slots=True, eq=False)
class FlightView:
    """One flight of a file; `recorded` has the measurements in its samples, None if it has none.

    Readouts and events are computed when they are shown: a table may have 100,000 flights, which are counted.
    """

    flight: Flight
    recorded: "Recorded | None"
    simulated: bool = False
    """Whether it is a simulation, which is shown but not stored."""

    @property
    def readouts(self) -> Mapping[str, ReadoutView]:
        """Its readouts by name, with those that a log shows of a descent on two devices."""
        return _readouts(self.flight, self.recorded)

    @property
    def events(self) -> tuple[EventView, ...]:
        """Its events in order of time."""
        return _events(self.recorded)

    @property
    def curve(self) -> "FlightCurve | None":
        """Height, speed and acceleration of the whole flight for plotting; None without samples."""
        return flight_curve(self.recorded) if self.recorded else None


@dataclass(frozen=True, slots=True, eq=False)
class FileView:
    """One file: its parser, why that one was chosen, the columns used, and the flights in it."""

    file: str
    format: str
    title: str
    why: str
    columns: "tuple[ColumnRead, ...]"
    rows: int
    dropped: int
    flights: tuple[FlightView, ...]
    notes: tuple[str, ...]
    rejected: int
    simulations: tuple[FlightView, ...] = ()
    """Its simulated flights, which would not be stored."""

    @property
    def shown(self) -> tuple[FlightView, ...]:
        """The flights and the simulations in it."""
        return self.flights + self.simulations

    @property
    def apogees(self) -> tuple[float, ...]:
        """The apogees of the flights that have one. [m]"""
        return tuple(one.flight.apogee for one in self.flights if one.flight.apogee is not None)


def file_view(imported: ImportedFile, flights: Sequence[Flight], notes: Sequence[str]) -> FileView:
    """A file as read; `flights` are those of the import, as they would be stored, and `notes` all its notes."""
    by_id = {one.flight_id: found for one, found in zip(imported.flights, imported.recorded, strict=True)}
    how = imported.recognition
    return FileView(
        imported.source,
        imported.format,
        how.title,
        how.why,
        how.columns,
        how.rows,
        how.dropped,
        tuple(FlightView(flight, by_id.get(flight.flight_id)) for flight in flights),
        tuple(notes),
        len(imported.rejected),
        tuple(_simulation_view(one, number) for number, one in enumerate(imported.simulated, start=1)),
    )


def _simulation_view(recorded: "Recorded", number: int) -> FlightView:
    """The values that a simulation states for its flight, as if they were stored."""
    fields, _ = columns(recorded, {})
    flight = Flight().with_changes(**fields, flight_id=f"simulation {number}")
    return FlightView(flight, recorded, simulated=True)


def _readouts(flight: Flight, recorded: "Recorded | None") -> dict[str, ReadoutView]:
    """The readouts of a flight by name, with those that a log shows of a descent on two devices."""
    readouts = {c.name: _readout(c, v, flight, recorded) for c in MEASURED if (v := flight.number(c.name)) is not None}
    return readouts | {
        c.name: _readout(c, one.value, flight, recorded)
        for c in TWO_DEVICES
        if recorded and (one := recorded.figures.get(c.name))
    }


def _readout(column: Column, value: float, flight: Flight, recorded: "Recorded | None") -> ReadoutView:
    scale = units.unit(column.quantity, column.unit)
    sd = (flight.columns.sd if column in TWO_DEVICES else flight.sd).get(column.name)
    stated = flight.as_stated(column)
    figure = recorded.figures.get(column.name) if recorded and (sd is not None or not stated) else None
    known = flight.source.get(column.name) or ("device" if stated or flight.origin.format else "typed")
    sensor = sensor_of(figure.source) if figure else known
    spread = None if sd is None else scale.from_si(sd) - scale.from_si(0)
    device = recorded.device.get(column.name) if recorded else None
    own = _number(stated) if stated or device is None else scale.from_si(device)
    return ReadoutView(scale.from_si(value), spread, sensor, own)


def _number(text: str) -> float | None:
    try:
        return float(text) if text else None
    except ValueError:
        return None


def _events(recorded: "Recorded | None") -> tuple[EventView, ...]:
    """The events of a flight in order of time."""
    if recorded is None:
        return ()
    lift = recorded.events.get("liftoff")
    zero = lift.time if lift else 0.0
    found = sorted(recorded.events.items(), key=lambda item: item[1].time)
    return tuple(
        EventView(
            name,
            event.time - zero,
            0.0 if name == "liftoff" else recorded.height_at(event.time),
            sensor_of(event.source),
        )
        for name, event in found
    )
