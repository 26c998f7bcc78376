"""The Tab key completes names from the flyer's ledger and the catalog, changes nothing, and never fails."""

from pathlib import Path

import pytest

from fieldkit.cli.main import main
from fieldkit.ledger import Ledger
from fieldkit.plugins import trained_digests

pytestmark = pytest.mark.fast

FLIGHTS = Path(__file__).parents[2] / "fieldkit" / "data" / "reference_flights.csv"


@pytest.fixture
def ledger(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> Path:
    """A ledger with the reference flights at the default path."""
    path = tmp_path / "ledger.db"
    monkeypatch.setenv("FIELDKIT_LEDGER", str(path))
    monkeypatch.setenv("FIELDKIT_HOME", str(tmp_path))
    assert main(["import", str(FLIGHTS)]) == 0
    capsys.readouterr()
    return path


def offered(line: str, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> list[str]:
    """The completions that bash receives after a TAB at the end of a line."""
    words = line.split(" ")
    monkeypatch.setenv("_FIELDKIT_COMPLETE", "complete_bash")
    monkeypatch.setenv("COMP_WORDS", line)
    monkeypatch.setenv("COMP_CWORD", str(len(words) - 1))
    assert main([]) == 0
    printed = capsys.readouterr()
    assert printed.err == ""
    return printed.out.split()


@pytest.mark.usefixtures("ledger")
@pytest.mark.parametrize(
    ("line", "answer"),
    [
        ("fieldkit pre", "predict"),
        ("fieldkit predict --rock", "--rocket"),
        ("fieldkit predict --rocket A", "Astra"),
        ("fieldkit loop --rocket As", "Astra"),
        ("fieldkit motors --fit A", "Astra"),
        ("fieldkit add --config B", "B"),
        ("fieldkit predict --motor F24", "F24-4W"),
        ("fieldkit delay --motor F24W", "F24W-4"),
        ("fieldkit show 1", "12"),
        ("fieldkit docs ph", "physics"),
    ],
)
def test_tab_completes(
    line: str, answer: str, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    assert answer in offered(line, monkeypatch, capsys)


def test_tab_creates_no_ledger(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setenv("FIELDKIT_LEDGER", str(tmp_path / "none.db"))
    assert offered("fieldkit loop --rocket A", monkeypatch, capsys) == []
    assert not (tmp_path / "none.db").exists()


def test_tab_is_silent_about_a_damaged_ledger(
    ledger: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    ledger.write_bytes(b"not a ledger" * 1000)
    assert offered("fieldkit loop --rocket A", monkeypatch, capsys) == []


def test_tab_changes_nothing(ledger: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    with Ledger.open() as before:
        history = before.history()
    offered("fieldkit show ", monkeypatch, capsys)
    with Ledger.open() as after:
        assert after.history() == history


def test_the_version_names_the_ensembles_by_their_digests(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["--version"]) == 0
    first, *others = capsys.readouterr().out.splitlines()
    assert first.startswith("fieldkit ")
    assert others == [f"ensemble {name} sha256:{digest}" for name, digest in trained_digests().items()]
    assert {len(digest) for digest in trained_digests().values()} == {64}
