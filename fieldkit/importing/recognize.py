"""Select the parser for a log: the one that recognizes it, or the one that the user chose."""

import re
import zipfile
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import chain

from fieldkit import zips
from fieldkit.analysis import rises
from fieldkit.errors import DamagedLog, UnknownFormat, unknown
from fieldkit.flight import BY_NAME, READOUTS
from fieldkit.importing.likeness import Likeness, likeness, nearest, score
from fieldkit.importing.reading import HEAD, ColumnChoice, Mapped, Note, Parsed, Parser, Reading, Recognition
from fieldkit.importing.tables.columns_read import ColumnRead, TableRead, of_series, samples_in, watched
from fieldkit.importing.tables.flight_headings import plain, table_names
from fieldkit.importing.tables.json_columns import columns_table
from fieldkit.importing.tables.labeled_lines import labeled_table
from fieldkit.importing.tables.layout import layout_of
from fieldkit.importing.tables.mapping import choice_for, is_of_flights
from fieldkit.importing.tables.nmea import fixes_table
from fieldkit.importing.tables.other_shapes import reshaped
from fieldkit.importing.tables.spreadsheet import SheetTable, as_csv, is_spreadsheet
from fieldkit.importing.tables.text import MAX_TABLE_SIZE, in_other_encodings, shown
from fieldkit.importing.tables.tracks import track_table
from fieldkit.importing.tables.unnamed import offered_mapping
from fieldkit.importing.tables.wrapped_lines import unstamped, unwrapped
from fieldkit.importing.weather import is_weather
from fieldkit.messages import with_words
from fieldkit.plugins import plugins
from fieldkit.safe_text import printable
from fieldkit.units import UNITS

MOST_LACKING = 4
"""Largest number of signs of a format, or of sheets of a spreadsheet, that a message lists. [1]"""
_OLD_WORKBOOK = bytes.fromhex("d0cf11e0a1b11ae1")
"""What a compound file of Microsoft begins with."""

_COMPRESSED = {b"\x1f\x8b": "gzip", b"BZh": "bzip2", b"\xfd7zXZ": "xz", b"7z\xbc\xaf": "7z", b"Rar!": "rar"}
"""What a compressed file begins with, and its kind."""
_MINUS = "\N{MINUS SIGN}".encode()
_NEGATIVE = re.compile(rb"((?:^|[,;|:=\t\"]|\d[eE]?) *)" + _MINUS + rb"(?=[.,]?\d)", re.MULTILINE)
"""A number with a typographic minus, as spreadsheets of some countries write it, at the beginning of a cell or after
another number. [bytes]"""


def parsers() -> Mapping[str, Parser]:
    """All parsers in the plug-in folders by name, as `--format` accepts it."""
    found = plugins("parsers", "PARSER")
    for name, parser in found.items():
        if not isinstance(parser, Parser):
            raise TypeError(f"PARSER of parsers/{name}.py is not a Parser")
    return found  # type: ignore[return-value]


def check_format(name: str, place: str = "") -> None:
    """Raise UnknownFormat, with the `place` first, for a name that no parser has."""
    if name not in parsers():
        raise UnknownFormat(f"{place}{unknown('format', name, parsers())}")


def parser_for(log: bytes, format: str | None = None) -> Parser:
    """The parser that recognizes a log with the highest score, or the one that `format` names.

    Raises UnknownFormat that names the most similar formats, or the parsers with equal scores.
    """
    return parsers()[_candidates(log, format, "")[0]]


def claims(log: bytes) -> list[str]:
    """Names of the parsers that recognize a log, highest score first; fallbacks only if no other does."""
    known = parsers()
    for fallback in (False, True):
        claimed = [name for name, p in known.items() if p.fallback is fallback and _claims(p, log[:HEAD])]
        if claimed:
            return sorted(claimed, key=lambda name: score(known[name], log), reverse=True)
    return []


