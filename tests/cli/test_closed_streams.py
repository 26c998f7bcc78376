"""Standard streams that were closed before the start, as by `>&-` or a service manager."""

from pathlib import Path

import pytest

from fieldkit.cli.main import main
from fieldkit.ledger import Ledger

CHECK_SHAPES = False
ADDED = ["add", "--rocket", "Astra", "--motor", "F24-4W", "--apogee", "240m"]


@pytest.fixture
def ledger(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> str:
    """An empty ledger."""
    monkeypatch.setenv("FIELDKIT_HOME", str(tmp_path / "home"))
    return str(tmp_path / "ledger.db")


def test_a_closed_output_is_reported_in_one_line_that_says_where_to_look(
    ledger: str, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr("sys.stdout", None)
    assert main(["--ledger", ledger, *ADDED]) == 1
    printed = capsys.readouterr().err.splitlines()
    assert printed[-1].startswith("the output: found ")
    assert "may have finished" in printed[-1]
    with Ledger.open(ledger) as kept:
        assert [flight.apogee for flight in kept.flights()] == [240.0]


def test_closed_messages_and_input_change_no_result(
    ledger: str, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr("sys.stdin", None)
    monkeypatch.setattr("sys.stderr", None)
    assert main(["--ledger", ledger, *ADDED]) == 0
    assert "240 m" in capsys.readouterr().out
    assert main(["--ledger", ledger, "add"]) == 1  # no one answers
