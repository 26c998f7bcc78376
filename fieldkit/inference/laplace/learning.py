"""Learn the hyperprior from real flights by maximizing the marginal likelihood with expectation-maximization.

The flights of several flyers are independent given the hyperprior. Each step computes every rocket's posterior given
all flights of its flyer (its fit combined with the messages of the other rockets), and sets each variance to the
posterior mean square of its random effects (Dempster, Laird and Rubin, J. R. Stat. Soc. B 39, 1977). Variances with few
groups stay near a stated start: each has a scaled inverse chi-squared prior that counts as `PRIOR_GROUPS` groups.
Readouts are linear around the last fits, which are repeated in every round.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from types import MappingProxyType

import numpy as np

from fieldkit.inference.laplace.fit import fit_robustly
from fieldkit.inference.laplace.fleet import RocketFit as Alone
from fieldkit.inference.laplace.fleet import independent_prior, joint_evidence, merged, message_of
from fieldkit.inference.laplace.linearization import Tangent
from fieldkit.inference.laplace.outlier_weights import outlier_weights, standardized_squares
from fieldkit.inference.laplace.posterior import Fit, solve
from fieldkit.model.fleet_drift import Period, period_of
from fieldkit.model.hyperprior import READOUTS, Hyperprior
from fieldkit.model.readout_data import observe
from fieldkit.model.rocket_model import FlownFlights, Model, base_model, with_shared
from fieldkit.model.shared_prior import SharedPrior, combined
from fieldkit.model.term_names import TermName, fleet_term
from fieldkit.physics.history import History, flown_and_planned
from fieldkit.progress import ReportProgress, no_op
from fieldkit.shapes import Array, Float

Fleet = Sequence[FlownFlights]
"""The flights of one flyer, rocket by rocket."""
PRIOR_GROUPS = 4.0
"""Number of groups that the prior of each variance counts as; with three flyers the estimate stays near its start.
[1]"""
MEAN_SD = 0.2
"""Prior standard deviation of each mean around its start. [1]"""
ROUNDS = 3
"""Number of rounds, each with a new linearization."""
LEARNED_LEVELS = ("rocket", "rocket_motor", "day")
"""Levels of the terms of one rocket whose variances are learned."""
STEPS = 25
"""Expectation-maximization steps per round."""


@dataclass(frozen=True, slots=True, eq=False)
class _Linear:
    """One rocket's flights, linearized at its last fit."""

    history: History
    period: Period | None
    tangent: Tangent
    unit_scatter: Float[Array, "flight readout scatter"]
    trust: Float[Array, "flight readout"]


class _Sums:
    """Sums of squares and counts by the name of the variance."""

    def __init__(self) -> None:
        self.square: dict[str, float] = {}
        self.count: dict[str, float] = {}

    def add(self, name: str, square: float, count: float) -> None:
        """Add the squares of some groups."""
        self.square[name] = self.square.get(name, 0.0) + square
        self.count[name] = self.count.get(name, 0.0) + count

    def variance(self, name: str, start: float) -> float:
        """Posterior mode of a variance whose prior is at `start`."""
        count = self.count.get(name, 0.0)
        return (self.square.get(name, 0.0) + PRIOR_GROUPS * start) / (count + PRIOR_GROUPS)


def learn_hyperprior(
    fleets: Sequence[Fleet],
    start: Hyperprior,
    rounds: int = ROUNDS,
    steps: int = STEPS,
    *,
    begin: Hyperprior | None = None,
    on_progress: ReportProgress = no_op,
) -> Hyperprior:
    """The hyperprior with the highest marginal likelihood of some flyers' flights, near a start.

    Random effects that the start lacks are not added. The priors of scales are not learned, because few flyers do not
    determine them. `begin` is the initial value of the iteration, by default the start. The result includes the
    uncertainty of each mean. Raises ImpossibleFlight for a flight without a dry mass.
    """
    start, found = replace(start, mean_sds={}), replace(begin or start, mean_sds={})
    for round_ in range(rounds):
        linear = [_linearized(fleet, found) for fleet in fleets]
        for step in range(steps):
            on_progress("learning", (round_ + step / steps) / rounds)
            found, linear = _step(linear, found, start)
    together = [_posteriors(_linearized(fleet, found), found)[1] for fleet in fleets]
    return replace(found, mean_sds=MappingProxyType(mean_sds(together, found)))


