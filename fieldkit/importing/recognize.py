"""Which parser reads a log: the one that recognizes it, or the one that the user chose."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

from fieldkit.errors import DamagedLog, UnknownFormat
from fieldkit.flight import BY_NAME, READOUTS
from fieldkit.importing.likeness import Likeness, likeness, nearest, score
from fieldkit.importing.reading import HEAD, ColumnChoice, Found, Mapped, Note, Parser, Reading, Recognition
from fieldkit.importing.tables.columns_read import ColumnRead, TableRead, of_series, samples_in, watched
from fieldkit.importing.tables.flight_headings import plain, table_names
from fieldkit.importing.tables.mapping import choice_for, is_of_flights
from fieldkit.importing.tables.spreadsheet import as_csv, is_spreadsheet
from fieldkit.plugins import plugins
from fieldkit.safe_text import printable
from fieldkit.units import UNITS

MOST_LACKING = 4
"""Number of signs of a format that are named. [1]"""


def parsers() -> Mapping[str, Parser]:
    """Every parser in the plug-in folders, by the name that `--format` takes."""
    found = plugins("parsers", "PARSER")
    for name, parser in found.items():
        if not isinstance(parser, Parser):
            raise TypeError(f"PARSER of parsers/{name}.py is not a Parser")
    return found  # type: ignore[return-value]


def recognise(log: bytes, format: str | None = None, source: str = "") -> Parser:
    """The parser that recognizes a log most surely, or the one that `format` names.

    Raises UnknownFormat that names the nearest formats, or the parsers that claim the log equally.
    """
    return parsers()[_candidates(log, format, source)[0]]


def claims(log: bytes) -> list[str]:
    """The names of the parsers that recognize a log, most certain first; fallbacks only if no other does."""
    shelf = parsers()
    for fallback in (False, True):
        claimed = [name for name, p in shelf.items() if p.fallback is fallback and _claims(p, log[:HEAD])]
        if claimed:
            return sorted(claimed, key=lambda name: score(shelf[name], log), reverse=True)
    return []


def _candidates(log: bytes, format: str | None, source: str, choices: Sequence[ColumnChoice] = ()) -> list[str]:
    """The parsers to try, by name, most certain first; if the user maps the columns, one that accepts a mapping."""
    mapped = any(not choice.headers for choice in choices)
    place = f"{source}: " if source else ""
    shelf = parsers()
    kind = _kind_of(log, choices)
    takers = [name for name, parser in shelf.items() if parser.mapped and parser.maps == kind]
    if format is not None:
        if format not in shelf:
            raise UnknownFormat(f"{place}no parser is called {format!r}, expected one of {', '.join(shelf)}")
        claimed = [format]
    else:
        claimed = claims(log)
    chosen = mapped or _chosen(log, choices) is not None
    if chosen and (not claimed or (shelf[claimed[0]].fallback and claimed[0] not in takers)):
        claimed = [name for name in takers if shelf[name].fallback or kind == "flights"]
    if not claimed:
        raise UnknownFormat(f"{place}no parser recognizes this file{_near(log)}{_hint(log)}")
    if len(claimed) > 1 and score(shelf[claimed[0]], log) == score(shelf[claimed[1]], log):
        both = " and ".join(sorted(claimed[:2]))
        raise UnknownFormat(f"{place}{both} both recognize this file; choose one with --format")
    if mapped and claimed[0] not in takers:
        expected = f"expected no mapping, or --format {' or '.join(takers)} with it"
        raise UnknownFormat(f"{place}found a column mapping for a log that {claimed[0]} reads without one; {expected}")
    if format is not None or shelf[claimed[0]].fallback:
        return claimed[:1]
    return claimed + [name for name, parser in shelf.items() if parser.fallback and _claims(parser, log[:HEAD])]


def _near(log: bytes) -> str:
    """The most similar formats of a file, and what it lacks for each."""
    shelf = parsers()
    near = (f"{shelf[name].title} ({name}) {_lacks(like)}" for name, like in nearest(shelf, log))
    shown_damage = "; ".join(near)
    return f"; most similar: {shown_damage}" if shown_damage else ", and no known format is similar"


def _lacks(like: Likeness) -> str:
    if not like.missing:
        return "has its column names but not its structure"
    return "lacks " + ", ".join(map(repr, like.missing[:MOST_LACKING]))


def _chosen(log: bytes, choices: Sequence[ColumnChoice]) -> ColumnChoice | None:
    """The user's mapping for such a table, of samples or of flights."""
    from fieldkit.importing.tables.layout import layout_of

    found = choice_for(table_names(log[:HEAD]), [one for one in choices if is_of_flights(one)]) if choices else None
    if found is not None or not choices:
        return found
    try:
        return choice_for(layout_of(log[:HEAD]).headers, choices)
    except DamagedLog:
        return None


def _kind_of(log: bytes, choices: Sequence[ColumnChoice]) -> str:
    """Whether the mapping for a table is of samples or of flights."""
    choice = _chosen(log, choices)
    return "flights" if choice is not None and is_of_flights(choice) else "samples"


def _hint(log: bytes) -> str:
    """What to do about a log that no parser recognizes, if known."""
    if log.startswith(b"PK\x03\x04"):
        return "; it is an archive; unpack it first"
    start = log[:HEAD]
    if b"\0" not in start and any(start.count(mark) > 4 for mark in (b",", b";", b"\t")):
        samples = "a table of samples is read with --map 'time=its column' --map 'altitude=its column [m]'"
        return f"; {samples}, one of flights with --map 'motor=its column' --map 'apogee=its column [m]'"
    return ""


def _claims(parser: Parser, head: bytes) -> bool:
    try:
        return parser.recognises(head)
    except DamagedLog:
        return False


