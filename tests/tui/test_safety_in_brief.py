"""The safety checks beside a forecast, by name."""

from fieldkit.planning.check import BY_EYE, SafetyCheck
from fieldkit.tui.next.next_words import safety_in_brief


def test_checks_that_only_the_flyer_can_make_are_counted() -> None:
    lines = [
        SafetyCheck("ceiling", "unknown", "no ceiling given", ""),
        SafetyCheck("misfire", "unknown", f"{BY_EYE}wait a minute", ""),
        SafetyCheck("rail exit speed", "caution", "13 m/s", ""),
    ]
    assert list(safety_in_brief(lines)) == ["! rail exit speed", "? 1 not given, 1 to check yourself"]
