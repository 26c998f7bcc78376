"""Convert spreadsheets (`.xlsx` and `.ods`) to CSV, so that every table parser can read them.

Of several sheets the first one that a parser recognizes is used, otherwise the first that is not empty.
"""

import csv
import io
import math
import zipfile
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass
from datetime import date, datetime, time

from python_calamine import CalamineWorkbook

from fieldkit import zips
from fieldkit.errors import DamagedLog
from fieldkit.importing.tables.spreadsheet_bounds import check_bounds

MAX_UNPACKED = 256 << 20
"""Largest uncompressed size of all files in a spreadsheet. [bytes]"""
_CONTENTS = ("xl/workbook.xml", "content.xml")
"""Files of which every spreadsheet contains one."""


def is_spreadsheet(log: bytes) -> bool:
    """Whether a file is a spreadsheet of a supported kind."""
    if not log.startswith(b"PK\x03\x04"):
        return False
    try:
        with zips.opened(log) as archive:
            names = set(archive.namelist())
            return bool(names & {*_CONTENTS}) and ("mimetype" not in names or _is_of_sheets(archive))
    except (zipfile.BadZipFile, OSError, ValueError, RuntimeError, NotImplementedError):
        return False


def _is_of_sheets(archive: zipfile.ZipFile) -> bool:
    with archive.open("mimetype") as kind:
        return b"spreadsheet" in kind.read(100)


@dataclass(frozen=True, slots=True)
class SheetTable:
    """A sheet as CSV in UTF-8, and the names of the other sheets that hold a recognized table."""

    content: bytes
    others: tuple[str, ...] = ()


def as_csv(log: bytes, recognized: Callable[[bytes], bool]) -> SheetTable:
    """The first recognized sheet of a spreadsheet, otherwise the first that is not empty.

    Raises DamagedLog if it cannot be read or exceeds the limits.
    """
    sheets = [(name, content, recognized(content)) for name, content in _sheets(log)]
    if not sheets:
        raise DamagedLog("found an empty spreadsheet, expected a table in one of its sheets")
    _, first, _ = next((sheet for sheet in sheets if sheet[2]), sheets[0])
    return SheetTable(first, tuple(name for name, content, known in sheets if known and content is not first))


def _sheets(log: bytes) -> Iterator[tuple[str, bytes]]:
    """Each sheet that is not empty, as its name and CSV; row by row, because a cell takes ten times its text."""
    try:
        with zips.opened(log) as archive:
            size = sum(one.file_size for one in archive.infolist())
            if size > MAX_UNPACKED:
                raise DamagedLog(f"found {size >> 20} MB in a spreadsheet, expected at most {MAX_UNPACKED >> 20}")
            check_bounds(archive)
        book = CalamineWorkbook.from_filelike(io.BytesIO(log))
        for name in book.sheet_names:
            sheet = book.get_sheet_by_name(name)
            if sheet.start is not None:
                yield name, _written(sheet.iter_rows(), sheet.start[1])
    except DamagedLog:
        raise
    except Exception as error:  # the spreadsheet reader's errors have no common class
        raise DamagedLog(f"found a spreadsheet that cannot be read ({type(error).__name__}); save it as CSV") from error


def _written(rows: Iterable[Sequence[object]], before: int) -> bytes:
    """Rows as CSV, with the number of empty columns before them."""
    out = io.BytesIO()
    text = io.TextIOWrapper(out, encoding="utf-8", newline="")
    writer = csv.writer(text, lineterminator="\n")
    for row in rows:
        writer.writerow([*before * [""], *map(_cell, row)])
    text.flush()
    return out.getvalue()


def _precision(moment: datetime | time) -> str:
    """The precision of a time: milliseconds if it has any, because a log may have several rows in a second."""
    return "milliseconds" if moment.microsecond >= 1000 else "seconds"


def _cell(value: object) -> str:
    """A cell as CSV text: numbers with a point and all digits, integers without decimals, dates in ISO 8601."""
    if value is None or (isinstance(value, float) and math.isnan(value)):
        return ""
    if isinstance(value, float) and value.is_integer() and abs(value) < 1e15:
        return str(int(value))
    if isinstance(value, datetime):
        midnight = value.time() == time()
        return value.date().isoformat() if midnight else value.isoformat(timespec=_precision(value))
    if isinstance(value, time):
        return value.isoformat(timespec=_precision(value))
    if isinstance(value, date):
        return value.isoformat()
    return "" if str(value) in ("NaT", "<NA>") else str(value)
