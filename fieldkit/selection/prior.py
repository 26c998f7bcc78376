"""The prior probability of a set of effects, common to the fit and the networks.

Each effect is in a rocket's model or not, independently of all others (spike and slab; Mitchell and Beauchamp, Journal
of the American Statistical Association 83, 1988). Families of effects, including `UNEXPLAINED`, are equally probable,
and the effects of a family share its probability equally. So a new effect file changes only its family: the odds of
every set without that family and the expected number of effects stay the same, and an effect that some flights cannot
show does not change their verdict.
"""

from collections.abc import Iterable, Mapping
from math import log, log1p
from typing import get_args

from fieldkit.physics.effect import LOGGED_EFFECTS, Effect, Family, effects

NO_EFFECT_PROBABILITY = 0.5
"""Prior probability that nothing is missing from a rocket's model. [1]"""
UNEXPLAINED = "unexplained"
"""Name of a pattern that no effect explains."""
FAMILIES: tuple[Family, ...] = get_args(Family)
FAMILY_PROBABILITY = 1 - NO_EFFECT_PROBABILITY ** (1 / (len(FAMILIES) + 1))
"""Prior expected number of effects in one family. [1]"""


def inclusion_probabilities(catalogue: Mapping[str, Effect] | None = None) -> dict[str, float]:
    """Prior probability that each effect, and something unexplained, is present, by their names in verdicts.

    Forms of an effect share its probability. `catalogue` is by default every installed effect.
    """
    known = effects() if catalogue is None else catalogue
    family = {effect.form_of or name: effect.family for name, effect in known.items()}
    members = list(family.values())
    return {name: FAMILY_PROBABILITY / members.count(own) for name, own in family.items()} | {
        UNEXPLAINED: FAMILY_PROBABILITY
    }


def log_prior_odds(names: Iterable[str]) -> float:
    """Log prior odds of a set against no effect, independent of other families. [nat]"""
    known = inclusion_probabilities() | dict.fromkeys(LOGGED_EFFECTS, FAMILY_PROBABILITY)
    return sum(log(known[name]) - log1p(-known[name]) for name in names)
