"""Mixtures of Gaussians over two bounded parameters: density, draws and quantiles in numpy.

A parameter in an interval is mapped to the real line by the logit of its relative position, so no draw can leave the
interval. The mixture is defined on that scale.

Derivation: the logit is the inverse of the logistic function, whose derivative turns densities of one scale into those
of the other.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from fieldkit.shapes import Array, Flags, Float

COMPONENTS = 8
"""Number of Gaussians of each member."""
WIDTH = 6 * COMPONENTS
"""Number of outputs of a member: for each Gaussian a log weight, two means, two log precisions and a slope."""
LOG_PRECISION_RANGE = (-4.0, 7.0)
"""Bounds of the log of a precision, here the inverse of a standard deviation: 55 to 0.0009 on the logit scale."""
GUARD_SHARPEST = (-4.0, 6.0)
"""Bounds of the log of the inverse standard deviation with which a readout is predicted."""
_GRID = np.linspace(-1.0, 1.0, 161)
_REACH = 7.0
"""Half width of the grid of a marginal distribution, in its standard deviations. [1]"""


@dataclass(frozen=True, slots=True)
class Mixture:
    """Gaussians over the logits (x, y) of two parameters in their intervals, one row per flight.

    With unit normals z, x = mean_x + z1 / exp(sharp_x) and y = mean_y + (z2 + slope z1) / exp(sharp_y). `low` and
    `high` are the intervals.
    """

    weight: Float[Array, "flight part"]
    mean: Float[Array, "flight part 2"]
    sharp: Float[Array, "flight part 2"]
    slope: Float[Array, "flight part"]
    low: Float[Array, "flight 2"]
    high: Float[Array, "flight 2"]

    def __len__(self) -> int:
        return len(self.weight)

    def rows(self, which: Any) -> "Mixture":
        """The selected flights."""
        return Mixture(*(getattr(self, name)[which] for name in self.__dataclass_fields__))

    def log_density(self, values: Float[Array, "*draw #flight 2"]) -> Float[Array, "*draw #flight"]:
        """Log density of the two parameters; -inf outside their intervals. [nat]"""
        place = (values - self.low) / (self.high - self.low)
        inside: Flags = np.all((place > 0) & (place < 1), axis=-1)
        place = np.where(inside[..., None], place, 0.5)
        stretch = np.log(place * (1 - place) * (self.high - self.low)).sum(axis=-1)
        offset = np.log(place / (1 - place))[..., None, :] - self.mean
        scaled = offset * np.exp(self.sharp)
        square = scaled[..., 0] ** 2 + (scaled[..., 1] - self.slope * scaled[..., 0]) ** 2
        parts = np.log(self.weight + 1e-300) + self.sharp.sum(axis=-1) - 0.5 * square
        top = parts.max(axis=-1)
        total = top + np.log(np.exp(parts - top[..., None]).sum(axis=-1)) - np.log(2 * np.pi)
        return np.asarray(np.where(inside, total - stretch, -np.inf))

    def draws(self, rng: np.random.Generator, count: int) -> Float[Array, "draw flight 2"]:
        """Draws of the two parameters, in the unit of their intervals."""
        ladder = np.cumsum(self.weight, axis=-1)
        part = (rng.uniform(size=(count, len(self), 1)) * ladder[:, -1:] > ladder).sum(axis=-1)
        flight = np.arange(len(self))
        z = rng.normal(size=(count, len(self), 2))
        z[..., 1] += self.slope[flight, part] * z[..., 0]
        logit = self.mean[flight, part] + z * np.exp(-self.sharp[flight, part])
        return np.asarray(self.low + (self.high - self.low) / (1 + np.exp(-logit)))

    def margin(self, axis: int) -> "Margin":
        """The marginal distribution of the first parameter, 0, or the second, 1."""
        sd = np.exp(-self.sharp[..., axis])
        if axis == 1:
            sd = sd * np.sqrt(1 + self.slope**2)
        mean = (self.weight * self.mean[..., axis]).sum(axis=-1)
        spread = np.sqrt((self.weight * (sd**2 + (self.mean[..., axis] - mean[:, None]) ** 2)).sum(axis=-1))
        logit = mean[:, None] + _REACH * spread[:, None] * np.sign(_GRID) * np.abs(_GRID) ** 1.5
        density = np.zeros(logit.shape)
        for number in range(self.weight.shape[1]):
            offset = (logit - self.mean[:, number, axis, None]) / sd[:, number, None]
            density += (self.weight / sd)[:, number, None] * np.exp(-0.5 * offset**2)
        pieces = 0.5 * (density[:, 1:] + density[:, :-1]) * np.diff(logit, axis=1)
        below = np.concatenate([np.zeros((len(self), 1)), np.cumsum(pieces, axis=1)], axis=1)
        place = 1 / (1 + np.exp(-logit))
        low, high = self.low[:, axis, None], self.high[:, axis, None]
        return Margin(low + (high - low) * place, below / below[:, -1:])


@dataclass(frozen=True, slots=True)
class Margin:
    """The distribution of one parameter, one row per flight: values, and the cumulative probability at each."""

    values: Float[Array, "flight node"]
    below: Float[Array, "flight node"]

    def rows(self, which: Any) -> "Margin":
        """The selected flights."""
        return Margin(self.values[which], self.below[which])

    def quantiles(self, levels: Float[Array, "level"]) -> Float[Array, "flight level"]:
        """The quantiles at these probabilities, in the unit of the parameter."""
        return np.stack([np.interp(levels, row, at) for row, at in zip(self.below, self.values, strict=True)])

    def moments(self) -> tuple[Float[Array, "flight"], Float[Array, "flight"]]:
        """Mean and standard deviation, in the unit of the parameter."""
        return self.moments_of(self.values)

    def moments_of(self, values: Float[Array, "flight node"]) -> tuple[Float[Array, "flight"], Float[Array, "flight"]]:
        """Mean and standard deviation of a function of the parameter, given by its values at the nodes, in their
        unit."""
        mass = np.diff(self.below, axis=1)
        middle = 0.5 * (values[:, 1:] + values[:, :-1])
        mean = (mass * middle).sum(axis=1)
        return mean, np.sqrt((mass * (middle - mean[:, None]) ** 2).sum(axis=1))

    def rank(self, values: Float[Array, "flight"]) -> Float[Array, "flight"]:
        """The cumulative probability at one value per flight. [1]"""
        rows = zip(values, self.values, self.below, strict=True)
        return np.array([np.interp(value, at, row) for value, at, row in rows])


def mixture(
    outputs: Float[Array, "flight member output"], low: Float[Array, "flight 2"], high: Float[Array, "flight 2"]
) -> Mixture:
    """The members' outputs as one mixture with equal weights; `low` and `high` are in the units of the parameters."""
    flights, members, _ = outputs.shape
    parts = outputs[..., :WIDTH].reshape(flights, members, 6, COMPONENTS).swapaxes(1, 2)
    weight = np.exp(parts[:, 0] - parts[:, 0].max(axis=-1, keepdims=True))
    weight /= members * weight.sum(axis=-1, keepdims=True)
    flat = parts.reshape(flights, 6, members * COMPONENTS)
    return Mixture(
        weight.reshape(flights, -1),
        np.stack([flat[:, 1], flat[:, 2]], axis=-1),
        np.clip(np.stack([flat[:, 3], flat[:, 4]], axis=-1), *LOG_PRECISION_RANGE),
        flat[:, 5],
        low,
        high,
    )


def joined(parts: Sequence[Mixture]) -> Mixture:
    """The flights of several mixtures in one mixture."""
    return Mixture(*(np.concatenate([getattr(part, name) for part in parts]) for name in Mixture.__dataclass_fields__))


def logits(
    values: Float[Array, "flight 2"], low: Float[Array, "flight 2"], high: Float[Array, "flight 2"]
) -> Float[Array, "flight 2"]:
    """Parameters on the logit scale of the mixture; the ends of an interval are limited to 14. [1]"""
    place = np.clip((values - low) / (high - low), 1e-6, 1 - 1e-6)
    return np.asarray(np.log(place / (1 - place)))
