"""What flights of other rockets show of the terms that all rockets of a flyer share, as a normal distribution."""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import numpy as np

from fieldkit.shapes import Array, Float


@dataclass(frozen=True, slots=True, eq=False)
class SharedPrior:
    """A normal distribution of named terms, which takes the place of their independent priors in a model."""

    names: tuple[str, ...]
    mean: Float[Array, "term"]
    covariance: Float[Array, "term term"]

    def only(self, names: Iterable[str]) -> "SharedPrior":
        """The marginal distribution of those terms that are among some names."""
        wanted = set(names)
        rows = [i for i, name in enumerate(self.names) if name in wanted]
        return SharedPrior(tuple(self.names[i] for i in rows), self.mean[rows], self.covariance[np.ix_(rows, rows)])


@dataclass(frozen=True, slots=True, eq=False)
class Message:
    """What one rocket's flights add to the knowledge of shared terms: a normal likelihood of them.

    Its logarithm is -x'Px/2 + x'h but for a constant, x being the terms less their hyperprior means, P the
    `precision` and h the `shift`.
    """

    names: tuple[str, ...]
    precision: Float[Array, "term term"]
    shift: Float[Array, "term"]


def combined(prior: SharedPrior, messages: Sequence[Message]) -> SharedPrior:
    """The prior of the shared terms, independent so far, after the messages of some rockets (Bayes' rule).

    Terms that a message names and the prior does not are left out of it, integrated over nothing: the prior has to name
    every term of every message.
    """
    place = {name: i for i, name in enumerate(prior.names)}
    precision = np.linalg.inv(prior.covariance)
    shift = np.zeros(len(prior.names))
    for message in messages:
        rows = [place[name] for name in message.names]
        precision[np.ix_(rows, rows)] += message.precision
        shift[rows] += message.shift
    covariance = np.linalg.inv(precision)
    covariance = 0.5 * (covariance + covariance.T)
    return SharedPrior(prior.names, prior.mean + covariance @ shift, covariance)
