"""The priors of registered effects: in words, and drawn for simulated flights."""

from collections.abc import Sequence

import numpy as np

from fieldkit.errors import BadValue, unknown
from fieldkit.physics.effect import Effect, Prior, effects
from fieldkit.shapes import Array, Float

MOST_FLOWN = 20
"""Maximum number of earlier flights of a rocket, for effects that grow from flight to flight. [1]"""


def known_effects(names: Sequence[str]) -> dict[str, Effect]:
    """The effects with these names, without duplicates. Raises BadValue for one that is not registered."""
    registry = effects()
    for name in names:
        if name not in registry:
            raise BadValue(unknown("effect", name, sorted(registry)))
    return {name: registry[name] for name in dict.fromkeys(names)}


def priors(names: Sequence[str]) -> dict[str, str]:
    """The priors of these effects in words, for a card. Raises BadValue for one that is not registered."""
    return {name: _words(effect) for name, effect in known_effects(names).items()}


def _words(effect: Effect) -> str:
    prior = effect.prior
    ends = f", between {prior.low:g} and {prior.high:g}"
    square = "its square: " if effect.squared else ""
    grown = f", times 0 to {MOST_FLOWN} flights before" if effect.grows else ""
    return f"{square}normal, {prior.mean:g} and {prior.sd:g}{ends}{grown} [{effect.unit}]"


def drawn(rng: np.random.Generator, prior: Prior, count: int) -> Float[Array, "flight"]:
    """Draws of a prior, within its bounds, in the unit of the effect.

    Source: rejection of draws out of bounds, von Neumann (1951), which gives the truncated normal distribution.
    """
    values = rng.normal(prior.mean, prior.sd, count)
    while (beyond := (values < prior.low) | (values > prior.high)).any():
        values[beyond] = rng.normal(prior.mean, prior.sd, int(beyond.sum()))
    return np.asarray(values)
