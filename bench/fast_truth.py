"""A fast simulator of a rigid rocket in three dimensions without roll, for hundreds of flights.

All flights of a batch advance together, one Runge-Kutta step at a time. The state is position, velocity, the direction
of the axis and its rate of turning. Weathercocking follows from the physics: crossflow acts on nose and fins
(Barrowman), each at its local velocity, and turns the axis because these forces act behind the center of mass. The
simulator also has the rail, burned propellant, thrust, drag by Mach and Reynolds number, wind shear, updraft and an
opening parachute. Checked against RocketPy in `bench.compare`.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from bench import barrowman, parachute
from bench.air import GAS, GRAVITY, pressure, station_pressure, temperature, turned, wind_speed
from bench.world import Launch, Track
from fieldkit.shapes import Array, Float

EARTH = 6371000.0
FINE, COARSE = 0.004, 0.02
"""Steps before and after the last burnout of a batch. [s]"""
TABLE = 400
"""Points of a resampled thrust curve."""
BATCH = 400
"""Number of flights in a batch; flights of similar duration are grouped."""


@dataclass(frozen=True, slots=True)
class Batch:
    """The launches of a batch as arrays."""

    thrust: Float[Array, "flight point"]
    spent: Float[Array, "flight point"]
    """Burned fraction of the propellant. [1]"""
    exhaust: Float[Array, "flight"]
    """Impulse per mass of propellant. [m/s]"""
    burn: Float[Array, "flight"]
    dry_mass: Float[Array, "flight"]
    casing: Float[Array, "flight"]
    propellant: Float[Array, "flight"]
    dry_cg: Float[Array, "flight"]
    motor_cg: Float[Array, "flight"]
    length: Float[Array, "flight"]
    area: Float[Array, "flight"]
    slopes: Float[Array, "surface flight"]
    stations: Float[Array, "surface flight"]
    cd: Float[Array, "flight"]
    power_off: Float[Array, "flight"]
    mach_rise: Float[Array, "flight"]
    reynolds: Float[Array, "flight"]
    step: Float[Array, "flight"]
    step_from: Float[Array, "flight"]
    step_to: Float[Array, "flight"]
    ground: Float[Array, "flight"]
    station: Float[Array, "flight"]
    wind: Float[Array, "flight"]
    wind_height: Float[Array, "flight"]
    shear: Float[Array, "flight"]
    updraft: Float[Array, "flight"]
    turn: Float[Array, "flight"]
    rail: Float[Array, "flight"]
    friction: Float[Array, "flight"]
    axis: Float[Array, "three flight"]
    ejection: Float[Array, "flight"]
    opening: Float[Array, "flight"]
    chute: Float[Array, "flight"]


def fly(launches: Sequence[Launch]) -> list[Track]:
    """The tracks of launches, in their order."""
    order = sorted(range(len(launches)), key=lambda i: launches[i].motor.burn_time + launches[i].delay)
    tracks: dict[int, Track] = {}
    for start in range(0, len(order), BATCH):
        part = order[start : start + BATCH]
        batch = stack([launches[i] for i in part])
        steps = _integrate(batch)
        tracks |= {i: _track(launches[i], batch, steps, place) for place, i in enumerate(part)}
    return [tracks[i] for i in range(len(launches))]


def stack(launches: Sequence[Launch]) -> Batch:
    """Launches side by side as arrays."""

    def each(value: str, part: str = "") -> Float[Array, "flight"]:
        return np.array([getattr(getattr(x, part) if part else x, value) for x in launches], dtype=float)

    curves = [np.linspace(0, x.motor.burn_time, TABLE) for x in launches]
    thrust = np.array([np.interp(t, x.motor.time, x.motor.thrust) for t, x in zip(curves, launches, strict=True)])
    impulse = np.array([np.trapezoid(x.motor.thrust, x.motor.time) for x in launches])
    coarse = np.concatenate([np.zeros((len(thrust), 1)), np.cumsum(thrust[:, 1:] + thrust[:, :-1], axis=1)], axis=1)
    spent = coarse / coarse[:, -1:]
    burn = np.array([x.motor.burn_time for x in launches])
    thrust *= (impulse / (coarse[:, -1] / 2 * burn / (TABLE - 1)))[:, None]
    frames = [x.airframe for x in launches]
    tilt, heading = each("tilt"), each("heading")
    propellant = each("propellant_mass", "motor")
    return Batch(
        thrust=thrust,
        spent=spent,
        exhaust=impulse / propellant,
        burn=burn,
        dry_mass=each("dry_mass"),
        casing=each("total_mass", "motor") - propellant,
        propellant=propellant,
        dry_cg=each("dry_cg", "airframe"),
        motor_cg=each("length", "airframe") - each("length", "motor") / 2,
        length=each("length", "airframe"),
        area=np.pi / 4 * each("diameter", "airframe") ** 2,
        slopes=np.array([[barrowman.NOSE_SLOPE] * len(frames), [barrowman.fin_slope(f) for f in frames]]),
        stations=np.array(
            [[barrowman.OGIVE_CENTRE * f.nose for f in frames], [barrowman.fin_centre(f) for f in frames]]
        ),
        cd=each("cd", "drag"),
        power_off=each("power_off", "drag"),
        mach_rise=each("mach_rise", "drag"),
        reynolds=each("reynolds", "drag"),
        step=each("step", "drag"),
        step_from=each("step_from", "drag"),
        step_to=each("step_to", "drag"),
        ground=each("temperature", "air"),
        station=np.array([station_pressure(x.air.qnh, x.air.elevation) for x in launches]),
        wind=each("wind", "air"),
        wind_height=each("wind_height", "air"),
        shear=each("shear", "air"),
        updraft=each("updraft", "air"),
        turn=each("turn", "air"),
        rail=each("rail_length"),
        friction=each("friction"),
        axis=np.array([np.sin(tilt) * np.cos(heading), np.sin(tilt) * np.sin(heading), np.cos(tilt)]),
        ejection=each("delay") + burn,
        opening=each("opening"),
        chute=each("chute_area"),
    )


def mach_factor(mach: Float[Array, "*n"], rise: Float[Array, "*n"] | float) -> Float[Array, "*n"]:
    """Drag by Mach number relative to slow flight: a rise from 0.75 to 1.05, then a slow fall. [1]"""
    up = np.clip((mach - 0.75) / 0.3, 0, 1)
    down = np.clip((mach - 1.05) / 0.55, 0, 1)
    return np.asarray(1 + rise * (up**2 * (3 - 2 * up) - 0.4 * down**2 * (3 - 2 * down)))


def _lookup(table: Float[Array, "flight point"], part: Float[Array, "flight"]) -> Float[Array, "flight"]:
    """A resampled curve at a fraction of the burn; its last value after burnout."""
    place = np.clip(part, 0, 1) * (TABLE - 1)
    low = np.minimum(place.astype(np.int64), TABLE - 2)
    rows = np.arange(len(table))
    return np.asarray(table[rows, low] + (place - low) * (table[rows, low + 1] - table[rows, low]))


def _slope(
    time: float, state: Float[Array, "four three flight"], b: Batch
) -> tuple[Float[Array, "four three flight"], Float[Array, "flight"]]:
    """Rate of change of the state, and the specific force along the axis."""
    position, velocity, axis, spin = state
    height = position[2]
    part = time / b.burn
    burning = part < 1
    thrust = np.where(burning, _lookup(b.thrust, part), 0.0)
    fuel = b.propellant * (1 - _lookup(b.spent, part))
    motor = b.casing + fuel
    mass = b.dry_mass + motor
    cg = (b.dry_mass * b.dry_cg + motor * b.motor_cg) / mass
    kelvin = temperature(height, b.ground)
    rho = pressure(height, b.ground, b.station) / (GAS * kelvin)
    blow = wind_speed(height, b.wind, b.wind_height, b.shear)
    air = np.array([*turned(blow, height, b.turn), b.updraft])
    flow = velocity - air
    fast = np.sqrt((flow**2).sum(axis=0)) + 1e-9
    cd = b.cd * np.where(burning, 1.0, b.power_off) * mach_factor(fast / np.sqrt(1.4 * GAS * kelvin), b.mach_rise)
    cd = cd * (np.maximum(fast, 5.0) / 50) ** -b.reynolds
    cd = cd * np.where((time >= b.step_from) & (time < b.step_to), b.step, 1.0)
    dynamic = rho / 2 * b.area * fast
    along = (flow * axis).sum(axis=0)
    force = (thrust - dynamic * cd * along) * axis
    torque = np.zeros_like(force)
    for slope, station in zip(b.slopes, b.stations, strict=True):
        arm = (cg - station) * axis
        local = flow + _cross(spin, arm)
        side = -dynamic * slope * (local - (local * axis).sum(axis=0) * axis)
        force = force + side
        torque = torque + _cross(arm, side)
    flow_rate = np.where(burning, thrust / b.exhaust, 0.0)
    torque = torque - flow_rate * (b.length - cg) ** 2 * spin
    inertia = (
        b.dry_mass * ((barrowman.GYRATION * b.length) ** 2 + (b.dry_cg - cg) ** 2) + motor * (b.motor_cg - cg) ** 2
    )
    gravity = GRAVITY * (EARTH / (EARTH + height)) ** 2
    free = force / mass
    free[2] -= gravity
    turn, twist = _cross(spin, axis), torque / inertia

    on_rail = (position**2).sum(axis=0) < b.rail**2
    guided = (thrust - dynamic * cd * along - b.friction) / mass - gravity * axis[2]
    resting = (velocity**2).sum(axis=0) < 1e-12
    guided = np.where(resting, np.maximum(guided, 0.0), guided)
    on_rail = on_rail & (time < b.ejection)
    push = np.where(on_rail, guided + gravity * axis[2], (free * axis).sum(axis=0) + gravity * axis[2])

    ejected = time >= b.ejection
    open_part = np.clip((time - b.ejection) / b.opening, 0, 1)
    drag_force = rho / 2 * fast * (b.cd * b.area + b.chute * open_part**2)
    hanging = -drag_force * flow / mass
    hanging[2] -= gravity

    change = np.empty_like(state)
    change[0] = velocity
    change[1] = np.where(on_rail, guided * axis, np.where(ejected, hanging, free))
    change[2] = np.where(on_rail | ejected, 0.0, turn)
    change[3] = np.where(on_rail | ejected, 0.0, twist)
    return change, push


def _cross(a: Float[Array, "three flight"], b: Float[Array, "three flight"]) -> Float[Array, "three flight"]:
    return np.array([a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]])


@dataclass(frozen=True, slots=True)
class _Steps:
    time: Float[Array, "step"]
    height: Float[Array, "step flight"]
    speed: Float[Array, "step flight"]
    push: Float[Array, "step flight"]


def _integrate(b: Batch) -> _Steps:
    """Every flight from ignition until it descends under its open parachute."""
    state = np.zeros((4, 3, len(b.burn)))
    state[2] = b.axis
    rows = []
    time, fine_until = 0.0, float(b.burn.max()) + 0.2
    last = float((b.ejection + b.opening).max()) + 1.5
    while True:
        first, push = _slope(time, state, b)
        rows.append((time, state[0, 2], np.sqrt((state[1] ** 2).sum(axis=0)), push))
        if time > last and (state[1, 2] < 0).all():
            break
        dt = FINE if time < fine_until else COARSE
        second, _ = _slope(time + dt / 2, state + dt / 2 * first, b)
        third, _ = _slope(time + dt / 2, state + dt / 2 * second, b)
        fourth, _ = _slope(time + dt, state + dt * third, b)
        state = state + dt / 6 * (first + 2 * second + 2 * third + fourth)
        state[2] /= np.sqrt((state[2] ** 2).sum(axis=0))
        time += dt
    times, heights, speeds, pushes = zip(*rows, strict=True)
    return _Steps(np.array(times), np.array(heights), np.array(speeds), np.array(pushes))


def _track(launch: Launch, b: Batch, steps: _Steps, i: int) -> Track:
    """One flight of a batch, with its descent."""
    height = steps.height[:, i]
    down = np.flatnonzero((height < 0) & (steps.time > b.burn[i]))
    stop = int(down[0]) if len(down) else _hanging(steps, b, i)
    time = steps.time[: stop + 1]
    ejection: float | None = float(b.ejection[i])
    if time[-1] < b.ejection[i]:
        ejection = None
    drop = np.empty(0)
    fall = np.empty(0)
    if height[stop] > 0:
        mass = launch.dry_mass + launch.motor.total_mass - launch.motor.propellant_mass
        drag_area = launch.chute_area + launch.drag.cd * float(b.area[i])
        fall, drop = parachute.descent(float(height[stop]), mass, drag_area, launch.air)
    return Track(
        time=np.concatenate([time, time[-1] + fall]),
        height=np.concatenate([height[: stop + 1], drop]),
        speed=np.concatenate([steps.speed[: stop + 1, i], np.full(len(drop), np.nan)]),
        push=np.concatenate([steps.push[: stop + 1, i], np.full(len(drop), np.nan)]),
        liftoff=float(steps.time[int(np.argmax(steps.speed[:, i] > 0.05))]),
        burnout=float(b.burn[i]),
        ejection=ejection,
    )


def _hanging(steps: _Steps, b: Batch, i: int) -> int:
    """The step at which a flight has descended under its open parachute for a second."""
    settled = steps.time > b.ejection[i] + b.opening[i] + 1.0
    sinking = np.concatenate([[False], np.diff(steps.height[:, i]) < 0])
    ready = np.flatnonzero(settled & sinking)
    return int(ready[0]) if len(ready) else len(steps.time) - 1
