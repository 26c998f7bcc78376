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
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from datetime import date
from itertools import pairwise
from typing import Literal

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
from fieldkit.progress import ReportProgress, no_op, part
from fieldkit.shapes import Array, Flags, Float

Level = Literal["motor_type", "lot", "day", "site", "device", "fleet"]
QUANTITIES = ("thrust", "stretch", "drag", "apogee")
"""What a candidate may change: log ratios of impulse, burn time, drag and the reading of height."""
WIDTHS = (0.5, 1.0, 2.0)
"""Factors on the prior standard deviation of an effect, equally probable a priori: a judgment. [1]"""
EFFECTS: Mapping[str, tuple[str, ...]] = {
    "motor_thrust": ("thrust",),
    "thrust_curve": ("stretch",),
    "motor_thrust+thrust_curve": ("thrust", "stretch"),
    "air_density": ("drag",),
    "weather": ("apogee",),
    "altimeter_scale": ("apogee",),
}
"""The quantities that change with each effect."""
SDS: Mapping[str, float] = {"thrust": 0.09, "stretch": 0.25, "drag": 0.12, "apogee": 0.05}
"""Prior standard deviation of each change, as that of the effects in `models/effects`. [1]"""
LEVEL_EFFECTS: Mapping[Level, tuple[str, ...]] = {
    "motor_type": ("motor_thrust", "thrust_curve", "motor_thrust+thrust_curve"),
    "lot": ("motor_thrust", "thrust_curve", "motor_thrust+thrust_curve"),
    "day": ("air_density", "weather"),
    "site": ("air_density",),
    "device": ("altimeter_scale",),
    "fleet": ("altimeter_scale",),
}
"""The effects that may act at each level."""
PRIOR_PROBABILITY: Mapping[Level, float] = {
    "motor_type": 0.05,
    "lot": 0.1,
    "day": 0.02,
    "site": 0.05,
    "device": 0.05,
    "fleet": 0.03,
}
"""Prior probability of a difference beyond the usual in one group of each level: judgments, round figures. A change of
a motor type from some day on counts as a lot, and one of all heights from some day on as `fleet`. [1]"""
MIN_FLIGHTS = 2
"""Minimum number of flights with and without a difference. [1]"""
MAX_EVALUATED = 12
"""Number of candidates whose evidence is computed in full, the best by the closed form. [1]"""
MAX_FINDINGS = 3
"""Maximum number of findings, each given those before it. [1]"""
SIMPLER_WINDOW = 1.0
"""An effect that changes fewer quantities is named if its log odds against the most probable one of its group are
within this. [nat]"""
MIN_PROBABILITY = 0.2
"""Probability from which a finding is reported. [1]"""


@dataclass(frozen=True, slots=True)
class Candidate:
    """A difference in a group of flights: of a motor type or lot, a day, a site, a device, or from some day on.

    `members` marks its flights, by rocket.
    """

    effect: str
    level: Level
    of: str
    since: date | None
    members: Mapping[str, Flags]

    @property
    def place(self) -> tuple[Level, str]:
        """The group, without the day from which on it differs."""
        return self.level, self.of

    @property
    def names(self) -> tuple[TermName, ...]:
        """The names of its terms, common to all rockets."""
        group = (self.level, self.of, self.since)
        return tuple(TermName(quantity, "difference", group) for quantity in EFFECTS[self.effect])

    def terms(self, rocket: str, width: float = WIDTHS[-1]) -> tuple[Term, ...]:
        """Its terms in the model of a rocket, with the prior of one of `WIDTHS`; none if it does not concern it."""
        weight = self.members.get(rocket)
        if weight is None or not weight.any():
            return ()
        quantities = EFFECTS[self.effect]
        pairs = zip(self.names, quantities, strict=True)
        return tuple(Term(name, quantity, 0.0, width * SDS[quantity], weight.astype(float)) for name, quantity in pairs)


