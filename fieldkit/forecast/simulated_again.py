"""Draws of a fit's terms, moved so that their simulated readouts are those that the tangent plane promised.

A fit draws terms from the tangent plane at its mode. Simulated again, draws far along a ridge, more drag with more
thrust, no longer reach the flown apogees, and forecasts would be too low. So each draw takes one Gauss-Newton step from
its simulated readouts to its linear ones. The step is small in directions that the flights do not determine
(randomized maximum likelihood: Oliver, He and Reynolds, 1996; randomize-then-optimize: Bardsley, Solonen, Haario and
Laine, SIAM Journal on Scientific Computing 36, 2014).
"""

import numpy as np

from fieldkit.inference.laplace.posterior import Fit
from fieldkit.model.readout_data import OBSERVED_READOUTS, compared
from fieldkit.model.simulated_readouts import shown
from fieldkit.shapes import Array, Float, Int, Integers

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
