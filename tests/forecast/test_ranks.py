"""Ranks of flights drawn from the model in their forecasts."""

import numpy as np

from fieldkit.flight import Flight
from fieldkit.forecast.assumed import forecast_model
from fieldkit.model.hyperprior import START
from fieldkit.model.readout_data import OBSERVED_READOUTS
from fieldkit.motors import catalogue
from fieldkit.physics.history import flown_and_planned
from studies.generated_ledgers import drawn_causes, drawn_scale
from tools.ranks import page, rank

MOTOR = catalogue().resolve("F24")


def test_a_flight_drawn_from_the_model_has_a_rank_in_its_forecast() -> None:
    found = rank(np.random.default_rng(2), START)
    assert 0.0 <= found <= 1.0
    assert found == rank(np.random.default_rng(2), START), "a ledger belongs to its seed"


def test_causes_are_as_frequent_as_their_prior_and_hit_what_is_seen() -> None:
    flights = [(Flight(str(n), "R", "A", "F24", dry_mass=0.3, diameter=0.066), MOTOR) for n in range(400)]
    model = forecast_model(flown_and_planned(flights), hyperprior=START)
    at = np.array([term.mean for term in model.terms])
    seen = np.broadcast_to(np.isin(OBSERVED_READOUTS, ("apogee",)), (len(flights), len(OBSERVED_READOUTS)))
    change = drawn_causes(np.random.default_rng(3), model, at, seen)
    share = np.any(change != 0, axis=1).mean()
    assert abs(share - 0.1) < 0.05, "one flight in ten has something; 0.015 is the standard error"
    assert not change[:, ~seen[0]].any(), "a readout that no one reads has no change"


def test_drawn_scales_have_their_prior() -> None:
    rng = np.random.default_rng(1)
    drawn = np.log([drawn_scale(rng, START.scatter).grid[0] for _ in range(400)])
    assert abs(np.median(drawn)) < 0.1
    assert 0.4 < drawn.std() < 0.65, "0.58 without the ends of the range"


def test_biased_forecasts_are_noticed() -> None:
    even = (np.arange(400) + 0.5) / 400
    fair, low = ([float(x) for x in list(page(ranks))[-3].split("|")[5:7]] for ranks in (even, even**0.7))
    assert min(fair) > 0.05
    assert max(low) < 0.01
