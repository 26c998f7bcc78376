"""Paths of files: the flyer's files on this computer (ledger, motors, captures), and the flights shipped with
fieldkit."""

import os
from collections.abc import Iterator
from contextlib import suppress
from pathlib import Path
from stat import S_ISLNK, S_ISREG
from typing import Literal, get_args

REFERENCE_FLIGHTS = Path(__file__).parent / "data" / "reference_flights.csv"
"""Twelve flights of one rocket, for trying things out."""
HOME = "FIELDKIT_HOME"
"""The environment variable for another folder of the data and the settings."""
DataFile = Literal[
    "captures",
    "crashes",
    "drafts",
    "drills.toml",
    "hyperprior.json",
    "kits.toml",
    "ledger.db",
    "limits.toml",
    "mappings.json",
    "measured",
    "motors",
    "rules",
    "seasons",
    "settings.json",
]
"""Files and folders that fieldkit looks for in the data folder."""
DATA_FILES: tuple[DataFile, ...] = get_args(DataFile)


def expanded(text: str | Path) -> Path:
    """A path with `~` replaced; that of an unknown user is left as it is, for which `Path.expanduser` raises an
    error. A NUL, which no path has, is replaced by its picture."""
    return Path(os.path.expanduser(str(text).replace("\0", "\u2400")))


LOCK_NAME = ".lock"
"""The file that is locked, in the folder of the file that changes: a replaced file itself cannot hold a lock."""
SQLITE_SUFFIXES = ("-journal", "-wal", "-shm")
"""Suffixes of the files that SQLite makes next to a ledger."""


def ledger_trouble(file: Path) -> str:
    """Why SQLite must not open a file as a ledger, as a phrase; empty if it may.

    It would wait forever for a pipe that has the name of its journal, roll back the journal that a link leads to, and
    cannot attach a file whose name is not text.
    """
    if not file.name:
        return "found a folder, expected a file"
    try:
        str(file).encode()
        file.resolve()
        for companion in (file.with_name(file.name + suffix) for suffix in SQLITE_SUFFIXES):
            with suppress(FileNotFoundError):
                mode = companion.lstat().st_mode
                if not S_ISREG(mode):
                    kind = "a link" if S_ISLNK(mode) else "a folder, a pipe or a device"
                    return f"found {kind} named {companion.name} beside it, where SQLite writes; remove that first"
    except UnicodeEncodeError:
        return "found a name that is not UTF-8, expected one; rename the file"
    except (OSError, RuntimeError, ValueError) as error:
        looped = isinstance(error, RuntimeError)
        return f"cannot be opened ({'a loop of links' if looped else getattr(error, 'strerror', None) or error})"
    return ""


def working_folder() -> Path:
    """The current folder; the user's home if it was deleted."""
    try:
        return Path.cwd()
    except OSError:
        return expanded("~")


def data_folder() -> Path:
    """The folder of the user's data, created if possible.

    If it cannot be created, there is nothing to read, and writing reports the reason.
    """
    folder = _data_path()
    with suppress(OSError):
        folder.mkdir(parents=True, exist_ok=True)
    return folder


def _data_path() -> Path:
    if home := _home():
        return home
    from platformdirs import user_data_path  # takes 15 ms to import

    return user_data_path("fieldkit", appauthor=False)


def data_file(name: DataFile) -> Path:
    """A file or folder of fieldkit's: the settings in the folder of settings, all else in the data folder, which is
    created if possible; the file may not exist."""
    return (_settings_path() if name == "settings.json" else data_folder()) / name


def motor_folder() -> Path:
    """The folder of the flyer's motor files, which may not exist."""
    return data_file("motors")


def hyperprior_file() -> Path:
    """The file of a hyperprior that the flyer learned from a club's flights; it and its folder may not exist."""
    name: DataFile = "hyperprior.json"
    return _data_path() / name


def settings_file() -> Path:
    """The file of the app's settings, which may not exist."""
    return data_file("settings.json")


def _settings_path() -> Path:
    if home := _home():
        return home
    from platformdirs import user_config_path  # takes 15 ms to import

    return user_config_path("fieldkit", appauthor=False)


CAPTURE_SUFFIXES = (".raw", ".jsonl")
"""Suffixes of the two files of a capture: its bytes, and its journal."""


def capture_folder() -> Path:
    """The folder of captures from loggers, which may not exist."""
    return data_file("captures")


def crash_folder() -> Path:
    """The folder of crash reports of the app, for its developers; it may not exist."""
    return data_file("crashes")


def is_own(file: Path) -> bool:
    """Whether a resolved path is one of fieldkit's own: anything in its folders, and a name that it looks for there.

    What a link in a folder leads to belongs to it, and so does a file with another name outside (a hard link).
    """
    try:
        folders = {data_folder().resolve(), _settings_path().resolve()}
    except (OSError, RuntimeError):  # a loop of links
        return False
    named = [folder / name for folder in folders for name in (*DATA_FILES, LOCK_NAME)]
    if any(file == own or own in file.parents for own in named):
        return True
    return file.exists() and any(_holds(folder, file) for folder in folders)


def _holds(folder: Path, file: Path) -> bool:
    """Whether an existing file is in a folder, by any name and through links."""
    places = {_identity(place) for place in (file, *file.parents)}
    return any(one in places for one in _identities(folder))


def _identities(folder: Path) -> Iterator[tuple[int, int]]:
    """The device and inode of a folder and of everything in it, including the targets of links."""
    seen: set[tuple[int, int]] = set()
    left = [folder]
    while left:
        place = left.pop()
        with suppress(OSError):  # it is missing, or a link is broken
            identity = _identity(place)
            if identity not in seen:
                seen.add(identity)
                yield identity
                left += place.iterdir() if place.is_dir() else []


def _identity(file: Path) -> tuple[int, int]:
    about = file.stat()
    return about.st_dev, about.st_ino


def _home() -> Path | None:
    named = os.environ.get(HOME)
    return expanded(named) if named else None
