"""From the bytes of a log or a table to flights.

A parser says whether it recognises a log and reads it into `Reading`s: what the log states, nothing
derived. What holds for every logger alike happens once, here: bounds, motor names, identities, flights
that come twice, rockets that are described in another file.
"""

import hashlib
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import fields, replace
from datetime import datetime

from fieldkit.arrival import digest_of
from fieldkit.errors import BadValue, DamagedLog, UnknownFormat
from fieldkit.flight import BY_NAME, READOUTS, Flight, Series
from fieldkit.logtext import shown
from fieldkit.mapping import Choice, choice_for
from fieldkit.parts import joined
from fieldkit.reading import Found, Intake, Mapped, Note, Parser, Reading, Rejected
from fieldkit.safe_text import printable
from fieldkit.sanity import check, doubts
from fieldkit.shelf import plugins

__all__ = [
    "HEAD",
    "CheckMotor",
    "Found",
    "Intake",
    "Mapped",
    "Note",
    "Parser",
    "Reading",
    "Rejected",
    "claims",
    "derived_id",
    "parsers",
    "read",
    "read_plans",
    "read_recordings",
    "read_together",
    "recognise",
]

HEAD = 65_536
"""How much of a log a parser sees when it is asked whether it recognises it. [bytes]"""


CheckMotor = Callable[[str], str | None]
"""A complaint about a motor's name as printed, or None if there is such a motor."""


def parsers() -> Mapping[str, Parser]:
    """Every parser on the shelf, by the name that `--format` takes."""
    found = plugins("parsers", "PARSER")
    for name, parser in found.items():
        if not isinstance(parser, Parser):
            raise TypeError(f"PARSER of parsers/{name}.py is not a Parser")
    return found  # type: ignore[return-value]


def recognise(log: bytes, format: str | None = None, source: str = "") -> Parser:
    """The one parser that recognises a log, or the one that `format` names.

    Raises UnknownFormat that lists what was tried, or the parsers that all claim the log.
    """
    return parsers()[_format_of(log, format, source)]


def claims(log: bytes) -> list[str]:
    """The names of the parsers that recognise a log; fallbacks are only asked where no other does."""
    asked = [[name for name, p in parsers().items() if p.fallback is fallback] for fallback in (False, True)]
    for names in asked:
        if claimed := [name for name in names if _claims(parsers()[name], log[:HEAD])]:
            return claimed
    return []


def _format_of(log: bytes, format: str | None, source: str, choices: Sequence[Choice] = ()) -> str:
    """The parser's name; where the flyer maps the columns, one that takes a mapping."""
    mapped = any(not choice.headers for choice in choices)
    place = f"{source}: " if source else ""
    names = ", ".join(parsers())
    takers = [name for name, parser in parsers().items() if parser.mapped]
    if format is not None:
        if format not in parsers():
            raise UnknownFormat(f"{place}no parser is called {format!r}, expected one of {names}")
        claimed = [format]
    else:
        claimed = claims(log)
    if not claimed and (mapped or _has_choice(log, choices)):
        claimed = [name for name in takers if parsers()[name].fallback]
    if not claimed:
        raise UnknownFormat(f"{place}no parser recognises this log; tried {names}{_hint(log)}")
    if len(claimed) > 1:
        raise UnknownFormat(f"{place}{' and '.join(claimed)} both recognise this log; choose one with --format")
    if mapped and claimed[0] not in takers:
        expected = f"expected none, or --format {' or '.join(takers)} with it"
        raise UnknownFormat(
            f"{place}found a mapping of columns for a log that {claimed[0]} reads by itself; {expected}"
        )
    return claimed[0]


def _has_choice(log: bytes, choices: Sequence[Choice]) -> bool:
    """Whether the flyer has said of such a table what its columns are."""
    from fieldkit.layout import layout_of

    try:
        return bool(choices) and choice_for(layout_of(log[:HEAD]).headers, choices) is not None
    except DamagedLog:
        return False


def _hint(log: bytes) -> str:
    """What a flyer can do about a log that nobody recognises, where one can tell."""
    if log.startswith(b"PK\x03\x04"):
        return "; it is a spreadsheet or an archive: save the sheet as CSV"
    start = log[:HEAD]
    if any(start.count(mark) > 4 for mark in (b",", b";", b"\t")):
        return "; a table of samples is read with --map 'time=its column' --map 'altitude=its column [m]'"
    return ""


def _claims(parser: Parser, head: bytes) -> bool:
    try:
        return parser.recognises(head)
    except DamagedLog:
        return False


def read(
    log: bytes,
    source: str,
    check_motor: CheckMotor,
    format: str | None = None,
    choices: Sequence[Choice] = (),
) -> Intake:
    """The flights of one log; `source` is its name in messages. Raises UnknownFormat or DamagedLog."""
    return read_together([(source, log)], check_motor, format, choices)[0]


