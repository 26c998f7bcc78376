"""Draws of a model's terms from the posterior of a fit.

Derivation: draws of a normal posterior, and of the independent normal prior of terms that no flight constrains. Both
are truncated at the bounds of the terms, as in the evidence: the posterior by rejection of draws out of bounds (von
Neumann, 1951), the prior by inversion of its distribution function.
"""

from collections.abc import Sequence

import numpy as np

from fieldkit.forecast.simulated_again import simulated_again
from fieldkit.inference.laplace.posterior import Fit, term_sds
from fieldkit.model.rocket_model import Model, Term
from fieldkit.model.term_names import TermName
from fieldkit.shapes import Array, Float, Int, Integers

MAX_REJECTIONS = 50
"""Maximum number of repetitions of a draw out of bounds, which is then moved to them. [1]"""
SINGLE_LEVELS = ("drift", "pattern")
"""Levels on which several terms act on one flight, so that their draws must be independent."""


def term_draws(
    model: Model,
    fitted: Sequence[int],
    result: Fit,
    draws: int,
    rng: np.random.Generator,
    *,
    again: bool = False,
) -> tuple[Float[Array, "draw term"], Float[Array, "draw 3"]]:
    """Draws of every term: terms that act on flown flights from their posterior, the others from their prior.

    Terms of a motor never flown are independent of the flights, so hundreds of motors do not slow down the fit. Terms
    of one kind, such as the thrust of each motor, use common random numbers: a motor gets the same draws among others
    as alone. With `again`, draws of the posterior are simulated again (`fieldkit.forecast.simulated_again`).
    """
    own, which = _sampled(result, draws, rng)
    if again:
        own, which = simulated_again(result, own, which)
    sds = term_sds(model)[which]
    values = np.empty((draws, len(model.terms)))
    values[:, fitted] = own
    random_draws: dict[TermName, Float[Array, "draw"]] = {}
    for i in sorted(set(range(len(model.terms))) - set(fitted)):
        term = model.terms[i]
        kind = term.name if term.name.level in SINGLE_LEVELS else term.name._replace(group="")
        random_draws[kind] = random_draws[kind] if kind in random_draws else rng.normal(size=draws)
        values[:, i] = _bounded(term, sds[:, i], random_draws[kind])
    return values, _scales(result, which)


def _bounded(term: Term, sd: Float[Array, "draw"], normal: Float[Array, "draw"]) -> Float[Array, "draw"]:
    """Draws of a term's prior within its bounds, from those of a standard normal distribution."""
    from scipy.special import ndtr, ndtri  # at the top, `show` would take 1.4 times as long

    if np.isfinite(term.low) or np.isfinite(term.high):
        below, above = ndtr((term.low - term.mean) / sd), ndtr((term.high - term.mean) / sd)
        normal = ndtri(below + (above - below) * ndtr(normal))
    return np.clip(term.mean + sd * normal, term.low, term.high)


def _sampled(
    result: Fit, draws: int, rng: np.random.Generator
) -> tuple[Float[Array, "draw term"], Int[Integers, "draw"]]:
    """Draws of a model's terms within their bounds, and the pair of scales of each draw."""
    which = rng.choice(len(result.weights), size=draws, p=result.weights)
    roots = np.linalg.cholesky(result.covariance)
    lows, highs = (np.array([getattr(term, end) for term in result.model.terms]) for end in ("low", "high"))
    values, outside = np.empty((draws, result.mean.shape[1])), np.arange(draws)
    for turn in range(MAX_REJECTIONS):
        own = which[outside]
        normal = rng.normal(size=(len(own), values.shape[1]))
        rng = rng if turn else rng.spawn(1)[0]  # so that later draws do not depend on the number of repetitions
        values[outside] = result.mean[own] + np.einsum("dtu,du->dt", roots[own], normal)
        outside = outside[((values[outside] < lows) | (values[outside] > highs)).any(axis=1)]
        if not len(outside):
            break
    return np.clip(values, lows, highs), which


def _scales(result: Fit, which: Int[Integers, "draw"]) -> Float[Array, "draw 3"]:
    """Scales of the scatter, the readings and the motor of a future flight."""
    hyperprior = result.model.hyperprior
    scatter, reading, _ = hyperprior.scales()
    return np.stack([scatter[which], reading[which], hyperprior.motor_scales()[which]], axis=-1)