@dataclass(frozen=True, slots=True, eq=False)
class FleetRocket:
    """A rocket's flights, linear around its fit without candidates.

    `slopes` are the derivatives of the readouts with respect to each of `QUANTITIES`.
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

    candidate: Candidate
    probability: float
    log_bayes: float
    strengths: Mapping[str, tuple[float, float]]
    others: tuple[tuple[Candidate, float], ...] = ()


def fleet_rocket(name: str, flown: FlownFlights, hyperprior: Hyperprior, period: Period | None) -> FleetRocket:
    """Fit a rocket and linearize it. Raises ImpossibleFlight for a flight without a dry mass, BadValue for a recovery
    figure or rail direction that cannot be read."""
    flights, found = [flight for flight, _ in flown], [motor for _, motor in flown]
    model = replace(base_model(flights, found, hyperprior, period=period), coarse=True)
    result = fit_robustly(model, observe(flights, found, [flight.clean for flight in flights], hyperprior))
    wide = model.with_terms(
        *(Term(TermName(name, "added"), name, 0.0, 1.0, np.ones(len(flights))) for name in QUANTITIES)
    )
    at = np.concatenate([result.tangent.at, np.zeros(len(QUANTITIES))])
    angles = known_angle_slope(result.model, result.tangent)
    (near,) = tangents(wide, [(tuple(range(len(wide.terms))), at)], angles)
    own = len(model.terms)
    slopes = {name: near.slope[..., own + row] for row, name in enumerate(QUANTITIES)}
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


def candidates(rockets: Sequence[FleetRocket]) -> list[Candidate]:
    """Every group of flights that may differ: by motor type and lot, day, site and device, and from some day on.

    A group has at least `MIN_FLIGHTS` flights, and so have the flights without the difference.
    """
    found: list[Candidate] = []
    labels_at = _labels(rockets)
    for kind, labels in labels_at.items():
        for of in dict.fromkeys(label for own in labels.values() for label in own if label):
            there = {name: np.array([label == of for label in own]) for name, own in labels.items()}
            found += _at(kind, of, None, there, rockets)
    motors = labels_at["motor_type"]
    every = {one.name: np.ones(len(one.model.flights), bool) for one in rockets}
    groups: list[tuple[Level, str, Mapping[str, Flags]]] = [("fleet", "all heights", every)]
    groups += [
        ("lot", of, {name: np.array([label == of for label in own]) for name, own in motors.items()})
        for of in dict.fromkeys(label for own in motors.values() for label in own)
    ]
    for level, of, members in groups:
        days = {one.name: _days(one) for one in rockets}
        dated = sorted(
            {
                day
                for name, own in days.items()
                for day, inside in zip(own, members[name], strict=True)
                if inside and day
            }
        )
        for _, day in pairwise(dated):
            since = {name: np.array([each is not None and each >= day for each in own]) for name, own in days.items()}
            later = {name: members[name] & since[name] for name in members}
            earlier = sum(int((members[name] & ~later[name] & _seen(rockets, name)).sum()) for name in members)
            if earlier >= MIN_FLIGHTS:
                found += _at(level, of, day, later, rockets)
    return found


def _at(
    level: Level, of: str, since: date | None, members: Mapping[str, Flags], rockets: Sequence[FleetRocket]
) -> Iterator[Candidate]:
    """A group with each effect that may act on it, if it has enough flights."""
    inside = sum(int((members[one.name] & one.data.seen[:, 0]).sum()) for one in rockets)
    total = sum(int(one.data.seen[:, 0].sum()) for one in rockets)
    if inside >= MIN_FLIGHTS and total - inside >= MIN_FLIGHTS:
        for effect in LEVEL_EFFECTS[level]:
            yield Candidate(effect, level, of, since, members)


def _seen(rockets: Sequence[FleetRocket], name: str) -> Flags:
    return next(one.data.seen[:, 0] for one in rockets if one.name == name)


def _days(one: FleetRocket) -> list[date | None]:
    """The day of each flight, None for one without a date."""
    return [flight.date_time.date() if flight.date_time else None for flight in one.model.flights]


def _labels(rockets: Sequence[FleetRocket]) -> dict[Level, dict[str, list[str]]]:
    """The group of each flight at every level, empty if unknown, by rocket."""
    found: dict[Level, dict[str, list[str]]] = defaultdict(dict)
    for one in rockets:
        groups: dict[Level, list[str]] = {
            "motor_type": one.model.groups("motor"),
            "lot": one.model.groups("lot"),
            "day": one.model.groups("day"),
            "site": one.model.groups("site"),
            "device": [recorded_device(flight.extra) for flight in one.model.flights],
        }
        for level, labels in groups.items():
            found[level][one.name] = labels
    return dict(found)


def recorded_device(extra: Mapping[str, str]) -> str:
    """The altimeter of a flight as a column of the flyer's table has it, empty if none does."""
    return next((text.strip() for header, text in extra.items() if header.casefold().strip() in DEVICE_HEADERS), "")


