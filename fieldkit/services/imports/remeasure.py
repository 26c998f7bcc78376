"""Reading the files of a flight again from the bytes in the ledger, and finding figures that differ."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

from fieldkit.errors import LedgerError
from fieldkit.flight import COLUMNS, LOGGED, MEASURED, SENSORS, TWO_DEVICES, Column, Flight
from fieldkit.flight.log_origin import FORMAT, KINDS, OTHER_LOGS, PART, LogOrigin
from fieldkit.importing import ColumnChoice
from fieldkit.importing.companion_files import same_moment
from fieldkit.importing.read import read_stored
from fieldkit.importing.recognize import parsers
from fieldkit.importing.tables.mapping import remembered
from fieldkit.quantities import counted
from fieldkit.services.imports.within_motor import within_motor

if TYPE_CHECKING:
    from fieldkit.ledger import Ledger


@dataclass(frozen=True, slots=True)
class Remeasured:
    """A flight as stored, as it was first imported if it was edited since, and both as read again now. `kept` names the
    readouts that the flyer typed or edited: they stay even if the files differ."""

    id: str
    flight: Flight
    entered: Flight | None
    renewed: Flight
    renewed_entered: Flight | None
    kept: tuple[str, ...] = ()

    @property
    def changes(self) -> Mapping[str, tuple[float | None, float | None]]:
        """Readouts that change: the current figure and the new one. [SI]"""
        pairs = {c.name: (self.flight.number(c.name), self.renewed.number(c.name)) for c in MEASURED}
        return {name: (old, new) for name, (old, new) in pairs.items() if old != new}

    @property
    def others(self) -> tuple[str, ...]:
        """Columns that change and are not readouts: a date, the firmware, an uncertainty."""
        fields = [c.name for c in COLUMNS if c not in MEASURED] + ["date_time"]
        found = [name for name in fields if getattr(self.flight, name) != getattr(self.renewed, name)]
        for c in MEASURED:
            found += [c.sd_header] * (self.flight.sd.get(c.name) != self.renewed.sd.get(c.name))
            found += [c.source_header] * (self.flight.source.get(c.name) != self.renewed.source.get(c.name))
        old, new = self.flight.extra, self.renewed.extra
        return (*found, *(name for name in {**old, **new} if old.get(name) != new.get(name)))


@dataclass(frozen=True, slots=True)
class StoredFiles:
    """The original bytes of a flight's log and of its additional files, the parser that reads the log, and the user's
    choices of columns if that parser may need one, latest first."""

    log: bytes
    format: str | None
    others: tuple[bytes, ...] = ()
    choices: tuple[ColumnChoice, ...] = ()


def remeasured(ledger: "Ledger", id: str) -> Remeasured | None:
    """A flight of the ledger with its files read again; None if no file has samples.

    Raises LedgerError for an unknown id, or if it is unclear which flight of a log it is, DamagedLog or UnknownFormat
    for a log that no parser reads anymore, and FieldkitError if saved choices of columns cannot be read.
    """
    flight, files = ledger.flight(id), stored_files(ledger, id)
    if files is None or not flight.origin.format:
        return None
    fresh = read_stored([files.log, *files.others], id, files.format, files.choices)
    entered = ledger.entered(id)
    read = _within(as_held(which(flight, fresh, id), flight, flight.origin.others), flight)
    kept = tuple(c.name for c in MEASURED if _stays(c, flight, entered, read))
    again = None if entered is None else renewed(entered, None, read)
    return Remeasured(id, flight, entered, renewed(flight, entered, read), again, kept)


def _within(fresh: Flight, flight: Flight) -> Flight:
    """A flight as read again, without readouts that its motor and mass rule out."""
    known = fresh.with_changes(motor=flight.motor, dry_mass=flight.dry_mass)
    return within_motor(known)[0].with_changes(motor=fresh.motor, dry_mass=fresh.dry_mass)


def stored_files(ledger: "Ledger", id: str) -> StoredFiles | None:
    """The files of a flight of the ledger; None if it has none. Raises LedgerError for an unknown id, FieldkitError if
    saved choices of columns are needed and cannot be read."""
    flight, log = ledger.flight(id), ledger.log(id)
    if log is None:
        return None
    format = format_of(flight)
    by_columns = format is None or parsers()[format].mapped is not None
    return StoredFiles(log, format, tuple(ledger.other_logs(id)), remembered() if by_columns else ())


def which(flight: Flight, fresh: Sequence[Flight], id: str) -> Flight:
    """The index of a flight among those read from files: by its lift-off, else by its number. Raises LedgerError if
    that is not certain."""
    found = list(fresh)
    if len(found) > 1:
        found = [one for one in fresh if same_moment(flight.date_time, one.date_time)]
    if len(found) != 1:
        found = [one for one in fresh if one.origin.part == flight.origin.part]
    if len(found) != 1:
        raise LedgerError(f"{id}: its log now holds {counted(len(fresh), 'flight')}, and none clearly matches this one")
    return found[0]


def as_held(fresh: Flight, flight: Flight, others: Sequence[str]) -> Flight:
    """A flight as read again, with the ledger's references to its files: the first one, and the `others`."""
    held = flight.origin
    first = LogOrigin(held.format, held.part, others=tuple(others) or held.others)
    return fresh.without_columns((FORMAT, PART, OTHER_LOGS)).with_columns(**first.columns())


