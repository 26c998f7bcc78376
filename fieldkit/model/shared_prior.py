"""Information from other rockets' flights about the terms that a flyer's rockets share, as a normal distribution."""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from fieldkit.model.fleet_drift import Period
from fieldkit.model.term_names import TermName
from fieldkit.shapes import Array, Float


@dataclass(frozen=True, slots=True, eq=False)
class SharedPrior:
    """A normal distribution of named terms that replaces their independent priors in a model.

    Mean and covariance are in the units of the terms. `period` is that of the fleet. `scatter` is the log likelihood of
    the flyer's scale of scatter at its `nodes`; empty if nothing is known of it. [nat]
    """

    names: tuple[TermName, ...]
    mean: Float[Array, "term"]
    covariance: Float[Array, "term term"]
    period: Period | None = None
    scatter: tuple[float, ...] = ()

    def same_as(self, other: "SharedPrior") -> bool:
        """Whether both are the same distribution."""
        arrays = ((self.mean, other.mean), (self.covariance, other.covariance))
        same = self.names == other.names and self.scatter == other.scatter
        return same and all(np.array_equal(one, another) for one, another in arrays)

    def only(self, names: Iterable[TermName]) -> "SharedPrior":
        """The marginal distribution of the terms among these names."""
        wanted = set(names)
        rows = [i for i, name in enumerate(self.names) if name in wanted]
        kept, covariance = tuple(self.names[i] for i in rows), self.covariance[np.ix_(rows, rows)]
        return replace(self, names=kept, mean=self.mean[rows], covariance=covariance)


@dataclass(frozen=True, slots=True, eq=False)
class Message:
    """The normal likelihood of the shared terms from one rocket's flights.

    Its logarithm is -x'Px/2 + x'h plus a constant, if x is the terms minus their hyperprior means, P the `precision`
    and h the `shift`.
    """

    names: tuple[TermName, ...]
    precision: Float[Array, "term term"]
    shift: Float[Array, "term"]


def combined(prior: SharedPrior, messages: Sequence[Message]) -> SharedPrior:
    """The independent prior of the shared terms updated with the messages of some rockets by Bayes' rule.

    Raises KeyError for a message with a term that the prior does not name: it could not be integrated over.
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
    return replace(prior, mean=prior.mean + covariance @ shift, covariance=covariance)
