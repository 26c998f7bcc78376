"""Linear fits in which any flight may be a one-off, as in the fits of forecasts.

Many flights are weighted by their probability of being one of the rocket's usual ones, and few ones are a mixture
(`fieldkit.inference.laplace.few_flights`). Derivation: Bayes' rule, in `fieldkit.inference.laplace.one_offs`.
"""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from fieldkit.inference.history.linear_fit import LinearFit
from fieldkit.inference.laplace.few_flights import MAX_FLIGHTS, with_and_without_one_off
from fieldkit.inference.laplace.one_offs import one_offs
from fieldkit.inference.laplace.outlier_weights import outlier_weights
from fieldkit.inference.laplace.posterior import Fit, solve
from fieldkit.model.causes import Signatures, signatures
from fieldkit.model.readout_data import OBSERVED_READOUTS, Data, compared
from fieldkit.model.simulated_readouts import shown

DOUBTFUL_WEIGHT = 0.4
"""Among more than `MAX_FLIGHTS` flights, one whose readouts all have at least this weight, which they have within three
standard deviations, is taken for a usual one. [1]"""
MAX_DOUBTFUL = 3
"""With more doubtful flights than this, all are compared, because the rocket may have changed for good. [1]"""
ROUNDS = 2
"""Number of updates of the probabilities of usual flights."""

Cases = Sequence[tuple[float, LinearFit]]
"""The linear fits of a mixture with their probabilities. [1]"""


def with_one_offs(linear: LinearFit) -> Cases:
    """The cases of a linear fit, which has robust weights, if flights may be one-offs. Raises ImpossibleFlight for a
    flight without a dry mass."""
    fit = linear.fit
    doubtful = _to_compare(fit)
    if not doubtful.seen.any():
        return [(1.0, linear)]
    known = signatures_at(fit)
    for _ in range(ROUNDS):
        fit = solve(fit.model, replace(fit.data, normal=one_offs(fit, doubtful, known).weight), fit.tangent)
        fit = solve(fit.model, replace(fit.data, trust=outlier_weights(fit)), fit.tangent)
    return [(chance, replace(linear, fit=one)) for chance, one in with_and_without_one_off(fit, known)]


def signatures_at(fit: Fit) -> Signatures:
    """The shifts of flights' readouts by causes of one-offs, which hardly depend on the drag at which they are
    simulated. Raises ImpossibleFlight for a flight without a dry mass."""

    def simulated() -> Signatures:
        model = replace(fit.model, coarse=True)
        usual = shown(model, fit.tangent.at[None], {})
        values = compared(np.stack([usual[name][0] for name in OBSERVED_READOUTS], axis=-1))
        return signatures(model, fit.tangent.at, values, fit.data.seen)

    return fit.model.once(f"signatures of {fit.data.seen.tobytes().hex()}", simulated)


def _to_compare(fit: Fit) -> Data:
    """The flights that may be one-offs."""
    seen = fit.data.seen
    odd = np.asarray((seen & (fit.data.trust < DOUBTFUL_WEIGHT)).any(axis=1))
    if seen.any(axis=1).sum() <= MAX_FLIGHTS or odd.sum() > MAX_DOUBTFUL:
        return fit.data
    return replace(fit.data, seen=seen & odd[:, None])
