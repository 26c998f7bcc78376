"""The safety checks in short: nothing that failed is shortened, nothing is left out."""

from fieldkit.planning.check import ADVICE_NOTE, BY_EYE, SafetyCheck, Verdict, short_safety_text, speed

LINES = [
    SafetyCheck(
        "ground wind", "unsafe", f"{speed(12.0)}; no launch above {speed(8.9)}", "NAR", "“20 miles per hour”", "O"
    ),
    SafetyCheck("class", "ok", "a model rocket", "NAR", "“class 1”", "O"),
    SafetyCheck("sky", "unknown", f"{BY_EYE}not into clouds", "NAR", "“not into clouds”", "O"),
    SafetyCheck("launch angle", "unknown", "not given; at most 30°", "NAR", "“within 30 degrees”", "O"),
    SafetyCheck("thrust to weight", "caution", "4.7 on average; good above 5", "ThrustCurve"),
    SafetyCheck("complex rocket", "ok", "one motor", "NAR"),
]


def test_passed_checks_are_named_and_failed_ones_come_last_in_full() -> None:
    assert list(short_safety_text(LINES)) == [
        "✓ ok: class, complex rocket",
        "? check yourself: sky",
        "? launch angle: not given; at most 30°",
        LINES[4].words(),
        LINES[0].words(),
        ADVICE_NOTE,
    ]
    assert "The rule: “20 miles per hour”" in LINES[0].words()


def test_figures_have_the_units_of_the_system() -> None:
    assert "26.8 mph; no launch above 19.9 mph" in list(short_safety_text(LINES, "US"))[-2]


def test_groups_without_a_check_are_left_out() -> None:
    assert list(short_safety_text([LINES[4]])) == [LINES[4].words(), ADVICE_NOTE]


def test_an_unverified_rule_is_marked_whatever_its_verdict() -> None:
    verdicts: tuple[Verdict, ...] = ("ok", "unknown", "caution")
    lines = [SafetyCheck("launch angle", one, "at most 20°", "Tripoli", "within 20 degrees", "U") for one in verdicts]
    texts = list(short_safety_text(lines))
    assert texts[0] == "✓ ok: launch angle (unverified)"
    assert texts[1] == "? launch angle: at most 20° (unverified)"
    assert "(unverified)" in texts[2]


def test_a_check_by_eye_of_two_rule_sets_is_named_once() -> None:
    twice = [LINES[2], SafetyCheck("sky", "unknown", f"{BY_EYE}no more than five-tenths cloud", "FAA")]
    assert next(short_safety_text(twice)) == "? check yourself: sky"