DEVICE_HEADERS = ("altimeter", "device", "logger", "altimeter_serial", "serial")
"""Headers of a column with the altimeter, in lower case."""


def search_fleet(rockets: Sequence[FleetRocket], on_progress: ReportProgress = no_op) -> list[FleetFinding]:
    """The differences that rockets share, the most probable first, each given those before it."""
    accepted: list[Candidate] = []
    found: list[FleetFinding] = []
    every = candidates(rockets)
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
    every: Sequence[Candidate],
    accepted: Sequence[Candidate],
    on_progress: ReportProgress,
) -> FleetFinding | None:
    base = {one.name: _fit_with(one, accepted) for one in rockets}
    scored = sorted(
        ((_screened(one, rockets, base) + _log_prior(one, every), one) for one in every), key=lambda p: -p[0]
    )
    best = [one for _, one in scored[:MAX_EVALUATED]]
    if not best:
        return None
    plain = {one.name: rocket_message(one, base[one.name], accepted) for one in rockets}
    weights, gains = [], []
    for number, one in enumerate(best):
        on_progress(f"{one.effect} of {one.of}", number / len(best))
        gain = log_bayes(one, rockets, plain, accepted)
        gains.append(gain)
        weights.append(gain + _log_prior(one, every))
    total = np.logaddexp.reduce([0.0, *weights])
    chance = np.exp(np.array(weights) - total)
    by_place: dict[tuple[Level, str], float] = defaultdict(float)
    for one, own in zip(best, chance.tolist(), strict=True):
        by_place[one.place] += own
    place = max(by_place, key=lambda key: by_place[key])
    there = [row for row, one in enumerate(best) if one.place == place]
    heaviest = max(weights[row] for row in there)
    likely = [row for row in there if weights[row] > heaviest - SIMPLER_WINDOW]
    top = min(likely, key=lambda row: (len(EFFECTS[best[row].effect]), -weights[row]))
    others = sorted(((one, own) for one, own in zip(best, chance.tolist(), strict=True)), key=lambda p: -p[1])
    return FleetFinding(
        best[top], by_place[place], gains[top], strengths(best[top], rockets, accepted), tuple(others[:5])
    )


def _log_prior(one: Candidate, every: Sequence[Candidate]) -> float:
    """Log prior odds of a candidate against no difference: its group's, shared by its days and effects. [nat]"""
    same = sum(other.place == one.place and (other.since is None) == (one.since is None) for other in every)
    chance = PRIOR_PROBABILITY[one.level]
    return float(np.log(chance / (1 - chance) / same))


def _fit_with(one: FleetRocket, some: Sequence[Candidate]) -> Fit:
    terms = [term for each in some for term in each.terms(one.name)]
    return one.fit(terms) if terms else one.plain


def rocket_message(one: FleetRocket, fit: Fit, some: Sequence[Candidate]) -> RocketFit:
    """What a fit of a rocket with some candidates tells the fleet, about their strengths too."""
    names = [name for each in some for name in each.names if name in fit.model.names]
    return RocketFit(fit.log_evidence, message_of(fit, names), independent_prior([fit.model], names))


