"""Forces along the logged flights of a rocket: thrust and drag beside the model's, and drag that switches.

Drag comes from `fieldkit.analysis.force_profile`, thrust from Newton's second law: the measured thrust less drag over
mass, plus the drag of the rocket at the measured speed, over the certified thrust over mass of that moment.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from fieldkit.analysis import Forces, Recorded
from fieldkit.analysis.force_profile import DragProfile, drag_profile
from fieldkit.flight import Flight, Series
from fieldkit.model.readout_data import OBSERVED_READOUTS, Data
from fieldkit.model.rocket_model import Model
from fieldkit.motors import Motor
from fieldkit.physics.atmosphere import pad_air
from fieldkit.physics.setups import RAIL_LENGTH, recorded
from fieldkit.selection.candidates import Candidate, Place, Switched, effect_terms
from fieldkit.selection.climb import RocketInputs, beside_model, track_of
from fieldkit.selection.coast_check import CoastCheck, coast_check
from fieldkit.selection.drag_steps import DragSteps, FlightDrag, LoggedDrag, drag_steps
from fieldkit.selection.prior import log_prior_odds
from fieldkit.shapes import Array, Float

DRAG_STEP = "drag_step"
"""Name of the effect of drag that switches in the coast."""
_THRUST_POINTS = 12
"""Number of points along a burn. [1]"""
_LARGEST_THRUST_SD = 0.5
"""Largest standard deviation of a ratio of thrusts that is shown. [1]"""
_LEAST_THRUST = 0.3
"""Least certified thrust, as a fraction of its mean, beside which measured thrust is shown. [1]"""
_GAIN_SD, _DRAG_SD = 0.02, 0.1
"""Relative errors of an accelerometer's gain and of the drag during a burn. [1]"""
_BEFORE_BURN, _AFTER_BURN = 0.05, 0.1
"""Time after lift-off and before the end of the certified thrust that is left out: rail and fading thrust. [s]"""
NO_DRAG = "its log does not show the drag of the coast"
_LEAST_EXPOSURE = 0.02
"""Fraction of a coast below which a step has no effect on the readouts. [1]"""


@dataclass(frozen=True, slots=True, eq=False)
class FlightLog:
    """What the log of a flight shows: forces in the climb, the standard deviation of its lift-off [s], and drag along
    its coast; None for what it does not show."""

    forces: Forces | None
    liftoff_sd: float | None
    drag: DragProfile | None


def flight_log(clocks: Sequence[Series], recorded: Recorded) -> FlightLog:
    """What samples that were measured as `recorded` show."""
    lift = recorded.events.get("liftoff")
    return FlightLog(recorded.forces, None if lift is None else lift.sd, drag_profile(clocks, recorded))


@dataclass(frozen=True, slots=True, eq=False)
class ThrustProfile:
    """Measured over certified thrust along a burn, with standard deviations. Times are from lift-off [s]."""

    time_from_liftoff: Float[Array, "point"]
    ratio: Float[Array, "point"]
    sd: Float[Array, "point"]


@dataclass(frozen=True, slots=True, eq=False)
class LoggedForces:
    """Thrust and drag along the logged flights by flight id, and what they show of drag that switches."""

    drag: Mapping[str, FlightDrag]
    thrust: Mapping[str, ThrustProfile]
    steps: DragSteps | None
    silent: Mapping[str, str]
    """Flights whose logs do not show drag, and why."""
    logs: tuple[LoggedDrag, ...] = ()
    """The drag that the logs show, of which `steps` is the interpretation."""


def logged_forces(model: Model, logs: Mapping[str, FlightLog | str]) -> LoggedForces:
    """The forces along the logs of a model's flights, by flight id; instead of a log the reason that it cannot be
    read."""
    shown, setups, silent = [], {}, {}
    for flight, found in zip(model.flights, model.found, strict=True):
        log = logs.get(flight.flight_id)
        if log is None or flight.dry_mass is None:
            continue
        if isinstance(log, str) or log.drag is None:
            silent[flight.flight_id] = log if isinstance(log, str) else NO_DRAG
            continue
        rocket = rocket_of(flight, found.motor, 0.0)
        mass = flight.dry_mass + found.motor.casing_mass
        unit = 2 * mass * log.drag.reference / float(rocket.air.density)
        shown.append(LoggedDrag(flight.flight_id, log.drag, unit, model.hyperprior.sd("drag", "flight")))
        setups[flight.flight_id] = rocket, log
    steps = drag_steps(shown, log_prior_odds([DRAG_STEP]))
    if steps is None:
        return LoggedForces({}, {}, None, silent)
    thrust = {
        name: profile
        for name, (rocket, log) in setups.items()
        if (profile := thrust_profile(log, replace(rocket, drag_area=steps.own))) is not None
    }
    return LoggedForces({one.flight_id: one for one in steps.flights}, thrust, steps, silent, tuple(shown))


