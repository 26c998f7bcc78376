"""Zip archives of unknown origin, opened within limits."""

import io
import zipfile

MAX_ENTRIES = 1000
"""Largest number of files in an archive; a design or a spreadsheet with pictures has a few dozen. [1]"""
METHODS = (zipfile.ZIP_STORED, zipfile.ZIP_DEFLATED)
"""The only compression of designs and spreadsheets. Python unpacks the others without a limit on memory, and a few
hundred bytes can expand to any size."""

_ENTRY = b"PK\x01\x02"


def opened(content: bytes) -> zipfile.ZipFile:
    """The archive in these bytes, whose files can be read piece by piece. Raises zipfile.BadZipFile."""
    if content.count(_ENTRY) > MAX_ENTRIES:
        raise zipfile.BadZipFile(f"more than {MAX_ENTRIES} files")
    archive = zipfile.ZipFile(io.BytesIO(content))
    if any(one.compress_type not in METHODS for one in archive.infolist()):
        raise zipfile.BadZipFile("a compression other than deflate")
    return archive
