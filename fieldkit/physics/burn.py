"""The burn: Newton's second law by the classical Runge-Kutta method (Kutta, 1901), in steps along the thrust curve."""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from fieldkit.physics.forces import EquationsOfMotion, length_of
from fieldkit.physics.state import Setup
from fieldkit.shapes import Array, Float, Integers

MAX_DRAG_FRACTION = 0.5
"""Largest fraction by which drag may change the speed in a step. [1]"""

SHORT_PATH = 1.0
"""Longest path of a step while a rocket turns into the wind. [m]"""
BIGGEST_GAIN = 0.4
"""Largest fraction by which thrust may change the speed of a planar flight off the rail in a step. [1]"""
MOST_PARTS = 64
"""Largest number of substeps per step. [1]"""

PARALLEL_DRAWS = 0.75
"""Minimum fraction of the draws that need another substep for it to be computed for all draws. [1]"""
WHOLE_SUBSTEP_DRAWS = 500
"""Up to this number of draws, a substep of all takes less time than the selection of those that need it. [1]"""

NEWTON = 8
"""Iterations of Newton's method for the time at which the rail ends. [1]"""

Stages = list[Array]
"""A quantity at the start, middle and end of a step."""


@dataclass(frozen=True, slots=True)
class BurnStep:
    """A step along the thrust curve: its length [s], and the thrust [N] and the mass [kg] in it."""

    dt: Array
    thrust: Stages
    mass: Stages

    @property
    def greatest(self) -> Array:
        """Thrust over mass, at most; an entry per draw. [m/s^2]"""
        return np.asarray(np.maximum(self.thrust[0], self.thrust[2]) / self.mass[2])

    def between(self, start: Array, end: Array) -> "BurnStep":
        """A part of the step, by fractions of it with an entry per draw. [1]"""
        return BurnStep(self.dt * (end - start), _between(self.thrust, start, end), _between(self.mass, start, end))

    def of(self, rows: Integers) -> "BurnStep":
        """The step of some draws."""
        thrust, mass = ([_some(stage, rows) for stage in stages] for stages in (self.thrust, self.mass))
        return BurnStep(_some(self.dt, rows), thrust, mass)


@dataclass(slots=True)
class AscentState:
    """State of all draws at one time of the ascent, with the extremes so far. SI units.

    `position` and `velocity` are [axis draw]: upward and, in a planar flight, downwind. `time` is counted from
    ignition, `flying` from lift-off.
    """

    time: Array
    flying: Array
    position: Array
    velocity: Array
    top_speed: Array
    top_speed_time: Array
    peak_accel: Array
    rail_speed: Array
    highest: Array
    highest_time: Array


def _highlight(track: AscentState, dt: Array, before: tuple[Array, Array], after: tuple[Array, Array]) -> None:
    """Update top speed and its time from the cubic through the speed and its slope at both ends of a step."""
    (speed0, slope0), (speed1, slope1) = before, after
    turns = (slope0 > 0) & (slope1 <= 0) & (dt > 0)
    ends_higher = speed1 > track.top_speed
    track.top_speed_time = np.where(ends_higher, track.time, track.top_speed_time)
    track.top_speed = np.where(ends_higher, speed1, track.top_speed)
    if not turns.any():
        return
    rise, lift0, lift1 = speed1 - speed0, slope0 * dt, slope1 * dt
    cubic, square = lift0 + lift1 - 2 * rise, 3 * rise - 2 * lift0 - lift1
    root = np.sqrt(np.maximum(square**2 - 3 * cubic * lift0, 0.0))
    place = np.clip(lift0 / np.where(turns, root - square, 1.0), 0.0, 1.0)
    peak = speed0 + place * (lift0 + place * (square + place * cubic))
    higher = turns & (peak > track.top_speed)
    track.top_speed_time = np.where(higher, track.time - (1 - place) * dt, track.top_speed_time)
    track.top_speed = np.where(higher, peak, track.top_speed)


def _speed(velocity: Array) -> Array:
    return np.asarray(np.abs(velocity[0]) if len(velocity) == 1 else length_of(velocity))


