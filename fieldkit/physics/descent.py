"""The descent: free fall to the charge, then under a drogue, a main, a single parachute or a streamer, with wind drift.

Under a device drag balances weight, so the speed is proportional to the inverse square root of the density (Knacke,
Parachute Recovery Systems Design Manual, 1991, chapter 5). Everything that descends moves with the wind at its height.
"""

from dataclasses import dataclass, field
from typing import Any

import numpy as np

from fieldkit.integrals import running_integral
from fieldkit.physics.atmosphere import Air
from fieldkit.physics.wind import WindProfile
from fieldkit.shapes import Array, Bool, Float
from fieldkit.units import STANDARD_GRAVITY

GRID = 401
"""Number of heights at which the wind drift of a descent is tabulated. [1]"""
FILL_CONSTANT, PARACHUTE_CD = 8.0, 0.75
"""Filling distance of a flat round parachute divided by its diameter [1], and its drag coefficient, referred to its
laid-out area [1]. Source: Knacke, 1991, section 5.4 and table 5-1."""
NO_SPEED = np.zeros(1)
"""Zero horizontal speed. [m/s]"""
MAX_REACH = 300.0
"""Gravity times time over terminal speed, above which a fall is treated as terminal. [1]"""


@dataclass(frozen=True, slots=True)
class Devices:
    """Descent speeds near the ground [m/s]: under the device that opens at the charge, and under a main that opens at a
    height above the pad [m], 0 for no main. Each takes `opening` to open [s], but no longer than it takes to travel its
    filling distance: `filling` divided by its descent speed [m^2/s] (see the function `filling`)."""

    first: Float[Array, "*#draw"]
    main: Float[Array, "*#draw"] = field(default_factory=lambda: np.zeros(1))
    main_altitude: float = 0.0
    opening: Float[Array, "*#draw"] | float = 0.0
    filling: Float[Array, "*#draw"] = field(default_factory=lambda: np.full(1, np.inf))


@dataclass(frozen=True, slots=True)
class FreeFall:
    """An airframe at apogee: its height above the pad [m], the time until the charge fires [s], negative before apogee
    and nan for never, the terminal speed that it approaches nose first [m/s], and its horizontal speed downwind and
    crosswind [m/s]."""

    apogee: Float[Array, "*#draw"]
    wait: Float[Array, "*#draw"]
    terminal: Float[Array, "*#draw"]
    sideways: tuple[Float[Array, "*#draw"], Float[Array, "*#draw"]] = (NO_SPEED, NO_SPEED)


@dataclass(frozen=True, slots=True)
class Sinking:
    """The descent without wind: time from apogee to the ground [s] and the part of it before a device is open [s],
    height [m] and fall speed [m/s] at the charge, heights at which the first device [m] and the main [m] are open, fall
    speed when the first is open [m/s] and at landing [m/s], and whether nothing opened."""

    time: Float[Array, "*draw"]
    free_time: Float[Array, "*draw"]
    eject_height: Float[Array, "*draw"]
    eject_speed: Float[Array, "*draw"]
    open_height: Float[Array, "*draw"]
    open_speed: Float[Array, "*draw"]
    main_height: Float[Array, "*draw"]
    landing_speed: Float[Array, "*draw"]
    ballistic: Bool[Any, "*draw"]


@dataclass(frozen=True, slots=True)
class DescentResult:
    """From apogee to the ground: time [s], distance downwind and to the right of it [m], height of the charge [m],
    height at which the first device is open [m], landing speed [m/s], and whether nothing opened."""

    time: Float[Array, "*draw"]
    along: Float[Array, "*draw"]
    across: Float[Array, "*draw"]
    eject_height: Float[Array, "*draw"]
    open_height: Float[Array, "*draw"]
    landing_speed: Float[Array, "*draw"]
    ballistic: Float[Array, "*draw"]


def filling(mass: Float[Array, "*#draw"], density: Float[Array, "*#draw"]) -> Float[Array, "*draw"]:
    """Filling distance of a parachute times its descent speed, for a mass [kg] in air of a density [kg/m^3]. [m^2/s]

    The filling distance is proportional to the diameter of the parachute, which follows from its descent speed.
    """
    return np.asarray(FILL_CONSTANT * np.sqrt(8 * mass * STANDARD_GRAVITY / (np.pi * PARACHUTE_CD * density)))