def renewed(flight: Flight, entered: Flight | None, fresh: Flight) -> Flight:
    """A flight updated from its files, except for values of the flyer; `entered` is the flight before any edit. A
    figure comes from the files if it was measured, stated by the device, or missing."""
    was = entered or flight
    changes: dict[str, object] = {}
    for column in MEASURED if was.log else COLUMNS + LOGGED:  # a table row that names a log uses its readouts only
        if _open_to(column, flight, was):
            changes[column.name] = fresh.number(column.name)
    if flight.date_time is None and was.date_time is None and not was.log:
        changes["date_time"] = fresh.date_time
    details = {part: _beside(part, changes, flight, was, fresh) for part in ("sd", "source")}
    measured = [c for c in TWO_DEVICES if c.sd_header in was.extra]  # otherwise the flyer's own
    two = {h for c in measured for h in (c.header, c.sd_header) if flight.extra.get(h) == was.extra.get(h)}
    ours = two | {c.stated_header for c in MEASURED} | {KINDS, OTHER_LOGS, "time_to_apogee_s", "time_to_apogee_sd_s"}
    extra = {name: text for name, text in flight.extra.items() if name not in ours or name in fresh.extra}
    for name, text in fresh.extra.items():
        if flight.extra.get(name) == was.extra.get(name):
            extra[name] = text
    return flight.with_changes(**changes, **details, extra=extra)


def _beside(
    part: str, changes: Mapping[str, object], flight: Flight, was: Flight, fresh: Flight
) -> dict[str, float | str]:
    """The new standard deviations or sources of a flight's readouts: those of the files for readouts in `changes`,
    except for what the flyer edited."""
    details: dict[str, float | str] = {}
    for column in MEASURED:
        own, first, new = (getattr(one, part).get(column.name) for one in (flight, was, fresh))
        renewed_value = changes.get(column.name, flight.number(column.name))
        value = new if column.name in changes and own == first else own
        if value is not None and renewed_value is not None:
            details[column.name] = value
    return details


def _open_to(column: Column, flight: Flight, was: Flight) -> bool:
    """Whether a figure comes from the files."""
    value = was.number(column.name)
    if flight.number(column.name) != value:
        return False  # edited
    if value is None:
        return True
    return column in MEASURED and from_files(column, was)


def from_files(column: Column, flight: Flight) -> bool:
    """Whether a readout was measured in a log or stated by its device."""
    value = flight.number(column.name)
    stated = flight.as_stated(column)
    source = flight.source.get(column.name, "")
    known = source in (*SENSORS, "stated") or (not source and column.name in flight.sd)
    return known or (not source and value is not None and stated == column.render(value))


def _stays(column: Column, flight: Flight, entered: Flight | None, fresh: Flight) -> bool:
    """Whether the user's own figure is retained if the files differ."""
    mine, theirs = flight.number(column.name), fresh.number(column.name)
    return theirs is not None and mine != theirs and not _open_to(column, flight, entered or flight)


def format_of(flight: Flight) -> str | None:
    """The parser that read the first file of a flight, None if it no longer exists."""
    known = flight.origin.format
    return known if known in parsers() else None
