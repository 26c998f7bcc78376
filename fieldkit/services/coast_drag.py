"""Drag against time along the coast of a flight's log, whatever its course."""

from dataclasses import dataclass

import numpy as np

from fieldkit.analysis.force_profile import DragLikelihood, DragProfile
from fieldkit.ledger import Ledger
from fieldkit.services.flight_logs import flight_log
from fieldkit.shapes import Array, Float

CHANGE_SD, CHANGE_TIME = 1.0, 0.5
"""Prior of drag over its mean that is open to any change: standard deviation [1] and correlation time [s]."""
TO_90 = 1.645
"""Standard deviations from the mean to the ends of a 90% interval. [1]"""


@dataclass(frozen=True, slots=True, eq=False)
class CoastDrag:
    """Drag over the mean drag of the coast, with its 90% interval, at times from lift-off [s]. [1]"""

    time: Float[Array, "interval"]
    low: Float[Array, "interval"]
    mean: Float[Array, "interval"]
    high: Float[Array, "interval"]
    source: str


def coast_drag(ledger: Ledger, id: str) -> CoastDrag | None:
    """Drag in the coast of a flight of the ledger; None without a log that shows it. Raises LedgerError, and
    FieldkitError if saved choices of columns are needed and cannot be read."""
    log = flight_log(ledger, id)
    return None if log is None or log.drag is None else against_time(log.drag)


def against_time(profile: DragProfile) -> CoastDrag:
    """The posterior of relative drag with a prior that is open to any change, averaged over the noise settings.

    Derivation: with m ~ N(1, K) and the likelihood -m'Pm/2 + s'm, m has the mean 1 + K (I + PK)^-1 (s - P1) and the
    covariance K (I + PK)^-1; the drag given m is `DragLikelihood.given`.
    """
    time = profile.time_from_liftoff
    prior = CHANGE_SD**2 * np.exp(-np.abs(time[:, None] - time) / CHANGE_TIME)
    likelihoods = [one.with_any_ports() for one in profile.likelihoods]
    weights = np.exp(np.array([one.log_weight for one in likelihoods]))
    weights = weights / weights.sum()
    parts = [_posterior(one, prior) for one in likelihoods]
    mean = sum(weight * middle for weight, (middle, _) in zip(weights, parts, strict=True))
    spread = sum(
        weight * (variance + (middle - mean) ** 2) for weight, (middle, variance) in zip(weights, parts, strict=True)
    )
    reach = TO_90 * np.sqrt(spread)
    return CoastDrag(time, mean - reach, np.asarray(mean), mean + reach, profile.source)


def _posterior(one: DragLikelihood, prior: Float[Array, "interval interval"]) -> tuple[Array, Array]:
    """Mean and variance of the relative drag in each interval."""
    size = len(prior)
    covariance = np.linalg.solve(np.eye(size) + prior @ one.precision, prior)
    level = 1.0 + covariance @ (one.shift - one.precision @ np.ones(size))
    passed = np.eye(size) - one.prior @ one.precision
    variance = one.variance + np.einsum("ij,jk,ik->i", passed, covariance, passed)
    return one.given(level), np.maximum(variance, 0.0)