def _along(velocity: Array, rate: Array) -> Array:
    """Rate of change of speed. [m/s^2]"""
    if len(velocity) == 1:
        return np.asarray(rate[0])
    return np.asarray((velocity * rate).sum(axis=0) / np.maximum(_speed(velocity), 1e-9))


def burn(setup: Setup, *, highlights: bool = True) -> AscentState:
    """The ascent from lift-off to burnout; all entries of the setup are flat, [draw] or [1].

    Without `highlights`, top speed, peak acceleration and rail exit speed are not computed.
    """
    rate = EquationsOfMotion(setup, burning=True)
    zero = np.zeros(setup.draws)
    start = zero + (lift_off_time(setup) if setup.pad_holds else 0.0)
    latest = start[np.isfinite(start)].max(initial=0.0)
    at_rest = np.zeros((rate.axes, setup.draws))
    track = AscentState(start, zero, at_rest, at_rest, zero, start, zero, zero, zero, start)
    slope, end = zero, np.ones(1)
    first_rate: Array | None = None
    for number, (first, step) in enumerate(_steps(setup)):
        held = _with_stages(setup, number)
        if held is not setup:
            rate, first_rate = EquationsOfMotion(held, burning=True), None
        if waits := bool(first.min() < latest):
            place = np.clip((start - first) / np.where(step.dt > 0, step.dt, 1.0), 0.0, 1.0)
            step = step.between(place, end)
        before, dt = (track.position, track.velocity), step.dt
        _advance(track, held, rate, step, first_rate)
        if highlights:
            _leave_rail(track, setup, dt, *before)
            slope_before = slope
            ended = rate(track.position, track.velocity, step.thrust[2], step.mass[2])
            slope, first_rate = (
                _along(track.velocity, ended),
                None if waits else ended,
            )  # the next step starts where this one ends
            track.peak_accel = np.maximum(track.peak_accel, np.where(dt > 0, slope, 0))
            _highlight(track, dt, (_speed(before[1]), slope_before), (_speed(track.velocity), slope))
    return track


def _with_stages(setup: Setup, step: int) -> Setup:
    """The setup with the drag of the stages still attached in a step."""
    drag = setup.burns.drag
    return setup if drag is None else setup.with_changes(drag_area=setup.drag_area * drag[step][setup.motor])


def _steps(setup: Setup) -> Iterator[tuple[Array, BurnStep]]:
    """Every step with its start [s]; it starts where the last one ended."""
    burns, motor = setup.burns, setup.motor
    empty, propellant = setup.dry_mass + burns.casing_mass[motor], burns.propellant_mass[motor]
    factor = setup.thrust_factor / setup.burn_stretch

    def push(step: int, stage: int) -> Array:
        return np.asarray(burns.thrust[step, stage][motor] * factor)

    def mass(step: int, stage: int) -> Array:
        return np.asarray(empty + propellant * (1 - burns.spent[step, stage][motor]))

    first, push_end, mass_end = burns.edge[0][motor] * setup.burn_stretch, push(0, 0), mass(0, 0)
    for step in range(len(burns.edge) - 1):
        last = burns.edge[step + 1][motor] * setup.burn_stretch
        if not (last > first).any():
            return
        pushes, masses = [push_end, push(step, 1), push(step, 2)], [mass_end, mass(step, 1), mass(step, 2)]
        yield first, BurnStep(last - first, pushes, masses)
        first, push_end, mass_end = last, pushes[2], masses[2]


def _between(values: Stages, start: Array, end: Array) -> Stages:
    """Start, middle and end values of a substep, for a quantity that is quadratic over the step; times in [0, 1]."""
    if len(start) == 1 and start[0] == 0 and end[0] == 1:
        return values
    at_start, at_middle, at_end = values
    linear, square = 4 * at_middle - 3 * at_start - at_end, 2 * (at_start + at_end) - 4 * at_middle
    places = (start, 0.5 * (start + end), end)
    return [np.asarray(at_start + at * (linear + at * square)) for at in places]


