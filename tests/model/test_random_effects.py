"""Effects as additional nuisances of simulated flights, named on the command line and drawn from their priors."""

import numpy as np
import pytest

from fieldkit.errors import BadValue
from fieldkit.model.prior_predictive import Truth, flown_motors, simulate
from fieldkit.model.random_effects import drawn, known_effects, priors
from fieldkit.motors import catalogue
from fieldkit.physics.effect import Prior, effects

pytestmark = pytest.mark.fast

MOTORS = flown_motors(catalogue().motors)[::60]


@pytest.fixture(scope="module")
def plain() -> Truth:
    """Simulated flights without effects."""
    return simulate(np.random.default_rng(1), MOTORS, 60)


@pytest.mark.sampled
@pytest.mark.parametrize("name", effects())
def test_every_effect_can_act_in_simulated_flights(name: str, plain: Truth) -> None:
    bent = simulate(np.random.default_rng(1), MOTORS, 60, [name])
    equal = len(plain) == len(bent) and np.allclose(plain.readouts, bent.readouts, equal_nan=True)
    assert not equal
    assert np.isfinite(bent.readouts[:, 0]).all()


def test_without_effects_the_flights_are_unchanged(plain: Truth) -> None:
    named = simulate(np.random.default_rng(1), MOTORS, 60, [])
    assert np.array_equal(plain.readouts, named.readouts, equal_nan=True)


def test_strengths_stay_within_the_bounds_of_their_prior() -> None:
    values = drawn(np.random.default_rng(2), Prior(0.1, 1.0, 0.0, 0.5), 500)
    assert values.min() >= 0
    assert values.max() <= 0.5


def test_an_unknown_effect_is_refused_with_the_known_ones() -> None:
    with pytest.raises(BadValue, match=r"no effect 'gusts', expected one of: air_density, .*wind"):
        known_effects(["wind", "gusts"])


def test_the_drawn_effects_are_in_the_card() -> None:
    assert priors(["mass_offset"]) == {
        "mass_offset": "normal, 0 and 0.09, between -0.5 and 0.6 [fraction of the dry mass]"
    }
