"""Files: reading those from elsewhere within bounds, writing those that a flyer asks for, and fieldkit's own, which are
replaced as a whole or not at all.
"""

import errno
import os
import stat
from collections.abc import Mapping
from pathlib import Path
from secrets import token_hex

from fieldkit.errors import FieldkitError
from fieldkit.paths import own_files

MAX_FILE_SIZE = 1 << 30
"""Size limit of a log or table. [byte]"""
LARGEST_OWN = 4 << 20
"""No file of what a flyer chose is larger. [byte]"""
BACKUPS = "-backups"
"""After the name of a ledger: the folder of its copies."""

_DATABASE = b"SQLite format 3\0"
_JOURNALS = (b"\xd9\xd5\x05\xf9\x20\xa1\x63\xd7", b"\x37\x7f\x06\x82", b"\x37\x7f\x06\x83")
"""First bytes of SQLite's rollback journal, and of its write-ahead log in both orders of bytes."""
COMPANION_SUFFIXES = ("-journal", "-wal", "-shm", BACKUPS)
"""Suffixes of the files that SQLite and fieldkit keep beside a ledger."""
_BINARY = getattr(os, "O_BINARY", 0)
"""Windows would write line ends of its own."""


def read(file: Path, *, plain: bool = False, most: int | None = None) -> bytes:
    """The bytes of a file from elsewhere, at most so many, by default `MAX_FILE_SIZE`.

    A device or a pipe in a folder may never end or never begin: none is opened. What a shell pours in under a name such
    as /dev/stdin is read to its end, but not with `plain`. Raises OSError, also for a file that is too large.
    """
    most = MAX_FILE_SIZE if most is None else most
    about = file.stat()
    if stat.S_ISREG(about.st_mode) or stat.S_ISDIR(about.st_mode):
        content = file.read_bytes() if about.st_size <= most else None
    elif stat.S_ISFIFO(about.st_mode) and _is_stream(file) and not plain:
        content = _poured(file, most)
    else:
        raise OSError(errno.EINVAL, "a pipe or a device, not a plain file")
    if content is None:
        raise OSError(errno.EFBIG, f"more than {most >> 20} MiB")
    return content


def read_own(file: Path) -> str:
    """The text of a small file of the flyer's own, such as settings. Raises OSError, UnicodeDecodeError."""
    return read(file, plain=True, most=LARGEST_OWN).decode()


def _poured(file: Path, most: int) -> bytes | None:
    """What comes out of a pipe, None if that is more than so many bytes."""
    content = bytearray()
    with file.open("rb") as source:
        while part := source.read(1 << 20):
            content += part
            if len(content) > most:
                return None
    return bytes(content)


def check_target(file: Path, *, force: bool = False) -> None:
    """Raise FieldkitError for a name that nothing is written to: a folder, a file of ours, without `force` any file.

    Of ours is every ledger (also one that is damaged or gone, by the backups beside it), its journals and its backups,
    and what the flyer chose and added; under whatever name, through links too.
    """
    try:
        target = file.resolve()
        if target.is_dir():
            raise FieldkitError(f"{file}: found a folder there, expected the name of a file")
        if target.is_block_device():
            raise FieldkitError(f"{file}: found a disk, expected the name of a file")
        kept = _kept(target)
    except (OSError, RuntimeError, ValueError) as error:  # a loop of links, a name with a zero in it
        raise FieldkitError(f"{file}: cannot be written ({getattr(error, 'strerror', None) or error})") from error
    if kept:
        raise FieldkitError(f"{file}: found {kept} there, which is never overwritten; expected another name")
    if not force and is_taken(file):
        raise _taken(file)


def is_taken(file: Path) -> bool:
    """Whether a name is an existing plain file, which is replaced only if the user confirms."""
    return file.is_file() and not _is_stream(file)


def write(file: Path, content: bytes, *, force: bool = False) -> None:
    """Write a file that was asked for, as a whole or not at all; only with `force` in the place of another one.

    What a link names is written, and the link stays. A device or a pipe gets the bytes as they are.
    Raises FieldkitError, for a name of a file of ours too; see `check_target`.
    """
    write_all({file: content}, force=force)


def write_all(contents: Mapping[Path, bytes], *, force: bool = False) -> None:
    """Write files that belong together, none of them if one may not be written; see `write`."""
    for file in contents:
        check_target(file, force=force)
    for file, content in contents.items():
        try:
            _write(file, content, force)
        except FileExistsError as error:  # it came in the meantime
            raise _taken(file) from error
        except OSError as error:
            raise _unwritten(file, error) from error


