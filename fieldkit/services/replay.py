"""Reading logs again: the samples of a flight of the ledger or of a file, and the values measured in them."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from types import MappingProxyType

from fieldkit.analysis import Figure, Recorded, measure, simulated
from fieldkit.errors import BadValue, DamagedLog, LedgerError, NoFlights, UnknownFormat
from fieldkit.flight import Flight, Series
from fieldkit.importing import Reading
from fieldkit.importing.companion_files import same_moment
from fieldkit.importing.read import read, read_recordings
from fieldkit.importing.reading import ColumnChoice
from fieldkit.importing.to_flights import derived_id
from fieldkit.ledger import Ledger
from fieldkit.quantities import counted
from fieldkit.safe_text import whole_number
from fieldkit.services.imports import StoredFiles, read_file, stored_files


@dataclass(frozen=True, slots=True, eq=False)
class Recording:
    """A recorded flight: its name, its kind, its samples and measured values.

    `reading` is None for a flight with readouts only.
    """

    name: str
    kind: str
    reading: Reading | None
    recorded: Recorded
    stated: Mapping[str, float] = field(default_factory=lambda: MappingProxyType({}))
    """Readouts that the device stated. [SI]"""


class FlightRecordings:
    """The samples of flights of the ledger, read again from the stored bytes.

    A file that holds several flights is read once if they are requested one after the other.
    """

    def __init__(self, ledger: Ledger) -> None:
        self._ledger = ledger
        self._last: tuple[StoredFiles, list[Reading]] | None = None

    def of(self, id: str) -> Recording | None:
        """The samples of a flight; None if it has none. Raises LedgerError for an unknown id, and if it is unclear
        which flight of a log it is, FieldkitError if saved choices of columns are needed and cannot be read."""
        files = stored_files(self._ledger, id)
        if files is None:
            return None
        if self._last is None or self._last[0] != files:
            self._last = files, self._read(files, id)
        readings = self._last[1]
        return _recording(id, _part(self._ledger.flight(id), readings, id)) if readings else None

    def _read(self, files: StoredFiles, id: str) -> list[Reading]:
        """The recorded flights of some files, or else the simulations; empty without samples."""
        try:
            readings = read_recordings(files.log, id, files.format, files.choices, files.others)
        except (DamagedLog, UnknownFormat):
            return []
        return [one for one in readings if one.describes == "flight"] or readings


def recording_of(ledger: Ledger, id: str) -> Recording | None:
    """The samples of one flight of the ledger, as `FlightRecordings` reads them."""
    return FlightRecordings(ledger).of(id)


def track_of(ledger: Ledger, id: str) -> Series:
    """The samples of a flight with satellite positions. Raises BadValue for a flight without, LedgerError."""
    found = recording_of(ledger, id)
    clocks = () if found is None or found.reading is None else found.reading.clocks
    for clock in clocks:
        if clock.latitude is not None and clock.longitude is not None:
            return clock
    raise BadValue(f"{id}: found no GPS positions, expected a flight with the log of a tracker")


def _part(flight: Flight, readings: list[Reading], id: str) -> Reading:
    """The reading of a flight in a log: by its lift-off, its number, or its name."""
    if len(same := [one for one in readings if same_moment(one.stated.get("date_time"), flight.date_time)]) == 1:
        return same[0]
    part = flight.origin.part or ("1" if len(readings) == 1 else "")
    if (number := whole_number(part)) and number <= len(readings):
        return readings[number - 1]
    named = [one for one in readings if one.stated.get("flight_id") == flight.flight_id]
    if len(named) != 1:
        raise LedgerError(f"{id}: its log holds {counted(len(readings), 'flight')} and none has this id")
    return named[0]


def recordings(
    ledger: Ledger | None, what: str, format: str | None = None, choices: Sequence[ColumnChoice] = ()
) -> list[Recording]:
    """The flights of a file, or the flight of the ledger with an id, as recordings to compare.

    Flights without a log have only their readouts. Raises FieldkitError if there is neither such a file nor such a
    flight.
    """
    path = Path(what)
    if path.is_file():
        return _in_file(path, format, choices)
    if ledger is None:
        raise NoFlights(f"{what}: no such file")
    found = recording_of(ledger, what)
    return [found or _by_readouts(ledger.flight(what), what)]


def _in_file(path: Path, format: str | None, choices: Sequence[ColumnChoice]) -> list[Recording]:
    log = read_file(path)
    try:
        readings = read_recordings(log, path.name, format, choices)
    except DamagedLog:
        flights = read(log, path.name, lambda motor: None, format).flights
        if not flights:
            raise
        return [_by_readouts(flight, flight.flight_id or derived_id(flight)) for flight in flights]
    many = len(readings) > 1
    return [_recording(f"{path.name}#{n}" if many else path.name, one) for n, one in enumerate(readings, start=1)]


def _recording(name: str, reading: Reading) -> Recording:
    kind = "simulation" if reading.describes == "simulation" else reading.device or "log"
    stated = {key: value for key, value in reading.stated.items() if isinstance(value, float)}
    analyze = simulated if kind == "simulation" else measure
    return Recording(name, kind, reading, analyze(reading.clocks, reading.events), stated)


def _by_readouts(flight: Flight, name: str) -> Recording:
    """A flight with readouts only; typed readouts have no uncertainty."""
    figures = {key: Figure(value, flight.sd.get(key, 0.0), "readout") for key, value in flight.readouts().items()}
    return Recording(name, "readouts", None, Recorded(figures=figures))