def log_bayes(
    one: Candidate, rockets: Sequence[FleetRocket], plain: Mapping[str, RocketFit], accepted: Sequence[Candidate]
) -> float:
    """Log Bayes factor of a candidate in the fleet, summed over the widths of its prior. [nat]"""
    fits = dict(plain)
    for rocket in rockets:
        if one.terms(rocket.name):
            fits[rocket.name] = rocket_message(rocket, _fit_with(rocket, [*accepted, one]), [*accepted, one])
    known, without = list(fits.values()), joint_evidence(list(plain.values()))
    gains = [joint_evidence(known, _with_width(known, one, width)) - without for width in WIDTHS]
    return float(np.logaddexp.reduce(gains) - np.log(len(WIDTHS)))


def _with_width(rockets: Sequence[RocketFit], one: Candidate, width: float) -> SharedPrior:
    """The prior of the shared terms of rockets, with that of the strengths of a candidate for one of `WIDTHS`."""
    prior = merged([rocket.prior for rocket in rockets])
    factors = np.array([width / WIDTHS[-1] if name in one.names else 1.0 for name in prior.names])
    return replace(prior, covariance=prior.covariance * np.outer(factors, factors))


def strengths(
    one: Candidate, rockets: Sequence[FleetRocket], accepted: Sequence[Candidate] = ()
) -> dict[str, tuple[float, float]]:
    """Posterior mean and standard deviation of each quantity that a candidate changes, as a log ratio. [1]"""
    some = [*accepted, one]
    known = shared_prior([rocket_message(rocket, _fit_with(rocket, some), some) for rocket in rockets])
    assert known is not None
    found = {}
    for name, quantity in zip(one.names, EFFECTS[one.effect], strict=True):
        row = known.names.index(name)
        found[quantity] = float(known.mean[row]), float(np.sqrt(known.covariance[row, row]))
    return found


def _screened(one: Candidate, rockets: Sequence[FleetRocket], base: Mapping[str, Fit]) -> float:
    """Log Bayes factor of a candidate in closed form at each rocket's most probable scales, with the terms of rockets
    independent: only to choose which candidates are worth a fit. [nat]

    Derivation: normal linear model with additional terms, marginal over the others (Woodbury's identity).
    """
    count = len(EFFECTS[one.effect])
    information, score = np.zeros((count, count)), np.zeros(count)
    for rocket in rockets:
        weight = one.members[rocket.name]
        if not weight.any():
            continue
        fit = base[rocket.name]
        scale, evidence = int(np.argmax(fit.weights)), fit.evidence
        used = evidence.readouts
        usable = fit.data.seen[:, used] & weight[:, None]
        columns = np.stack([rocket.slopes[name][:, used] for name in EFFECTS[one.effect]], axis=-1)
        columns = np.where(usable[..., None], columns, 0.0)
        offset = fit.mean[scale] - np.array([term.mean for term in fit.model.terms])
        left = evidence.miss - evidence.slope @ offset
        weighed = evidence.sharpness[scale] @ columns
        ties = np.einsum("fot,fou->tu", evidence.slope, weighed)
        information += np.einsum("fou,fov->uv", columns, weighed) - ties.T @ fit.covariance[scale] @ ties
        score += np.einsum("fou,fo->u", weighed, left)
    gains = []
    for width in WIDTHS:
        sds = width * np.array([SDS[quantity] for quantity in EFFECTS[one.effect]])
        precision = information + np.diag(1 / sds**2)
        log_det = np.linalg.slogdet(precision)[1] + 2 * np.log(sds).sum()
        gains.append(0.5 * (score @ np.linalg.solve(precision, score) - log_det))
    return float(np.logaddexp.reduce(gains) - np.log(len(WIDTHS)))


def log_shifts(
    one: Candidate, rockets: Sequence[FleetRocket], order: Mapping[tuple[str, str], int], latest: int
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
            fits[key] = rocket_message(rocket, rocket.fit(terms, seen), [one] if terms else [])
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
