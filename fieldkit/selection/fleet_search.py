"""The search for differences that several rockets share: a motor type or lot, a day, a site, an altimeter.

A candidate changes one or two quantities of the model (thrust, burn time, drag by the air, the reading of height) on a
group of flights of all rockets, such as those on one motor type from some day on. Given its strengths and the terms of
the fleet, rockets are independent, so its evidence is the joint evidence of the fleet with the strengths among the
shared terms (`fieldkit.inference.laplace.fleet`). A strength is normal with a standard deviation that is summed over a
grid, which has heavier tails than a normal distribution (scale mixtures; Andrews and Mallows, 1974): most lots differ
by a little, and some by a lot. Every rocket is linear around its fit without candidates, while the scales of its
scatter and the weights of its outliers are found again with each candidate, because a lasting change otherwise passes
for scatter.
"""

from collections import defaultdict
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from fieldkit.inference.laplace.fit import fit_robustly, robust_at
from fieldkit.inference.laplace.fleet import (
    RocketFit,
    independent_prior,
    joint_evidence,
    merged,
    message_of,
    shared_prior,
)
from fieldkit.inference.laplace.linearization import Tangent, known_angle_slope, tangents
from fieldkit.inference.laplace.posterior import Fit
from fieldkit.model.fleet_drift import Period, period_of
from fieldkit.model.hyperprior import Hyperprior
from fieldkit.model.readout_data import Data, observe
from fieldkit.model.rocket_model import FlownFlights, Model, Term, base_model, with_shared
from fieldkit.model.shared_prior import SharedPrior
from fieldkit.model.term_names import TermName
from fieldkit.physics.effect import SharedBy
from fieldkit.physics.history import flown_and_planned
from fieldkit.progress import ReportProgress, no_op, part
from fieldkit.selection.fleet_groups import PRIOR_WIDTHS, SharedDifference, differences, shared_quantities
from fieldkit.shapes import Array, Flags, Float

PRIOR_PROBABILITY: Mapping[SharedBy, float] = {
    "motor_type": 0.05,
    "lot": 0.1,
    "day": 0.02,
    "site": 0.05,
    "device": 0.05,
    "fleet": 0.03,
}
"""Prior probability of a difference beyond the usual in one group of each level: judgments, round figures. A change of
a motor type from some day on counts as a lot, and one of all heights from some day on as `fleet`. [1]"""
MAX_EVALUATED = 12
"""Number of candidates whose evidence is computed in full, the best by the closed form. [1]"""
MAX_FINDINGS = 3
"""Maximum number of findings, each given those before it. [1]"""
SIMPLER_WINDOW = 1.0
"""An effect that changes fewer quantities is named if its log odds against the most probable one of its group are
within this. [nat]"""
MIN_PROBABILITY = 0.2
"""Probability from which a finding is reported. [1]"""


@dataclass(frozen=True, slots=True, eq=False)
class FleetRocket:
    """A rocket's flights, linear around its fit without candidates.

    `slopes` are the derivatives of the readouts with respect to each of `shared_quantities`.
    """

    name: str
    model: Model
    data: Data
    near: Tangent
    slopes: Mapping[str, Float[Array, "flight readout"]]
    plain: Fit

    def fit(self, terms: Sequence[Term] = (), seen: Flags | None = None, shared: SharedPrior | None = None) -> Fit:
        """The posterior with more terms, from all flights or those `seen`, with information from other rockets."""
        model = with_shared(self.model.with_terms(*terms), shared)
        added = [self.slopes[str(term.bends)] * term.weight[:, None] for term in terms]
        slope = np.concatenate([self.near.slope, np.stack(added, axis=-1)], axis=-1) if added else self.near.slope
        at = np.concatenate([self.near.at, np.zeros(len(terms))])
        data = self.data
        if seen is not None:
            data = replace(data, seen=data.seen & seen[:, None], trust=np.ones(data.trust.shape))
        return robust_at(model, data, Tangent(at, self.near.values, slope, self.near.scatter_slope))


