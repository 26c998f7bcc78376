"""From the bytes of a log or a table to flights.

A parser says whether it recognises a log and reads it into `Reading`s: what the log states, nothing
derived. What holds for every logger alike happens once, here: bounds, motor names, identities, flights
that come twice, rockets that are described in another file.
"""

import hashlib
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, fields, replace
from datetime import datetime, time, timedelta
from pathlib import Path
from typing import Literal

from fieldkit.arrival import OTHER_LOGS, digest_of
from fieldkit.errors import BadValue, DamagedLog, UnknownFormat
from fieldkit.flight import BY_NAME, READOUTS, Flight, Series
from fieldkit.logtext import shown
from fieldkit.mapping import Choice, choice_for
from fieldkit.safe_text import printable
from fieldkit.sanity import check, doubts
from fieldkit.shelf import plugins

SAME_MOMENT = timedelta(seconds=2)
"""Files of one logger that state the same lift-off to within this are of one flight."""
HEAD = 65_536
"""How much of a log a parser sees when it is asked whether it recognises it. [bytes]"""


@dataclass(frozen=True, slots=True)
class Reading:
    """One flight as a log states it, or one rocket of a list of rockets.

    `stated` maps fields of `Flight` to SI values or texts, `columns` the same fields to the names that
    this log has for them (for messages). `rocket_key` is the log's own name of the rocket, by which a list of
    rockets read together with it adds what it knows. `series` holds the samples where there are any, a `Series`
    for each clock of the log; `events` maps what the logger itself marked, in `EVENTS`' words where there is one,
    to seconds on the first of these clocks. A simulation is a flight that nobody flew: it can be compared
    with a flight and is never taken into the ledger. `part` is the kind of file, where a logger writes several
    for one flight; their clocks then share one zero, and those read together become one reading.
    """

    stated: Mapping[str, object] = field(default_factory=dict)
    extra: Mapping[str, str] = field(default_factory=dict)
    columns: Mapping[str, str] = field(default_factory=dict)
    row: int | None = None
    describes: Literal["flight", "rocket", "simulation"] = "flight"
    rocket_key: str = ""
    series: Series | tuple[Series, ...] = ()
    events: Mapping[str, float] = field(default_factory=dict)
    device: str = ""
    firmware: str = ""
    serial: str = ""
    part: str = ""

    @property
    def clocks(self) -> tuple[Series, ...]:
        """The samples, a `Series` for each clock of the log."""
        return (self.series,) if isinstance(self.series, Series) else self.series


EVENTS = ("liftoff", "burnout", "apogee", "ejection", "drogue", "main", "landing")
"""What most loggers mark; `drogue` and `main` are outputs of a logger, `ejection` is the motor's own charge."""


@dataclass(frozen=True, slots=True)
class Note:
    """Something the flyer should know about a log, which keeps nothing out of the ledger."""

    text: str
    row: int | None = None


@dataclass(frozen=True, slots=True)
class Mapped(Note):
    """Which columns of a table are read as what: for the flyer to see, and to be remembered if it was chosen."""

    choice: Choice = Choice({})
    chosen: bool = False


Found = Reading | DamagedLog | Note
"""What a parser finds in a log: readings, rows that are damaged (and cost only themselves), notes."""


@dataclass(frozen=True, slots=True)
class Parser:
    """One logger or table format.

    `recognises` sees the first `HEAD` bytes; raising DamagedLog there means no. `read` gets the whole
    log, and raises DamagedLog when nothing of it can be used. A `fallback` knows no logger: it is asked
    about a log that no other parser recognises, so it never takes one from a parser that knows better.
    `mapped` is `read` with what the flyer says of the columns, best choice first, where a format wants that.
    """

    title: str
    recognises: Callable[[bytes], bool]
    read: Callable[[bytes], Sequence[Found]]
    fallback: bool = False
    mapped: Callable[[bytes, Sequence[Choice]], Sequence[Found]] | None = None


