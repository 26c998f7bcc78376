"""Text from a log's bytes, and rows from a text, regardless of the program that wrote them.

Loggers and spreadsheets write UTF-8 with or without a byte order mark, UTF-16, or the old Windows code page, and pad
with NUL. Row numbers are those that a spreadsheet displays: the first row is 1, blank rows count, and a quoted cell
with line breaks is still one row.
"""

import codecs
import csv
import io
from collections.abc import Iterator, Sequence
from contextlib import suppress
from itertools import chain, islice, pairwise, zip_longest

from fieldkit.errors import DamagedLog, nearest
from fieldkit.quantities import counted
from fieldkit.units import is_unit

BLOCK = 1 << 19
"""Size of the part of a log that is decoded at a time, and the longest line; the first part is a small fraction of it,
because often only the first lines are needed. [bytes]"""
ENDLESS_LINE_MARK = "\0"
"""Start of what replaces a line longer than a block."""


MAX_TABLE_SIZE = 32 << 20
"""Largest size of a table with a row for each flight, or of anything read in one piece: about 100,000 flights with all
their readouts. [bytes]"""
MAX_TABLE_LINES = 500_000
"""Largest number of lines of such a table: short damaged ones take most time and memory. [1]"""

MAX_REREAD = 20
"""How often on average the lines of a table may be read again after an unmatched quotation mark, which may seem to end
only lines later: otherwise the time would grow with the square of the length. [1]"""

MOST_NULS = 0.01
"""Largest fraction of NULs in a text, in case some of it was lost. [1]"""
MOST_WIDE = 32 << 20
"""Largest size of a UTF-16 log that has to be converted in one piece. [bytes]"""


def decode_whole(log: bytes) -> str:
    """The text of a log that is read in one piece. Raises DamagedLog for a long one, or for bytes that are not text."""
    if len(log) > MAX_TABLE_SIZE:
        raise _too_large(f"{len(log) >> 20} MB", f"{MAX_TABLE_SIZE >> 20}")
    return decode(log)


def check_count(lines: int) -> None:
    """Raise DamagedLog for more lines, or flights, than are read in one piece."""
    if lines > MAX_TABLE_LINES:
        raise _too_large(counted(lines, "line"), f"{MAX_TABLE_LINES:,}")


def _too_large(found: str, most: str) -> DamagedLog:
    return DamagedLog(f"found {found}, expected at most {most} in a table of flights; split it, or export by rocket")


def decode(log: bytes) -> str:
    """The text of a log: UTF-16 or UTF-8, each line that is not UTF-8 in cp1252.

    NUL padding at the end is dropped, and so is a last character that was cut in two; a few NULs elsewhere remain.
    Raises DamagedLog for bytes that are not text.
    """
    while log.startswith(codecs.BOM_UTF8):
        log = log[len(codecs.BOM_UTF8) :]
    encoding = encoding_of(log[:2])
    try:
        text = codecs.getincrementaldecoder(encoding)().decode(log)
    except UnicodeDecodeError as error:
        if encoding != "utf-8":
            raise DamagedLog("found binary data, expected text") from error
        text = "\n".join(_line(line, row) for row, line in enumerate(log.split(b"\n"), start=1))
    text = text.lstrip("\ufeff").rstrip("\0")
    if text.count("\0") > len(text) * MOST_NULS:
        raise DamagedLog("found binary data, expected text", row=text.count("\n", 0, text.index("\0")) + 1)
    return text


def _line(line: bytes, row: int) -> str:
    """A line in UTF-8, else in cp1252. Raises DamagedLog."""
    for encoding in ("utf-8", "cp1252"):
        with suppress(UnicodeDecodeError):
            return line.decode(encoding)
    raise DamagedLog("found binary data, expected text", row=row)


def encoding_of(start: bytes) -> str:
    """The encoding of a text, based on its first two bytes: UTF-16, otherwise UTF-8."""
    if start == codecs.BOM_UTF16_LE or (start[1:] == b"\0" and start[:1] != b"\0"):
        return "utf-16-le"
    if start == codecs.BOM_UTF16_BE or (start[:1] == b"\0" and start[1:] != b"\0"):
        return "utf-16-be"
    return "utf-8"


_OTHER_ENCODINGS = ("cp932", "gb18030", "cp949", "big5", "cp1251", "cp1250", "cp1253", "mac_roman")
"""Encodings in which spreadsheets of Japan, China, Korea, Taiwan, eastern Europe and Greece save text."""