@dataclass(frozen=True, slots=True)
class ParsedLog:
    """A log as read by one parser, named: what it found, why that parser, and the columns used."""

    format: str
    found: Sequence[Found]
    recognition: Recognition


def open_log(log: bytes, source: str, format: str | None, choices: Sequence[ColumnChoice] = ()) -> ParsedLog:
    """A log as the parser reads it that recognizes it most surely and finds a flight in it.

    If none of those that recognize it does, it is as the surest one has it. Raises UnknownFormat, or the DamagedLog
    of that one.
    """
    log = table_of(log, source)
    names = _candidates(log, format, source, choices)
    tried: list[ParsedLog | DamagedLog] = []
    for name in names:
        try:
            opened = _opened(log, name, format, choices)
        except DamagedLog as error:
            tried.append(error)
            if parsers()[name].simulates:
                break  # what another parser took for a flight was never flown
            continue
        if len(names) == 1 or holds_flight(opened.found):
            return _instead(opened, names[: len(tried)], tried)
        tried.append(opened)
    first = tried[0]
    if isinstance(first, DamagedLog):
        raise shown_damage(first, source) from first
    return first


def table_of(log: bytes, source: str) -> bytes:
    """A log as it is, or the sheet of a spreadsheet as CSV. Raises DamagedLog."""
    if not is_spreadsheet(log):
        return log
    try:
        return as_csv(log, lambda sheet: bool(claims(sheet)))
    except DamagedLog as error:
        raise shown_damage(error, source) from error


def _opened(log: bytes, name: str, format: str | None, choices: Sequence[ColumnChoice]) -> ParsedLog:
    """A log as one parser reads it. Raises DamagedLog."""
    parser = parsers()[name]
    with watched() as tables:
        found = parser.mapped(log, choices) if parser.mapped and choices else parser.read(log)
    return ParsedLog(
        name, found, replace(_recognition(found, tables), title=parser.title, why=_why(parser, log, found, format))
    )


def holds_flight(found: Sequence[Found]) -> bool:
    """Whether a parser found a flight: stated values, or samples that rise like a rocket."""
    return any(isinstance(item, Reading) and _is_flight(item) for item in found)


def _is_flight(reading: Reading) -> bool:
    from fieldkit.analysis import rises

    if reading.describes != "flight" or reading.part or not reading.clocks:
        return True
    return any(isinstance(reading.stated.get(c.name), float) for c in READOUTS) or rises(reading.clocks)


def _instead(opened: ParsedLog, names: Sequence[str], tried: Sequence[ParsedLog | DamagedLog]) -> ParsedLog:
    """What was opened, with a note of each parser that recognizes it more surely and made nothing of it."""
    notes = [
        Note(f"{parsers()[name].title} recognizes it and {_made(one)}; read as {parsers()[opened.format].title}")
        for name, one in zip(names, tried, strict=True)
    ]
    return replace(opened, found=[*opened.found, *notes]) if notes else opened


def _made(one: "ParsedLog | DamagedLog") -> str:
    return f"cannot read it ({one.found})" if isinstance(one, DamagedLog) else "finds no flight in it"


def _why(parser: Parser, log: bytes, found: Sequence[Found], format: str | None) -> str:
    """Why a parser was chosen, as a phrase."""
    if format is not None:
        return "chosen with --format"
    if any(isinstance(item, Mapped) and item.choice.channels for item in found):
        return "its columns were mapped"
    if parser.fallback:
        return "no logger's parser recognizes it, and its columns have the names of a table of samples"
    like = likeness(parser, log)
    signs = ", ".join(map(repr, like.found[:MOST_LACKING]))
    return f"it has {signs}, like {parser.title} files" if signs else f"it has the structure of {parser.title} files"


def _recognition(found: Sequence[Found], tables: Sequence[TableRead]) -> Recognition:
    """How a log was read: by the tables read from it, or without any by what was found."""
    readings = [item for item in found if isinstance(item, Reading)]
    damaged = sum(isinstance(item, DamagedLog) for item in found)
    if tables:
        simulated = any(item.describes == "simulation" for item in readings)
        columns = dict.fromkeys(
            replace(column, source="simulation") if simulated and column.source != "clock" else column
            for table in tables
            for column in table.columns
        )
        dropped = max(damaged, sum(table.dropped for table in tables))
        return Recognition(columns=tuple(columns), rows=sum(table.rows for table in tables), dropped=dropped)
    clocks = [series for item in readings for series in item.clocks]
    if clocks:
        return Recognition(columns=of_series(clocks), rows=samples_in(clocks), dropped=damaged)
    named = {
        field: name for item in readings for field, name in {**dict.fromkeys(item.stated, ""), **item.columns}.items()
    }
    columns_read = (_stated_column(field, name) for field, name in named.items())
    return Recognition(columns=tuple(columns_read), rows=len(readings), dropped=damaged)


def _stated_column(field: str, name: str) -> ColumnRead:
    """A column of a flight table or of a summary: its name there, else fieldkit's own."""
    column = BY_NAME.get(field)
    ending = plain(name).rpartition("_")[2]
    unit = "" if column is None else ending if ending in UNITS[column.quantity] else column.unit
    return ColumnRead(name or (column.header if column else field), field, unit, "stated")


MAX_REPORTED = 1500
"""Longest message, whatever a log contains. [character]"""


def shown_damage(error: DamagedLog, source: str, row: int | None = None) -> DamagedLog:
    """An error of a damaged log as it is shown: with the log's name, on one line, safe for a terminal."""
    column = printable(error.column)[:MAX_REPORTED] if error.column else None
    return DamagedLog(printable(error.found)[:MAX_REPORTED], row=row or error.row, column=column, source=source)
