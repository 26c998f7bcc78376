"""Commands answer in a lived-in home as in an empty one: what is saved there changes units and defaults of what people
read, never a figure, and stops nothing."""

import shutil
from pathlib import Path

import pytest

from fieldkit.cli.main import main
from fieldkit.paths import HOME, REFERENCE_FLIGHTS
from tests.lived_in import move_in

CHECK_SHAPES = False
COMMANDS = (
    ["flights", "--json"],
    ["show", "1", "--json"],
    ["infer", "1", "2", "--json"],
    ["predict", "--quick", "--motor", "F24-4W", "--config", "A", "--json"],
    ["predict", "--motor", "F24-4W", "--config", "A", "--wind", "3", "--json"],
    ["delay", "--motor", "F24", "--json"],
    ["ballast", "--motor", "F24-4W", "--target", "200m", "--json"],
    ["landing", "--motor", "F24-4W", "--wind", "3", "--json"],
    ["simulate", "--motor", "F24", "--dry-mass", "310", "--diameter", "66", "--cd", "0.6", "--alpha", "1", "--json"],
    ["contest", "--motor", "F24-4W", "--season", "2026", "--json"],
    ["tag", "1", "weak_launch"],
    ["edit", "2", "wind=3mps"],
    ["add", "--rocket", "Astra", "--flight-id", "99", "--motor", "F24-4W", "--apogee", "250m"],
    ["export", "-", "--format", "json"],
    ["undo"],
    ["predictions"],
)


@pytest.fixture(scope="module")
def homes(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, Path]:
    """An empty and a lived-in home, each beside a ledger of the reference flights."""
    empty, lived = (tmp_path_factory.mktemp(name) for name in ("empty", "lived"))
    with pytest.MonkeyPatch.context() as patch:
        move_in(lived, patch)
        patch.setenv(HOME, str(empty / "home"))
        assert main(["--ledger", str(empty / "ledger.db"), "import", str(REFERENCE_FLIGHTS)]) == 0
    shutil.copy(empty / "ledger.db", lived)
    return empty, lived


@pytest.mark.parametrize("command", COMMANDS, ids=lambda command: " ".join(command[:1]))
def test_what_a_home_holds_changes_no_answer(
    command: list[str], homes: tuple[Path, Path], monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    answers, stated = [], bool({"--json", "json"} & {*command})  # others print the user's units
    for folder in homes:
        monkeypatch.setenv(HOME, str(folder / "home"))
        capsys.readouterr()
        status = main(["--ledger", str(folder / "ledger.db"), *command])
        shown = capsys.readouterr()
        answers.append((status, stated and shown.out))
    assert answers[0] == answers[1], shown.err
    assert status == 0, shown.err
