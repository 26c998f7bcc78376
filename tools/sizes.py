"""Prints the contents and sizes of wheels and source archives: `python tools/sizes.py dist`."""

import sys
import tarfile
from collections import Counter
from collections.abc import Iterator
from pathlib import Path
from zipfile import ZipFile

FOLDERS_LISTED = 6
"""Number of folders to list per archive."""


def contents(archive: Path) -> Iterator[tuple[str, int]]:
    """Every file in an archive: its path and unpacked size. [byte]"""
    if archive.suffix == ".whl":
        with ZipFile(archive) as wheel:
            yield from ((one.filename, one.file_size) for one in wheel.infolist())
        return
    with tarfile.open(archive) as source:
        yield from ((one.name.partition("/")[2], one.size) for one in source if one.isfile())


def report(archive: Path) -> str:
    """An archive's size, and its largest folders unpacked."""
    folders: Counter[str] = Counter()
    for path, size in contents(archive):
        folders["/".join(path.split("/")[:2])] += size
    largest = ", ".join(f"{folder} {size / 1e6:.1f}" for folder, size in folders.most_common(FOLDERS_LISTED))
    return f"{archive.name}: {archive.stat().st_size / 1e6:.1f} MB; unpacked: {largest} MB"


if __name__ == "__main__":
    for file in sorted(Path(sys.argv[1]).glob("fieldkit-*")):
        print(report(file))
