"""Draws of a model's terms from the posterior of a fit.

Derivation: draws of a normal posterior, and of the independent normal prior of terms that no flight constrains. Both
are truncated at the bounds of the terms, as in the evidence: the posterior by rejection of draws out of bounds (von
Neumann, 1951), the prior by inversion of its distribution function.

Simulated again, draws of the tangent plane far along a ridge, more drag with more thrust, no longer reach the flown
apogees, and forecasts would be too low. So each draw takes one Gauss-Newton step from its simulated readouts to its
linear ones. The step is small in directions that the flights do not determine (randomized maximum likelihood: Oliver,
He and Reynolds, 1996; randomize-then-optimize: Bardsley, Solonen, Haario and Laine, SIAM Journal on Scientific
Computing 36, 2014).
"""

from collections.abc import Sequence

import numpy as np

from fieldkit.inference.laplace.posterior import Fit, term_sds
from fieldkit.model.readout_data import OBSERVED_READOUTS, compared
from fieldkit.model.rocket_model import Model, Term
from fieldkit.model.simulated_readouts import shown
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
    as alone. With `again`, draws of the posterior are simulated again (`fieldkit.forecast.term_draws`).
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


MAX_SIMULATIONS = 6000
"""Maximum number of flights to simulate, about 20 ms; with more flights, fewer draws are distinct. [1]"""
MIN_DRAWS = 150
"""Minimum number of distinct draws. [1]"""


def simulated_again(
    result: Fit, terms: Float[Array, "draw term"], which: Int[Integers, "draw"]
) -> tuple[Float[Array, "draw term"], Int[Integers, "draw"]]:
    """The draws of the terms, each with its scales, moved to the ridge of the simulator; in their
    units.

    If they are more than `MAX_SIMULATIONS` allows, the first ones stand for all, in turn. Raises ImpossibleFlight for a
    flight without a dry mass.
    """
    count = int(result.data.seen.any(axis=1).sum())
    if not count or not terms.shape[1]:
        return terms, which
    some = min(len(terms), max(MIN_DRAWS, MAX_SIMULATIONS // count))
    moved = _moved(result, terms[:some], which[:some])
    rows = np.arange(len(terms)) % some
    return moved[rows], which[rows]


def _moved(result: Fit, terms: Float[Array, "draw term"], which: Int[Integers, "draw"]) -> Float[Array, "draw term"]:
    evidence, mean = result.evidence, np.array([term.mean for term in result.model.terms])
    linear = evidence.miss - np.einsum("fot,dt->dfo", evidence.slope, terms - mean)
    readings = shown(result.model, terms, {})
    found = compared(np.stack([readings[name] for name in OBSERVED_READOUTS], axis=-1))[..., evidence.readouts]
    usable = (result.data.seen & np.isfinite(result.tangent.values))[:, evidence.readouts] & np.isfinite(found)
    miss = np.where(usable, result.data.values[:, evidence.readouts] - found, linear)
    weighed = (evidence.sharpness[which] @ (linear - miss)[..., None])[..., 0]
    gradient = np.einsum("fot,dfo->dt", evidence.slope, weighed)
    step = np.einsum("dtu,du->dt", result.covariance[which], gradient)
    low, high = (np.array([getattr(term, end) for term in result.model.terms]) for end in ("low", "high"))
    return np.asarray(np.clip(terms - step, low, high))
