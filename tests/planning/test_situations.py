"""The planning situations of `situations.toml`, each with the right answer and its source, as a flyer asks for them."""

import json
import shlex
import tomllib
from pathlib import Path

import pytest

from tests.commands import Run

TABLE = Path(__file__).with_name("situations.toml")
SITUATIONS = tomllib.loads(TABLE.read_text(encoding="utf-8"))["situation"]


PLANS = [one for one in SITUATIONS if "plan" in one]
QUESTIONS = [one for one in SITUATIONS if "ask" in one]


def _import_flights(one: dict[str, str], run: Run, folder: Path) -> None:
    if "flights" in one:
        (folder / "flights.csv").write_text(one["flights"].strip())
        run("import", folder / "flights.csv")


@pytest.mark.parametrize("one", QUESTIONS, ids=[one["name"] for one in QUESTIONS])
def test_a_question_has_the_right_answer(one: dict[str, str], run: Run, tmp_path: Path) -> None:
    _import_flights(one, run, tmp_path)
    answer = run(*shlex.split(one["ask"]), status=None)
    assert " ".join(one["says"].split()) in " ".join((answer.out + answer.err).split())


@pytest.mark.parametrize("one", PLANS, ids=[one["name"] for one in PLANS])
def test_a_situation_has_the_right_verdict_for_the_right_reason(one: dict[str, str], run: Run, tmp_path: Path) -> None:
    _import_flights(one, run, tmp_path)
    if "flyer" in one:
        run("flyer", *shlex.split(one["flyer"]))
    (made,) = json.loads(run("predict", *shlex.split(one["plan"]), "--json").out)["predictions"]
    found = [line for line in made["safety"] if line["check"] == one["check"]]
    assert [line["verdict"] for line in found] == [one["verdict"]], found
    shown = found[0]["text"] + found[0].get("rule", "")
    assert one.get("says", "") in shown, shown


def test_every_situation_names_its_source_and_all_verdicts_occur() -> None:
    assert all(one["source"] for one in SITUATIONS)
    assert len({one["name"] for one in SITUATIONS}) == len(SITUATIONS) >= 45
    assert len(PLANS) + len(QUESTIONS) == len(SITUATIONS)
    assert {one["verdict"] for one in PLANS} == {"ok", "caution", "unsafe", "unknown"}
