"""Convert readings to flights: limits, motor names, IDs, duplicates, and rockets from another file."""

import hashlib
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import fields, replace
from typing import TYPE_CHECKING

from fieldkit.errors import BadValue, DamagedLog, UnknownMotor
from fieldkit.flight import BY_NAME, MEASURED, READOUTS, Flight, Series
from fieldkit.flight.further_units import LIFT_OFF_MASS, in_own_units
from fieldkit.flight.limits import check
from fieldkit.flight.plan import check_plan
from fieldkit.flight.plausibility import doubts
from fieldkit.flight.storable import NAMES, check_keys, check_name, check_texts, long_names
from fieldkit.importing.reading import ImportedFile, Mapped, Note, Parsed, Reading, Rejected
from fieldkit.importing.recognize import shown_damage
from fieldkit.importing.tables.text import shown
from fieldkit.messages import amount, marked, message
from fieldkit.motors import catalogue
from fieldkit.motors.several import tagged
from fieldkit.quantities import counted

if TYPE_CHECKING:
    from fieldkit.analysis import Recorded

CheckMotor = Callable[[str], str | None]
"""Function that returns the error in a motor's name, or None if the motor exists."""


def imported_file(
    source: str, format: str, found: Sequence[Parsed], rockets: Mapping[str, Reading], check_motor: CheckMotor
) -> ImportedFile:
    """The flights in the readings of one source, and the rejected rows; `rockets` are by `rocket_key`."""
    kept: dict[tuple[str, str], tuple[Flight, int | None]] = {}
    recorded: "dict[tuple[str, str], Recorded | None]" = {}
    rejected: list[Rejected] = []
    notes = [item for item in found if isinstance(item, Note)]
    for item in found:
        try:
            if isinstance(item, DamagedLog):
                raise item
            if isinstance(item, Reading) and item.describes == "simulation":
                continue
            if isinstance(item, Reading) and item.describes == "rocket":
                _flight(item)
            elif isinstance(item, Reading):
                flight = _measured(_named(item, rockets), check_motor)
                notes += _keep(flight, item.row, kept)
                recorded.setdefault((flight.rocket, flight.flight_id), item.recorded)
        except DamagedLog as error:
            whole = shown_damage(error, source)
            rejected.append(Rejected(source, whole.row, whole.column, whole.found))
    if found and all(isinstance(item, Reading) and item.describes == "rocket" for item in found):
        notes.append(Note(f"describes {counted(len(found), 'rocket')} and no flight; import it with the flights"))
    if any(isinstance(item, Reading) and item.describes == "simulation" for item in found):
        notes.append(Note(_SIMULATION_NOTE.format(source)))
    strangers = {item.rocket_key for item in found if isinstance(item, Reading)} - {"", *rockets}
    if strangers:
        notes.append(Note(_FOREIGN_MOTORS.format(counted(len(strangers), "rocket"))))
    lines = (message(marked(shown_damage(DamagedLog(note.text, row=note.row), source))) for note in notes)
    flights, places = zip(*kept.values(), strict=True) if kept else ((), ())
    mapped = tuple(item for item in found if isinstance(item, Mapped))
    measured = tuple(recorded[name] for name in kept)
    simulated = tuple(
        item.recorded
        for item in found
        if isinstance(item, Reading) and item.describes == "simulation" and item.recorded is not None
    )
    return ImportedFile(
        source, format, flights, tuple(rejected), tuple(lines), places, mapped, measured, simulated=simulated
    )


_SIMULATION_NOTE = "is a simulation and is not imported as a flight; `fieldkit compare FLIGHT {}` compares it with one"
_FOREIGN_MOTORS = "only a number and no mass of {}; import the file that lists the rockets together with this one"


def _named(reading: Reading, rockets: Mapping[str, Reading]) -> Reading:
    """Complete a reading from a list of rockets; the log's own values take precedence."""
    if not reading.rocket_key:
        return reading
    rocket = rockets.get(reading.rocket_key)
    known = rocket.stated if rocket else {"rocket": reading.rocket_key}
    return replace(reading, stated={**known, **reading.stated})


def _keep(flight: Flight, row: int | None, kept: dict[tuple[str, str], tuple[Flight, int | None]]) -> list[Note]:
    """Add a flight to the others, and return notes on long names and implausible values. Raises DamagedLog if its
    name is taken."""
    name = (flight.rocket, flight.flight_id)
    if name not in kept:
        kept[name] = flight, row
        return [Note(phrase, row) for phrase in (*long_names(flight), *doubts(flight))]
    first, first_row = kept[name]
    if first != flight:
        found = f"found {shown(flight.flight_id)}, which row {first_row} has for another flight of this rocket"
        raise DamagedLog(found, row=row, column="flight_id")
    return [Note(f"repeats row {first_row}", row)]


