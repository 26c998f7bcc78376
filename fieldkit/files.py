"""Files: reading those from elsewhere within bounds, writing those that a flyer asks for, and fieldkit's own, which are
replaced as a whole or not at all.
"""

import errno
import os
import stat
from pathlib import Path
from tempfile import NamedTemporaryFile

from fieldkit.errors import FieldkitError

LARGEST = 1 << 30
"""No log or table is larger. [byte]"""


def read(file: Path, *, plain: bool = False) -> bytes:
    """The bytes of a file from elsewhere; with `plain` no pipe and no device, which may never end or never begin.

    Raises OSError, also for a file that is larger than `LARGEST`.
    """
    about = file.stat()
    if stat.S_ISREG(about.st_mode) or stat.S_ISDIR(about.st_mode):
        content = file.read_bytes() if about.st_size <= LARGEST else None
    elif plain:
        raise OSError(errno.EINVAL, "not a plain file")
    else:
        content = _poured(file)
    if content is None:
        raise OSError(errno.EFBIG, f"more than {LARGEST >> 20} MiB")
    return content


def _poured(file: Path) -> bytes | None:
    """What comes out of a pipe, None where that is more than `LARGEST`."""
    content = bytearray()
    with file.open("rb") as source:
        while part := source.read(1 << 20):
            content += part
            if len(content) > LARGEST:
                return None
    return bytes(content)


def write(file: Path, content: bytes) -> None:
    """Write a file that was asked for, whatever its name stands for. Raises FieldkitError."""
    try:
        file.write_bytes(content)
    except OSError as error:
        raise _unwritten(file, error) from error


def replace(file: Path, content: bytes) -> None:
    """Put content in the place of a file of ours; a kill or a power cut leaves the old one or the new one.

    Raises FieldkitError.
    """
    try:
        file.parent.mkdir(parents=True, exist_ok=True)
        with NamedTemporaryFile(dir=file.parent, prefix=f".{file.name}.", suffix=".new", delete=False) as new:
            new.write(content)
            new.flush()
            os.fsync(new.fileno())
        os.replace(new.name, file)
    except OSError as error:
        raise _unwritten(file, error) from error


def _unwritten(file: Path, error: OSError) -> FieldkitError:
    return FieldkitError(f"{file}: cannot be written ({error.strerror})")