def mean_sds(flyers: Sequence[SharedPrior], hyperprior: Hyperprior) -> dict[str, float]:
    """Standard deviation of each mean over flyers, given the posterior of every flyer's fleet. [1] or [s]

    Fleets are normal around the means with covariance T. If the posterior covariance of a fleet is V, its flights add
    the precision T^-1 - T^-1 V T^-1 for the means (Woodbury). The prior standard deviation of each mean is `MEAN_SD`.
    """
    quantities = [quantity for quantity in hyperprior.means if hyperprior.sd(quantity, "fleet")]
    between = np.array([hyperprior.sd(quantity, "fleet") ** 2 for quantity in quantities])
    precision = np.diag(np.full(len(quantities), 1 / MEAN_SD**2))
    for flyer in flyers:
        known = flyer.only([fleet_term(quantity) for quantity in quantities])
        rows = [quantities.index(name.quantity) for name in known.names]
        gained = np.diag(between[rows]) - known.covariance
        precision[np.ix_(rows, rows)] += gained / np.outer(between[rows], between[rows])
    variances = np.diag(np.linalg.inv(precision))
    return {quantity: float(np.sqrt(variance)) for quantity, variance in zip(quantities, variances, strict=True)}


def evidence(fleets: Sequence[Fleet], hyperprior: Hyperprior) -> float:
    """Log marginal likelihood of all flights given the means, near the mode of each rocket's terms. [nat]

    Raises ImpossibleFlight for a flight without a dry mass.
    """
    hyperprior = replace(hyperprior, mean_sds={})
    found = [_fitted([flown_and_planned(flown) for flown in fleet], _period(fleet), hyperprior) for fleet in fleets]
    alone = [
        [Alone(one.log_evidence, message_of(one), independent_prior([one.model])) for one in fits] for fits in found
    ]
    return float(sum(map(joint_evidence, alone)))


def _model(history: History, hyperprior: Hyperprior, period: Period | None) -> Model:
    return replace(base_model(history, hyperprior, period=period), coarse=True)


def _fitted(histories: Sequence[History], period: Period | None, hyperprior: Hyperprior) -> list[Fit]:
    return [fit_robustly(_model(one, hyperprior, period), observe(one, hyperprior)) for one in histories]


def _linearized(fleet: Fleet, hyperprior: Hyperprior) -> list[_Linear]:
    found, histories, period = [], [flown_and_planned(flown) for flown in fleet], _period(fleet)
    for history, result in zip(histories, _fitted(histories, period, hyperprior), strict=True):
        sds = np.array([kind.sd for kind in result.model.scatter])
        found.append(_Linear(history, period, result.tangent, result.tangent.scatter_slope / sds, result.data.trust))
    return found


def _period(fleet: Fleet) -> Period | None:
    return period_of(flight for flown in fleet for flight, _ in flown)


def _step(
    fleets: Sequence[Sequence[_Linear]], hyperprior: Hyperprior, start: Hyperprior
) -> tuple[Hyperprior, list[list[_Linear]]]:
    """One expectation-maximization step, and the rockets with updated weights of their outliers."""
    sums, means = _Sums(), _Sums()
    updated = []
    for fleet in fleets:
        fits, together = _posteriors(fleet, hyperprior)
        for result in fits:
            _count_rocket(result, sums)
        _count_shared(together, hyperprior, sums, means)
        updated.append([replace(one, trust=outlier_weights(result)) for one, result in zip(fleet, fits, strict=True)])
    return _maximized(hyperprior, start, sums, means), updated


def _posteriors(fleet: Sequence[_Linear], hyperprior: Hyperprior) -> tuple[list[Fit], SharedPrior]:
    """The fit of every rocket given all flights of the fleet, and the posterior of the shared terms."""
    alone = [_solved(one, hyperprior, None) for one in fleet]
    prior = merged([independent_prior([result.model]) for result in alone])
    messages = [message_of(result) for result in alone]
    together = combined(prior, messages)
    fits = [
        _solved(one, hyperprior, combined(prior, [m for j, m in enumerate(messages) if j != i]))
        for i, one in enumerate(fleet)
    ]
    return fits, together


def _solved(one: _Linear, hyperprior: Hyperprior, shared: SharedPrior | None) -> Fit:
    model = with_shared(_model(one.history, hyperprior, one.period), shared)
    data = replace(observe(one.history, hyperprior), trust=one.trust)
    sds = np.array([kind.sd for kind in model.scatter])
    return solve(model, data, replace(one.tangent, scatter_slope=one.unit_scatter * sds))


def _count_rocket(result: Fit, sums: _Sums) -> None:
    """One rocket's part of the sums for the variances of its terms, scatter and residuals."""
    model, weights = result.model, result.weights
    scatter, reading, _ = model.hyperprior.scales()
    by = {"": np.ones_like(scatter), "scatter": scatter, "reading": reading}
    shared = set(model.shared.names) if model.shared else set()
    square = result.mean**2 + np.diagonal(result.covariance, axis1=1, axis2=2)
    for i, term in enumerate(model.terms):
        name = term.name
        if name == TermName("drag"):  # including the unknown area of rockets without a recorded diameter
            sums.add("drag", float(weights @ square[:, i]) / term.sd**2, 1.0)
        elif name.level in LEARNED_LEVELS and name not in shared:
            sums.add(f"{name.quantity}.{name.level}", float(weights @ (square[:, i] / by[term.scaled_by] ** 2)), 1.0)
    for kind, value in _scatter_squares(result).items():
        sums.add(f"{kind}.flight", value, float(result.data.seen.any(axis=1).sum()))
    left = np.einsum("s,sfo->fo", weights, standardized_squares(result)) * result.data.trust
    for column, readout in enumerate(READOUTS):
        seen = result.data.seen[:, column]
        sums.add(f"residual.{readout}", float(left[seen, column].sum()), float(seen.sum()))