@dataclass(frozen=True, slots=True)
class FleetFinding:
    """A difference that several rockets may share, with the probability that its group differs beyond the usual [1].

    `log_bayes` is its log Bayes factor [nat]; `strengths` are mean and standard deviation of each changed quantity, as
    a log ratio [1]; `others` are other explanations with their probabilities.
    """

    candidate: SharedDifference
    probability: float
    log_bayes: float
    strengths: Mapping[str, tuple[float, float]]
    others: tuple[tuple[SharedDifference, float], ...] = ()


def fleet_rocket(name: str, flown: FlownFlights, hyperprior: Hyperprior, period: Period | None) -> FleetRocket:
    """Fit a rocket and linearize it. Raises ImpossibleFlight for a flight without a dry mass."""
    history = flown_and_planned(flown)
    model = replace(base_model(history, hyperprior, period=period), coarse=True)
    result = fit_robustly(model, observe(history, hyperprior))
    quantities = shared_quantities()
    wide = model.with_terms(
        *(Term(TermName(name, "added"), name, 0.0, 1.0, np.ones(len(flown))) for name in quantities)
    )
    at = np.concatenate([result.tangent.at, np.zeros(len(quantities))])
    angles = known_angle_slope(result.model, result.tangent)
    (near,) = tangents(wide, [(tuple(range(len(wide.terms))), at)], angles)
    own = len(model.terms)
    slopes = {name: near.slope[..., own + row] for row, name in enumerate(quantities)}
    near = replace(near, at=near.at[:own], slope=near.slope[..., :own])
    return FleetRocket(name, model, result.data, near, slopes, robust_at(model, result.data, near))


def fleet_of(
    flown: Mapping[str, FlownFlights], hyperprior: Hyperprior, on_progress: ReportProgress = no_op
) -> list[FleetRocket]:
    """Every rocket of a flyer, linearized; errors as in `fleet_rocket`."""
    period = period_of(flight for own in flown.values() for flight, _ in own)
    found = []
    for number, (name, own) in enumerate(flown.items()):
        on_progress(name, number / len(flown))
        found.append(fleet_rocket(name, own, hyperprior, period))
    return found


def fleet_differences(rockets: Sequence[FleetRocket]) -> list[SharedDifference]:
    """Every group of flights of some rockets that may differ."""
    return differences({one.name: one.model for one in rockets}, {one.name: one.data.seen[:, 0] for one in rockets})


def search_fleet(rockets: Sequence[FleetRocket], on_progress: ReportProgress = no_op) -> list[FleetFinding]:
    """The differences that rockets share, the most probable first, each given those before it."""
    accepted: list[SharedDifference] = []
    found: list[FleetFinding] = []
    every = fleet_differences(rockets)
    for number in range(MAX_FINDINGS):
        one = _next_finding(rockets, every, accepted, part(on_progress, number / MAX_FINDINGS, 1 / MAX_FINDINGS))
        if one is None or one.probability < MIN_PROBABILITY:
            break
        found.append(one)
        accepted.append(one.candidate)
        every = [other for other in every if other.place != one.candidate.place]
    return sorted(found, key=lambda item: -item.probability)