def _write(file: Path, content: bytes, force: bool) -> None:
    target = file.resolve()
    if _is_stream(file) or (target.exists() and not target.is_file()):
        with os.fdopen(_into_stream(file), "wb") as stream:
            stream.write(content)
        return
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
    """A device or a pipe, to be written to. Raises OSError for a pipe that nobody reads, which would wait for ever."""
    if not file.is_fifo():
        return os.open(file, os.O_WRONLY | _BINARY)
    try:
        pipe = os.open(file, os.O_WRONLY | os.O_NONBLOCK)
    except OSError as error:
        nobody = "nobody reads this pipe" if error.errno == errno.ENXIO else error.strerror
        raise OSError(error.errno, nobody) from error
    os.set_blocking(pipe, True)
    return pipe


def _name(new: Path, target: Path) -> None:
    """Give a new file its name. Raises FileExistsError if another file has it."""
    try:
        os.link(new, target)
    except FileExistsError:
        raise
    except OSError:  # a disk without hard links
        if target.exists():
            raise FileExistsError(errno.EEXIST, os.strerror(errno.EEXIST)) from None
        os.replace(new, target)


def _written_beside(file: Path, content: bytes) -> Path:
    """A new file in the folder of another one, its content on the disk."""
    new = file.with_name(f".{file.name[:100]}.{token_hex(8)}.new")
    try:
        with os.fdopen(os.open(new, os.O_WRONLY | os.O_CREAT | os.O_EXCL | _BINARY, 0o666), "wb") as out:
            out.write(content)
            out.flush()
            os.fsync(out.fileno())
    except BaseException:
        new.unlink(missing_ok=True)
        raise
    return new


def _is_stream(file: Path) -> bool:
    """Whether a name stands for what is open already, such as /dev/stdout."""
    return file.is_absolute() and file.parts[1:2] in (("dev",), ("proc",))


def _kept(target: Path) -> str:
    """What fieldkit keeps at a path, in a word or two; empty for nothing."""
    head = _head(target)
    if head.startswith(_DATABASE):
        return "a ledger or another database"
    if head.startswith(_JOURNALS):
        return "the journal of a database"
    if _is_ledger(target):
        return "a ledger's name"
    if any(_belongs_to_ledger(place) or _holds_copies(place) for place in (target, *target.parents)):
        return "a file that belongs to a ledger"
    if any(_same(target, own) or own in target.parents for own in own_files()):
        return "a file that fieldkit manages"
    return ""


def _is_ledger(file: Path) -> bool:
    """Whether a ledger is at a path, or was: copies of it are kept beside."""
    return bool(file.name) and (
        _head(file).startswith(_DATABASE) or _holds_copies(file.with_name(f"{file.name}{BACKUPS}"))
    )


def _belongs_to_ledger(place: Path) -> bool:
    """Whether a name is that of a ledger and an ending that SQLite or fieldkit puts to it."""
    return any(
        place.name.endswith(end) and _is_ledger(place.with_name(place.name.removesuffix(end)))
        for end in COMPANION_SUFFIXES
    )


def _holds_copies(folder: Path) -> bool:
    """Whether a folder is that of a ledger's copies, by its name and what it holds."""
    if not folder.name.endswith(BACKUPS) or not folder.is_dir():
        return False
    ledger = folder.with_name(folder.name.removesuffix(BACKUPS))
    return any(folder.glob("*_*Z_*.db")) or (bool(ledger.name) and _head(ledger).startswith(_DATABASE))


def _head(file: Path) -> bytes:
    """The first bytes of a plain file, none of anything else."""
    if not file.is_file():
        return b""
    with file.open("rb") as opened:
        return opened.read(16)


def _same(one: Path, other: Path) -> bool:
    try:
        return one.samefile(other)
    except OSError:
        return one == other


def replace(file: Path, content: bytes) -> None:
    """Put content in the place of a file of ours; a kill or a power cut leaves the old one or the new one.

    Raises FieldkitError.
    """
    try:
        file.parent.mkdir(parents=True, exist_ok=True)
        new = _written_beside(file, content)
        try:
            os.replace(new, file)
        finally:
            new.unlink(missing_ok=True)
    except OSError as error:
        raise _unwritten(file, error) from error


def _taken(file: Path) -> FieldkitError:
    return FieldkitError(f"{file}: found an existing file, expected a new name, or --force to replace it")


def _unwritten(file: Path, error: OSError) -> FieldkitError:
    return FieldkitError(f"{file}: cannot be written ({error.strerror})")
