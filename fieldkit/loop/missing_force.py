"""The missing force: measured less modelled acceleration along the climb, and which physical terms it is made of.

Nothing is integrated. At every sample the model's thrust and drag are computed from the measured speed and height, so
that what is left belongs to that moment: thrust, drag in either phase, the rail, the sensor. Terms are added one by
one while the extended Bayesian information criterion falls (Chen and Chen, Biometrika 95, 2008), which pays for every
term that could have been added. Samples that a smoother has tied together count as what they are worth.
"""

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from math import lgamma
from typing import Protocol, runtime_checkable

import numpy as np

from fieldkit.motors.motor import Motor
from fieldkit.shapes import Array, Flags, Float
from fieldkit.simulator.atmosphere import Air
from fieldkit.simulator.effect import effects
from fieldkit.simulator.state import State


@dataclass(frozen=True, slots=True, eq=False)
class Track:
    """A measured climb, straight up, on one clock in SI units.

    `push` is thrust less drag over mass, as an axial accelerometer feels it, with its standard deviation; heights are
    above the pad. `burning` is true up to burnout.
    """

    time_from_liftoff: Float[Array, "time"]
    height: Float[Array, "time"]
    speed: Float[Array, "time"]
    push: Float[Array, "time"]
    push_sd: Float[Array, "time"]
    burning: Flags


@runtime_checkable
class Measured(Protocol):
    """What is taken of forces measured in a log, whoever measured them; as in `Track`."""

    @property
    def time_from_liftoff(self) -> Float[Array, "time"]: ...
    @property
    def height(self) -> Float[Array, "time"]: ...
    @property
    def speed(self) -> Float[Array, "time"]: ...
    @property
    def push(self) -> Float[Array, "time"]: ...
    @property
    def push_sd(self) -> Float[Array, "time"]: ...
    @property
    def burning(self) -> Flags: ...


def track_of(measured: Measured) -> Track:
    """The climb of which forces were measured."""
    return Track(*(getattr(measured, name) for name in Track.__dataclass_fields__))


@dataclass(frozen=True, slots=True, eq=False)
class Rocket:
    """What the model flies: motor, mass without it [kg], Cd times area [m^2], the air, the rail [m]."""

    motor: Motor
    dry_mass: float
    drag_area: float
    air: Air
    rail_length: float = 1.0
    thrust_factor: float = 1.0


@dataclass(frozen=True, slots=True, eq=False)
class Missing:
    """The missing force per mass along the climb [m/s^2], and the model's own thrust and drag per mass there."""

    track: Track
    rocket: Rocket
    force: Float[Array, "time"]
    thrust: Float[Array, "time"]
    steepness: Float[Array, "time"]
    """Rate of change of thrust per mass. [m/s^3]"""
    drag: Float[Array, "time"]


@dataclass(frozen=True, slots=True)
class Term:
    """One physical term of the library: what it is, the effect it stands for (empty for none), and its unit."""

    name: str
    effect: str
    unit: str
    column: Callable[[Missing], Float[Array, "time"]]


@dataclass(frozen=True, slots=True)
class Found:
    """A term that is there, with its coefficient; `gain` is what it takes off the criterion. `also` are terms that
    would have done nearly as well in its place."""

    term: Term
    value: float
    sd: float
    gain: float
    also: tuple[str, ...]


@dataclass(frozen=True, slots=True)
class Law:
    """What the missing force is made of, the most telling term first; empty where nothing is missing.

    `explained` is the share of its variance, `left` what remains [m/s^2], `worth` the number of samples that
    the record is worth.
    """

    terms: tuple[Found, ...]
    explained: float
    left: float
    worth: float

    @property
    def effects(self) -> tuple[str, ...]:
        """Names of the effects that it asks for."""
        return tuple(found.term.effect for found in self.terms if found.term.effect)


SHIFTS = tuple(sorted(np.linspace(-0.15, 0.15, 13).tolist(), key=abs))
"""Of the clock that are tried, the smallest first. [s]"""
MOST = 4
"""Terms at most."""
NEARLY = 4.0
"""Of the criterion, within which another term is named beside the chosen one."""
STRICT = 1.0
"""Weight of the number of candidates in the extended criterion."""
SLOWEST = 5.0
"""Below this speed a climb is over and its direction unknown. [m/s]"""


