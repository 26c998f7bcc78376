"""Reading files of unknown origin within limits, writing files that a flyer requests, and replacing fieldkit's files
atomically.
"""

import errno
import os
import re
import shutil
import stat
from collections.abc import Mapping
from itertools import count
from os.path import isfile
from pathlib import Path
from typing import Any

from fieldkit.errors import FieldkitError, FileTaken
from fieldkit.paths import SQLITE_SUFFIXES, is_own

MAX_FILE_SIZE = 1 << 30
"""Size limit of a log or table. [byte]"""
LARGEST_OWN = 4 << 20
"""Size limit of a settings file. [byte]"""
LARGEST_TOML = 256 << 10
"""Size limit of a file of kits, limits, rules or seasons. [byte]"""
MAX_DOTS = 200
"""Largest number of dots in a line of such a file: the parser's memory grows with the square of a key's parts. [1]"""
BACKUPS = "-backups"
"""Suffix of the folder with a ledger's backups."""

_DATABASE = b"SQLite format 3\0"
_JOURNALS = (b"\xd9\xd5\x05\xf9\x20\xa1\x63\xd7", b"\x37\x7f\x06\x82", b"\x37\x7f\x06\x83")
"""First bytes of SQLite's rollback journal, and of its write-ahead log in both byte orders."""
COMPANION_SUFFIXES = (*SQLITE_SUFFIXES, BACKUPS)
"""Suffixes of the files that SQLite and fieldkit store next to a ledger."""
_BINARY_MODE = getattr(os, "O_BINARY", 0)
"""Keeps Windows from changing line endings."""
_STREAM = re.compile(r"(/dev/stdin)|(/dev/stdout|-)|(/dev/stderr)|/(?:dev|proc/self)/fd/([0-9]{1,6})")
"""Names of the open streams of this process; `-` is its output, as for most commands."""


def read(file: Path, *, plain: bool = False, most: int | None = None) -> bytes:
    """The bytes of a file of unknown origin, up to a size limit, by default `MAX_FILE_SIZE`.

    Devices and pipes in a folder are not opened, because they may block or never end. Input from a shell, such as
    /dev/stdin, is read to its end unless `plain`. Raises OSError, also for a file that is too large.
    """
    most = MAX_FILE_SIZE if most is None else most
    about = file.stat()
    if stat.S_ISREG(about.st_mode) or stat.S_ISDIR(about.st_mode):
        content = file.read_bytes() if about.st_size <= most else None
    elif stat.S_ISFIFO(about.st_mode) and _stream(file) is not None and not plain:
        content = _poured(file, most)
    else:
        raise OSError(errno.EINVAL, "a pipe or a device, not a plain file")
    if content is None:
        raise OSError(errno.EFBIG, f"more than {most >> 20} MiB" if most >> 20 else f"more than {most >> 10} KiB")
    return content


def first_bytes(file: Path, most: int) -> bytes:
    """The first bytes of a plain file of unknown origin; any other is not opened, as in `read`. Raises OSError."""
    if not stat.S_ISREG(file.stat().st_mode):
        raise OSError(errno.EINVAL, "a folder, a pipe or a device, not a plain file")
    with file.open("rb") as content:
        return content.read(most)


def read_own(file: Path) -> str:
    """The text of a small file such as the settings. Raises OSError, UnicodeDecodeError."""
    return read(file, plain=True, most=LARGEST_OWN).decode("utf-8-sig")


def read_toml(file: Path) -> dict[str, Any]:
    """The tables of a small TOML file. Raises OSError, and ValueError for any other content."""
    return toml_of(read(file, plain=True, most=LARGEST_TOML).decode("utf-8-sig"))


