"""The help names each value by what a user types, not by its type in the code."""

import re
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from typer.main import get_command

from fieldkit.cli.docs import page_names
from fieldkit.cli.main import EXPLAINED_ON, app, main
from fieldkit.cli.metavars import placeholders

pytestmark = pytest.mark.fast
CHECK_SHAPES = False


def _commands(group: Any, above: str = "") -> Iterator[tuple[str, Any]]:
    for name, command in group.commands.items():
        yield f"{above}{name}", command
        yield from _commands(command, f"{name} ") if hasattr(command, "commands") else ()


COMMANDS = dict(_commands(get_command(app)))


@pytest.mark.parametrize("command", sorted(COMMANDS))
def test_no_option_shows_a_type_from_the_code(command: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert main([*command.split(), "--help"]) == 0
    shown = capsys.readouterr().out
    assert re.findall(r"<(?:str|int|float|datetime|%[^>]*)>|\{[a-z_]+\}", shown) == []


@pytest.mark.parametrize("command", sorted(COMMANDS))
def test_the_help_wraps_at_the_width_of_the_terminal_alone(command: str) -> None:
    assert "\n" not in COMMANDS[command].help.replace("\n\n", "")


@pytest.mark.parametrize("command", sorted(EXPLAINED_ON))
def test_the_help_names_a_page_of_the_manual(command: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert EXPLAINED_ON[command] in page_names()
    assert main([command, "--help"]) == 0
    assert f"In the manual: fieldkit docs {EXPLAINED_ON[command]}" in capsys.readouterr().out


def test_each_placeholder_belongs_to_an_option_or_argument() -> None:
    names = {parameter.name for command in COMMANDS.values() for parameter in command.params}
    columns = {"coast_drag", "burn_impulse"}  # measured in logs only, no options
    assert placeholders().keys() - names <= columns


def test_a_value_with_a_unit_is_named_by_its_quantity(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["predict", "--help"]) == 0
    shown = " ".join(capsys.readouterr().out.split())
    assert re.search(r"--dry-mass\S* ?MASS", shown)
    assert re.search(r"--wind\S* ?SPEED", shown)


@pytest.mark.parametrize(
    ("line", "option"),
    [
        ("kits Foo --mount abc", "--mount"),
        ("kits Foo --dry-mass -g", "--dry-mass"),
        ("sites Field --size -3", "--size"),
        ("ballast --target x", "--target"),
        ("ballast --target 800ft --within 0", "--within"),
        ("ballast --target 800ft --lightest z", "--lightest"),
        ("simulate --motor C6-5 --dry-mass 1g --diameter 1in --cd 1 --booster-mass x", "--booster-mass"),
    ],
)
def test_a_refused_number_is_named_by_its_option(
    line: str, option: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setenv("FIELDKIT_HOME", str(tmp_path))
    monkeypatch.setenv("FIELDKIT_LEDGER", str(tmp_path / "ledger.db"))
    assert main(line.split()) == 1
    assert capsys.readouterr().err.startswith(f"{option}: found ")
