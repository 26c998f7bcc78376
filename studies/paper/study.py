"""The reference study: the parts of the published bias, and the errors that remain without it."""

from dataclasses import dataclass
from typing import Any

import numpy as np

from fieldkit.flight import Flight
from fieldkit.model.readout_data import observe
from fieldkit.motors import catalogue
from fieldkit.physics.flight import apogees, fly
from fieldkit.physics.history import history_of
from fieldkit.reference.flights import Reference, reference
from fieldkit.reference.report import PaperReport, report
from fieldkit.scoring.bootstrap import LEVELS, Interval, Judged, judge, resampled
from fieldkit.selection.diagnose import Diagnosis, diagnose
from fieldkit.selection.extended_model import rocket_model
from fieldkit.shapes import Array, Float
from studies.paper.assumption_steps import AssumptionStep, step, worlds
from studies.paper.two_flights import TwoFlights, two_flights


@dataclass(frozen=True, slots=True)
class BiasPart:
    """A part of the published bias, its name and the mean over the eight flights. [m]"""

    title: str
    bias: float


@dataclass(frozen=True, slots=True)
class Ejection:
    """Time from apogee to ejection with the delay in the motor's name [s], the loss of apogee by it and by a short
    delay. [m]"""

    after_apogee: float
    cost: float
    cost_short: float


SHORT_DELAY = 0.2
"""Fraction by which a certified delay may be short (NFPA 1125). [1]"""


@dataclass(frozen=True, slots=True)
class Study:
    """Everything on the page: the paper's report, the steps from its physics to fieldkit's, the parts of the bias, and
    the rest."""

    report: PaperReport
    flights: Reference
    steps: tuple[AssumptionStep, ...]
    parts: tuple[BiasPart, ...]
    lowered: tuple[float, ...]
    """Mean reduction by each step of the apogees at the published Cd and alpha. [m]"""
    ejection: Ejection
    loop: Diagnosis
    left_out: Judged
    left_out_after: Judged
    pair: TwoFlights


def study() -> Study:
    """Compute the study from the twelve flights and the published results."""
    every = reference()
    valid = every.part(every.valid)
    loop = _loop(every.flights)
    steps = tuple(step(world, valid) for world in worlds())
    flown = [one.world.heights(valid, valid.published_cd, valid.published_alpha).mean() for one in steps]
    return Study(
        report(),
        valid,
        steps,
        parts_of(valid, steps),
        tuple(float(before - after) for before, after in zip(flown[:1] + flown[:-1], flown, strict=True)),
        _ejection(valid),
        loop,
        judge(loop.forecasts_before, loop.data.values[:, 0], loop.data.seen[:, 0]),
        judge(loop.forecasts_after, loop.data.values[:, 0], loop.data.seen[:, 0]),
        two_flights(every),
    )


def parts_of(flights: Reference, steps: tuple[AssumptionStep, ...]) -> tuple[BiasPart, ...]:
    """Parts that add up to the published bias: the network's, one for each step of the physics, and the rest."""
    bias = [float((one.rebuilt - flights.apogee).mean()) for one in steps]
    published = float((flights.published_apogee - flights.apogee).mean())
    moved = [
        BiasPart(after.world.title, before_bias - after_bias)
        for before_bias, after_bias, after in zip(bias, bias[1:], steps[1:], strict=False)
    ]
    network = BiasPart("the published network in place of the exact posterior", published - bias[0])
    return (*moved, BiasPart("shrinkage toward the prior, left in the exact posterior", bias[-1]), network)


def _loop(flights: tuple[Flight, ...]) -> Diagnosis:
    """The verdict of `fieldkit loop` on these flights."""
    found = [catalogue().resolve(flight.motor) for flight in flights]
    history = history_of(flights, found)
    return diagnose(rocket_model(history), observe(history))


def _ejection(flights: Reference) -> Ejection:
    """The flights on the F24-4W at the published Cd and alpha, with certified thrust and the casing's mass."""
    rows = flights.part(np.array([flight.motor.startswith("F24") for flight in flights.flights]))
    world = next(one for one in worlds() if one.key == "ejection")
    setup = world.build(rows, rows.published_cd, rows.published_alpha)
    free = apogees(setup.with_changes(delay=np.full(len(rows), np.nan)))

    def cost(delay: float) -> float:
        return float((free - apogees(setup.with_changes(delay=delay * setup.delay))).mean())

    return Ejection(float(fly(setup).apogee_to_eject.mean()), cost(1.0), cost(1.0 - SHORT_DELAY))


def interval(misses: Float[Array, "flight"], absolute: bool = False) -> Interval:
    """The 90% bootstrap interval of a mean error. [m]"""
    values: Any = np.abs(misses) if absolute else misses
    low, high = np.quantile(values[resampled(len(misses))].mean(axis=1), LEVELS)
    return float(low), float(high)