def _parts(setup: Setup, track: AscentState, step: BurnStep) -> Array:
    """Number of substeps that a step needs if drag is stiff (light, wide and fast rockets); [1] if none do. [1]

    Drag pulls the speed toward equilibrium at the rate rho Cd A v / m; a substep may cover `MAX_DRAG_FRACTION` of that.
    A planar flight also gets substeps where it leaves the rail and while thrust still changes its speed considerably.
    """
    dt, thrust, mass = step.dt, step.thrust, step.mass
    greatest = max(thrust[0].max(), thrust[2].max()) / mass[2].min()
    fastest = np.abs(track.velocity[0]).max() + dt.max() * greatest
    bound = setup.drag_area.max() * setup.air.density.max() * fastest * dt.max() / mass[2].min()
    if len(track.position) == 1 and bound <= MAX_DRAG_FRACTION:
        return np.ones(1)
    speed = _speed(track.velocity) + dt * step.greatest
    stiffness = setup.drag_area * setup.air.density * speed * dt / mass[2]
    wanted = stiffness / MAX_DRAG_FRACTION
    if len(track.position) > 1:
        wanted = np.maximum(wanted, _bends(setup, track, dt, step.greatest))
    if np.max(wanted) <= 1:
        return np.ones(1)
    return np.asarray(np.fmin(np.fmax(np.ceil(wanted), 1.0), MOST_PARTS))


def _bends(setup: Setup, track: AscentState, dt: Array, push: Array) -> Array:
    """Number of substeps if a planar path curves, given the acceleration by thrust [m/s^2]. [1]"""
    path, speed = _speed(track.position), _speed(track.velocity)
    ahead = (speed + 0.5 * push * dt) * dt
    turning = (path < setup.rail_length + setup.turn_length) & (path + ahead > setup.rail_length)
    gains = np.where(path < setup.rail_length, 0.0, push * dt / np.maximum(speed, 1e-9))
    return np.maximum(np.where(turning, ahead / SHORT_PATH, 0.0), gains / BIGGEST_GAIN) / setup.stride


def _advance(
    track: AscentState, setup: Setup, rate: EquationsOfMotion, step: BurnStep, first_rate: Array | None
) -> None:
    """Advance a step in as many substeps as each draw needs; if few draws need more, those continue separately.

    `first_rate` is the acceleration at the start of the step, if known.
    """
    parts = _parts(setup, track, step)
    moving, rows = track, np.arange(len(track.time))
    for part in range(int(parts.max())):
        busy = parts > part
        if len(rows) > WHOLE_SUBSTEP_DRAWS and busy.mean() < PARALLEL_DRAWS:
            _put_back(track, moving, rows)
            rows, kept = rows[busy], np.flatnonzero(busy)
            moving = AscentState(*(getattr(track, name)[..., rows] for name in AscentState.__dataclass_fields__))
            setup = setup.part(kept)
            rate = EquationsOfMotion(setup, burning=True, axes=len(moving.position))
            parts, step = parts[kept], step.of(kept)
        start, end = np.minimum(part / parts, 1.0), np.minimum((part + 1) / parts, 1.0)
        _step(moving, rate, step.between(start, end), first_rate)
        first_rate = None
    _put_back(track, moving, rows)


def _some(values: Array, rows: Integers) -> Array:
    """The entries of some draws; an entry shared by all draws stays as it is, [1]."""
    return values if len(values) == 1 else values[rows]


def _put_back(track: AscentState, moving: AscentState, rows: Integers) -> None:
    """Merge draws that continued separately back into the others."""
    if moving is track:
        return
    for name in ("position", "velocity", "time", "flying", "highest", "highest_time"):
        values = getattr(track, name).copy()
        values[..., rows] = getattr(moving, name)
        setattr(track, name, values)


def _step(track: AscentState, rate: EquationsOfMotion, step: BurnStep, first_rate: Array | None) -> None:
    """One classical Runge-Kutta step of position and velocity; `first_rate` as in `_advance`."""
    dt, thrust, mass = step.dt, step.thrust, step.mass
    x, v, half, sixth = track.position, track.velocity, 0.5 * dt, dt / 6
    a1 = rate(x, v, thrust[0], mass[0]) if first_rate is None else first_rate
    v2 = v + half * a1
    a2 = rate(x + half * v, v2, thrust[1], mass[1])
    v3 = v + half * a2
    a3 = rate(x + half * v2, v3, thrust[1], mass[1])
    v4 = v + dt * a3
    a4 = rate(x + dt * v3, v4, thrust[2], mass[2])
    a2 += a3
    track.position = x + dt * (v + sixth * (a1 + a2))
    a2 *= 2
    a2 += a1
    a2 += a4
    track.velocity = v + sixth * a2
    track.time = track.time + dt
    track.flying = track.flying + dt
    if rate.planar:
        _stop_on_rail(track, rate, x)
    if track.velocity[0].min() < 0:
        _turn_over(track, dt, x[0], v[0])