def _measured(reading: Reading, check_motor: CheckMotor) -> Flight:
    """The flight that a reading describes, with a name. Raises DamagedLog if it has no readout, tag, log or samples, an
    impossible value, or an unknown motor."""
    flight = tagged(_weighed(_flight(reading), reading))
    if not (flight.readouts() or flight.log or flight.tags or reading.clocks):
        found = f"found no readout, expected at least one such as {READOUTS[0].header}"
        raise DamagedLog(f"{found}; planned flights are for predict --flights", row=reading.row)
    try:
        check_keys(flight)
        check_texts(flight)
    except BadValue as error:
        raise DamagedLog(str(error), row=reading.row) from error
    _check_motor(flight, reading, check_motor)
    return flight if flight.flight_id else flight.with_changes(flight_id=derived_id(flight, reading.clocks))


def _weighed(flight: Flight, reading: Reading) -> Flight:
    """A flight with its dry mass, if only the lift-off mass is stated; with an unknown motor, the stated mass stays an
    extra column. Raises DamagedLog if the result is not positive."""
    if reading.liftoff_mass is None or flight.dry_mass is not None:
        return flight

    try:
        loaded = catalogue().resolve_several(flight.motor).motor.loaded_mass
    except UnknownMotor:
        return flight.with_columns(**{LIFT_OFF_MASS: f"{1000 * reading.liftoff_mass:.12g}"})
    if reading.liftoff_mass <= loaded:
        found = f"found a lift-off mass of {amount(reading.liftoff_mass, 'g')}"
        alone = f"the mass of {amount(loaded, 'g')} of {flight.motor}"
        raise DamagedLog(message(f"{found}, expected more than {alone}"), row=reading.row)
    return flight.with_changes(dry_mass=reading.liftoff_mass - loaded)


def plan_of(reading: Reading, check_motor: CheckMotor) -> Flight:
    """The planned flight that a reading describes, without readouts. Raises DamagedLog for an impossible value, for
    one of `check_plan` that cannot be read, for a name that no table can show, or if its motor is missing or unknown.
    """
    flight = _weighed(_flight(reading), reading)
    if not flight.motor:
        raise DamagedLog("found nothing, expected the motor's name", row=reading.row, column="motor")
    for name in NAMES:
        try:
            check_name(getattr(flight, name))
        except BadValue as error:
            raise DamagedLog(str(error), row=reading.row, column=reading.columns.get(name, name)) from error
    _check_motor(flight, reading, check_motor)
    try:
        check_texts(flight)
        check_plan(flight)
    except BadValue as error:
        raise DamagedLog(message(marked(error)), row=reading.row) from error
    unread = dict.fromkeys(column.name for column in MEASURED)
    return flight.with_changes(flight_id=flight.flight_id or f"row-{reading.row}", **unread)


def _flight(reading: Reading) -> Flight:
    """The flight that a reading states. Raises DamagedLog for an impossible figure."""
    for name, value in reading.stated.items():
        try:
            if isinstance(value, float):
                check(BY_NAME[name], value)
        except BadValue as error:
            raise DamagedLog(message(marked(error)), row=reading.row, column=reading.columns.get(name, name)) from error
    return (Flight(extra=in_own_units(reading.extra)) if reading.extra else Flight()).with_changes(**reading.stated)


def _check_motor(flight: Flight, reading: Reading, check_motor: CheckMotor) -> None:
    """Raise DamagedLog for an unknown motor; combinations of several motors are not looked up."""
    if not flight.motor or {"cluster", "staged"} & set(flight.tags):
        return
    if complaint := check_motor(flight.motor):
        raise DamagedLog(complaint, row=reading.row, column=reading.columns.get("motor", "motor"))


def derived_id(flight: Flight, clocks: Sequence[Series] = ()) -> str:
    """A name for a flight without one: its date and a digest of its configuration and readouts, or of its samples.

    The same figures give the same name in any unit, any order of columns and any table. Notes, tags and conditions may
    be edited without changing it.
    """
    figures = [f"{name}={value:.6g}" for name, value in sorted(flight.readouts().items())]
    when = flight.date_time.isoformat() if flight.date_time else ""
    samples = [] if figures else [hashlib.sha256(channel).hexdigest() for channel in _channels(clocks)]
    content = "\x1f".join([flight.rocket, flight.config, flight.motor, when, *figures, *samples])
    digest = hashlib.sha256(content.encode("utf-8", "surrogatepass")).hexdigest()[:10]
    return f"{flight.date_time:%Y-%m-%d}-{digest}" if flight.date_time else f"flight-{digest}"


def _channels(clocks: Sequence[Series]) -> Iterator[bytes]:
    channels = (getattr(series, channel.name) for series in clocks for channel in fields(Series))
    return (channel.tobytes() for channel in channels if channel is not None)
