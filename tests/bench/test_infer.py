"""The scores of single flights: exact answers have no error, and confident wrong ones score worst."""

import math

import pytest

from bench.infer import line, misses

pytestmark = pytest.mark.fast


def posterior(middle: float, sd: float) -> dict[str, float]:
    """A log-normal posterior in the format of `infer`."""
    mean = middle * math.exp(sd**2 / 2)
    return {"cd": mean, "cd_sd": mean * math.sqrt(math.expm1(sd**2)), "alpha": 1.0}


def test_the_logarithm_of_a_log_normal_follows_from_its_mean_and_sd() -> None:
    ((error, sd, alpha),) = misses([posterior(0.66, 0.2)], 0.6)
    assert error == pytest.approx(math.log(0.66 / 0.6))
    assert sd == pytest.approx(0.2)
    assert alpha == 1.0


def test_a_flight_without_a_cd_is_left_out() -> None:
    assert not list(misses([{"cd": None, "cd_sd": None, "alpha": 1.0}, {"cd": math.nan, "cd_sd": 1, "alpha": 1}], 0.6))


def test_being_confident_and_wrong_scores_worse_than_being_unsure() -> None:
    sure, unsure = (list(misses([posterior(0.9, sd)], 0.6)) for sd in (0.1, 0.4))
    assert " 0%" in line("sure", sure)
    assert "100%" in line("unsure", unsure)
    assert float(line("sure", sure).split()[-2]) < float(line("unsure", unsure).split()[-2])
