"""The verdict: probable effects are named, and given effects are accepted."""

import re
from dataclasses import replace
from datetime import datetime
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from fieldkit.errors import UnknownEffect
from fieldkit.flight import Flight
from fieldkit.model.readout_data import OBSERVED_READOUTS, observe
from fieldkit.model.rocket_model import Model, Term, base_model
from fieldkit.model.simulated_readouts import shown
from fieldkit.model.term_names import TermName
from fieldkit.motors import catalogue
from fieldkit.physics.effect import effects
from fieldkit.physics.history import history_of
from fieldkit.presentation.loop_text import how_sure, what_forecasts_become
from fieldkit.selection import verdict as verdicts
from fieldkit.selection.candidates import EACH_GROUP, Candidate, Pattern, Place, effect_candidates, effect_terms
from fieldkit.selection.diagnose import averaged, diagnose
from fieldkit.selection.hypotheses import Hypothesis, SetPosterior
from fieldkit.selection.model_check import ModelCheck
from fieldkit.selection.patterns import pattern_candidates
from fieldkit.selection.prior import UNEXPLAINED
from fieldkit.selection.verdict import (
    COST_OF_FALSE_NAME,
    NAMING_PROBABILITY,
    of_heights,
    verdict,
    verdict_that_fits,
)

pytestmark = pytest.mark.fast

CHECK_SHAPES = False


def posterior(weights: dict[str, float]) -> SetPosterior:
    """A posterior over sets, joined by `+`, with these probabilities; an empty name means no effect."""
    seen = SimpleNamespace(seen=np.ones((1, 1), bool))
    fitted = SimpleNamespace(log_evidence=0.0, weights=np.ones(1), data=seen)

    def candidate(name: str) -> Candidate:
        effect = "" if name == UNEXPLAINED else name
        bends = effects()[effect] if effect else "drag"
        place = Place(effect) if effect else Place(pattern=Pattern("day", "before"))
        return Candidate(place, (Term(TermName(name, "effect"), bends, 0.0, 1.0, np.ones(1)),))

    return SetPosterior(
        tuple(
            Hypothesis(tuple(candidate(one) for one in name.split("+") if one), fitted, float(np.log(weight)))
            for name, weight in weights.items()
        )
    )


