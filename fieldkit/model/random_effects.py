"""Registered effects as additional nuisances of simulated flights, each with a strength drawn from its prior."""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from fieldkit.errors import BadValue, unknown
from fieldkit.physics.effect import Effect, Prior, effects
from fieldkit.physics.state import Setup
from fieldkit.shapes import Array, Float

MOST_FLOWN = 20
"""Maximum number of earlier flights of a rocket, for effects that grow from flight to flight. [1]"""

EffectStrengths = tuple[tuple[Effect, Float[Array, "flight"]], ...]
"""Effects and their strengths, one per flight."""


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


def bent(rng: np.random.Generator, names: Sequence[str], setup: Setup, count: int) -> tuple[Setup, EffectStrengths]:
    """The setup of a number of flights as changed by the named effects, and the effects that will act on the readings.

    Without names, no random number is drawn. Raises BadValue for an effect that is not registered.
    """
    bends: list[tuple[Effect, Array]] = []
    for effect in known_effects(names).values():
        strength = effect.strength(drawn(rng, effect.prior, count))
        if effect.grows:
            strength = strength * rng.integers(MOST_FLOWN + 1, size=count)
        setup = effect.bend_setup(setup, strength)
        bends.append((effect, strength))
    return setup, tuple(bends)


def shown_by(bends: EffectStrengths, readouts: Mapping[str, Float[Array, "flight"]]) -> Mapping[str, Any]:
    """The readouts, in SI, as changed by the effects."""
    for effect, strength in bends:
        readouts = effect.bend_reading(readouts, strength)
    return readouts


def drawn(rng: np.random.Generator, prior: Prior, count: int) -> Float[Array, "flight"]:
    """Draws of a prior, within its bounds, in the unit of the effect.

    Source: rejection of draws out of bounds, von Neumann (1951), which gives the truncated normal distribution.
    """
    values = rng.normal(prior.mean, prior.sd, count)
    while (beyond := (values < prior.low) | (values > prior.high)).any():
        values[beyond] = rng.normal(prior.mean, prior.sd, int(beyond.sum()))
    return np.asarray(values)
