"""The quick search: its added plan does not change the results of the flown flights."""

from dataclasses import replace
from typing import Any

import pytest

from fieldkit.forecast.at_once import forecast_at_once
from fieldkit.inference.history.effect_probabilities import EffectProbabilities, effect_probabilities
from fieldkit.selection import quick_look as quick_looks
from fieldkit.selection.quick_look import quick_look
from tests.inference.history.histories import history


def test_strong_wear_is_the_verdict() -> None:
    worn = history(24, wear=0.05)
    look = quick_look("Test", list(zip(worn.flights[:-1], worn.found[:-1], strict=True)), worn.used_in_fit)
    assert "wear" in look.effect.split("+")
    assert look.candidates[0].effect == "wear"
    assert look.candidates[0].log_bayes > 5
    assert look.after.mae < look.before.mae


def test_the_confidence_in_several_effects_is_that_all_are_present(monkeypatch: pytest.MonkeyPatch) -> None:
    chances = {"wear": 0.9, "wind": 0.8, "flutter": 0.1}

    def likely(*known: Any) -> EffectProbabilities:
        found = effect_probabilities(*known)
        return replace(found, inclusion={**dict.fromkeys(found.inclusion, 0.0), **chances}, none=0.01)

    monkeypatch.setattr(quick_looks, "effect_probabilities", likely)
    flights = history(6)
    look = quick_look("Test", list(zip(flights.flights[:-1], flights.found[:-1], strict=True)), flights.used_in_fit)
    assert (look.effect, look.confidence) == ("wear+wind", pytest.approx(0.9 * 0.8))


def test_a_plan_without_a_name_is_forecast_like_one_with_a_name() -> None:
    worn = history(12, wear=0.05)
    flown = list(zip(worn.flights[:-1], worn.found[:-1], strict=True))
    plan, found = worn.flights[-1], worn.found[-1]
    named, unnamed = (forecast_at_once(flown, (replace(plan, flight_id=name), found)) for name in ("next", ""))
    assert unnamed.apogees == pytest.approx(named.apogees)