@pytest.mark.parametrize(
    ("weights", "effect", "confidence", "also"),
    [
        ({"": 0.6, "wind": 0.4}, "none", 0.6, ()),
        ({"": 0.2, "wind": 0.76, "wear": 0.04}, "wind", 0.76, ()),
        ({"": 0.05, "wind": 0.7, "wear": 0.25}, "wind", 0.7, ("wear",)),
        ({"": 0.1, "wind+wear": 0.5, "wind": 0.4}, "wind", 0.9, ("wear+wind",)),
        ({"": 0.1, "wind+wear": 0.3, "wind": 0.6}, "wind", 0.9, ()),
        ({"wind+wear": 0.2, "wind+wear+unexplained": 0.2, "wind": 0.6}, "wind", 1.0, ("wear+wind",)),
        ({"": 0.1, "wind+wear": 0.8, "wind": 0.1}, "wind+wear", 0.8, ()),
        ({"": 0.1, "wind": 0.5, "wear": 0.4}, "wind", 0.9, ("wear",)),
        ({"": 0.2, "unexplained": 0.7, "wind": 0.1}, "unexplained", 0.8, ()),
        ({"": 0.2, "unexplained": 0.4, "wind": 0.4}, "unexplained", 0.8, ("wind",)),
    ],
)
def test_effects_that_are_probable_enough_are_named(
    weights: dict[str, float],
    effect: str,
    confidence: float,
    also: tuple[str, ...],
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(verdicts, "in_words", lambda accepted: "it is there")
    named = verdict(posterior(weights))
    assert named.effect == effect
    assert named.confidence == pytest.approx(confidence)
    assert named.also == also


@pytest.mark.parametrize(
    ("weights", "why"),
    [
        ({"": 0.85, "wind": 0.15}, "the flights match the model within their scatter"),
        ({"": 0.6, "wind": 0.4}, "the most probable is weathercocking in the wind, 40%"),
        ({"": 0.4, "heavier_recovery": 0.35, "wind": 0.25}, "the most probable is a wrong mass, 35%"),
        ({"": 0.45, "unexplained": 0.55}, "something may be missing, but nothing is probable enough to name"),
    ],
)
def test_a_verdict_of_none_does_not_deny_a_probable_unknown_effect(weights: dict[str, float], why: str) -> None:
    named = verdict(posterior(weights))
    assert named.effect == "none"
    assert named.why.endswith(why)


@pytest.mark.parametrize("p", [1.0, 0.02])
@pytest.mark.parametrize(
    "weights",
    [
        {"": 0.62, "wind": 0.38},
        {"": 0.9, "wind": 0.1},
        {"": 0.1, "wind": 0.9},
        {"": 0.5, "wind": 0.43, "wear": 0.01, "mach_drag": 0.02, "base_drag": 0.02, "tip_off": 0.02},
    ],
)
def test_a_flyer_can_add_up_the_chances_of_a_verdict(
    weights: dict[str, float], p: float, monkeypatch: pytest.MonkeyPatch
) -> None:
    """What the loop tries and anything else make what is missing; forecasts use no correction for the rest."""
    monkeypatch.setattr(verdicts, "in_words", lambda accepted: "it is there")
    sets, check = posterior(weights), ModelCheck(p, None)
    named = verdict_that_fits(verdict(sets), check, sets.nothing)
    found: Any = SimpleNamespace(
        diagnosis=SimpleNamespace(
            effect=named.effect,
            confidence=named.confidence,
            also=named.also,
            accepted=named.accepted,
            posterior=sets,
            averaged=averaged(sets),
        )
    )
    sure = [int(one) for one in re.findall(r"(\d+)%", how_sure(found))]
    over, _, others = what_forecasts_become(found).partition(";")
    forecasts = {name: int(chance) for chance, name in re.findall(r"(\d+)% ([^,]+)", over)}
    rare = re.search(r"sets below 2%, (\d+)% in all", others)
    assert sum(forecasts.values()) + (int(rare[1]) if rare else 0) == 100
    assert ("match the model" in named.why) == (named.effect == "none" and sure[0] < 20), named.why
    if named.effect == "none":
        missing, tried, other = sure
        assert missing == tried + other
        assert tried == 100 - forecasts["no correction"]
    else:
        right, other = sure
        assert right + other == 100 - forecasts["no correction"]


@pytest.mark.parametrize(("lowers", "effect"), [(0.001, "wind"), (0.05, "early_ejection+wind")])
def test_an_effect_that_hardly_changes_the_heights_is_not_named_beside_one_that_does(
    lowers: float, effect: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    changes = {"wind": 0.1, "early_ejection": lowers}
    monkeypatch.setattr(verdicts, "in_words", lambda accepted: "it is there")
    monkeypatch.setattr(verdicts, "own_variance", lambda fit: np.full((1, 1), 0.05**2))
    monkeypatch.setattr(
        verdicts,
        "with_and_without",
        lambda trial: {"apogee": np.exp([[-changes[trial.candidate.effect]], [0.0]])},
    )
    found = posterior({"": 0.1, "early_ejection+wind": 0.8, "wind": 0.1})
    named = of_heights(verdict(found), found)
    assert named.effect == effect
    assert named.confidence == pytest.approx(0.9 if effect == "wind" else 0.8)
    assert ("early_ejection" in named.why) == (effect == "wind")


def test_at_the_threshold_naming_and_not_naming_have_the_same_cost() -> None:
    assert pytest.approx(NAMING_PROBABILITY) == COST_OF_FALSE_NAME * (1 - NAMING_PROBABILITY)


def test_the_inclusion_probability_is_the_sum_over_sets_with_the_effect() -> None:
    found = posterior({"": 0.1, "wind+wear": 0.5, "wind": 0.4})
    assert found.inclusion == pytest.approx({"wind": 0.9, "wear": 0.5})
    assert found.without(["wear"]).inclusion == pytest.approx({"wind": 0.8})
    assert found.probability.sum() == pytest.approx(1.0)


def season(**columns: list[Any]) -> Model:
    """Sixteen flights on four days of one rocket in two configurations, at a site without a description."""
    flights = [
        Flight(
            f"{number:02d}",
            "Astra",
            "AB"[number % 2],
            ("F24", "F39", "E35")[number % 3],
            datetime(2026, 5, 1 + 7 * (number // 4), 10 + number % 4),
            dry_mass=(0.322, 0.448)[number % 2],
            diameter=0.066,
            delay=12.0,
        ).with_changes(**{name: values[number] for name, values in columns.items()})
        for number in range(16)
    ]
    return base_model(history_of(flights, [catalogue().resolve(flight.motor) for flight in flights]))


def measured(model: Model, scatter: float = 0.01, seed: int = 3) -> Model:
    """The same flights with simulated readouts, with slightly different thrust and drag each time."""
    rng = np.random.default_rng(seed)
    values = np.array([[term.mean for term in model.terms]])
    size = (1, len(model.flights))
    scatter_draws = {"thrust": scatter * rng.normal(size=size), "drag": scatter * rng.normal(size=size)}
    readings = shown(model, values, scatter_draws)
    read = {name: readings[name][0] * (1 + 0.004 * rng.normal(size=size[1])) for name in OBSERVED_READOUTS}
    flights = [
        flight.with_changes(**{name: float(read[name][row]) for name in OBSERVED_READOUTS})
        for row, flight in enumerate(model.flights)
    ]
    return replace(model, history=replace(model.history, flights=tuple(flights)))


def test_hot_and_cold_days_change_the_air_density_and_the_altimeter_together() -> None:
    kelvin = [288.15 + (-10.0, 14.0, 2.0, 22.0)[number // 4] for number in range(16)]
    flown = measured(season(temperature=kelvin))
    forgotten = [flight.with_changes(temperature=None) for flight in flown.flights]
    model = base_model(history_of(forgotten, flown.found))
    diagnosis = diagnose(model, observe(history_of(forgotten, flown.found, used_in_fit=[True] * 16)))
    assert diagnosis.effect == "air_density"
    (trial,) = diagnosis.accepted
    assert trial.candidate.place == Place("weather", EACH_GROUP)
    mean, sd = trial.strength()
    assert abs(mean - np.sqrt(np.mean([100, 196, 4, 484]))) < 3 * sd
    assert diagnosis.after.mae < diagnosis.before.mae


def test_an_effect_given_by_the_flyer_is_accepted_whatever_the_evidence() -> None:
    model = measured(season())
    data = observe(model.history.using([True] * 16))
    taken = diagnose(model, data, given=("wear", "mass_offset"))
    assert taken.effect == "wear+mass_offset"
    assert [trial.candidate.effect for trial in taken.accepted] == ["wear", "mass_offset"]
    assert abs(taken.accepted[0].strength()[0]) < 0.01
    assert taken.confidence < 0.5


def test_the_probability_of_a_given_effect_is_counted_once() -> None:
    model = measured(season())
    taken = diagnose(model, observe(model.history.using([True] * 16)), given=("mass_offset",))
    assert taken.confidence == pytest.approx(taken.posterior.inclusion["mass_offset"], rel=0.3)


@pytest.mark.parametrize("name", ["gremlins", "", "wind"])
def test_an_unknown_effect_or_one_that_no_flight_could_show_is_an_error(name: str) -> None:
    model = measured(season())
    with pytest.raises(UnknownEffect, match="mass_offset"):
        diagnose(model, observe(model.history.using([True] * 16)), given=(name,))


def test_an_effect_of_each_day_has_a_strength_for_every_day_without_a_temperature() -> None:
    model = season(temperature=[290.0] * 4 + [None] * 12)
    terms = effect_terms(Place("weather", EACH_GROUP), model)
    assert len(terms) == 3
    np.testing.assert_array_equal(sum(term.weight for term in terms), [0.0] * 4 + [1.0] * 12)


def test_the_forms_of_an_effect_share_its_prior_odds() -> None:
    model = season(site=["mead", "hill"] * 8)
    shares: dict[str, float] = {}
    for candidate in effect_candidates(model, np.ones(16, bool)):
        shares[candidate.effect] = shares.get(candidate.effect, 0.0) + float(np.exp(candidate.log_fraction))
    assert shares.pop("air_density") == pytest.approx(1.0)
    assert all(one == pytest.approx(1.0) for one in shares.values())


def test_a_flyers_own_column_is_tested_as_a_pattern() -> None:
    paint = [{"paint": "rough" if number % 3 else "smooth"} for number in range(16)]
    names = [candidate.place.pattern for candidate in pattern_candidates(season(extra=paint))]
    assert Pattern("text", "paint", "rough") in names
    assert Pattern("text", "paint", "smooth") in names
    assert not any("paint" in str(candidate.place) for candidate in pattern_candidates(season()))
