"""Reports of unexpected errors: a crash file with the location, and a line for the flyer.

The file is meant to be sent to others, so it contains nothing private: the type of an error and the lines of the
program, but not its message, which may quote a flight, and no variables; paths start after the home folder.
"""

import platform
import sys
import traceback
from collections.abc import Iterator
from dataclasses import dataclass
from datetime import UTC, datetime
from importlib.metadata import version
from pathlib import Path

import fieldkit
from fieldkit.errors import FieldkitError
from fieldkit.files import replace
from fieldkit.paths import crash_folder, expanded

MAX_CRASH_FILES = 20
"""Number of crash files retained. [1]"""
MAX_FRAMES = 60
"""Innermost calls of one error that are logged. [1]"""


@dataclass(frozen=True, slots=True)
class Crash:
    """An unexpected error: where it was raised, and its crash file, None if none could be saved."""

    where: str
    file: Path | None

    def line(self) -> str:
        """The message for the user."""
        kept = f"details are in {self.file}, without your flights" if self.file else "no report could be saved"
        return f"an error in fieldkit itself, {self.where}; your flights and drafts are safe; {kept}"


def record(error: BaseException) -> Crash:
    """Save a crash file for an error, and delete the oldest files beyond `MAX_CRASH_FILES`."""
    where = place_of(error)
    file = crash_folder() / f"{datetime.now(UTC):%Y%m%dT%H%M%S%f}.txt"
    try:
        replace(file, ("\n".join(_lines(error)) + "\n").encode())
        for old in sorted(file.parent.glob("*.txt"))[:-MAX_CRASH_FILES]:
            old.unlink(missing_ok=True)
    except (FieldkitError, OSError):
        return Crash(where, None)
    return Crash(where, file)


def place_of(error: BaseException) -> str:
    """The type of an error, and the line that raised it."""
    frames = _frames(error)
    return f"{type(error).__name__} in {frames[-1][0]} line {frames[-1][1]}" if frames else type(error).__name__


def _lines(error: BaseException) -> Iterator[str]:
    """The versions, and every error of the chain, the root cause first."""
    yield f"fieldkit {fieldkit.__version__}, Textual {version('textual')}, Python {platform.python_version()}"
    yield f"{platform.system()} {platform.machine()}, {datetime.now(UTC):%Y-%m-%d %H:%M} UTC"
    for one in _chain(error):
        yield ""
        yield type(one).__name__
        for file, line, function, code in _frames(one)[-MAX_FRAMES:]:
            yield f"  {file} line {line}, {function}: {code}"


def _chain(error: BaseException) -> list[BaseException]:
    """An error and its causes, the root cause first."""
    chain: list[BaseException] = []
    now: BaseException | None = error
    while now is not None and now not in chain:
        chain.insert(0, now)
        now = now.__cause__ or (None if now.__suppress_context__ else now.__context__)
    return chain


def _frames(error: BaseException) -> list[tuple[str, int, str, str]]:
    """The calls that led to an error, the innermost last: file, line number, function, and source line."""
    found = traceback.extract_tb(error.__traceback__)
    return [(shortened(frame.filename), frame.lineno or 0, frame.name, frame.line or "") for frame in found]


def shortened(file: str) -> str:
    """A path that starts at the folder from which Python imported the file, else at the home folder; else the file's
    name."""
    path, home = Path(file), expanded("~")
    for root in (Path(fieldkit.__file__).parents[1], *map(Path, sys.path), Path(sys.base_prefix)):
        if root.is_absolute() and root != Path(root.anchor) and root != home and path.is_relative_to(root):
            return path.relative_to(root).as_posix()
    try:
        return f"~/{path.relative_to(home).as_posix()}"
    except ValueError:
        return path.name
