"""Hypotheses about missing effects, each a set of effects in their places, with posterior probabilities."""

from collections.abc import Collection, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from fieldkit.inference.laplace.importance import Sampled
from fieldkit.inference.laplace.posterior import Fit
from fieldkit.selection.candidates import Candidate, Place
from fieldkit.selection.prior import UNEXPLAINED, log_prior_odds
from fieldkit.selection.trial import Trial
from fieldkit.shapes import Array, Float

Members = frozenset[str]
"""Names of effects, and `UNEXPLAINED`, as in verdicts."""


@dataclass(frozen=True, slots=True, eq=False)
class Hypothesis:
    """Effects, each in one place, and the fit of the model with them; no effects for the plain model.

    `log_prior` is the log ratio of its prior probability to the plain model's. [nat] `correction` is the correction of
    the fit's log evidence by importance sampling [nat], and `sampled` the result of the sampling, if it was done.
    """

    candidates: tuple[Candidate, ...]
    fit: Fit
    log_prior: float = 0.0
    correction: float = 0.0
    sampled: Sampled | None = None

    @property
    def members(self) -> Members:
        """Its terms in addition to the plain model's."""
        return members_of(self.candidates)

    @property
    def places(self) -> tuple[Place, ...]:
        """The place of each effect."""
        return tuple(candidate.place for candidate in self.candidates)

    @property
    def trials(self) -> tuple[Trial, ...]:
        """Each effect as a trial with the joint fit."""
        return tuple(Trial(candidate, self.fit) for candidate in self.candidates)

    @property
    def log_evidence(self) -> float:
        """Log marginal likelihood of the observed readouts. [nat]"""
        return self.fit.log_evidence + self.correction

    @property
    def log_weight(self) -> float:
        """Log of prior probability times evidence, up to a common constant. [nat]"""
        return self.log_prior + self.log_evidence


def members_of(candidates: Sequence[Candidate]) -> Members:
    """The names of candidates as in verdicts."""
    return frozenset(candidate.effect or UNEXPLAINED for candidate in candidates)


def prior_of(candidates: Sequence[Candidate]) -> float:
    """Log prior odds of effects in these places against no effect. [nat]

    Derivation: the odds of the set times the fraction of each effect's prior that its place has.
    """
    return log_prior_odds(members_of(candidates)) + sum(candidate.log_fraction for candidate in candidates)


@dataclass(frozen=True, eq=False)
class SetPosterior:
    """The posterior over hypotheses, the plain model among them."""

    hypotheses: tuple[Hypothesis, ...]

    @cached_property
    def probability(self) -> Float[Array, "hypothesis"]:
        """Posterior probability of each hypothesis. [1]"""
        weight = np.array([one.log_weight for one in self.hypotheses])
        return np.asarray(np.exp(weight - np.logaddexp.reduce(weight)))

    @cached_property
    def sets(self) -> dict[Members, float]:
        """Posterior probability of every set, summed over places, the most probable first. [1]"""
        found: dict[Members, float] = {}
        for one, chance in zip(self.hypotheses, self.probability, strict=True):
            found[one.members] = found.get(one.members, 0.0) + float(chance)
        return dict(sorted(found.items(), key=lambda item: -item[1]))

    @cached_property
    def inclusion(self) -> dict[str, float]:
        """Posterior probability that each effect is present, alone or with others, the most probable first. [1]"""
        found: dict[str, float] = {}
        for members, chance in self.sets.items():
            for name in members:
                found[name] = found.get(name, 0.0) + chance
        return dict(sorted(found.items(), key=lambda item: -item[1]))

    def any_of(self, names: Collection[str]) -> float:
        """Posterior probability that at least one of these effects is present. [1]"""
        return sum(chance for members, chance in self.sets.items() if members & set(names))

    def all_of(self, names: Collection[str]) -> float:
        """Posterior probability that all of these effects are present, alone or with others. [1]"""
        return sum(chance for members, chance in self.sets.items() if set(names) <= members)

    @property
    def nothing(self) -> float:
        """Posterior probability that the plain model lacks no effect and no pattern. [1]"""
        return self.sets.get(frozenset(), 0.0)

    def best(self, members: Members | None = None) -> Hypothesis:
        """The most probable hypothesis, of all or of one set."""
        found = [one for one in self.hypotheses if members is None or one.members == members]
        return max(found, key=lambda one: one.log_weight)

    def log_bayes(self, name: str) -> float:
        """Log Bayes factor of an effect alone, averaged over places, against the plain model. [nat]"""
        plain = self.best(frozenset())
        alone = [one.log_weight for one in self.hypotheses if one.members == {name}]
        if not alone:
            return float("-inf")
        return float(np.logaddexp.reduce(alone)) - log_prior_odds([name]) - plain.log_weight

    def without(self, names: Collection[str]) -> "SetPosterior":
        """The posterior given that none of these effects is present."""
        return replace(self, hypotheses=tuple(one for one in self.hypotheses if not one.members & set(names)))
