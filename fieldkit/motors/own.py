"""The user's own motors: `.eng` and `.rse` files in a folder of the user's data."""

import json
from collections.abc import Sequence
from contextlib import suppress
from pathlib import Path

from fieldkit import files
from fieldkit.errors import DamagedLog, FieldkitError
from fieldkit.motors import rasp, rocksim
from fieldkit.motors.catalogue import Catalogue, catalogue
from fieldkit.motors.motor import Motor
from fieldkit.motors.own_corrections import FILE_NAME, read_own_corrections

SUFFIXES = (".eng", ".rse")
MAX_MOTOR_FILE_SIZE = 16 << 20
"""Size limit of a motor file; all motors of the catalog together are smaller. [bytes]"""
_REPORTED = ".reported.json"
"""The file in the folder with the errors that were reported, and the files as they were."""


def read(data: bytes, source: str) -> list[Motor]:
    """The motors in a file, all of which are sound. Raises DamagedLog."""
    motors, errors = sound_motors(data, source)
    if errors:
        raise errors[0]
    return motors


def sound_motors(data: bytes, source: str) -> tuple[list[Motor], list[DamagedLog]]:
    """The motors in a file, and the errors of the damaged ones; RockSim or RASP is recognized by content. Raises
    DamagedLog if no motor is sound."""
    markup = data.lstrip(b"\xef\xbb\xbf\xff\xfe \t\r\n\0").startswith(b"<")
    motors, errors = rocksim.read(data, source) if markup else rasp.read(data, source)
    if not motors:
        raise errors[0]
    return motors, errors


def own_motors(folder: Path) -> tuple[list[Motor], list[FieldkitError]]:
    """The motors of every `.eng` and `.rse` file in a folder, and the errors of those that cannot be read.

    A missing folder has no motors; a damaged file does not affect the others.
    """
    motors: list[Motor] = []
    errors: list[FieldkitError] = []
    for path in sorted(folder.iterdir()) if folder.is_dir() else []:
        if path.suffix.lower() in SUFFIXES:
            try:
                found, damaged = sound_motors(_content(path), path.name)
                motors += found
                errors += damaged
            except FieldkitError as error:
                errors.append(error)
    return motors, errors


def known_motors(folder: Path) -> tuple[Catalogue, list[FieldkitError]]:
    """The shipped motors plus the user's own, with the user's corrections, and an error for each file that cannot be
    read and each correction that cannot be applied."""
    motors, errors = own_motors(folder)
    rows, unread = read_own_corrections(folder)
    known = catalogue().with_motors(motors) if motors else catalogue()
    known, unused = known.with_corrections(rows) if rows else (known, [])
    return known, [*errors, *unread, *unused]


def unreported(errors: Sequence[FieldkitError], folder: Path) -> Sequence[FieldkitError]:
    """The errors of `known_motors`; none if they were reported before and no file of the folder has changed since.

    They count as reported from now on, unless that cannot be saved.
    """
    file = folder / _REPORTED
    if not errors and not file.exists():
        return errors
    present = [one for one in sorted(folder.iterdir()) if one.suffix.lower() in SUFFIXES or one.name == FILE_NAME]
    states = [[one.name, about.st_mtime_ns, about.st_size] for one in present if (about := one.lstat())]
    report = json.dumps({"files": states, "errors": [str(error) for error in errors]})
    with suppress(OSError, UnicodeDecodeError):
        if file.exists() and files.read_own(file) == report:
            return []
    with suppress(OSError, FieldkitError):
        files.replace(file, report.encode())
    return errors


def import_file(path: Path, folder: Path) -> tuple[list[Motor], list[DamagedLog]]:
    """Read a motor file and save a copy in the folder; returns its motors, and the errors of damaged ones. Raises
    DamagedLog, FieldkitError.

    A file of the same name is replaced, which allows users to correct it; if it is a link, only one to a motor file.
    """
    content = _content(path)
    motors, errors = sound_motors(content, path.name)
    suffix = path.suffix.lower() if path.suffix.lower() in SUFFIXES else SUFFIXES[0]
    file = folder / f"{path.stem}{suffix}"
    if file.is_symlink() and file.is_file():
        sound_motors(_content(file), file.name)
    files.replace(file, content)
    return motors, errors


def _content(path: Path) -> bytes:
    try:
        return files.read(path, plain=True, most=MAX_MOTOR_FILE_SIZE)
    except OSError as error:
        raise DamagedLog(f"cannot be read ({error.strerror}), expected a motor file", source=path.name) from error
