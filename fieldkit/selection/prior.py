"""The prior probability of a set of effects, the same for the fit and for the networks.

Each effect is in a rocket's model or out of it, independently of all others (spike and slab; Mitchell and Beauchamp,
Journal of the American Statistical Association 83, 1988). Families of effects, and `UNEXPLAINED` as one more, are
equally probable, and a family's probability is shared equally by its effects. So another effect file takes from its own
family alone: the odds of every set without that family are what they were, the expected number of effects stays, and an
effect that some flights could not show changes nothing there.
"""

from collections.abc import Iterable, Mapping
from math import log, log1p
from typing import get_args

from fieldkit.physics.effect import Effect, Family, effects

NO_EFFECT_PROBABILITY = 0.5
"""Prior probability that nothing is missing from a rocket's model: as likely as not. [1]"""
UNEXPLAINED = "unexplained"
"""A residual process that no effect accounts for."""
FAMILIES: tuple[Family, ...] = get_args(Family)
FAMILY_PROBABILITY = 1 - NO_EFFECT_PROBABILITY ** (1 / (len(FAMILIES) + 1))
"""Prior expectation of the number of effects of one family. [1]"""


def inclusion_probabilities(catalogue: Mapping[str, Effect] | None = None) -> dict[str, float]:
    """Prior probability that each effect is there, and that something unexplained is, by the names verdicts speak of.

    Forms of an effect share its probability. `catalogue` is by default every effect there is.
    """
    known = effects() if catalogue is None else catalogue
    family = {effect.form_of or name: effect.family for name, effect in known.items()}
    members = list(family.values())
    return {name: FAMILY_PROBABILITY / members.count(own) for name, own in family.items()} | {
        UNEXPLAINED: FAMILY_PROBABILITY
    }


def log_prior_odds(names: Iterable[str], catalogue: Mapping[str, Effect] | None = None) -> float:
    """Log of the prior probability of a set over that of nothing, whatever other families hold. [nat]"""
    known = inclusion_probabilities(catalogue)
    return sum(log(known[name]) - log1p(-known[name]) for name in names)