def rocket_of(flight: Flight, motor: Motor, drag_area: float) -> RocketInputs:
    """The model of a flight: certified motor, weighed mass, the air of the day; area [m^2]."""
    conditions = ("site_elevation", "temperature", "pressure", "humidity")
    air = pad_air(*(np.asarray(recorded([flight], name)[0]) for name in conditions))
    assert flight.dry_mass is not None
    rail = RAIL_LENGTH if flight.rail_length is None else flight.rail_length
    return RocketInputs(motor, flight.dry_mass, drag_area, air, rail)


def thrust_profile(log: FlightLog, rocket: RocketInputs) -> ThrustProfile | None:
    """Thrust along a burn relative to the certified curve; None if the log does not resolve it.

    An uncertain time of lift-off moves the curve: its slope times that is part of the error.
    """
    if log.forces is None or log.liftoff_sd is None:
        return None
    beside = beside_model(track_of(log.forces), rocket)
    track, motor = beside.track, rocket.motor
    full = rocket.dry_mass + motor.casing_mass + motor.propellant_mass
    least = _LEAST_THRUST * motor.total_impulse / motor.thrust_end / full
    last = motor.thrust_end - _AFTER_BURN
    used = (beside.thrust > least) & (track.time_from_liftoff > _BEFORE_BURN) & (track.time_from_liftoff < last)
    rows = np.flatnonzero(used)
    if rows.size < _THRUST_POINTS:
        return None
    points = []
    for part in np.array_split(rows, _THRUST_POINTS):
        thrust, drag = beside.thrust[part].mean(), beside.drag[part].mean()
        net = track.push[part].mean()
        late = log.liftoff_sd * np.abs(beside.steepness[part]).mean()
        sd = np.linalg.norm([track.push_sd[part].mean(), _GAIN_SD * net, _DRAG_SD * drag, late])
        points.append((track.time_from_liftoff[part].mean(), (net + drag) / thrust, sd / thrust))
    kept = [point for point in points if point[2] < _LARGEST_THRUST_SD]
    return ThrustProfile(*np.array(kept).T) if len(kept) > 2 else None


def forces_check(forces: LoggedForces | None, probability: float) -> CoastCheck | None:
    """Whether the drag of the logged coasts is that of the model, if it switches with this probability [1]; None
    without such logs."""
    if forces is None or forces.steps is None:
        return None
    return coast_check(forces.logs, forces.steps, min(probability, forces.steps.present))


def step_candidate(model: Model, forces: LoggedForces | None) -> tuple[Candidate, ...]:
    """Drag that switches in the coast as a candidate for the model of a rocket, with the evidence of the logs' coasts
    as part of its prior; empty if no log shows it.

    That evidence contains the drag of each coast, so the readouts must not (`without_coast_drag`).
    """
    steps = forces.steps if forces is not None else None
    if steps is None or not any(one.steps and one.member > 0.5 for one in steps.flights):
        return ()
    size = max(abs(steps.size), 1e-9) * np.sign(steps.size)
    members = {one.flight_id: (one.mean - 1) / size for one in steps.flights if one.member > 0.5}
    members = {name: amount for name, amount in members.items() if abs(amount) > _LEAST_EXPOSURE}
    if not members:
        return ()
    amounts = tuple((flight.flight_id, float(members.get(flight.flight_id, 0.0))) for flight in model.flights)
    usual = float(np.mean(list(members.values())))
    place = Place(DRAG_STEP, switched=Switched(amounts, usual, steps.fraction))
    strength, *others = effect_terms(place, model)
    shown = replace(strength, mean=steps.size, sd=steps.size_sd)
    return (Candidate(place, (shown, *others), (steps.size,), steps.log_bayes),)


def with_probability(forces: LoggedForces, probability: float) -> LoggedForces:
    """The forces with drag that switches at most as probable as the whole evidence, readouts included, makes it [1].

    By the law of total probability a flight's step then is more probably one of its own.
    """
    if forces.steps is None or probability >= forces.steps.present:
        return forces
    return replace(forces, drag={name: _with_probability(one, probability) for name, one in forces.drag.items()})


def _with_probability(one: FlightDrag, probability: float) -> FlightDrag:
    """A flight of a rocket on which drag switches with this probability. [1]"""
    member = probability * one.shared + (1 - probability) * one.lone
    factor = member / max(one.member, 1e-9)
    steps = tuple(replace(step, probability=factor * step.probability) for step in one.steps)
    return replace(one, member=member, steps=steps)


def without_coast_drag(data: Data, model: Model, forces: LoggedForces) -> Data:
    """Readouts without the drag of the coasts that logs show in detail."""
    logged = np.array([flight.flight_id in forces.drag for flight in model.flights])
    seen = data.seen.copy()
    seen[logged, OBSERVED_READOUTS.index("coast_drag")] = False
    return replace(data, seen=seen)
