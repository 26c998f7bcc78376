"""Whether drag along logged coasts is what the model says: a posterior predictive check.

By the model a flight has the rocket's own drag, with the scatter of flights, and with some probability a step
(`fieldkit.selection.drag_steps`). The alternative is drag that changes along the coast in any way, as a Gaussian
process. The statistic of a flight is the logarithm of the Bayes factor between the two; how large it is if the model is
right shows in replicates of the log. The smallest p-value of all flights is compared with that of replicated rockets
(Westfall and Young, Resampling-Based Multiple Testing, 1993).

The setting of the noise of a log is taken as known, the most probable one, and so is the error of the static ports.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from fieldkit.selection.drag_steps import (
    LONE_PROBABILITY,
    LONE_SD,
    PULSE_PROBABILITY,
    SIZE_SD,
    DragSteps,
    LoggedDrag,
    PossibleSteps,
    given_ports,
    possible_steps,
    summed_over_steps,
)
from fieldkit.shapes import Array, Float, Int, Integers

REPLICATES = 400
"""Number of replicated logs of each flight. [1]"""
CHANGE_SD, CHANGE_TIME = 0.5, 1.0
"""Any change of drag along a coast: standard deviation relative to the rocket's own [1], about that of a step, and
correlation time [s]."""
SEED = 29
"""Seed of the replicates."""


@dataclass(frozen=True, slots=True)
class CoastCheck:
    """The p-value of what the model leaves in the drag of logged coasts [1]; the flight with the clearest change, and
    the drag there relative to the rocket's own [1], at a time from lift-off [s]."""

    p: float
    flight_id: str
    time_from_liftoff: float
    ratio: float


@dataclass(frozen=True, slots=True, eq=False)
class _Kind:
    """What a flight may have: its log probability [nat], the log prior of each step, and the mean and standard
    deviation of its relative size [1]."""

    log_probability: float
    log_prior: Float[Array, "step"]
    mean: float
    sd: float


@dataclass(frozen=True, slots=True, eq=False)
class _LoggedCoast:
    """A logged coast under the model: relative drag without a step [1], the steps it may have, and their kinds."""

    level: float
    possible: PossibleSteps
    kinds: tuple[_Kind, ...]
    change: Float[Array, "interval interval"]

    @property
    def precision(self) -> Float[Array, "interval interval"]:
        """Precision of the log's likelihood of relative drag. [1]"""
        return self.possible.parts[0].likelihood.precision

    def replicates(self, rng: np.random.Generator) -> Float[Array, "history interval"]:
        """The shift of the log's likelihood, first as recorded, then in replicates: normal, with the precision as its
        covariance, around the precision times the relative drag."""
        recorded = self.possible.parts[0].likelihood.shift
        drag = np.full((REPLICATES, recorded.size), self.level)
        chance = np.exp([kind.log_probability for kind in self.kinds])
        which = rng.choice(len(chance) + 1, REPLICATES, p=[1 - chance.sum(), *chance])
        for row in np.flatnonzero(which).tolist():
            kind, part = self.kinds[which[row] - 1], self.possible.parts[rng.integers(len(self.possible.parts))]
            step = int(rng.choice(kind.log_prior.size, p=np.exp(kind.log_prior)))
            inside = np.zeros(recorded.size)
            inside[self.possible.first[step] : self.possible.last[step]] = 1.0
            drag[row] += self.level * rng.normal(kind.mean, kind.sd) * (part.ramp @ inside)
        values, vectors = np.linalg.eigh(self.precision)
        noise = rng.normal(size=drag.shape) * np.sqrt(np.maximum(values, 0.0)) @ vectors.T
        return np.concatenate([recorded[None], drag @ self.precision + noise])

    def log_bayes(self, shift: Float[Array, "history interval"]) -> Float[Array, "history"]:
        """Log Bayes factor of any change against the model, for each shift. [nat]"""
        log_none = np.log1p(-sum(np.exp(kind.log_probability) for kind in self.kinds))
        found = [np.full(len(shift), log_none)]
        for part in self.possible.parts:
            sums = np.cumsum(np.pad(shift @ part.ramp, ((0, 0), (1, 0))), axis=1)
            pushed = sums[:, self.possible.last] - sums[:, self.possible.first]
            linear = self.level * pushed - self.level**2 * part.joint
            for kind in self.kinds:
                log_prior = kind.log_prior + kind.log_probability - np.log(len(self.possible.parts))
                found.append(summed_over_steps(linear, self.level**2 * part.both, kind.mean, kind.sd, log_prior))
        return np.asarray(self._log_any(shift) - np.logaddexp.reduce(found))

    def _log_any(self, shift: Float[Array, "history interval"]) -> Float[Array, "history"]:
        """Log Bayes factor of any change against no change. [nat]

        Derivation: with a normal change c, its log likelihood r'c - c'Pc/2 integrates to
        r'Cr/2 + log(det C / det K)/2, with C the inverse of P plus the inverse of the covariance K.
        """
        root = np.linalg.cholesky(self.change)
        inner = np.eye(len(root)) + root.T @ self.precision @ root
        rest = (shift - self.level * self.precision.sum(axis=0)) @ root
        square = (rest @ np.linalg.inv(inner) * rest).sum(axis=-1)
        return np.asarray(0.5 * (square - np.linalg.slogdet(inner).logabsdet))

    def clearest(self) -> tuple[int, float]:
        """The interval whose drag differs most from the rocket's own in standard deviations, if it may change in any
        way, and the ratio there [1]."""
        rest = self.possible.parts[0].likelihood.shift - self.level * self.precision.sum(axis=0)
        spread = np.linalg.inv(np.eye(len(rest)) + self.change @ self.precision) @ self.change
        off = spread @ rest
        place = int(np.argmax(np.abs(off) / np.sqrt(np.diagonal(spread))))
        return place, 1 + float(off[place]) / self.level