def _scatter_squares(result: Fit) -> Mapping[str, float]:
    """Posterior mean squares of the standardized random effects of single flights, summed over the flights.

    With slopes S = U diag(s), noise N and residual r after the terms, the posterior mean is z = S' N^-1 r and the
    covariance is I - S' N^-1 S + S' N^-1 A C A' N^-1 S.
    """
    model, evidence = result.model, result.evidence
    offset = result.mean - np.array([term.mean for term in model.terms])
    left = evidence.miss - np.moveaxis(evidence.slope @ offset.T, -1, 0)
    usable = (np.abs(evidence.slope).sum(axis=-1) > 0) | (np.abs(evidence.miss) > 0)
    slope = (
        np.where(usable[..., None], result.tangent.scatter_slope[:, evidence.readouts], 0.0)[None]
        * model.scatter_scales()[:, None, None]
    )
    gain = np.swapaxes(slope, -1, -2) @ evidence.sharpness
    mean = (gain @ left[..., None])[..., 0]
    spread = gain @ evidence.slope
    known = np.einsum("sfzt,stu,sfzu->sfz", spread, result.covariance, spread, optimize=True)
    unexplained = 1 - np.einsum("sfzo,sfoz->sfz", gain, slope)
    flown = result.data.seen.any(axis=1)
    square = np.einsum("s,sfz->fz", result.weights, mean**2 + unexplained + known)[flown].sum(axis=0)
    return {str(kind.bends): float(value) for kind, value in zip(model.scatter, square, strict=True)}


def _count_shared(together: SharedPrior, hyperprior: Hyperprior, sums: _Sums, means: _Sums) -> None:
    """One flyer's part of the sums for the variances of shared terms and for the means over flyers."""
    variances = np.diag(together.covariance)
    for name, mean, variance in zip(together.names, together.mean, variances, strict=True):
        quantity = name.quantity
        if name.level == "fleet":
            sums.add(f"{quantity}.fleet", float((mean - hyperprior.mean(quantity)) ** 2 + variance), 1.0)
            means.add(quantity, float(mean), 1.0)
        else:
            sums.add(f"{quantity}.{name.level}", float(mean**2 + variance), 1.0)


def _maximized(now: Hyperprior, start: Hyperprior, sums: _Sums, means: _Sums) -> Hyperprior:
    """The hyperprior that follows from the sums."""
    sds = dict(now.sds)
    for name in now.sds:
        quantity, _, level = name.partition(".")
        if name == "drag.rocket":
            sds[name] = now.sds[name] * _factor(sums, "drag", now.sds[name], start.sds[name])
        elif level == "flight":
            kind = "residual.apogee" if quantity == "apogee" else name
            factor = _factor(sums, kind, now.sds[name], start.sds[name])
            sds[name] = now.sds[name] * factor
        elif name in sums.count:
            sds[name] = float(np.sqrt(sums.variance(name, start.sds[name] ** 2)))
    ratio = tuple(
        value * _factor(sums, f"residual.{readout}", value, start.ratio[i]) if i and value else value
        for i, (readout, value) in enumerate(zip(READOUTS, now.ratio, strict=True))
    )
    fixed = tuple(
        value * _factor(sums, f"residual.{readout}", value, start.fixed[i]) if not now.ratio[i] else value
        for i, (readout, value) in enumerate(zip(READOUTS, now.fixed, strict=True))
    )
    centers = {name: _center(means, name, now, start) for name in now.means}
    area = now.unknown_area * sds["drag.rocket"] / now.sds["drag.rocket"]
    return replace(now, means=centers, sds=sds, ratio=ratio, fixed=fixed, unknown_area=area)


def _factor(sums: _Sums, name: str, now: float, start: float) -> float:
    """Factor on a standard deviation, from sums of standardized squares. [1]"""
    count = sums.count.get(name, 0.0)
    return float(np.sqrt((sums.square.get(name, 0.0) + PRIOR_GROUPS * (start / now) ** 2) / (count + PRIOR_GROUPS)))


def _center(means: _Sums, quantity: str, now: Hyperprior, start: Hyperprior) -> float:
    variance = now.sd(quantity, "fleet") ** 2
    if not variance or quantity not in means.count:
        return now.mean(quantity)
    precision = means.count[quantity] / variance
    return float((means.square[quantity] / variance + start.mean(quantity) / MEAN_SD**2) / (precision + 1 / MEAN_SD**2))