def opening_time(
    devices: Devices, descent_speed: Float[Array, "*#draw"], speed: Float[Array, "*#draw"]
) -> Float[Array, "*draw"]:
    """Time from the charge to an open device, by its descent speed [m/s] and the airspeed at the charge [m/s]. [s]

    A parachute fills over a fixed distance, not in a fixed time: the higher the speed, the sooner it is open.
    """
    path = devices.filling / np.maximum(descent_speed, 1e-9)
    return np.asarray(np.minimum(devices.opening, path / np.maximum(np.abs(speed), 1e-9)))


def fall_by(
    time: Float[Array, "*#draw"], terminal: Float[Array, "*#draw"], gravity: float = STANDARD_GRAVITY
) -> Float[Array, "*draw"]:
    """Distance a body falls from rest in a time [s] against drag with a terminal speed [m/s]. [m]"""
    reach = gravity * np.maximum(time, 0.0) / terminal
    bent = np.minimum(reach, MAX_REACH)
    log_cosh = np.log1p(2 * np.sinh(0.5 * bent) ** 2)
    return np.asarray(terminal**2 / gravity * (log_cosh + (reach - bent)))


def fall_speed(
    time: Float[Array, "*#draw"], terminal: Float[Array, "*#draw"], gravity: float = STANDARD_GRAVITY
) -> Float[Array, "*draw"]:
    """Speed of a body after falling from rest for a time [s], as in `fall_by`. [m/s]"""
    return np.asarray(terminal * np.tanh(gravity * np.maximum(time, 0.0) / terminal))


def fall_time(
    height: Float[Array, "*#draw"], terminal: Float[Array, "*#draw"], gravity: float = STANDARD_GRAVITY
) -> Float[Array, "*draw"]:
    """Time a body takes to fall from rest through a height [m], as in `fall_by`. [s]"""
    deep = np.maximum(height, 0.0) * gravity / terminal**2
    steep = np.minimum(deep, MAX_REACH)
    grown = np.expm1(steep)
    return np.asarray(terminal / gravity * (np.log1p(grown + np.sqrt(grown * (grown + 2))) + (deep - steep)))


def lag(
    device: Float[Array, "*#draw"],
    before: Float[Array, "*#draw"],
    after: Float[Array, "*#draw"],
    gravity: float = STANDARD_GRAVITY,
) -> Float[Array, "*draw"]:
    """Extra time while a device slows from one speed to another, compared with its own steady descent. [s]

    All speeds are fall speeds [m/s]. Exact at constant density: integrating v' = g (1 - v^2/u^2) gives the path over u
    plus u/g ln((u + after) / (u + before)).
    """
    return np.asarray(device / gravity * np.log((device + after) / (device + before)))


def settling(device: Float[Array, "*#draw"], speed: Float[Array, "*#draw"]) -> Float[Array, "*draw"]:
    """Ratio of the horizontal distance covered while the horizontal airspeed decays to zero under a device to that
    airspeed at opening. `device` is its descent speed [m/s], `speed` the airspeed at opening [m/s]. [s]

    Drag reduces the horizontal speed in proportion to the path through the air, u' = -g/U^2 |v| u. For a fall that
    starts at v0 and ends at U this integrates to U/g arccos(r) / sqrt(1 - r^2) with r = v0/U; for v0 = U it is U/g.
    """
    ratio = speed / device
    slow = np.arccos(np.minimum(ratio, 1.0)) / np.sqrt(np.maximum(1 - ratio**2, 1e-12))
    fast = np.arccosh(np.maximum(ratio, 1.0)) / np.sqrt(np.maximum(ratio**2 - 1, 1e-12))
    near = np.abs(ratio - 1) < 1e-4
    return np.asarray(device / STANDARD_GRAVITY * np.where(near, 1.0, np.where(ratio < 1, slow, fast)))


def _under(device: Array, stage: tuple[Array, Array], before: Array, air: Air, gravity: float) -> tuple[Array, Array]:
    """Time under a device with a descent speed near the ground [m/s] from one height to another [m], entered at a fall
    speed [m/s], and the final speed. [s], [m/s]"""
    high, low = stage
    there = device / np.sqrt(air.density_ratio(high))
    deep = np.exp(-2 * gravity * (high - low) / there**2)
    after = np.sqrt(np.maximum(there**2 + (before**2 - there**2) * deep, 0.0))
    time = (air.sinking_path(high) - air.sinking_path(low)) / device + lag(there, before, after, gravity)
    return time, after * np.sqrt(air.density_ratio(high) / air.density_ratio(low))