def _stop_on_rail(track: AscentState, rate: EquationsOfMotion, position: Array) -> None:
    """Stop draws that friction would push back along the rail: it only resists the motion."""
    setup = rate.setup
    back = setup.rail_friction > 0
    if not back.any():
        return
    back = back & (rate.along_rail(position) < setup.rail_length) & (rate.along_rail(track.velocity) < 0)
    higher = back & (position[0] > track.highest)
    track.highest_time = np.where(higher, track.time, track.highest_time)
    track.highest = np.where(higher, position[0], track.highest)
    track.position = np.where(back, position, track.position)
    track.velocity = np.where(back, 0.0, track.velocity)


def _turn_over(track: AscentState, dt: Array, height: Array, upward: Array) -> None:
    """Update the apogee of a flight that turns over under power; upward speed is assumed linear within a step."""
    turns = (upward > 0) & (track.velocity[0] <= 0)
    left = upward * dt / np.where(turns, upward - track.velocity[0], 1.0)
    top = height + 0.5 * upward * left
    higher = turns & (top > track.highest)
    track.highest_time = np.where(higher, track.time - dt + left, track.highest_time)
    track.highest = np.where(higher, top, track.highest)


def _leave_rail(track: AscentState, setup: Setup, dt: Array, position: Array, velocity: Array) -> None:
    """Update the speed at the end of the rail, from the cubic through path and speed at both ends of a step."""
    before, after = _speed(position), _speed(track.position)
    leaves = np.flatnonzero((after >= setup.rail_length) & (before < setup.rail_length))
    if not len(leaves):
        return
    rail, dt = _some(setup.rail_length, leaves), _some(dt, leaves)
    left, rise = rail - before[leaves], (after - before)[leaves]
    lift0, lift1 = _speed(velocity[:, leaves]) * dt, _speed(track.velocity[:, leaves]) * dt
    square, cubic = 3 * rise - 2 * lift0 - lift1, lift0 + lift1 - 2 * rise
    place = np.ones(len(rise))
    for _ in range(NEWTON):
        slope = lift0 + place * (2 * square + 3 * place * cubic)
        miss = place * (lift0 + place * (square + place * cubic)) - left
        place = np.minimum(np.maximum(place - miss / np.where(slope > 0, slope, np.inf), 0.0), 1.0)
    track.rail_speed = track.rail_speed.copy()
    track.rail_speed[leaves] = (lift0 + place * (2 * square + 3 * place * cubic)) / dt


def lift_off_time(setup: Setup) -> Float[Array, "draw"]:
    """Time at which thrust first exceeds weight and friction on the rail; inf if it never does. [s]

    Derivation: Newton's second law at rest, with the thrust linear between two points of its curve.
    """
    burns, motor = setup.burns, setup.motor
    mass = setup.dry_mass + burns.casing_mass[motor] + burns.propellant_mass[motor]
    weight = mass * (setup.gravity + setup.rail_friction)
    needed = weight * setup.burn_stretch / setup.thrust_factor
    result = np.where(burns.rise_thrust[0][motor] > needed, burns.rise_time[0][motor], np.inf)
    for knot in range(len(burns.rise_time) - 1):
        before, after = burns.rise_thrust[knot][motor], burns.rise_thrust[knot + 1][motor]
        crosses = (after > needed) & np.isinf(result)
        if crosses.any():
            share = np.clip((needed - before) / np.where(after > before, after - before, np.inf), 0.0, 1.0)
            start, end = burns.rise_time[knot][motor], burns.rise_time[knot + 1][motor]
            result = np.where(crosses, start + share * (end - start), result)
        if not np.isinf(result).any():
            break
    return np.asarray(result * setup.burn_stretch)