def toml_of(text: str) -> dict[str, Any]:
    """The tables in a TOML text. Raises ValueError, also for a text that the parser cannot read within its limits and
    for an integer of more than 64 bits."""
    import tomllib  # takes 12 ms to import

    if any(line.count(".") > MAX_DOTS for line in text.splitlines()):
        raise ValueError(f"a line of more than {MAX_DOTS} dots")
    try:
        tables = tomllib.loads(text)
    except RecursionError as error:
        raise ValueError("values nested too deeply") from error
    left: list[Any] = [tables]
    while left:
        value = left.pop()
        if isinstance(value, dict | list):
            left += value.values() if isinstance(value, dict) else value
        elif isinstance(value, int) and value.bit_length() > 63:
            raise ValueError("an integer of more than 64 bits")
    return tables


def _poured(file: Path, most: int) -> bytes | None:
    """The content of a pipe; None if it exceeds the size limit."""
    content = bytearray()
    with file.open("rb") as source:
        while part := source.read(1 << 20):
            content += part
            if len(content) > most:
                return None
    return bytes(content)


def check_target(file: Path, *, force: bool = False) -> None:
    """Raise FieldkitError for a path that must not be written: a folder, a disk, a file of fieldkit, and any existing
    file without `force`.

    Files of fieldkit are every ledger (also a damaged or deleted one, recognized by its backups), its journals and
    backups, and the flyer's settings and additions, under any name and through links.
    """
    try:
        target = file.resolve()
        if target.is_dir():
            raise FieldkitError(f"{file}: found a folder there, expected the name of a file")
        if target.is_block_device():
            raise FieldkitError(f"{file}: found a disk, expected the name of a file")
        kept = _kept(target)
    except (OSError, RuntimeError, ValueError) as error:  # a loop of links, or a name with a NUL character
        raise FieldkitError(f"{file}: cannot be written ({getattr(error, 'strerror', None) or error})") from error
    if kept:
        raise FieldkitError(f"{file}: found {kept} there, which is never overwritten; expected another name")
    if not force and is_taken(file):
        raise FileTaken(file)


def is_taken(file: Path) -> bool:
    """Whether a path is an existing plain file, which is replaced only if the user confirms."""
    return isfile(file) and _stream(file) is None


def write(file: Path, content: bytes, *, force: bool = False) -> None:
    """Write a requested file atomically; an existing one is replaced only with `force`.

    A link stays, and its target is written. A device, a pipe or an open stream receives the bytes directly. Raises
    FieldkitError if the file cannot be written, also for a file of fieldkit; see `check_target`.
    """
    write_all({file: content}, force=force)


def write_all(contents: Mapping[Path, bytes], *, force: bool = False) -> None:
    """Write a group of files, or none if `check_target` rejects one; see `write`. Raises FieldkitError."""
    for file in contents:
        check_target(file, force=force)
    for file, content in contents.items():
        try:
            _write(file, content, force)
        except FileExistsError as error:  # it was created in the meantime
            raise FileTaken(file) from error
        except OSError as error:
            raise _unwritten(file, error) from error


def _write(file: Path, content: bytes, force: bool) -> None:
    target = file.resolve()
    if _stream(file) is not None or (target.exists() and not target.is_file()):
        with os.fdopen(_into_stream(file), "wb") as stream:
            stream.write(content)
    else:
        _put(target, content, force)


def _put(target: Path, content: bytes, force: bool) -> None:
    """Write a file atomically, with the permissions of one that it replaces. Raises FileExistsError unless `force`."""
    mode = stat.S_IMODE(target.stat().st_mode) if target.exists() else None
    new = _written_beside(target, content)
    try:
        if mode is not None:
            new.chmod(mode)
        if force:
            os.replace(new, target)
        else:
            _name(new, target)
    finally:
        new.unlink(missing_ok=True)


def _into_stream(file: Path) -> int:
    """Open a device or a pipe for writing, or share an open stream. Raises OSError for a pipe without a reader."""
    if (number := _stream(file)) is not None:
        return os.dup(number)
    if not file.is_fifo():
        return os.open(file, os.O_WRONLY | _BINARY_MODE)
    try:
        pipe = os.open(file, os.O_WRONLY | os.O_NONBLOCK)
    except OSError as error:
        nobody = "no program reads this pipe" if error.errno == errno.ENXIO else error.strerror
        raise OSError(error.errno, nobody) from error
    os.set_blocking(pipe, True)
    return pipe


