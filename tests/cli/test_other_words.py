"""Commands, options, columns, motors and pages under another name: the message names the one that is meant."""

import pytest

from fieldkit.cli.main import OTHER_OPTIONS, OTHER_WORDS, SUBJECT_OF
from fieldkit.errors import nearest
from tests.commands import Run


@pytest.mark.parametrize(("word", "meant"), OTHER_WORDS.items())
def test_a_command_under_another_name_is_named(run: Run, word: str, meant: str) -> None:
    assert f"No such command '{word}'. Did you mean '{meant}'?" in run(word, status=2).err
    assert word not in SUBJECT_OF
    assert meant.startswith("--") or meant in SUBJECT_OF


@pytest.mark.parametrize(
    ("command", "typed", "meant"),
    [
        ("predict", "--temp", "--temperature"),
        ("add", "--coast", "--coast-to-apogee"),
        ("add", "--mass", "--dry-mass, --lift-off-mass"),
        ("add", "--altitude", "--apogee, --eject-altitude"),
        ("predict", "--altitude", "--main-altitude"),
        ("add", "--drymass", "--dry-mass, --dry-mass-g"),
    ],
)
def test_an_option_that_is_cut_short_or_has_another_name_is_named(
    run: Run, command: str, typed: str, meant: str
) -> None:
    err = " ".join(run(command, typed, "3", status=2).err.replace("│", " ").split())
    assert f"No such option: {typed} (Possible options: {meant})" in err


def test_other_names_of_options_are_not_options(run: Run) -> None:
    assert not any(other in run("add", "--help").out for other in OTHER_OPTIONS)


def test_the_beginning_of_a_name_is_meant_before_a_similar_one() -> None:
    assert nearest("temp", ["site", "temperature", "timer"]) == ["temperature"]
    assert nearest("Der", ["Der Red Max", "Deer"]) == ["Der Red Max", "Deer"]


def test_a_motor_with_its_digits_in_another_order_is_named_first(run: Run) -> None:
    assert "no motor 'F93-6'; did you mean AeroTech F39T," in run("predict", "--motor", "F93-6", status=1).err


@pytest.mark.parametrize(("command", "title"), [("ballast", "Plan the next flight"), ("units", "Commands for the l")])
def test_the_manual_opens_at_the_page_about_a_command(run: Run, command: str, title: str) -> None:
    assert title in run("docs", command).out
