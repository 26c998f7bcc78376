"""The check of the averaged model: right models pass as often as chance says, and what they leave is found."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest

from fieldkit.inference.laplace.fit import fit
from fieldkit.inference.laplace.posterior import Fit
from fieldkit.model.certified_prior import CERTIFIED_PRIOR
from fieldkit.model.readout_data import observe
from fieldkit.physics.history import history_of
from fieldkit.selection.extended_model import rocket_model
from fieldkit.selection.model_check import MIN_P, UNLISTED, ModelCheck, fit_check
from fieldkit.selection.verdict import NAMING_PROBABILITY, LoopVerdict, verdict_that_fits
from fieldkit.shapes import Array
from tests.seasons import season

pytestmark = pytest.mark.fast

READOUTS = ("apogee", "top_speed", "burn_time", "coast_to_apogee")


def fitted(seed: int, bend: Callable[[Array], Array] = np.zeros_like, readout: str = "apogee") -> Fit:
    """A fit to twelve flights; `bend` is what a log readout has in addition, by flight."""
    flown = season(np.random.default_rng(seed), READOUTS, scatter=0.03)
    extra = np.exp(bend(np.arange(len(flown), dtype=float)))
    flights = [
        flight.with_changes(**{readout: (flight.number(readout) or 0.0) * float(more)})
        for (flight, _), more in zip(flown, extra, strict=True)
    ]
    found = [motor for _, motor in flown]
    model = replace(rocket_model(history_of(flights, found), hyperprior=CERTIFIED_PRIOR), coarse=True)
    return fit(model, observe(history_of(flights, found, used_in_fit=[True] * len(flights))), outlier_flights=True)


def test_right_models_are_rarely_rejected() -> None:
    p = np.array([fit_check(fitted(seed)).p for seed in range(12)])
    assert (p < MIN_P).mean() < 0.35
    assert np.median(p) > 0.15


@pytest.mark.parametrize(
    ("bend", "left"),
    [
        (lambda order: 0.03 * (order - 5.5), "order"),
        (lambda order: 0.25 * np.where(order < 6, 1.0, -1.0), "order"),
        (lambda order: 0.2 * np.where(order % 3 == 0, 1.0, -0.5), "readouts"),  # another motor on every third flight
    ],
)
def test_what_a_model_leaves_is_found_with_its_place(bend: Callable[[Array], Array], left: str) -> None:
    found = fit_check(fitted(3, bend, "coast_to_apogee"))
    assert found.p < MIN_P
    assert found.left == left
    assert "coast to apogee" in found.pattern


def test_a_single_wild_flight_is_no_pattern() -> None:
    assert fit_check(fitted(3, lambda order: -0.5 * (order == 7.0))).p > MIN_P


def named(confidence: float) -> LoopVerdict:
    return LoopVerdict("wind", confidence, "because", ("wear",))


def test_a_name_counts_the_unlisted_in_its_probability() -> None:
    fits = ModelCheck(0.6, None)
    assert fits.unlisted == pytest.approx(UNLISTED)
    found = verdict_that_fits(named(0.98), fits, 0.01)
    assert (found.effect, found.also) == ("wind", ("wear",))
    assert found.confidence == pytest.approx(0.98 * (1 - UNLISTED))


def test_whatever_is_named_must_explain_what_was_measured() -> None:
    left = ModelCheck(0.0025, "order", "a trend of the coast to apogee")
    found = verdict_that_fits(named(0.99), left, 0.001)
    assert found.effect == "unexplained"
    assert found.confidence > NAMING_PROBABILITY
    assert found.also == ("wind", "wear")
    assert "a trend of the coast to apogee beside wind" in found.why


def test_a_small_rest_makes_a_strong_name_less_sure_but_not_wrong() -> None:
    found = verdict_that_fits(named(0.99), ModelCheck(0.04, "readouts", "the apogee by motor"), 0.001)
    assert found.effect == "wind"
    assert 0.8 < found.confidence < 0.95


def test_a_smaller_p_value_makes_the_unlisted_more_probable() -> None:
    chances = [ModelCheck(p, None).unlisted for p in (0.5, 0.3, 0.1, 0.03, 0.01, 0.003)]
    assert chances == sorted(chances)
    assert chances[-1] > 0.5