def missing_force(track: Track, rocket: Rocket, guard: float = 0.0) -> Missing:
    """Measured less modelled push at every sample that flies upward, the clock set by the thrust curve.

    Samples within `guard` [s] of burnout are left out: where acceleration was made from heights, smoothing has
    mixed thrust and drag there.
    """
    time = track.time_from_liftoff
    burnout = float(time[track.burning].max(initial=-np.inf))
    flown = (track.speed > SLOWEST) & (np.abs(time - burnout) >= guard)
    track = Track(*(getattr(track, name)[flown] for name in Track.__dataclass_fields__))
    return beside_model(_on_time(track, rocket), rocket)


def _on_time(track: Track, rocket: Rocket) -> Track:
    """The same with its clock shifted to where thrust rises and ends: a lift-off is detected late or early."""

    def left(shift: float) -> float:
        missing = beside_model(replace(track, time_from_liftoff=track.time_from_liftoff + shift), rocket)
        columns = [term.column(missing) / track.push_sd for term in library(missing)]
        rest = _residual(missing.force / track.push_sd, columns)
        return float(rest @ rest)

    if track.burning.sum() < 4:
        return track
    return replace(track, time_from_liftoff=track.time_from_liftoff + min(SHIFTS, key=left))


def beside_model(track: Track, rocket: Rocket) -> Missing:
    """Every sample beside the model's thrust and drag there."""
    thrust, steepness, mass = _thrust(track.time_from_liftoff, rocket)
    density = rocket.air.density * rocket.air.thinning(track.height)
    drag = 0.5 * density * rocket.drag_area * track.speed * np.abs(track.speed) / mass
    return Missing(track, rocket, track.push - thrust + drag, thrust, steepness, drag)


def _thrust(
    time: Float[Array, "time"], rocket: Rocket
) -> tuple[Float[Array, "time"], Float[Array, "time"], Float[Array, "time"]]:
    """Thrust per mass [m/s^2], its rate of change [m/s^3] and mass [kg] at times from lift-off."""
    motor, factor = rocket.motor, rocket.thrust_factor
    full = rocket.dry_mass + motor.casing_mass + motor.propellant_mass
    knots = np.linspace(0.0, motor.thrust_end, 2000)
    curve = factor * np.interp(knots, motor.time, motor.thrust)
    lift_off = knots[int(np.argmax(curve > full * 9.80665))]
    spent = np.concatenate([[0.0], np.cumsum((curve[1:] + curve[:-1]) / 2)])
    mass = full - motor.propellant_mass * np.interp(time + lift_off, knots, spent / spent[-1])
    slope = np.gradient(curve, knots)
    push, steep = (np.interp(time + lift_off, knots, values, right=0.0) for values in (curve, slope))
    return push / mass, steep / mass, mass


def library(missing: Missing) -> list[Term]:
    """Terms that a climb of this kind could show: those of the shelf that act as a force, and those below."""
    fixed = [
        Term("drag", "", "share of Cd", lambda m: -m.drag),
        Term("thrust", "motor_thrust", "share of the thrust", lambda m: m.thrust),
        Term(
            "longer burn",
            "thrust_curve",
            "share of the burn time",
            lambda m: -(m.thrust + m.track.time_from_liftoff * m.steepness),
        ),
        Term("rail", "rail_friction", "m/s^2", lambda m: np.where(m.track.height < m.rocket.rail_length, -1.0, 0.0)),
        Term("constant", "", "m/s^2", lambda m: np.ones(len(m.force))),
        Term("linear in speed", "", "1/s", lambda m: -m.track.speed),
        Term("gain of the accelerometer", "", "share of the push", lambda m: m.thrust - m.drag),
    ]
    return [*fixed, *_forces(missing)]


def _forces(missing: Missing) -> Iterator[Term]:
    """Effects of the shelf that bend the acceleration, at a strength of one."""
    for name, effect in effects().items():
        if effect.acceleration is None:
            continue

        def column(at: Missing, name: str = name) -> Float[Array, "time"]:
            force, track = effects()[name].acceleration, at.track
            assert force is not None
            one = np.ones(len(at.force))
            phases = [
                force(State(track.height, track.speed, at.drag, burning, at.rocket.air), one)
                for burning in (True, False)
            ]
            return np.where(track.burning, *phases)

        yield Term(effect.title, name, effect.unit, column)


