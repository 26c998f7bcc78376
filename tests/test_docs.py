"""What the README says is so: its commands run, its paths exist, its examples work, CI runs what it shows."""

import re
import shlex
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest

from fieldkit.cli.main import main
from fieldkit.errors import DamagedLog

ROOT = Path(__file__).parents[1]
README = (ROOT / "README.md").read_text(encoding="utf-8")
TO_BE_MADE = {"parsers/skylark.py", "models/effects/sticky_altimeter.py", ".venv/bin"}
"""Paths of the README that a reader makes."""


def blocks(language: str) -> list[str]:
    """The fenced blocks of the README in a language."""
    return re.findall(rf"^```{language}\n(.*?)^```$", README, flags=re.MULTILINE | re.DOTALL)


def quoted() -> Iterator[str]:
    """Everything in the README's running text that is set as code."""
    text = re.sub(r"^```.*?^```$", "", README, flags=re.MULTILINE | re.DOTALL)
    yield from re.findall(r"`([^`]+)`", text)


SETUP, TESTS, *EXAMPLES = [block.strip() for block in blocks("sh")]


@pytest.fixture
def at_the_root(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """A flyer's shell in the checkout, with an empty ledger of their own."""
    monkeypatch.setenv("FIELDKIT_LEDGER", str(tmp_path / "ledger.db"))
    monkeypatch.setenv("XDG_DATA_HOME", str(tmp_path))
    monkeypatch.setenv("COLUMNS", "80")
    monkeypatch.chdir(ROOT)


@pytest.mark.usefixtures("at_the_root")
def test_the_examples_run_one_after_the_other(tmp_path: Path) -> None:
    lines = [line for block in EXAMPLES for line in block.splitlines()]
    assert len(lines) >= 10
    for line in lines:
        program, *arguments = shlex.split(line)
        assert program == "fieldkit"
        arguments = [str(tmp_path / one) if one in ("flights.csv", "card.pdf") else one for one in arguments]
        assert main(arguments) == 0, line


def test_every_command_that_is_mentioned_exists(capsys: pytest.CaptureFixture[str]) -> None:
    commands = {words[1] for text in quoted() if (words := text.split())[0] == "fieldkit" and len(words) > 1}
    assert len(commands) >= 5
    for command in commands - {"COMMAND"}:
        assert main([command, "--help"]) == 0, command
    capsys.readouterr()


def test_every_path_that_is_mentioned_exists() -> None:
    words = {word for text in quoted() for word in text.split()}
    words |= set(re.findall(r"\]\(([^)]+)\)", README))
    paths = {word for word in words if re.fullmatch(r"\.?[\w]+(/[\w.]+)+/?|[\w]+\.(md|toml)", word)}
    assert len(paths) >= 12
    for path in paths - TO_BE_MADE:
        assert (ROOT / path).exists(), path


def test_ci_runs_the_second_command_as_it_stands() -> None:
    assert "pytest" in TESTS
    assert TESTS in [line.strip() for line in (ROOT / ".ci" / "run").read_text().splitlines()]


def test_the_first_command_ends_in_the_demo() -> None:
    assert "pip install ." in SETUP
    assert SETUP.endswith("fieldkit demo")


def test_the_logger_of_the_readme_is_read() -> None:
    parser, _ = blocks("python")
    module: dict[str, object] = {}
    exec(compile(parser, "skylark.py", "exec"), module)
    skylark = module["PARSER"]
    log = b"SKYLARK 2\n0.00,0\n0.05,12.5\n0.10,100\n"
    assert skylark.recognises(log)
    (reading,) = skylark.read(log)
    assert reading.stated == {"apogee": pytest.approx(30.48)}
    with pytest.raises(DamagedLog, match=r"row 3: found '0\.05'"):
        skylark.read(b"SKYLARK 2\n0.00,0\n0.05\n")


def test_the_effect_of_the_readme_bends_the_reading() -> None:
    _, effect = blocks("python")
    module: dict[str, object] = {}
    exec(compile(effect, "sticky_altimeter.py", "exec"), module)
    sticky = module["EFFECT"]
    readings = {"apogee": np.array([[100.0, 200.0]]), "top_speed": np.array([[50.0, 60.0]])}
    bent = sticky.bend_reading(readings, np.array([[2.0, 2.0]]))
    assert bent["apogee"].tolist() == [[98.0, 198.0]]
    assert bent["top_speed"].tolist() == [[50.0, 60.0]]


def test_the_picture_is_of_this_demo() -> None:
    picture = (ROOT / "docs" / "demo.svg").read_text(encoding="utf-8")
    words = re.findall(r"<text[^>]*>([^<]*)</text>", picture)
    source = (ROOT / "fieldkit" / "cli" / "demo.py").read_text(encoding="utf-8")
    assert "Astra" in " ".join(words)
    for heading in ("flight", "motor", "apogee", "Cd", "alpha", "tag", "ejection"):
        assert heading in words
        assert f'"{heading}"' in source
