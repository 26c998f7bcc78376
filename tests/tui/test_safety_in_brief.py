"""The safety checks beside a forecast, by name."""

from fieldkit.planning.check import BY_EYE, SafetyCheck
from fieldkit.presentation.forecast_text import when_it_fires
from fieldkit.tui.next.next_words import folded, safety_in_brief, unfolded


def test_checks_that_only_the_flyer_can_make_are_counted() -> None:
    lines = [
        SafetyCheck("ceiling", "unknown", "no ceiling given", ""),
        SafetyCheck("misfire", "unknown", f"{BY_EYE}wait a minute", ""),
        SafetyCheck("rail exit speed", "caution", "13 m/s", ""),
    ]
    assert list(safety_in_brief(lines)) == ["! rail exit speed", "? 1 not given, 1 to check yourself"]


def test_folded_checks_say_what_was_found_and_unfolded_ones_the_rule_and_its_source_too() -> None:
    line = SafetyCheck("certification", "caution", "2 (fieldkit flyer --certification 1)", "NFPA 1127", "Be certified")
    assert next(iter(folded([line], "SI"))) == "! certification: caution: 2 (Ctrl+P, Your card)"
    assert next(iter(unfolded([line], "SI"))) == (
        "! certification: caution: 2 (Ctrl+P, Your card). The rule: Be certified [NFPA 1127]"
    )


def test_a_charge_fires_before_at_or_after_apogee() -> None:
    assert [when_it_fires(seconds) for seconds in (-0.3, -0.04, 0.04, 1.25)] == [
        "0.3 s BEFORE apogee",
        "at apogee",
        "at apogee",
        "1.2 s after apogee",
    ]