def in_other_encodings(log: bytes) -> Iterator[bytes]:
    """A log that is neither UTF-8 nor UTF-16 in UTF-8, as the text of each encoding that it may have."""
    head = log[:BLOCK]
    if len(log) > MAX_TABLE_SIZE or b"\0" in head:
        return
    try:
        codecs.getincrementaldecoder("utf-8")().decode(head)
    except UnicodeDecodeError:
        for encoding in _OTHER_ENCODINGS:
            try:
                yield log.decode(encoding).encode()
            except UnicodeDecodeError:
                continue


def _size(log: bytes) -> int:
    """The length of a log without NUL padding at the end."""
    size = len(log)
    while size and not log[size - 1]:
        start = max(0, size - BLOCK)
        size = start + len(log[start:size].rstrip(b"\0"))
    return size


def blocks(log: bytes, after: int = 0) -> Iterator[tuple[int, list[str]]]:
    """The lines of a log below row `after` in blocks, each with the number of its first line.

    Only one block is decoded at a time. Nothing is rejected: an invalid character becomes U+FFFD, and a line longer
    than a block begins with `ENDLESS_LINE_MARK`. NUL padding at the end is dropped.
    """
    number, rest, end = 1, "", "\n" if b"\n" in log[: 4 * BLOCK] else "\r"
    for text in _texts(log):
        if not rest and text.isspace():
            number += text.count(end)
            continue
        first, *others = (rest + text).split(end)
        *lines, rest = (ENDLESS_LINE_MARK if len(first) > BLOCK else first, *others)
        skipped = min(max(after + 1 - number, 0), len(lines))
        yield number + skipped, [line.strip("\r\ufeff") for line in lines[skipped:]]
        number += len(lines)
    if number > after:
        yield number, [rest.strip("\r\ufeff")]


def first_lines(log: bytes, after: int = 0, most: int = 200) -> list[str]:
    """The first lines of a log below row `after`, at most `most`."""
    lines = chain.from_iterable(block for _, block in blocks(log, after))
    return list(islice(lines, most))


def lines_of(text: str) -> list[str]:
    """The lines at the beginning of a log, as `blocks` counts them."""
    return [line.strip("\r\ufeff") for line in text.split("\n" if "\n" in text else "\r")]


def narrow(log: bytes) -> bytes:
    """A log with one byte per character, for a parser that examines bytes: a terminal may have saved it as UTF-16.

    Raises DamagedLog for a long one in UTF-16, or for bytes that are not text.
    """
    if encoding_of(log[:2]) == "utf-8":
        return log
    if len(log) > MOST_WIDE:
        raise DamagedLog(f"found {len(log) >> 20} MB of UTF-16, expected at most {MOST_WIDE >> 20}; save it as UTF-8")
    return decode(log).encode()


