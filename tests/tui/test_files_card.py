"""The card of the folder of settings lists every file that fieldkit keeps."""

from pathlib import Path

import pytest

from fieldkit.cli.main import main
from fieldkit.paths import DATA_FILES, LOCK_NAME, REFERENCE_FLIGHTS, SQLITE_SUFFIXES, data_file, settings_file
from fieldkit.tui.crash import record
from fieldkit.tui.setup.setting_card import FILES
from tests.lived_in import move_in

LOG = Path(__file__).parents[2] / "sample_logs" / "altos_csv__with_satellites.csv"
BESIDE = (LOCK_NAME, "ledger.db-backups", *(f"ledger.db{suffix}" for suffix in SQLITE_SUFFIXES))
"""What is made beside files in a home: no file of the flyer's own."""


def test_every_file_that_fieldkit_looks_for_is_listed() -> None:
    assert {*FILES} == {*DATA_FILES}


def test_every_file_in_a_used_home_is_listed(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delenv("FIELDKIT_LEDGER", raising=False)
    home = move_in(tmp_path, monkeypatch)
    assert main(["import", str(LOG), "--rocket", "Law"]) == 0
    assert main(["show", "1"]) in (0, 1)
    assert main(["import", str(REFERENCE_FLIGHTS)]) == 0
    assert main(["undo"]) == 0
    record(ValueError("for the developers"))
    written = {file.name for file in home.iterdir()} - {*BESIDE}
    assert {"ledger.db", "settings.json", "mappings.json", "crashes"} <= written <= {*FILES}


def test_the_settings_listed_are_those_read(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delenv("FIELDKIT_HOME", raising=False)
    for variable in ("HOME", "XDG_DATA_HOME", "XDG_CONFIG_HOME", "LOCALAPPDATA"):
        monkeypatch.setenv(variable, str(tmp_path / variable))
    assert data_file("settings.json") == settings_file()