def _candidates(
    log: bytes,
    format: str | None,
    source: str,
    choices: Sequence[ColumnChoice] = (),
    claimed: list[str] | None = None,
) -> list[str]:
    """Names of the parsers to try, highest score first; if the user maps the columns, one that accepts a mapping.

    `claimed` are those that recognize the log, if known.
    """
    mapped = any(not choice.headers for choice in choices)
    place, known, kind = f"{source}: " if source else "", parsers(), _kind_of(log, choices)
    takers = [name for name, parser in known.items() if parser.mapped and parser.maps == kind]
    if format is not None:
        check_format(format, place)
        claimed = [format]
    elif claimed is None:
        claimed = claims(log)
    chosen = mapped or _chosen(log, choices) is not None
    if chosen and (not claimed or (known[claimed[0]].fallback and claimed[0] not in takers)):
        claimed = [name for name in takers if known[name].fallback or kind == "flights"]
    if not claimed:
        raise UnknownFormat(f"{place}no parser recognizes this file{_near(log)}{_hint(log)}")
    if len(claimed) > 1 and score(known[claimed[0]], log) == score(known[claimed[1]], log):
        both = " and ".join(sorted(claimed[:2]))
        raise UnknownFormat(f"{place}{both} both recognize this file; choose one with --format")
    if mapped and claimed[0] not in takers:
        expected = f"expected no mapping, or --format {' or '.join(takers)} with it"
        raise UnknownFormat(f"{place}found a column mapping for a log that {claimed[0]} reads without one; {expected}")
    if format is not None or known[claimed[0]].fallback:
        return claimed[:1]
    return claimed + [name for name, parser in known.items() if parser.fallback and _claims(parser, log[:HEAD])]


def _near(log: bytes) -> str:
    """The formats most similar to a file, and what the file lacks for each."""
    known = parsers()
    near = "; ".join(f"{known[name].title} ({name}) {_lacks(like)}" for name, like in nearest(known, log))
    return f"; most similar: {near}" if near else ", and no known format is similar"


def _lacks(like: Likeness) -> str:
    if not like.missing:
        return "has its column names but not its structure"
    return "lacks " + ", ".join(map(repr, like.missing[:MOST_LACKING]))


def _chosen(log: bytes, choices: Sequence[ColumnChoice]) -> ColumnChoice | None:
    """The user's mapping for such a table of samples or of flights."""
    if not choices:
        return None
    try:
        found = choice_for(table_names(log[:HEAD]), [one for one in choices if is_of_flights(one)])
        return found or choice_for(layout_of(log[:HEAD]).saved_names, choices)
    except DamagedLog:  # not a table, so none that was mapped
        return None


def _kind_of(log: bytes, choices: Sequence[ColumnChoice]) -> str:
    """Whether the mapping for a table is of samples or of flights."""
    choice = _chosen(log, choices)
    return "flights" if choice is not None and is_of_flights(choice) else "samples"


def _hint(log: bytes) -> str:
    """Advice about a log that no parser recognizes, if there is any."""
    if log.startswith(b"PK\x03\x04"):
        return f"; it is an archive{_archive_advice(log)}"
    if log.startswith(_OLD_WORKBOOK):
        return "; it is a workbook of an old Excel (.xls); save it as .xlsx or CSV"
    if packed := next((name for magic, name in _COMPRESSED.items() if log.startswith(magic)), ""):
        return f"; it is compressed ({packed}); unpack it first"
    start = log[:HEAD]
    if is_weather(start):
        return "; it is saved weather, which `fieldkit weather FILE` fills in"
    if len(log) > MAX_TABLE_SIZE:
        return f"; tracks, JSON and labeled lines of more than {MAX_TABLE_SIZE >> 20} MB are not read: cut it"
    if start.lstrip(b"\xef\xbb\xbf \r\n").startswith(b"<"):
        return "; it is XML, such as a track for maps; export a table (CSV) instead"
    if offered := offered_mapping(log):
        return "; its columns have no names, by their numbers it is read with " + " ".join(
            f"--map '{one}'" for one in offered
        )
    if b"\0" not in start and any(start.count(mark) > 4 for mark in (b",", b";", b"\t")):
        time, height, motor = ("#1", "#2", "#3") if _is_without_names(start) else ("its column",) * 3
        samples = f"a table of samples is read with --map 'time={time}' --map 'altitude={height} [m]'"
        samples += ", or without a clock with --map 'time=20 Hz'" * (time != "#1")
        flights = f"one of flights with --map 'motor={motor}' --map 'apogee={height} [m]'"
        return f"; {samples}, {flights}" + ", by the numbers of its columns" * (time == "#1")
    return ""