def _next_finding(
    rockets: Sequence[FleetRocket],
    every: Sequence[SharedDifference],
    accepted: Sequence[SharedDifference],
    on_progress: ReportProgress,
) -> FleetFinding | None:
    base = {one.name: _fit_with(one, accepted) for one in rockets}
    scored = sorted(
        ((_screened(one, rockets, base) + _log_prior(one, every), one) for one in every), key=lambda p: -p[0]
    )
    best = [one for _, one in scored[:MAX_EVALUATED]]
    if not best:
        return None
    plain = {one.name: rocket_message(base[one.name], accepted) for one in rockets}
    weights, gains = [], []
    for number, one in enumerate(best):
        on_progress(f"{one.effect} of {one.of}", number / len(best))
        gain = log_bayes(one, rockets, plain, accepted)
        gains.append(gain)
        weights.append(gain + _log_prior(one, every))
    total = np.logaddexp.reduce([0.0, *weights])
    chance = np.exp(np.array(weights) - total)
    by_place: dict[tuple[SharedBy, str], float] = defaultdict(float)
    for one, own in zip(best, chance.tolist(), strict=True):
        by_place[one.place] += own
    place = max(by_place, key=lambda key: by_place[key])
    there = [row for row, one in enumerate(best) if one.place == place]
    heaviest = max(weights[row] for row in there)
    likely = [row for row in there if weights[row] > heaviest - SIMPLER_WINDOW]
    top = min(likely, key=lambda row: (len(best[row].effects), -weights[row]))
    others = sorted(((one, own) for one, own in zip(best, chance.tolist(), strict=True)), key=lambda p: -p[1])
    return FleetFinding(
        best[top], by_place[place], gains[top], strengths(best[top], rockets, accepted), tuple(others[:5])
    )


def _log_prior(one: SharedDifference, every: Sequence[SharedDifference]) -> float:
    """Log prior odds of a candidate against no difference: its group's, shared by its days and effects. [nat]"""
    same = sum(other.place == one.place and (other.since is None) == (one.since is None) for other in every)
    chance = PRIOR_PROBABILITY[one.level]
    return float(np.log(chance / (1 - chance) / same))


def _fit_with(one: FleetRocket, some: Sequence[SharedDifference]) -> Fit:
    terms = [term for each in some for term in each.terms(one.name)]
    return one.fit(terms) if terms else one.plain


def rocket_message(fit: Fit, some: Sequence[SharedDifference]) -> RocketFit:
    """The information from a fit of a rocket with some candidates for the fleet, about their strengths too."""
    names = [name for each in some for name in each.names if name in fit.model.names]
    return RocketFit(fit.log_evidence, message_of(fit, names), independent_prior([fit.model], names))


def log_bayes(
    one: SharedDifference,
    rockets: Sequence[FleetRocket],
    plain: Mapping[str, RocketFit],
    accepted: Sequence[SharedDifference],
) -> float:
    """Log Bayes factor of a candidate in the fleet, summed over the widths of its prior. [nat]"""
    fits = dict(plain)
    for rocket in rockets:
        if one.terms(rocket.name):
            fits[rocket.name] = rocket_message(_fit_with(rocket, [*accepted, one]), [*accepted, one])
    known, without = list(fits.values()), joint_evidence(list(plain.values()))
    gains = [joint_evidence(known, _with_width(known, one, width)) - without for width in PRIOR_WIDTHS]
    return float(np.logaddexp.reduce(gains) - np.log(len(PRIOR_WIDTHS)))


def _with_width(rockets: Sequence[RocketFit], one: SharedDifference, width: float) -> SharedPrior:
    """The prior of the shared terms of rockets, with that of the strengths of a candidate for one of `PRIOR_WIDTHS`."""
    prior = merged([rocket.prior for rocket in rockets])
    factors = np.array([width / PRIOR_WIDTHS[-1] if name in one.names else 1.0 for name in prior.names])
    return replace(prior, covariance=prior.covariance * np.outer(factors, factors))


def strengths(
    one: SharedDifference, rockets: Sequence[FleetRocket], accepted: Sequence[SharedDifference] = ()
) -> dict[str, tuple[float, float]]:
    """Posterior mean and standard deviation of each quantity that a candidate changes, as a log ratio. [1]"""
    some = [*accepted, one]
    known = shared_prior([rocket_message(_fit_with(rocket, some), some) for rocket in rockets])
    assert known is not None
    found = {}
    for name, quantity in zip(one.names, one.quantities, strict=True):
        row = known.names.index(name)
        found[quantity] = float(known.mean[row]), float(np.sqrt(known.covariance[row, row]))
    return found