@dataclass(frozen=True, slots=True)
class Rejected:
    """A row that did not become a flight, and why."""

    file: str
    row: int | None
    column: str | None
    error: str


@dataclass(frozen=True, slots=True)
class Intake:
    """What one file brought: flights and the rows they are from, rows that are none, what one should know."""

    source: str
    format: str
    flights: tuple[Flight, ...]
    rejected: tuple[Rejected, ...]
    notes: tuple[str, ...]
    rows: tuple[int | None, ...]
    mapped: tuple[Mapped, ...] = ()


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
        for (source, name, found), digest in zip(_joined([one for one, _ in read], digests), digests, strict=True)
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


Opened = tuple[str, str, Sequence[Found]]
"""A file as it was opened: its name, the parser, what that found."""


def _joined(opened: Sequence[Opened], digests: Sequence[str]) -> list[Opened]:
    """Files in which the parts of each flight are one reading; the files of the other parts say where it is.

    The one reading names the digests of the other files. A part that has no other says that it may have.
    """
    places = [(i, item) for i, (_, _, found) in enumerate(opened) for item in found if isinstance(item, Reading)]
    groups: list[list[tuple[int, Reading]]] = []
    for place in (place for place in places if place[1].part):
        same = [other for group in groups for other in group if _folder(opened, other) == _folder(opened, place)]
        fitting = [group for group in groups if all(_are_parts(place, other, same) for other in group)]
        fitting[0].append(place) if len(fitting) == 1 else groups.append([place])
    found = [list(items) for _, _, items in opened]
    for group in groups:
        (home, main), *others = sorted(group, key=lambda place: _worth(place[1]))
        if not others:
            found[home].append(Note(_PART.format(main.part, main.device), main.row))
            continue
        whole = _whole(main, [other for _, other in others])
        named = dict.fromkeys(digests[i] for i, _ in others)
        whole = replace(whole, extra={**whole.extra, OTHER_LOGS: " ".join(named)})
        found[home] = [whole if item is main else item for item in found[home]]
        for i, other in others:
            note = Note(f"is part of the flight of {opened[home][0]}")
            found[i] = [note if item is other else item for item in found[i]]
    return [(source, format, items) for (source, format, _), items in zip(opened, found, strict=True)]


_PART = "is the {} file of a flight by {}; its other files count where they are imported with it, in one command"


def _worth(part: Reading) -> int:
    """Which part of a flight to name it by: one with heights, else one with samples, else any."""
    return 0 if any(series.altitude is not None for series in part.clocks) else 1 if part.clocks else 2


def _folder(opened: Sequence[Opened], place: tuple[int, Reading]) -> tuple[str, Path]:
    return place[1].device, Path(opened[place[0]][0]).parent


def _are_parts(place: tuple[int, Reading], other: tuple[int, Reading], same: Sequence[tuple[int, Reading]]) -> bool:
    """Whether two readings of files, among others of one folder, can be of one flight."""
    one, two = place[1], other[1]
    if other not in same or place[0] == other[0] or one.part == two.part or len({one.serial, two.serial} - {""}) > 1:
        return False
    first, second = one.stated.get("date_time"), two.stated.get("date_time")
    if not isinstance(first, datetime) or not isinstance(second, datetime):
        return all(one.part != third.part for _, third in same)
    if time() in (first.time(), second.time()):
        return first.date() == second.date()
    return abs(first - second) < SAME_MOMENT


def _whole(main: Reading, others: Sequence[Reading]) -> Reading:
    """One reading of its parts; where they differ the first counts."""
    parts = [*reversed(others), main]
    return replace(
        main,
        stated={name: value for part in parts for name, value in part.stated.items()},
        extra={name: value for part in parts for name, value in part.extra.items()},
        events={name: when for part in parts for name, when in part.events.items()},
        series=tuple(series for part in (main, *others) for series in part.clocks),
        firmware=next((part.firmware for part in (main, *others) if part.firmware), ""),
        serial=next((part.serial for part in (main, *others) if part.serial), ""),
        part="",
    )


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