def _archive_advice(log: bytes) -> str:
    """What to do about an archive that is no spreadsheet."""
    try:
        with zips.opened(log):
            return "; unpack it first"
    except (zipfile.BadZipFile, OSError, ValueError, RuntimeError, NotImplementedError) as error:
        return f" that cannot be opened ({error}); download or save it again"


def _is_without_names(head: bytes) -> bool:
    """Whether a file is a table of numbers without a line of names."""
    try:
        return not layout_of(head).named
    except DamagedLog:
        return False


def _claims(parser: Parser, head: bytes) -> bool:
    try:
        return parser.recognises(head)
    except DamagedLog:
        return False


@dataclass(frozen=True, slots=True)
class ParsedLog:
    """A log as read by one parser, with its name: what it found, why it was chosen, and the columns used."""

    format: str
    found: Sequence[Parsed]
    recognition: Recognition


def open_log(log: bytes, source: str, format: str | None, choices: Sequence[ColumnChoice] = ()) -> ParsedLog:
    """Read a log with the highest-scoring parser that finds a flight in it.

    If none does, or a simulator's parser cannot read it, the result is that of the highest-scoring parser. Raises
    UnknownFormat, or that parser's DamagedLog.
    """
    sheet, claimed = _sheet_of(log, source)
    log, others = sheet.content, sheet.others
    try:
        names = _candidates(log, format, source, choices, claimed)
    except DamagedLog as error:
        raise shown_damage(error, source) from error
    tried: list[ParsedLog | DamagedLog] = []
    for name in names:
        try:
            opened = _opened(log, name, format, choices)
        except DamagedLog as error:
            tried.append(error)
            if parsers()[name].simulates:
                break  # whatever another parser finds in this was never flown
            continue
        if len(names) == 1 or holds_flight(opened.found):
            return _beside(_instead(opened, names[: len(tried)], tried), others)
        tried.append(opened)
    first = tried[0]
    if isinstance(first, DamagedLog):
        raise shown_damage(first, source) from first
    return _beside(first, others)


def _beside(opened: ParsedLog, others: Sequence[str]) -> ParsedLog:
    """The opened log with a note about other sheets of its spreadsheet that hold tables."""
    if not others:
        return opened
    names = ", ".join(map(shown, others[:MOST_LACKING]))
    if len(others) > MOST_LACKING:
        names += f" and {len(others) - MOST_LACKING} more"
    note = Note(
        f"only one sheet is read; {names} also {'holds' if len(others) == 1 else 'hold'} a table: save it as CSV"
    )
    return replace(opened, found=[*opened.found, note])


def table_of(log: bytes, source: str) -> bytes:
    """The text that parsers read from a log: see `_sheet_of`. Raises DamagedLog."""
    return _sheet_of(log, source)[0].content


def _with_ascii_minus(log: bytes) -> bytes:
    """A log whose negative numbers have the minus of a keyboard; other texts keep theirs."""
    return _NEGATIVE.sub(rb"\1-", log) if _MINUS in log else log


def _sheet_of(log: bytes, source: str) -> tuple[SheetTable, list[str] | None]:
    """A log without wrapped lines, or as CSV: a spreadsheet, fixes, a track, JSON or labeled lines; and the names of
    the parsers that recognize it, if they had to be asked. Raises DamagedLog."""
    if not is_spreadsheet(log):
        log = _with_ascii_minus(unwrapped(log))
        table = fixes_table(log) or track_table(log) or columns_table(log) or labeled_table(log)
        claimed = claims(log)
        if table is not None:
            return (SheetTable(log), claimed) if claimed else (SheetTable(table), None)
        for one in chain(unstamped(log) or (), () if claimed else in_other_encodings(log)):
            if own := claims(one):
                return SheetTable(one), own
        if not claimed and (other := reshaped(log)) and (own := claims(other)):
            return SheetTable(other), own
        return SheetTable(log), claimed
    try:
        return as_csv(log, lambda sheet: bool(claims(sheet))), None
    except DamagedLog as error:
        raise shown_damage(error, source) from error


