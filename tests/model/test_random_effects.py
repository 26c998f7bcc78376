"""Priors of effects: draws, words in a card, and unknown names."""

import numpy as np
import pytest

from fieldkit.errors import BadValue
from fieldkit.model.random_effects import drawn, known_effects, priors
from fieldkit.physics.effect import Prior

pytestmark = pytest.mark.fast


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
