"""Writing files: those that a flyer asks for, and fieldkit's own, which are replaced as a whole or not at all."""

import os
from pathlib import Path
from tempfile import NamedTemporaryFile

from fieldkit.errors import FieldkitError


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
