"""Ranks of flights drawn from the model in their forecasts."""

import numpy as np

from fieldkit.model.hyperprior import START
from tools.ranks import drawn_scale, page, rank


def test_a_flight_drawn_from_the_model_has_a_rank_in_its_forecast() -> None:
    found = rank(np.random.default_rng(2), START)
    assert 0.0 <= found <= 1.0
    assert found == rank(np.random.default_rng(2), START), "a ledger belongs to its seed"


def test_drawn_scales_have_their_prior() -> None:
    rng = np.random.default_rng(1)
    drawn = np.log([drawn_scale(rng, START.scatter).grid[0] for _ in range(400)])
    assert abs(np.median(drawn)) < 0.1
    assert 0.4 < drawn.std() < 0.65, "0.58 without the ends of the range"


def test_biased_forecasts_are_noticed() -> None:
    even = (np.arange(400) + 0.5) / 400
    fair, low = ([float(x) for x in list(page(ranks))[-1].split("|")[5:7]] for ranks in (even, even**0.7))
    assert min(fair) > 0.05
    assert max(low) < 0.01