def read_together(
    files: Iterable[tuple[str, bytes]],
    check_motor: CheckMotor,
    format: str | None = None,
    choices: Sequence[Choice] = (),
) -> list[Intake]:
    """The flights of several logs, given as (name, bytes), an Intake each, in order.

    A list of rockets among them names and weighs the rockets of the others. Files of one folder that a logger
    wrote of one flight bring one flight, in the first of them that holds heights. `choices` say which columns of a
    table are what, best first. Raises UnknownFormat or DamagedLog for the first file that cannot be used at all,
    before anything is taken from any. The bytes of a file are let go before its flights are measured.
    """
    read = [((source, *_open(log, source, format, choices)), digest_of(log)) for source, log in files]
    digests = [digest for _, digest in read]
    opened = [
        (source, name, _with_figures(found, name, digest))
        for (source, name, found), digest in zip(joined([one for one, _ in read], digests), digests, strict=True)
    ]
    everything = [item for _, _, found in opened for item in found if isinstance(item, Reading)]
    rockets = {item.rocket_key: item for item in everything if item.describes == "rocket"}
    return [_intake(source, name, found, rockets, check_motor) for source, name, found in opened]


def read_recordings(
    log: bytes, source: str, format: str | None = None, choices: Sequence[Choice] = ()
) -> list[Reading]:
    """The readings of a log that hold samples, flights and simulations, as they were recorded.

    Raises UnknownFormat or DamagedLog, also where the log has no samples.
    """
    _, found = _open(log, source, format, choices)
    readings = [item for item in found if isinstance(item, Reading) and item.clocks]
    if not readings:
        raise DamagedLog("found no samples, expected a log of heights over time", source=source)
    return readings


def read_plans(table: bytes, source: str, check_motor: CheckMotor, format: str | None = None) -> list[Flight]:
    """The planned flights of a table, one a row and in order; readouts in it are left out.

    A plan without a `flight_id` is named after its row, `row-2`. Raises DamagedLog for the first bad
    row, because a forecast that skips a plan would be taken for another's.
    """
    _, found = _open(table, source, format)
    plans = []
    for item in found:
        if isinstance(item, DamagedLog):
            raise _told(item, source)
        if isinstance(item, Reading) and item.describes == "flight":
            try:
                plans.append(_plan(item, check_motor))
            except DamagedLog as error:
                raise _told(error, source, item.row) from error
    return plans


