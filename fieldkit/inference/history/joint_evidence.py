"""The log odds of every effect beside the others, from the closed-form evidence of sets of at most two.

Derivation: Bayes' theorem over the sets, with independent prior odds of the effects; the evidence of two effects is the
product of their own, times that of one beside the other relative to that alone.
"""

from itertools import combinations

import numpy as np

from fieldkit.shapes import Array, Float


def log_odds(
    log_prior_odds: Float[Array, "effect"], log_bayes: Float[Array, "effect"], beside: Float[Array, "effect effect"]
) -> tuple[Float[Array, "effect"], float]:
    """The log odds that each effect is present, and that none is. [nat]

    `log_prior_odds` are those of each effect before the flights, `log_bayes` is its log Bayes factor, and `beside` that
    of each beside each other, alone on the diagonal.
    """
    count = len(log_bayes)
    if not count:
        return np.zeros(0), 0.0
    own = log_prior_odds + log_bayes
    pairs = np.array(list(combinations(range(count), 2)), int).reshape(-1, 2)
    first, second = pairs.T
    weights = np.r_[0.0, own, own[first] + own[second] + beside[first, second] - beside[first, first]]
    has = np.zeros((len(weights), count), bool)
    has[1 : count + 1] = np.eye(count, dtype=bool)
    has[np.arange(count + 1, len(weights)), first] = has[np.arange(count + 1, len(weights)), second] = True
    there = np.logaddexp.reduce(np.where(has, weights[:, None], -np.inf), axis=0)
    absent = np.logaddexp.reduce(np.where(has, -np.inf, weights[:, None]), axis=0)
    return there - absent, float(-np.logaddexp.reduce(weights[1:]))