def coast_check(logs: Sequence[LoggedDrag], steps: DragSteps, probability: float) -> CoastCheck:
    """The check of the logged coasts of a rocket, whose drag switches with this probability [1]."""
    rng = np.random.default_rng(SEED)
    coasts = [_coast(log, steps, probability) for log in logs]
    size = np.stack([one.log_bayes(one.replicates(rng)) for one in coasts])
    p = np.stack([_as_large(row) for row in size])  # flight, history
    smallest = p.min(axis=0)
    first = int(np.lexsort((-size[:, 0], p[:, 0]))[0])
    place, ratio = coasts[first].clearest()
    time = float(logs[first].profile.time_from_liftoff[place])
    return CoastCheck(float((smallest <= smallest[0] + 1e-9).mean()), logs[first].flight_id, time, ratio)


def _as_large(size: Float[Array, "history"]) -> Float[Array, "history"]:
    """Fraction of the histories in which a statistic is at least as large as in each. [1]"""
    order: Int[Integers, "history"] = np.searchsorted(np.sort(size), size, side="left")
    return np.asarray((size.size - order) / size.size)


def _coast(log: LoggedDrag, steps: DragSteps, probability: float) -> _LoggedCoast:
    """A coast under the model; what is not known of the rocket's own drag adds to the scatter of its level."""
    known = replace(log, scatter=float(np.hypot(log.scatter, steps.own_sd)))
    known = replace(known, profile=replace(log.profile, likelihoods=log.profile.likelihoods[:1]))
    possible = possible_steps(given_ports(known, steps.ports))
    level = steps.own / log.unit
    member = min(max(probability * steps.fraction, 1e-12), 1 - 1e-9)
    spread = float(np.hypot(steps.size_sd, SIZE_SD * abs(steps.size)))
    rest = float(np.log1p(-member))
    kinds = (
        _Kind(float(np.log(member)), possible.log_prior, steps.size, spread),
        _Kind(rest + float(np.log(LONE_PROBABILITY)), possible.log_prior, 0.0, LONE_SD),
        _Kind(rest + float(np.log(PULSE_PROBABILITY)), possible.log_prior_short, 0.0, LONE_SD),
    )
    time = log.profile.time_from_liftoff
    change = (level * CHANGE_SD) ** 2 * np.exp(-np.abs(time[:, None] - time) / CHANGE_TIME)
    return _LoggedCoast(level, possible, kinds, change + 1e-9 * level**2 * np.eye(time.size))