def derived_id(flight: Flight, clocks: Sequence[Series] = ()) -> str:
    """A name for a flight that has none: its date and a digest of what was flown and read off, or else of its samples.

    The same figures give the same name in any unit, any order of columns and any table; notes, tags
    and conditions may be edited without changing it.
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


def _open(log: bytes, source: str, format: str | None, choices: Sequence[Choice] = ()) -> tuple[str, Sequence[Found]]:
    """The name of the parser that reads a log, and what it finds in it."""
    name = _format_of(log, format, source, choices)
    parser = parsers()[name]
    try:
        return name, parser.mapped(log, choices) if parser.mapped and choices else parser.read(log)
    except DamagedLog as error:
        raise _told(error, source) from error


MOST_TOLD = 1500
"""A message is no longer than this, whatever a log holds. [characters]"""


def _told(error: DamagedLog, source: str, row: int | None = None) -> DamagedLog:
    """What is wrong with a log as it is shown: with its name, on one line, and harmless for a terminal."""
    column = printable(error.column)[:MOST_TOLD] if error.column else None
    return DamagedLog(printable(error.found)[:MOST_TOLD], row=row or error.row, column=column, source=source)


def _with_figures(found: Sequence[Found], format: str, digest: str) -> Sequence[Found]:
    """What was found in a log, with the readouts of flights that were recorded measured in their samples."""
    with_samples = [id(item) for item in found if isinstance(item, Reading) and item.clocks]
    if not with_samples:
        return found
    told: list[Found] = []
    for item in found:
        if isinstance(item, Reading) and item.clocks and item.describes == "flight":
            told += _recorded(item, format, digest[:10], with_samples.index(id(item)) + 1, len(with_samples))
        else:
            told.append(item)
    return told


def _recorded(reading: Reading, format: str, digest: str, part: int, parts: int) -> list[Found]:
    """A reading with samples as one whose readouts are measured in them, and what is to be said of that.

    Its flight is named after the bytes of its log, so that another way of measuring does not make it another flight;
    the extra columns say which parser reads the log again, and which of its flights this is.
    """
    from fieldkit.recording import columns, measure

    recorded = measure(reading.clocks, reading.events)
    fields, extra = columns(recorded, reading.stated)
    if not fields.get("flight_id"):
        when = fields.get("date_time")
        start = f"{when:%Y-%m-%d}" if isinstance(when, datetime) else "flight"
        fields["flight_id"] = f"{start}-{digest}" + (f"-{part}" if parts > 1 else "")
    told = {"device": reading.device, "firmware": reading.firmware, "serial": reading.serial, "log_format": format}
    if parts > 1:
        told["log_part"] = str(part)
    known = {name: text for name, text in told.items() if text}
    measured = replace(reading, stated=fields, extra={**reading.extra, **extra, **known})
    return [measured, *(Note(text, reading.row) for text in recorded.notes)]


def _intake(
    source: str, format: str, found: Sequence[Found], rockets: Mapping[str, Reading], check_motor: CheckMotor
) -> Intake:
    kept: dict[tuple[str, str], tuple[Flight, int | None]] = {}
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
        except DamagedLog as error:
            told = _told(error, source)
            rejected.append(Rejected(source, told.row, told.column, told.found))
    if found and all(isinstance(item, Reading) and item.describes == "rocket" for item in found):
        notes.append(Note(f"describes {len(found)} rockets and no flight; import it with the flights"))
    if any(isinstance(item, Reading) and item.describes == "simulation" for item in found):
        notes.append(Note(_SIMULATED.format(source)))
    strangers = {item.rocket_key for item in found if isinstance(item, Reading)} - {"", *rockets}
    if strangers:
        notes.append(Note(_STRANGERS.format(len(strangers))))
    lines = (str(_told(DamagedLog(note.text, row=note.row), source)) for note in notes)
    flights, places = zip(*kept.values(), strict=True) if kept else ((), ())
    mapped = tuple(item for item in found if isinstance(item, Mapped))
    return Intake(source, format, flights, tuple(rejected), tuple(lines), places, mapped)


_SIMULATED = "is a simulation and is not taken for a flight; `fieldkit compare FLIGHT {}` puts it beside one"
_STRANGERS = (
    "{} rockets are known by their number alone and have no mass; "
    "import the file that lists the rockets together with this one"
)


def _named(reading: Reading, rockets: Mapping[str, Reading]) -> Reading:
    """A reading with what a list of rockets knows of its rocket; what the log itself states wins."""
    if not reading.rocket_key:
        return reading
    rocket = rockets.get(reading.rocket_key)
    known = rocket.stated if rocket else {"rocket": reading.rocket_key}
    return replace(reading, stated={**known, **reading.stated})


def _keep(flight: Flight, row: int | None, kept: dict[tuple[str, str], tuple[Flight, int | None]]) -> list[Note]:
    """Add a flight to those kept and say what is odd about it. Raises DamagedLog if its name is taken."""
    name = (flight.rocket, flight.flight_id)
    if name not in kept:
        kept[name] = flight, row
        return [Note(phrase, row) for phrase in doubts(flight)]
    first, first_row = kept[name]
    if first != flight:
        found = f"found {shown(flight.flight_id)}, which row {first_row} has for another flight of this rocket"
        raise DamagedLog(found, row=row, column="flight_id")
    return [Note(f"repeats row {first_row}", row)]


def _measured(reading: Reading, check_motor: CheckMotor) -> Flight:
    """The flight that a reading tells of, with a name. Raises DamagedLog if it was never flown."""
    flight = _flight(reading)
    if not (flight.readouts() or flight.log or flight.tags or reading.clocks):
        found = f"found no readout, expected at least one such as {READOUTS[0].header}"
        raise DamagedLog(f"{found}; planned flights are for predict --flights", row=reading.row)
    _check_motor(flight, reading, check_motor)
    return flight if flight.flight_id else flight.with_changes(flight_id=derived_id(flight, reading.clocks))


def _plan(reading: Reading, check_motor: CheckMotor) -> Flight:
    """The planned flight that a reading tells of. Raises DamagedLog if it lacks a motor."""
    flight = _flight(reading)
    if not flight.motor:
        raise DamagedLog("found nothing, expected the motor's name", row=reading.row, column="motor")
    _check_motor(flight, reading, check_motor)
    unread = dict.fromkeys(column.name for column in READOUTS)
    return flight.with_changes(flight_id=flight.flight_id or f"row-{reading.row}", **unread)


def _flight(reading: Reading) -> Flight:
    """What a reading states, as a flight. Raises DamagedLog for a figure that no flight can have."""
    for name, value in reading.stated.items():
        if isinstance(value, float):
            try:
                check(BY_NAME[name], value)
            except BadValue as error:
                raise DamagedLog(str(error), row=reading.row, column=reading.columns.get(name, name)) from error
    return Flight(extra=dict(reading.extra)).with_changes(**reading.stated)


def _check_motor(flight: Flight, reading: Reading, check_motor: CheckMotor) -> None:
    """Raise DamagedLog for a motor nobody makes; several motors at once are not looked up."""
    if not flight.motor or {"cluster", "staged"} & set(flight.tags):
        return
    if complaint := check_motor(flight.motor):
        raise DamagedLog(complaint, row=reading.row, column=reading.columns.get("motor", "motor"))
