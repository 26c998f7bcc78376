"""Where files are: a flyer's own on this computer (ledger, motors, captures), and the flights that come along."""

import os
from contextlib import suppress
from pathlib import Path

REFERENCE_FLIGHTS = Path(__file__).parent / "data" / "reference_flights.csv"
"""Twelve flights of one rocket, to try things on."""
HOME = "FIELDKIT_HOME"
"""The variable of the environment that names another folder for all of these."""
DATA_FILES = ("mappings.json", "limits.toml", "drills.toml", "motors", "seasons", "captures", "crashes")
"""Files and folders that fieldkit and its user keep in the data folder, beside the ledger."""


def data_folder() -> Path:
    """The folder of the user's data, made if it is not there yet and can be.

    If it cannot, there is nothing in it to read, and who writes there says why that fails.
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
    """The folder of the flyer's own motor files, which may not be there."""
    return data_folder() / "motors"


def hyperprior_file() -> Path:
    """The file of a hyperprior that the flyer learned from a club's flights, which may not be there; nor its folder."""
    return _data_path() / "hyperprior.json"


def settings_file() -> Path:
    """The file of what the flyer chose in the app, which may not be there."""
    if home := _home():
        return home / "settings.json"
    from platformdirs import user_config_path

    return user_config_path("fieldkit", appauthor=False) / "settings.json"


def capture_folder() -> Path:
    """The folder of what was captured from loggers, which may not be there."""
    return data_folder() / "captures"


def crash_folder() -> Path:
    """The folder of crash reports of the app, for its developers; it may not exist."""
    return data_folder() / "crashes"


def own_files() -> list[Path]:
    """The files and folders that fieldkit keeps a flyer's choices and additions in, if the home can be used."""
    try:
        folder = data_folder().resolve()
        return [settings_file().resolve(), *(folder / name for name in DATA_FILES)]
    except (OSError, RuntimeError):
        return []


def _home() -> Path | None:
    named = os.environ.get(HOME)
    return Path(named).expanduser() if named else None
