"""What the flights of a rocket taught, fitted once and flown with any number of plans in one batch.

`fieldkit.loop.predict` fits anew for its plans. Here the fit holds one stand-in for each motor that was flown and
one for all that were not; a plan takes the terms of its stand-in, so that hundreds of plans cost one fit.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from fieldkit.errors import UnknownMotor
from fieldkit.flight import Flight
from fieldkit.loop.candidates import Place
from fieldkit.loop.fit import fit_robustly, own_reading_sd
from fieldkit.loop.model import SCATTER, Model, observe, reference_area, shown
from fieldkit.loop.predict import forecast_model, model_name, sample
from fieldkit.motors import Found
from fieldkit.shapes import Array, Float

DRAWS = 150
"""Flights flown for each plan of many. [1]"""


@dataclass(frozen=True, slots=True)
class Learnt:
    """The posterior of a rocket, as draws, and the stand-in whose terms each motor takes over.

    `lean` is how much the log of the apogee changes with scatter in tilt, per stand-in. `plan` is the flight
    that plans start from; `rests_on` counts the flights that taught the model.
    """

    plan: Flight
    model: Model
    stand_in: dict[int, int]
    values: Float[Array, "draw term"]
    scales: Float[Array, "draw 2"]
    lean: Float[Array, "flight"]
    rests_on: int
    name: str
    seed: int


@dataclass(frozen=True, slots=True)
class Outcomes:
    """Plans as they may fly: `figures` are the readouts and more, [draw plan] in SI, nan for none.

    `apogee` is what the altimeter shows, `true` the height itself, each reading with its error in `apogee`.
    """

    plans: tuple[Flight, ...]
    found: tuple[Found, ...]
    figures: dict[str, Float[Array, "draw plan"]]

    def of(self, name: str) -> Float[Array, "draw plan"]:
        """One figure of all plans."""
        return self.figures[name]

    def quantiles(self, name: str, levels: Sequence[float] = (0.05, 0.5, 0.95)) -> Float[Array, "level plan"]:
        """Quantiles of a figure over the draws that have it; nan where none has. [SI]"""
        values = self.figures[name]
        known = np.isfinite(values).any(axis=0)
        out = np.full((len(levels), values.shape[1]), np.nan)
        if known.any():
            out[:, known] = np.nanquantile(values[:, known], levels, axis=0)
        return out


def learn(
    flown: Sequence[tuple[Flight, Found]],
    plan: Flight,
    stranger: Found,
    accepted: Sequence[Place] = (),
    *,
    draws: int = DRAWS,
    seed: int = 0,
) -> Learnt:
    """Fit a rocket's flights once, for plans that start from `plan`.

    `stranger` is any motor; where the rocket has not flown it, it stands in for all that were not flown. Raises
    ImpossibleFlight for a plan without a dry mass, UnknownMotor where every motor given was flown.
    """
    motors = {id(item.motor): item for _, item in flown}
    if id(stranger.motor) in motors:
        raise UnknownMotor("found a motor that was flown, expected one that stands for those that were not")
    representatives = [*motors.values(), stranger]
    flights = [flight for flight, _ in flown] + [plan] * len(representatives)
    found = [item for _, item in flown] + representatives
    teach = [flight.clean for flight, _ in flown] + [False] * len(representatives)
    model = forecast_model(flights, found, accepted)
    fit = fit_robustly(model, observe(flights, teach))
    values, scales = sample(fit, draws, np.random.default_rng(seed))
    ahead = slice(len(flown), None)
    return Learnt(
        plan=plan,
        model=model.part(ahead),
        stand_in={key: row for row, key in enumerate(motors)},
        values=values,
        scales=scales,
        lean=fit.tangent.scatter_slope[ahead, 0, -1],
        rests_on=int(np.sum(np.asarray(teach) & fit.data.seen.any(axis=1))),
        name=model_name(accepted),
        seed=seed,
    )


def outcomes(learnt: Learnt, plans: Sequence[Flight], found: Sequence[Found]) -> Outcomes:
    """Fly plans, all in one batch and on the same draws, so that plans differ by what is planned alone."""
    rows = [learnt.stand_in.get(id(item.motor), len(learnt.stand_in)) for item in found]
    terms = tuple(replace(term, weight=term.weight[rows]) for term in learnt.model.terms)
    area = learnt.model.area[rows]
    if any(plan.diameter is not None and plan.diameter != learnt.plan.diameter for plan in plans):
        area = reference_area(plans)
    model = Model(tuple(plans), tuple(found), area, terms)
    rng = np.random.default_rng([learnt.seed, 1])
    draws = len(learnt.values)
    same = np.ones(len(plans))
    scatter: dict[str, Any] = {
        kind.bends: rng.normal(size=(draws, 1)) * kind.sd * learnt.scales[:, :1] * same
        for kind in SCATTER
        if kind.bends != "tilt"
    }
    figures = dict(shown(model, learnt.values, scatter))
    lean = learnt.lean[rows] * rng.normal(size=(draws, 1)) * learnt.scales[:, :1]
    apogee = figures["apogee"] * np.exp(lean)
    error = own_reading_sd(apogee) * learnt.scales[:, 1:] * rng.normal(size=(draws, 1))
    error = np.clip(error, -1.0, 1.0)  # of a hop of a metre the error in ratio knows no bounds
    figures["apogee"] = np.nan_to_num(apogee * np.exp(error))
    figures["true"] = figures["true"] * np.exp(lean)
    return Outcomes(tuple(plans), tuple(found), figures)
