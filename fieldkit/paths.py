"""Paths of files: the flyer's files on this computer (ledger, motors, captures), and the flights shipped with
fieldkit."""

import os
from contextlib import suppress
from pathlib import Path

REFERENCE_FLIGHTS = Path(__file__).parent / "data" / "reference_flights.csv"
"""Twelve flights of one rocket, for trying things out."""
HOME = "FIELDKIT_HOME"
"""The environment variable for another data folder."""
DATA_FILES = ("mappings.json", "limits.toml", "drills.toml", "motors", "seasons", "captures", "crashes")
"""Files and folders in the data folder besides the ledger."""


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
    from platformdirs import user_data_path

    return user_data_path("fieldkit", appauthor=False)


def motor_folder() -> Path:
    """The folder of the flyer's motor files, which may not exist."""
    return data_folder() / "motors"


def hyperprior_file() -> Path:
    """The file of a hyperprior that the flyer learned from a club's flights; it and its folder may not exist."""
    return _data_path() / "hyperprior.json"


def settings_file() -> Path:
    """The file of the app's settings, which may not exist."""
    if home := _home():
        return home / "settings.json"
    from platformdirs import user_config_path

    return user_config_path("fieldkit", appauthor=False) / "settings.json"


def capture_folder() -> Path:
    """The folder of captures from loggers, which may not exist."""
    return data_folder() / "captures"


def crash_folder() -> Path:
    """The folder of crash reports of the app, for its developers; it may not exist."""
    return data_folder() / "crashes"


def own_files() -> list[Path]:
    """The files and folders of a flyer's settings and additions, if the data folder can be used."""
    try:
        folder = data_folder().resolve()
        return [settings_file().resolve(), *(folder / name for name in DATA_FILES)]
    except (OSError, RuntimeError):
        return []


def _home() -> Path | None:
    named = os.environ.get(HOME)
    return Path(named).expanduser() if named else None