def _screened(one: SharedDifference, rockets: Sequence[FleetRocket], base: Mapping[str, Fit]) -> float:
    """Log Bayes factor of a candidate in closed form at each rocket's most probable scales, with the terms of rockets
    independent: only to choose which candidates are worth a fit. [nat]

    Derivation: normal linear model with additional terms, marginal over the others (Woodbury's identity).
    """
    count = len(one.effects)
    information, score = np.zeros((count, count)), np.zeros(count)
    for rocket in rockets:
        weight = one.members[rocket.name]
        if not weight.any():
            continue
        fit = base[rocket.name]
        scale, evidence = int(np.argmax(fit.weights)), fit.evidence
        used = evidence.readouts
        usable = fit.data.seen[:, used] & weight[:, None]
        columns = np.stack([rocket.slopes[name][:, used] for name in one.quantities], axis=-1)
        columns = np.where(usable[..., None], columns, 0.0)
        offset = fit.mean[scale] - np.array([term.mean for term in fit.model.terms])
        left = evidence.miss - evidence.slope @ offset
        weighed = evidence.sharpness[scale] @ columns
        ties = np.einsum("fot,fou->tu", evidence.slope, weighed)
        information += np.einsum("fou,fov->uv", columns, weighed) - ties.T @ fit.covariance[scale] @ ties
        score += np.einsum("fou,fo->u", weighed, left)
    gains = []
    for width in PRIOR_WIDTHS:
        sds = width * np.array(one.sds)
        precision = information + np.diag(1 / sds**2)
        log_det = np.linalg.slogdet(precision)[1] + 2 * np.log(sds).sum()
        gains.append(0.5 * (score @ np.linalg.solve(precision, score) - log_det))
    return float(np.logaddexp.reduce(gains) - np.log(len(PRIOR_WIDTHS)))


def log_shifts(
    one: SharedDifference, rockets: Sequence[FleetRocket], order: Mapping[tuple[str, str], int], latest: int
) -> dict[tuple[str, str], float]:
    """By how much a candidate shifts the forecast log apogee of each of its latest flights, from the flights before.

    `order` is the position of every flight, by rocket and id. Only flights with an earlier one in the group are
    forecast, and only rockets that the candidate concerns inform them. [1]
    """
    concerned = [rocket for rocket in rockets if one.terms(rocket.name)]
    turns = {
        rocket.name: np.array([order[rocket.name, own.flight_id] for own in rocket.model.flights])
        for rocket in concerned
    }
    inside = {rocket.name: one.members[rocket.name] & rocket.data.seen[:, 0] for rocket in concerned}
    judged = sorted(
        (int(turns[name][row]), name, row) for name, rows in inside.items() for row in np.flatnonzero(rows).tolist()
    )
    fits: dict[tuple[str, int, bool], RocketFit] = {}

    def message(rocket: FleetRocket, turn: int, terms: Sequence[Term]) -> RocketFit:
        seen = turns[rocket.name] < turn
        key = rocket.name, int(seen.sum()), bool(terms)
        if key not in fits:
            fits[key] = rocket_message(rocket.fit(terms, seen), [one] if terms else [])
        return fits[key]

    def forecast(turn: int, name: str, row: int, *, changed: bool) -> float:
        own = next(rocket for rocket in concerned if rocket.name == name)
        terms = {rocket.name: one.terms(rocket.name) if changed else () for rocket in concerned}
        others = [message(rocket, turn, terms[rocket.name]) for rocket in concerned if rocket is not own]
        fit = own.fit(terms[name], turns[name] < turn, shared_prior(others))
        return float(fit.tangent.slope[row, 0] @ (fit.moments()[0] - fit.tangent.at))

    return {
        (name, next(rocket for rocket in concerned if rocket.name == name).model.flights[row].flight_id): (
            forecast(turn, name, row, changed=True) - forecast(turn, name, row, changed=False)
        )
        for turn, name, row in judged[1:][-latest:]
    }