def _texts(log: bytes) -> Iterator[str]:
    begin, size = 0, _size(log)
    while log.startswith(codecs.BOM_UTF8, begin):
        begin += len(codecs.BOM_UTF8)
    decoder = codecs.getincrementaldecoder(encoding_of(log[begin : begin + 2]))("replace")
    for start, end in pairwise([begin, *range(begin + BLOCK // 32, size, BLOCK), size]):
        yield decoder.decode(log[start:end])


def is_cut(log: bytes) -> bool:
    """Whether a log ends within a line, ignoring padding."""
    size = _size(log)
    return log[max(0, size - 1) : size] not in (b"\n", b"\r", b"")


def rows(text: str, separator: str) -> Iterator[tuple[int, list[str] | DamagedLog]]:
    """The rows of a table with their numbers; a row with a NUL or an unmatched quotation mark is a DamagedLog.

    The latter ends at the end of its line, so that an unmatched quotation mark costs one row and not the rest of the
    table; if there are too many for that (`MAX_REREAD`), the last row is one for the rest of the table.
    Raises DamagedLog for too many lines.
    """
    check_count(max(map(text.count, "\n\r")))
    csv.field_size_limit(MAX_TABLE_SIZE)  # an exported ledger can be imported again, however long its notes are
    lines = list(io.StringIO(text, newline=""))
    row, start, left, damaged = 0, 0, MAX_REREAD * len(lines), "\0" in text
    while start < len(lines):
        reader = csv.reader(map(lines.__getitem__, range(start, len(lines))), delimiter=separator, strict=True)
        whole = 0
        try:
            for cells in reader:
                row, whole = row + 1, reader.line_num
                yield row, _lost(row) if damaged and any("\0" in cell for cell in cells) else cells
            return
        except csv.Error as error:
            row, start, left = row + 1, start + whole + 1, left - (reader.line_num - whole)
            if left < 0:
                found = (
                    "found too many quotation marks that are not closed, expected pairs of them; the rest is not read"
                )
                yield row, DamagedLog(found, row=row)
                return
            found = "found a quotation mark that is not closed or not doubled, expected pairs of them"
            if "limit" in str(error):
                found = f"found an endless cell, expected at most {MAX_TABLE_SIZE} characters"
            yield row, DamagedLog(found, row=row)


def _lost(row: int) -> DamagedLog:
    return DamagedLog("found a NUL character, as where a part was lost, expected text", row=row)


_EMPTY_ABOVE = 3
"""One in so many cells of a row of headings above groups of columns is empty at least. [1]"""
_MOST_TITLES, _LEAST_BELOW_TITLE = 5, 3
"""Largest number of title rows above a table's header, and the smallest number of cells in the header then. [1]"""


def first_row(text: str, separator: str) -> tuple[int, list[str]]:
    """The header of a table with its row number: the first row that is not blank, a spreadsheet's `sep=;` or a title.

    A title is a single cell above a row of several cells. (0, []) if there is no header.
    """
    titles: list[tuple[int, list[str]]] = []
    for row, cells in rows(text, separator):
        if isinstance(cells, DamagedLog):
            break
        filled = sum(bool(cell.strip()) for cell in cells)
        if not filled or cells[0].strip().lower().startswith("sep="):
            continue
        if filled > 1 and (not titles or filled >= _LEAST_BELOW_TITLE):
            return _with_row_below(text, separator, row, cells)
        titles.append((row, cells))
        if len(titles) > _MOST_TITLES or filled > 1:
            break
    return titles[0] if titles else (0, [])


def _with_row_below(text: str, separator: str, row: int, cells: list[str]) -> tuple[int, list[str]]:
    """A header with its row number, completed by the row below it where headings above groups of columns are merged:
    `Flight,,Result,` above `No,Date,Apogee,Duration`. A unit below a heading is that of the heading."""
    empty = sum(not cell.strip() for cell in cells)
    if empty < max(2, len(cells) / _EMPTY_ABOVE):
        return row, cells
    below = next(((n, found) for n, found in islice(rows(text, separator), row + 1) if n > row), (row, []))
    if isinstance(below[1], DamagedLog) or not _names_more(cells, below[1]):
        return row, cells
    joined, group = [], ""
    for upper, lower in zip_longest(cells, below[1], fillvalue=""):
        group = upper.strip() or group
        unit = lower.strip().strip("()[]")
        joined.append(f"{group} ({unit})" if is_unit(unit) else lower.strip() or upper.strip())
    return below[0], joined


def _names_more(cells: Sequence[str], below: Sequence[str]) -> bool:
    """Whether a row below a header consists of names, and has some where the header is empty."""
    named = [cell.strip() for cell in below if cell.strip()]
    more = any(lower.strip() and not upper.strip() for upper, lower in zip_longest(cells, below, fillvalue=""))
    return more and len(named) > 2 and not any(any(map(str.isdigit, cell)) for cell in named)


def first_names(head: bytes) -> tuple[str, ...]:
    """The cells of the first row of a table, split by the separator that gives the most cells. Raises DamagedLog."""
    text = decode(head)
    cells = max((first_row(text, separator)[1] for separator in (",", ";", "\t")), key=len)
    return tuple(cell.strip() for cell in cells)


def shown(cell: str, most: int = 40) -> str:
    """A cell as messages quote it: in quotes, with control characters escaped, truncated if long."""
    cell = cell.strip()
    return repr(cell if len(cell) <= most else cell[:most] + "…")


MAX_COLUMNS = 30
"""Number of columns that a message lists. [1]"""
MAX_COMPARED = 300
"""Number of columns with which a misspelled name is compared. [1]"""


def no_column(wanted: str, names: Sequence[str]) -> str:
    """The message about a column that a table does not have: the most similar names, or the first ones."""
    near = nearest(wanted[:40], (name[:40] for name in names[:MAX_COMPARED]))
    hint = f"; did you mean {' or '.join(map(shown, near))}?" if near else ""
    listed = ", ".join(shown(name) for name in names[:MAX_COLUMNS])
    return f"found no column {shown(wanted)}{hint or f', expected one of {listed}'}"


def line_end(log: bytes) -> bytes:
    """The line ending of a log: a carriage return if there are no line feeds, otherwise a line feed."""
    return b"\n" if b"\n" in log[: 1 << 21] or b"\r" not in log[: 1 << 21] else b"\r"


def lines(log: bytes, longest: int = 1 << 20) -> Iterator[bytes]:
    """The lines of a log, one at a time; of a line without end only its last part."""
    start, mark = 0, line_end(log)
    while start <= len(log):
        end = log.find(mark, start)
        end = len(log) if end < 0 else end
        yield log[max(start, end - longest) : end]
        start = end + 1
