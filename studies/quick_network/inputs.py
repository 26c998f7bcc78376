"""What a network sees of a history: its flights relative to simulations, and the closed forms of one linear pass."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from fieldkit.inference.history.effect_probabilities import families, odds_of
from fieldkit.inference.history.evidence import Trials, weigh_placed
from fieldkit.inference.history.linear_fit import (
    LinearFit,
    declared_terms,
    linear_fit,
    on_one_new_motor,
    prepared_fit,
    robust,
)
from fieldkit.inference.history.moments import apogee_mixture
from fieldkit.inference.history.placed_effects import directions
from fieldkit.inference.history.response import FlightResponse, moved_at
from fieldkit.inference.laplace.one_offs import one_offs
from fieldkit.inference.laplace.outlier_weights import outlier_weights
from fieldkit.inference.laplace.posterior import solve
from fieldkit.model.causes import signatures
from fieldkit.model.documents import SEARCH_PRIOR, with_documents
from fieldkit.model.hyperprior import Hyperprior
from fieldkit.model.readout_data import as_compared, readings
from fieldkit.model.rocket_model import base_model, usual_terms
from fieldkit.model.shared_prior import SharedPrior
from fieldkit.physics.effect import effects, spoken
from fieldkit.physics.history import History
from fieldkit.physics.setups import recorded
from fieldkit.selection.prior import UNEXPLAINED, inclusion_probabilities
from fieldkit.selection.quick_candidates import quick_candidates
from fieldkit.shapes import Array, Flags, Float

SCATTER, READING, DOCUMENTS = (0.2, 0.5, 1.0, 2.2), (0.4, 1.1), (0.15, 1.0)
"""Values of the scales in the pass, relative to their medians. [1]"""
READOUTS = 6
"""Readouts of every flight that are not from logs: the first of `OBSERVED_READOUTS`."""
SENSITIVE = ("drag", "thrust", "mass")
"""Properties whose effect on the readouts a network sees."""
CAUSE_ROUNDS = 1
"""Updates of the weights of flights by their probability of being usual ones. [1]"""
MAX_ODDS = 15.0
"""Limit of log odds in the inputs. [nat]"""
PER_EFFECT = 8
"""Closed-form inputs of every effect."""


@dataclass(frozen=True, slots=True)
class ClosedForms:
    """The closed forms of one history: the forecast as a mixture over scales (weight, mean, variance that more flights
    would reduce, variance of a single flight), log odds of effects, of nothing and of something unexplained, and the
    probabilities of the causes of each flight with that of none last."""

    weight: Float[Array, "scale"]
    mean: Float[Array, "scale"]
    known: Float[Array, "scale"]
    own: Float[Array, "scale"]
    odds: dict[str, float]
    none: float
    unexplained: float
    causes: Float[Array, "flight cause"]
    flights: Float[Array, "flight raw"]
    closed_flights: Float[Array, "flight closed"]
    closed: Float[Array, "closed"]
    reference: float

    def moments(self) -> tuple[float, float]:
        """Mean and standard deviation of the log apogee. [1]"""
        mean = float(self.weight @ self.mean)
        return mean, float(np.sqrt(self.weight @ (self.known + self.own + (self.mean - mean) ** 2)))

    def draws(self, count: int = 1000, tail: float = 4.0) -> Float[Array, "draw"]:
        """Draws of the log apogee with a Student t for single flights, the same random numbers for every history."""
        rng = np.random.default_rng(0)
        which = rng.choice(len(self.weight), count, p=self.weight / self.weight.sum())
        single = rng.normal(size=count) * np.sqrt(tail / rng.chisquare(tail, count)) * np.sqrt(self.own[which])
        return np.asarray(self.mean[which] + np.sqrt(self.known[which]) * rng.normal(size=count) + single)


def scaled(hyperprior: Hyperprior) -> Hyperprior:
    """A hyperprior with a few values of every scale."""
    scatter, reading, documents = (getattr(hyperprior, name) for name in ("scatter", "reading", "documents"))
    return replace(
        hyperprior,
        scatter=replace(scatter, grid=tuple(scatter.median * x for x in SCATTER)),
        reading=replace(reading, grid=tuple(reading.median * x for x in READING)),
        documents=documents and replace(documents, grid=DOCUMENTS),
    )


def closed_forms(
    history: History, response: FlightResponse, forecast: Hyperprior, shared: SharedPrior | None = None
) -> ClosedForms:
    """The closed forms of a history with one plan, from the response of its flights to every effect."""
    flown = history.flights[: history.flown]
    read = readings(flown, history.found[: history.flown])
    search = base_model(history, SEARCH_PRIOR)
    search = replace(search, hyperprior=scaled(search.hyperprior))
    search = search.with_terms(*usual_terms(search))
    candidates = quick_candidates(replace(search, history=on_one_new_motor(history)))
    data = as_compared(read, history.used_in_fit, search.hyperprior)
    selection = robust(linear_fit(prepared_fit(search, history.flown), data, response))
    placed, chances = directions(candidates), inclusion_probabilities()
    prior = {**chances, "": chances[UNEXPLAINED]}
    every = weigh_placed(selection, placed)
    exact_scales = selection.model.hyperprior.document_scales() == DOCUMENTS[0]
    exact_weight = np.where(exact_scales, selection.fit.log_weight, -1e4)
    exact = weigh_placed(replace(selection, fit=replace(selection.fit, log_weight=exact_weight)), placed)
    odds, none = odds_of(every, prior)
    exact_odds, exact_none = odds_of(exact, prior)
    ahead = base_model(history, with_documents(forecast), shared)
    ahead = replace(ahead, hyperprior=scaled(ahead.hyperprior))
    ahead = ahead.with_terms(*usual_terms(ahead)).with_terms(*declared_terms(history.flights))
    ahead_data = as_compared(read, history.used_in_fit, ahead.hyperprior)
    plain = robust(linear_fit(prepared_fit(ahead, history.flown), ahead_data, response, start=selection.offset))
    causes, miss = _causes(plain)
    mixture = apogee_mixture(plain)
    weight, mean, known, own = mixture.weight, mixture.mean[:, 0], mixture.known[:, 0], mixture.own[:, 0]
    moved = moved_at(response, 0.0)
    columns = []
    groups = families(every)
    for name in effect_names():
        if name not in groups:
            columns.append([0.0] * PER_EFFECT)
            continue
        rows = groups[name]
        row = max(rows, key=lambda row: float(every.weight[row]))
        columns.append(
            [
                1.0,
                odds[name] / 4,
                exact_odds[name] / 4,
                _evidence(every, rows),
                _evidence(exact, rows),
                every.mean[row] / every.prior_sd[row],
                every.mean[row] / every.sd[row] / 4,
                np.log(len(rows)) / 3,
            ]
        )
    _, sd = float(weight @ mean), float(np.sqrt(weight @ (known + own)))
    few = [none / 4, exact_none / 4, odds.get("", 0.0) / 4, exact_odds.get("", 0.0) / 4, np.log(sd), exact_weight.max()]
    few[-1] = float(np.logaddexp.reduce(exact_weight) - selection.fit.log_evidence) / 4
    logit = np.log(np.clip(causes, 1e-7, 1)) - np.log(np.clip(1 - causes, 1e-7, 1))
    closed_flights = np.column_stack([np.clip(logit, -MAX_ODDS, MAX_ODDS) / 4, np.clip(np.nan_to_num(miss), -8, 8)])
    return ClosedForms(
        weight,
        mean,
        known,
        own,
        {name: own for name, own in odds.items() if name},
        none,
        odds.get("", -MAX_ODDS),
        causes,
        _flights(history, data.values, data.seen, moved),
        closed_flights,
        np.clip(np.nan_to_num([*few, *np.ravel(columns)]), -8, 8),
        float(moved[""][-1, 0]),
    )


def effect_names() -> tuple[str, ...]:
    """The effects that verdicts name, in alphabetical order."""
    return tuple(sorted({spoken(name) for name in effects()}))


def _evidence(trials: Trials, rows: Sequence[int]) -> float:
    """The evidence of a family, compressed. [1]"""
    return float(np.arcsinh(np.logaddexp.reduce(trials.weight[rows]) / 4))


def _causes(linear: LinearFit) -> tuple[Float[Array, "flight cause"], Float[Array, "flight readout"]]:
    """Probabilities of the causes of each flight and of none, and standardized errors of the prediction without it."""
    fit = linear.fit
    known = signatures(replace(fit.model, coarse=True), fit.tangent.at, fit.tangent.values, fit.data.seen)
    for number in range(CAUSE_ROUNDS):
        found = one_offs(fit, known=known)
        if number == CAUSE_ROUNDS - 1:
            break
        data = replace(fit.data, normal=found.weight)
        fit = solve(fit.model, data, fit.tangent)
        fit = solve(fit.model, replace(data, trust=outlier_weights(fit)), fit.tangent)
    return np.column_stack([found.cause, found.normal]), (found.miss / found.sd)[:, :READOUTS]


def _flights(history: History, values: Array, seen: Flags, moved: dict[str, Array]) -> Float[Array, "flight raw"]:
    """Every flight and the plan (last): readouts relative to a simulation at the reference drag, what changes them, the
    conditions, and which flights share a motor, configuration, site or day."""
    flights, count = history.flights, history.flown
    shown, miss = np.zeros((count + 1, READOUTS)), np.zeros((count + 1, READOUTS))
    shown[:count] = seen[:, :READOUTS]
    expected = np.nan_to_num(moved[""][:, :READOUTS])
    miss[:count] = np.where(seen[:, :READOUTS], values[:, :READOUTS] - expected[:count], 0.0)
    miss[:, 5] /= 5.0  # times to ejection are differences in seconds
    along = [np.nan_to_num(moved[kind][:, [0, 1, 4]]) for kind in SENSITIVE]
    shifts = []
    for name, effect in effects().items():
        key = f"{name} 0"
        size = abs(effect.prior.mean) + effect.prior.sd
        shifts.append(np.nan_to_num(moved[key][:, 0] * size) if key in moved else np.zeros(count + 1))
    wind, temperature, elevation, angle = (
        recorded(flights, name) for name in ("wind", "temperature", "site_elevation", "rail_angle")
    )
    kinds = {per: history.groups(per) for per in ("motor", "config", "site", "day")}
    same = [np.array([own == kinds[per][-1] for own in kinds[per]], float) for per in kinds]
    first = [np.array([own == kinds[per][0] for own in kinds[per]], float) for per in ("motor", "config", "site")]
    impulse = np.log([found.motor.total_impulse for found in history.found])
    mass = np.log(recorded(flights, "dry_mass"))
    used = np.r_[np.array(history.used_in_fit[:count], float), 0.0]
    conditions = [
        np.nan_to_num(wind) / 5,
        np.isfinite(wind),
        np.nan_to_num(temperature - 288.0) / 10,
        np.isfinite(temperature),
        np.nan_to_num(elevation) / 1000,
        np.nan_to_num(angle) * 10,
        mass - mass.mean(),
        impulse - impulse.mean(),
        np.isfinite(history.delays),
        np.nan_to_num(np.log(history.delays) - expected[:, 4]),
        np.linspace(0, 1, count + 1),
        np.log1p(np.arange(count + 1)) / 4,
        np.r_[np.zeros(count), 1.0],
        used,
    ]
    every = np.column_stack([shown, 3 * miss, *along, *shifts, *conditions, *same, *first]).astype(float)
    return np.asarray(np.clip(np.nan_to_num(every), -8, 8))


def truth_flags(names: Sequence[str], present: Sequence[str]) -> list[bool]:
    """Whether each effect that verdicts name is present."""
    spoken_names = {spoken(name) for name in present}
    return [name in spoken_names for name in names]
