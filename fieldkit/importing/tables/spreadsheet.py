"""Convert spreadsheets (`.xlsx` and `.ods`) and tables of web pages to CSV, so that every table parser can read them.

Of several sheets the first one that a parser recognizes is used, otherwise the first that is not empty.
"""

import zipfile
import zlib
from collections.abc import Callable, Iterator
from dataclasses import dataclass

from fieldkit import zips
from fieldkit.errors import DamagedLog
from fieldkit.importing.tables import markup, ods, xlsx

MAX_UNPACKED = 256 << 20
"""Largest uncompressed size of all files in a spreadsheet. [bytes]"""
_KINDS = {xlsx.WORKBOOK: xlsx.sheets, ods.CONTENT: ods.sheets}
"""How to read a spreadsheet, by the part that it contains."""


def is_spreadsheet(log: bytes) -> bool:
    """Whether a file is a spreadsheet of a supported kind."""
    if not log.startswith(b"PK\x03\x04"):
        return markup.is_markup(log)
    try:
        with zips.opened(log) as archive:
            names = set(archive.namelist())
            return bool(names & {*_KINDS}) and ("mimetype" not in names or _is_of_sheets(archive))
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
    first, known = b"", list[str]()
    for name, content in sheets(log):
        if recognized(content):
            first = first if known else content
            known.append(name)
        first = first or content
    if not first:
        raise DamagedLog("found an empty spreadsheet, expected a table in one of its sheets")
    return SheetTable(first, tuple(known[1:]))


def sheets(log: bytes) -> Iterator[tuple[str, bytes]]:
    """Each sheet that is not empty, as its name and CSV. Raises DamagedLog."""
    if markup.is_markup(log):
        yield from ((name, content) for name, content in markup.sheets(log) if content)
        return
    try:
        with zips.opened(log) as archive:
            size = sum(one.file_size for one in archive.infolist())
            if size > MAX_UNPACKED:
                raise DamagedLog(f"found {size >> 20} MB in a spreadsheet, expected at most {MAX_UNPACKED >> 20}")
            present = set(archive.namelist())
            reader = next(read for part, read in _KINDS.items() if part in present)
            yield from ((name, content) for name, content in reader(archive) if content)
    except (zipfile.BadZipFile, zlib.error, EOFError, OSError, RuntimeError, NotImplementedError) as error:
        raise DamagedLog(f"found a spreadsheet that cannot be read ({error}); save it as CSV") from error
