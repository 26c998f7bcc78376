"""The safety checks next to a forecast: what failed is stated, the others are counted."""

import pytest

from fieldkit.planning.check import ADVICE_NOTE, BY_EYE, SafetyCheck, Verdict, speed
from fieldkit.presentation.safety_text import every_check, failed_checks, other_checks
from tests.commands import Run

LINES = [
    SafetyCheck("class", "ok", "a model rocket", "NAR", "“class 1”", "O"),
    SafetyCheck("sky", "unknown", f"{BY_EYE}not into clouds", "NAR", "“not into clouds”", "O"),
    SafetyCheck("launch angle", "unknown", "not given; at most 30°", "NAR", "“within 30 degrees”", "O"),
    SafetyCheck("thrust to weight", "caution", "4.7 on average; good above 5", "ThrustCurve"),
    SafetyCheck(
        "ground wind", "unsafe", f"{speed(12.0)}; no launch above {speed(8.9)}", "NAR", "“20 miles per hour”", "O"
    ),
]


def test_failed_checks_come_first_and_the_others_are_counted() -> None:
    assert list(failed_checks(LINES)) == [
        "⊘ ground wind: unsafe: 12.0 m/s; no launch above 8.9 m/s",
        "! thrust to weight: caution: 4.7 on average; good above 5",
    ]
    assert list(other_checks(LINES)) == ["? 1 not given, 1 to check yourself", "✓ 1 passed"]


def test_every_check_in_full_has_its_rule_and_the_source_if_it_failed() -> None:
    first, *others, last = every_check(LINES, "US")
    assert first == ("⊘ ground wind: unsafe: 26.8 mph; no launch above 19.9 mph. The rule: “20 miles per hour” [NAR]")
    assert [text[0] for text in others] == ["!", "?", "?", "✓"]
    assert last == ADVICE_NOTE


def test_an_unverified_rule_is_marked_whatever_its_verdict() -> None:
    verdicts: tuple[Verdict, ...] = ("ok", "unknown", "caution")
    lines = [SafetyCheck("launch angle", one, "at most 20°", "Tripoli", "within 20 degrees", "U") for one in verdicts]
    assert sum("(unverified)" in text for text in every_check(lines)) == 3
    assert "(unverified)" in next(failed_checks(lines))


PLANNING = (["predict"], ["delay"], ["ballast", "--target", "700ft"], ["landing"], ["contest", "--season", "2027"])


@pytest.mark.sampled
@pytest.mark.parametrize("command", PLANNING, ids=lambda command: command[0])
def test_the_answer_comes_first_and_the_option_prints_every_check(run: Run, command: list[str]) -> None:
    plan = ["--rocket", "Lark", "--motor", "F39-6T", "--dry-mass", "400g", "--diameter", "66mm", "--wind", "10m/s"]
    folded, every = (run(*command, *plan, *more).out for more in ((), ("--checks",)))
    checks = folded.partition("\n  safety\n")[2]
    answer = folded.partition("\n\n")[0]
    assert every.startswith(answer)
    assert "safety" not in answer
    assert "not given" in checks
    assert "no launch above" in checks
    assert "The rule" not in checks
    assert "The rule" in every
    assert len(checks.splitlines()) < 8 < 20 < len(every.partition("\n  safety\n")[2].splitlines())


def test_checks_of_a_table_of_plans_are_printed_once_for_the_flights_they_concern(run: Run, tmp_path: object) -> None:
    table = f"{tmp_path}/plans.csv"
    with open(table, "w", encoding="utf-8") as file:
        file.write("flight_id,rocket,motor,dry_mass_g,diameter_mm,wind_mps\n")
        file.writelines(f"{flight},Lark,F39-6T,400,66,{wind}\n" for flight, wind in (("a", 10), ("b", 10), ("c", 2)))
    out = " ".join(run("predict", "--flights", table).out.split())
    assert out.count("a, b: ⊘ ground wind: unsafe: 10.0 m/s") == 1
    assert out.count("every flight: air ") == 1
    assert "--checks lists every check" in out
    assert "c: ? launch angle: unknown" in " ".join(run("predict", "--flights", table, "--checks").out.split()).replace(
        "every flight", "c"
    )