def _name(new: Path, target: Path) -> None:
    """Give a new file its name. Raises FileExistsError if another file has it."""
    try:
        os.link(new, target)
    except OSError as error:  # also if the disk does not support hard links
        if isinstance(error, FileExistsError) or target.exists():
            raise FileExistsError(errno.EEXIST, os.strerror(errno.EEXIST)) from None
        os.replace(new, target)


def _written_beside(file: Path, content: bytes) -> Path:
    """A new file in the folder of another one, with its content flushed to the disk."""
    new = file.with_name(f".{file.name[:40]}.{os.urandom(8).hex()}.new")
    try:
        with os.fdopen(os.open(new, os.O_WRONLY | os.O_CREAT | os.O_EXCL | _BINARY_MODE, 0o666), "wb") as out:
            out.write(content)
            out.flush()
            os.fsync(out.fileno())
    except BaseException:
        new.unlink(missing_ok=True)
        raise
    return new


def _stream(file: Path) -> int | None:
    """The number of the open stream that a path such as /dev/stdout names, None for other paths."""
    named = _STREAM.fullmatch(str(file))
    return None if named is None else int(named[4] or (named.lastindex or 1) - 1)


def _kept(target: Path) -> str:
    """The kind of fieldkit's file at a path, in a word or two; empty for other files."""
    head = _head(target)
    if head.startswith(_DATABASE):
        return "a ledger or another database"
    if head.startswith(_JOURNALS):
        return "the journal of a database"
    if _is_ledger(target):
        return "a ledger's name"
    if any(_belongs_to_ledger(place) or _holds_copies(place) for place in (target, *target.parents)):
        return "a file that belongs to a ledger"
    if is_own(target):
        return "a file that fieldkit manages"
    return ""


def _is_ledger(file: Path) -> bool:
    """Whether a ledger is at a path, or was, according to its backups."""
    return bool(file.name) and (
        _head(file).startswith(_DATABASE) or _holds_copies(file.with_name(f"{file.name}{BACKUPS}"))
    )


def _belongs_to_ledger(place: Path) -> bool:
    """Whether a path is that of a ledger plus a suffix that SQLite or fieldkit adds."""
    return any(
        place.name.endswith(end) and _is_ledger(place.with_name(place.name.removesuffix(end)))
        for end in COMPANION_SUFFIXES
    )


def _holds_copies(folder: Path) -> bool:
    """Whether a folder has a ledger's backups, by its name and contents."""
    if not folder.name.endswith(BACKUPS) or not folder.is_dir():
        return False
    ledger = folder.with_name(folder.name.removesuffix(BACKUPS))
    return any(folder.glob("*_*Z_*.db")) or (bool(ledger.name) and _head(ledger).startswith(_DATABASE))


def _head(file: Path) -> bytes:
    """The first bytes of a plain file; empty for anything else."""
    if not file.is_file():
        return b""
    with file.open("rb") as opened:
        return opened.read(16)


def replace(file: Path, content: bytes) -> None:
    """Replace a file of fieldkit atomically: a kill or a power cut leaves the old file or the new one.

    A link stays, and its target is replaced. Raises FieldkitError if it cannot be written.
    """
    try:
        file.parent.mkdir(parents=True, exist_ok=True)
        _put(file.resolve() if file.is_file() else file, content, force=True)
    except OSError as error:
        raise _unwritten(file, error) from error


def also_named(file: Path, name: str) -> Path:
    """Give a file's bytes another name in the same folder, with a number if that is taken. Raises OSError."""
    aside = free_name(file, name)
    try:
        os.link(file, aside)
    except OSError:  # a disk without hard links
        shutil.copy2(file, aside)
    return aside


def free_name(file: Path, name: str) -> Path:
    """An unused name next to a file, with a number if needed."""
    names = (file.with_name(name if not number else f"{name}-{number}") for number in count())
    return next(one for one in names if not one.exists())


def _unwritten(file: Path, error: OSError) -> FieldkitError:
    return FieldkitError(f"{file}: cannot be written ({error.strerror})")