def sink(free: FreeFall, devices: Devices, air: Air, gravity: float = STANDARD_GRAVITY) -> Sinking:
    """Descend from apogee under a gravity [m/s^2].

    A charge before apogee fires at the same speed as one equally long after it; the device is open at apogee if there
    was time for it.
    """
    terminal = free.terminal
    apogee, after = np.maximum(np.asarray(free.apogee, float), 0.0), np.asarray(free.wait, float)
    charge = apogee - fall_by(after, terminal, gravity)
    speed = np.hypot(fall_speed(np.abs(after), terminal, gravity), np.hypot(*free.sideways))
    opens = np.maximum(after + opening_time(devices, devices.first, speed), 0.0)
    opened = apogee - fall_by(opens, terminal, gravity)
    ballistic = ~(opened > 0)
    opened = np.where(ballistic, 0.0, opened)
    main_at, falls, ground = np.zeros_like(opened), fall_speed(opens, terminal, gravity), np.zeros_like(opened)
    if devices.main_altitude > 0:
        late = opening_time(devices, devices.main, devices.first)
        main_at = np.clip(devices.main_altitude - devices.first * late, 0.0, opened)
    time, landing = _under(devices.first, (opened, main_at), falls, air, gravity)
    if devices.main_altitude > 0:
        slowly, slow = _under(devices.main, (main_at, ground), landing, air, gravity)
        time, landing = np.where(main_at > 0, time + slowly, time), np.where(main_at > 0, slow, landing)
    hard = fall_time(apogee, terminal, gravity)
    known = np.isfinite(after) & (charge > 0)
    return Sinking(
        time=np.where(ballistic, hard, opens + time),
        free_time=np.where(ballistic, hard, opens),
        eject_height=np.where(known, charge, np.nan),
        eject_speed=np.where(known, speed, np.nan),
        open_height=np.where(ballistic, np.nan, opened),
        open_speed=np.where(ballistic, np.nan, falls),
        main_height=main_at,
        landing_speed=np.where(ballistic, fall_speed(hard, terminal, gravity), landing),
        ballistic=ballistic,
    )


def descend(free: FreeFall, devices: Devices, air: Air, wind: WindProfile) -> DescentResult:
    """Descend as in `sink`, drifting with the wind; `air` is the same for all draws.

    An airframe that falls nose first keeps its horizontal velocity at apogee; once a device is open, that velocity
    approaches the wind's within `settling` of the device.
    """
    fell = sink(free, devices, air)
    opened = np.nan_to_num(fell.open_height)
    table = _Table.of(float(np.max(free.apogee, initial=1.0)), air, wind)
    last = devices.main if devices.main_altitude > 0 else devices.first
    first, main = table.between(opened, fell.main_height), table.between(fell.main_height, np.zeros_like(opened))
    over_wind = [
        speed - np.interp(opened, table.height, blow) for speed, blow in zip(free.sideways, table.wind, strict=True)
    ]
    through_air = np.hypot(*over_wind)
    carried = [
        speed * fell.free_time
        + np.where(
            fell.ballistic,
            0.0,
            above / devices.first
            + below / last
            + relative * settling(devices.first, np.hypot(np.nan_to_num(fell.open_speed), through_air)),
        )
        for speed, relative, above, below in zip(free.sideways, over_wind, first, main, strict=True)
    ]
    return DescentResult(
        time=fell.time,
        along=carried[0],
        across=carried[1],
        eject_height=fell.eject_height,
        open_height=fell.open_height,
        landing_speed=fell.landing_speed,
        ballistic=fell.ballistic.astype(float),
    )


@dataclass(frozen=True, slots=True)
class _Table:
    """Integrals from the ground up of the square root of the density ratio times the wind components [m^2/s], and the
    wind components [m/s]."""

    height: Array
    along: Array
    across: Array
    wind: tuple[Array, Array]

    @classmethod
    def of(cls, top: float, air: Air, wind: WindProfile) -> "_Table":
        height = np.linspace(0.0, 1.0, GRID) ** 2 * top  # finer near the ground, where the wind changes
        thin = np.sqrt(air.density_ratio(height))
        along, across = wind.components(height)
        sums = running_integral(thin * np.stack([along, across]), height)
        return cls(height, sums[0], sums[1], (along, across))

    def between(self, high: Array, low: Array) -> tuple[Array, Array]:
        """The integral between two heights, to be divided by a speed near the ground."""

        def part(values: Array) -> Array:
            return np.asarray(np.interp(high, self.height, values) - np.interp(low, self.height, values))

        return part(self.along), part(self.across)