def law(missing: Missing, terms: Sequence[Term] | None = None) -> Law:
    """The fewest terms that the missing force is made of.

    What is left of a shift of the clock is taken out beforehand where the motor burns.
    """
    terms = library(missing) if terms is None else terms
    columns = {term.name: term.column(missing) / missing.track.push_sd for term in terms}
    wanted = missing.force / missing.track.push_sd
    clock = [missing.steepness / missing.track.push_sd] if missing.track.burning.sum() > 3 else []
    columns = {name: column for name, column in columns.items() if np.linalg.norm(column) > 1e-9}
    worth = _worth(wanted, [*clock, *columns.values()])
    chosen: list[str] = []
    also: list[tuple[str, ...]] = []
    gains: list[float] = []
    score = _criterion(wanted, clock, 0, len(columns), worth)
    while len(chosen) < min(MOST, len(columns)):
        basis = [*clock, *(columns[name] for name in chosen)]
        trial = {
            name: _criterion(wanted, [*basis, column], len(chosen) + 1, len(columns), worth)
            for name, column in columns.items()
            if name not in chosen
        }
        best = min(trial, key=lambda name: trial[name])
        if trial[best] >= score:
            break
        also.append(tuple(name for name in trial if name != best and trial[name] < min(trial[best] + NEARLY, score)))
        gains.append(score - trial[best])
        chosen.append(best)
        score = trial[best]
    return _told(missing, wanted, clock, columns, {t.name: t for t in terms}, chosen, gains, also, worth)


def _told(
    missing: Missing,
    wanted: Array,
    clock: Sequence[Array],
    columns: Mapping[str, Array],
    terms: Mapping[str, Term],
    chosen: Sequence[str],
    gains: Sequence[float],
    also: Sequence[tuple[str, ...]],
    worth: float,
) -> Law:
    basis = np.stack([*clock, *(columns[name] for name in chosen)], axis=-1) if clock or chosen else None
    left = wanted
    found: list[Found] = []
    if basis is not None:
        value, *_ = np.linalg.lstsq(basis, wanted, rcond=None)
        left = wanted - basis @ value
        scatter = float(left @ left) / max(worth - basis.shape[1], 1.0)
        sd = np.sqrt(np.diag(np.linalg.pinv(basis.T @ basis)) * scatter)
        skip = len(clock)
        found = [
            Found(terms[name], float(value[skip + i]), float(sd[skip + i]), gains[i], also[i])
            for i, name in enumerate(chosen)
        ]
    total = float(wanted @ wanted)
    residual = left * missing.track.push_sd
    return Law(tuple(found), 1 - float(left @ left) / total, float(np.sqrt((residual**2).mean())), worth)


def _criterion(wanted: Array, basis: Sequence[Array], terms: int, candidates: int, worth: float) -> float:
    """The extended Bayesian information criterion of a least-squares fit; less is better."""
    left = _residual(wanted, basis)
    ways = lgamma(candidates + 1) - lgamma(terms + 1) - lgamma(candidates - terms + 1)
    return worth * float(np.log(left @ left)) + terms * float(np.log(worth)) + 2 * STRICT * ways


def _residual(wanted: Array, basis: Sequence[Array]) -> Array:
    if not len(basis):
        return wanted
    stacked = np.stack(basis, axis=-1)
    value, *_ = np.linalg.lstsq(stacked, wanted, rcond=None)
    return np.asarray(wanted - stacked @ value)


def _worth(wanted: Array, basis: Sequence[Array]) -> float:
    """How many independent samples the record is worth, by how alike neighbours are that no term explains.

    Sum of the autocorrelation of the full library's residual up to its first zero (Sokal's integrated time).
    """
    left = _residual(wanted, basis)
    left = left - left.mean()
    power = np.correlate(left, left, "full")[len(left) - 1 :]
    if power[0] <= 0:
        return float(len(wanted))
    alike = power / power[0]
    zero = np.flatnonzero(alike <= 0.05)
    upto = int(zero[0]) if len(zero) else len(alike)
    return max(float(len(wanted) / (1 + 2 * alike[1:upto].sum())), len(basis) + 2.0)
