"""The prior over sets of effects: a new file changes only its family."""

from dataclasses import replace

import numpy as np
import pytest

from fieldkit.physics.effect import effects
from fieldkit.selection.prior import (
    FAMILIES,
    FAMILY_PROBABILITY,
    NO_EFFECT_PROBABILITY,
    UNEXPLAINED,
    inclusion_probabilities,
    log_prior_odds,
)

pytestmark = pytest.mark.fast


def test_another_effect_reduces_only_the_prior_of_its_own_family() -> None:
    more = {**effects(), "novelty": replace(effects()["wear"], title="novelty")}
    before, after = inclusion_probabilities(), inclusion_probabilities(more)
    others = [name for name, effect in effects().items() if effect.family != "aging" and not effect.form_of]
    assert {name: after[name] for name in others} == {name: before[name] for name in others}
    assert after["novelty"] + after["wear"] == pytest.approx(before["wear"])
    assert sum(after.values()) == pytest.approx(sum(before.values()))


def test_another_form_of_an_effect_changes_nothing() -> None:
    more = {**effects(), "haze": replace(effects()["weather"], title="haze")}
    assert inclusion_probabilities(more) == inclusion_probabilities()


def test_the_family_probability_follows_from_that_of_no_effect() -> None:
    nothing = (1 - FAMILY_PROBABILITY) ** (len(FAMILIES) + 1)
    assert nothing == pytest.approx(NO_EFFECT_PROBABILITY)
    chances = inclusion_probabilities()
    odds = sum(np.log(chances[name] / (1 - chances[name])) for name in ("wind", UNEXPLAINED))
    assert log_prior_odds(["wind", UNEXPLAINED]) == pytest.approx(odds)
