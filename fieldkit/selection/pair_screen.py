"""Screening of pairs of effects, with readouts linear around a smaller model, for the search's choice of sets.

Two effects may cancel, such as wear and wind on days that become calmer, so that neither improves the model alone. The
change in evidence from both follows in closed form as from one, from products that all pairs share.

Derivation: `fieldkit.inference.evidence`.
"""

from collections.abc import Iterator, Mapping, Sequence
from typing import NamedTuple

import numpy as np

from fieldkit.inference.evidence import pair_evidence
from fieldkit.inference.laplace.posterior import Fit
from fieldkit.physics.effect import Effect
from fieldkit.selection.candidates import Candidate
from fieldkit.selection.hypotheses import Members
from fieldkit.selection.prior import log_prior_odds
from fieldkit.selection.screen import NEGLIGIBLE_SCALE_WEIGHT, Columns, stacked
from fieldkit.shapes import Array, Float


class _Tried(NamedTuple):
    """An effect with one strength in one place, around one start; `place` and `family` number its place and effect."""

    candidate: Candidate
    start: float
    place: int
    family: int


def pair_weights(families: Mapping[str, Sequence[Candidate]], columns: Columns, near: Fit) -> dict[Members, float]:
    """Log posterior weight of every pair of effects with one strength each, summed over their places, against the
    model without them. [nat]"""
    names = [name for name, family in families.items() if any(_has_one_strength(one) for one in family)]
    tried = list(_tried([families[name] for name in names]))
    if len(names) < 2:
        return {}
    log_prior = np.array([one.candidate.log_fraction for one in tried])
    weight = _gains(tried, columns, near) + log_prior[:, None] + log_prior
    places, kinds = ([one.place for one in tried], [one.family for one in tried])
    first_of_place = np.unique(places, return_index=True)[1]
    for axis in (0, 1):
        weight = np.maximum.reduceat(weight, first_of_place, axis=axis)
    first_of_kind = np.unique(np.array(kinds)[first_of_place], return_index=True)[1]
    for axis in (0, 1):
        weight = np.logaddexp.reduceat(weight, first_of_kind, axis=axis)
    return {
        frozenset((one, other)): float(weight[i, i + 1 + j]) + log_prior_odds([one, other])
        for i, one in enumerate(names)
        for j, other in enumerate(names[i + 1 :])
    }


def _has_one_strength(one: Candidate) -> bool:
    return len(one.terms) == 1 and isinstance(one.terms[0].bends, Effect)


def _tried(families: Sequence[Sequence[Candidate]]) -> Iterator[_Tried]:
    place = 0
    for number, family in enumerate(families):
        for one in family:
            if _has_one_strength(one):
                yield from (_Tried(one, start, place, number) for start in one.starts)
                place += 1


def _gains(tried: Sequence[_Tried], columns: Columns, near: Fit) -> Float[Array, "tried other"]:
    """Log Bayes factor of the model with two effects against the one without, for every pair. [nat]

    The score of each effect is that with the other at its expected strength.
    """
    scales = np.flatnonzero(near.weights > NEGLIGIBLE_SCALE_WEIGHT)
    slope, expected = stacked([(one.candidate, one.start) for one in tried], columns, near)
    count = len(tried)
    shown = np.concatenate([near.evidence.miss[..., None], slope[..., 0], expected], axis=-1)
    own, other = slice(1, count + 1), slice(count + 1, None)
    sds = np.array([one.candidate.terms[0].sd for one in tried])
    found = np.full((count, count), -np.inf)
    for scale, product in zip(scales, near.linear(scales).regressors(shown).gram(), strict=True):
        between, moved, both = product[own, own], product[own, other], product[other, other]
        score = (product[own, 0] - np.diagonal(moved))[:, None] - moved
        shift = product[0, other] - np.diagonal(both) / 2
        gain = shift[:, None] + shift - both + pair_evidence(between, np.diagonal(between) + 1 / sds**2, score)
        np.logaddexp(found, near.log_weight[scale] + gain, out=found)
    return np.asarray(found - near.log_evidence - np.log(np.multiply.outer(sds, sds)))
