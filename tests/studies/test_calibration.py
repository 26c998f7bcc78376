"""Forecasts over the hyperprior: the quick form of `python -m studies.calibration`."""

from collections.abc import Sequence

import numpy as np
import pytest

from fieldkit.model.hyperprior import learned
from fieldkit.shapes import Array
from studies.calibration import TruthRank, coverage, rank, ranked, table, uniformity
from tests.effort import THOROUGH

CHECK_SHAPES = False
LEDGERS = 40 if THOROUGH else 24
CHANCE = 0.001
"""Significance level of the test for uniform ranks: a false alarm in one of a thousand runs."""


@pytest.fixture(scope="module")
def found() -> list[TruthRank]:
    return [ranked(number, learned(), rockets=2) for number in range(LEDGERS)]


def ranks(found: Sequence[TruthRank], figure: str) -> Array:
    return np.array([getattr(one, figure) for one in found])


@pytest.mark.parametrize("figure", ["apogee", "log_cd"])
def test_forecasts_of_drawn_ledgers_are_calibrated(found: list[TruthRank], figure: str) -> None:
    from scipy.stats import binom

    own = ranks(found, figure)
    assert uniformity(own) > CHANCE
    for level in (0.5, 0.9):
        low, high = binom.ppf((CHANCE / 2, 1 - CHANCE / 2), LEDGERS, level) / LEDGERS
        assert low <= coverage(own, level) <= high


def test_the_table_has_a_line_for_every_group(found: list[TruthRank]) -> None:
    lines = table(found)
    assert lines[2].startswith("all ")
    assert f"{LEDGERS:5d}" in lines[2]
    assert any(line.startswith("readouts: apogee ") for line in lines)


@pytest.mark.parametrize(("shift", "width"), [(0.0, 0.5), (0.8, 1.0), (0.0, 2.5)], ids=["narrow", "biased", "wide"])
def test_a_distorted_posterior_is_noticed(shift: float, width: float) -> None:
    rng = np.random.default_rng(1)
    draws, truths = shift + width * rng.normal(size=(60, 999)), rng.normal(size=60)
    own = np.array([rank(row, truth, rng) for row, truth in zip(draws, truths.tolist(), strict=True)])
    assert uniformity(own) < CHANCE


def test_uniform_ranks_are_rejected_at_the_stated_rate() -> None:
    rng = np.random.default_rng(6)
    found = np.array([uniformity(rng.uniform(size=40), seed) for seed in range(100)])
    assert 0 <= (found < 0.1).sum() <= 20
    assert (found > 0.5).sum() > 30
