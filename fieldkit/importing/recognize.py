"""Which parser reads a log: the one that recognises it, or the one that the flyer names."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from fieldkit.errors import DamagedLog, UnknownFormat
from fieldkit.flight import BY_NAME
from fieldkit.importing.reading import HEAD, Choice, Found, Mapped, Parser, Reading, Recognition
from fieldkit.importing.tables.columns_read import ColumnRead, TableRead, of_series, samples_in, watched
from fieldkit.importing.tables.mapping import choice_for
from fieldkit.plugins import plugins
from fieldkit.safe_text import printable


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
    head, shelf = log[:HEAD], parsers()
    for fallback in (False, True):
        if claimed := [name for name, p in shelf.items() if p.fallback is fallback and _claims(p, head)]:
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
    from fieldkit.importing.tables.layout import layout_of

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


@dataclass(frozen=True, slots=True)
class Opened:
    """A log as one parser, by its name, read it: what it found, why it was taken, and the columns it used."""

    format: str
    found: Sequence[Found]
    recognition: Recognition


def open_log(log: bytes, source: str, format: str | None, choices: Sequence[Choice] = ()) -> Opened:
    """A log as the parser reads it that recognises it. Raises UnknownFormat or DamagedLog."""
    name = _format_of(log, format, source, choices)
    parser = parsers()[name]
    with watched() as tables:
        try:
            found = parser.mapped(log, choices) if parser.mapped and choices else parser.read(log)
        except DamagedLog as error:
            raise told(error, source) from error
    return Opened(name, found, _recognition(_why(parser, found, format), found, tables))


def _why(parser: Parser, found: Sequence[Found], format: str | None) -> str:
    """Why a parser was taken, in a phrase."""
    if format is not None:
        return "named with --format"
    if any(isinstance(item, Mapped) and item.choice.channels for item in found):
        return "its columns were named for it"
    if parser.fallback:
        return "no logger's parser recognizes it, and its columns are named as those of a table of samples"
    return f"it begins as a file of {parser.title} does"


def _recognition(why: str, found: Sequence[Found], tables: Sequence[TableRead]) -> Recognition:
    """How a log was read: by the tables that were read of it, or where there is none by what was found."""
    readings = [item for item in found if isinstance(item, Reading)]
    damaged = sum(isinstance(item, DamagedLog) for item in found)
    if tables:
        columns = dict.fromkeys(column for table in tables for column in table.columns)
        dropped = max(damaged, sum(table.dropped for table in tables))
        return Recognition(why, tuple(columns), sum(table.rows for table in tables), dropped)
    clocks = [series for item in readings for series in item.clocks]
    if clocks:
        return Recognition(why, of_series(clocks), samples_in(clocks), damaged)
    named = {
        field: name for item in readings for field, name in {**dict.fromkeys(item.stated, ""), **item.columns}.items()
    }
    columns_read = (_stated_column(field, name) for field, name in named.items())
    return Recognition(why, tuple(columns_read), len(readings), damaged)


def _stated_column(field: str, name: str) -> ColumnRead:
    """A column of a flight table, or what a summary states: its name there, else fieldkit's own."""
    column = BY_NAME.get(field)
    unit = column.unit if column else ""
    return ColumnRead(name or (column.header if column else field), field, unit, "stated")


MOST_TOLD = 1500
"""A message is no longer than this, whatever a log holds. [characters]"""


def told(error: DamagedLog, source: str, row: int | None = None) -> DamagedLog:
    """What is wrong with a log as it is shown: with its name, on one line, and harmless for a terminal."""
    column = printable(error.column)[:MOST_TOLD] if error.column else None
    return DamagedLog(printable(error.found)[:MOST_TOLD], row=row or error.row, column=column, source=source)