def _opened(log: bytes, name: str, format: str | None, choices: Sequence[ColumnChoice]) -> ParsedLog:
    """Read a log with one parser. Raises DamagedLog."""
    parser = parsers()[name]
    with watched() as tables:
        found = parser.mapped(log, choices) if parser.mapped and choices else parser.read(log)
    return ParsedLog(
        name, found, replace(_recognition(found, tables), title=parser.title, why=_why(parser, log, found, format))
    )


def holds_flight(found: Sequence[Parsed]) -> bool:
    """Whether a parser found a flight: stated values, or samples that rise like a rocket."""
    return any(isinstance(item, Reading) and _is_flight(item) for item in found)


def _is_flight(reading: Reading) -> bool:
    if reading.describes != "flight" or reading.part or not reading.clocks:
        return True
    return any(isinstance(reading.stated.get(c.name), float) for c in READOUTS) or rises(reading.clocks)


def _instead(opened: ParsedLog, names: Sequence[str], tried: Sequence[ParsedLog | DamagedLog]) -> ParsedLog:
    """The opened log with a note about each higher-scoring parser that found no flight in it."""
    notes = [
        Note(f"{parsers()[name].title} recognizes it and {_made(one)}; read as {parsers()[opened.format].title}")
        for name, one in zip(names, tried, strict=True)
    ]
    return replace(opened, found=[*opened.found, *notes]) if notes else opened


def _made(one: "ParsedLog | DamagedLog") -> str:
    return f"cannot read it ({one.found})" if isinstance(one, DamagedLog) else "finds no flight in it"


def _why(parser: Parser, log: bytes, found: Sequence[Parsed], format: str | None) -> str:
    """Why a parser was chosen, as a phrase."""
    if format is not None:
        return "chosen with --format"
    if any(isinstance(item, Mapped) and item.choice.channels for item in found):
        return "its columns were mapped"
    if parser.fallback:
        shown_by = "numbers" if _is_without_names(log[:HEAD]) else "names"
        return f"no logger's parser recognizes it, and its columns have the {shown_by} of a table of samples"
    like = likeness(parser, log)
    signs = ", ".join(map(repr, like.found[:MOST_LACKING]))
    return f"it has {signs}" if signs else "it has the structure of this format"


def _recognition(found: Sequence[Parsed], tables: Sequence[TableRead]) -> Recognition:
    """How a log was read: from the tables read, or without any from what was found."""
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
    columns_read = [_stated_column(field, name) for field, name in named.items()]
    used = {column.name for column in columns_read}
    extra = dict.fromkeys(name for item in readings for name in item.extra if name not in {*used, *named})
    columns_read += [ColumnRead(name, "", "", "text") for name in extra]
    return Recognition(columns=tuple(columns_read), rows=len(readings), dropped=damaged)


def _stated_column(field: str, name: str) -> ColumnRead:
    """A column of a flight table or of a summary: its name in the file, otherwise fieldkit's own name."""
    column = BY_NAME.get(field)
    ending = plain(name).rpartition("_")[2]
    unit = "" if column is None else ending if ending in UNITS[column.quantity] else column.unit
    return ColumnRead(name or (column.header if column else field), field, unit, "stated")


MAX_REPORTED = 1500
"""Largest length of a message, whatever a log contains. [characters]"""


def shown_damage(error: DamagedLog, source: str, row: int | None = None) -> DamagedLog:
    """An error about a damaged log ready for display: with the log's name, on one line, safe for a terminal."""
    column = printable(error.column)[:MAX_REPORTED] if error.column else None
    found = with_words(error.found, printable)
    found = found if len(found) <= MAX_REPORTED else found[:MAX_REPORTED]
    return DamagedLog(found, row=row or error.row, column=column, source=source)
