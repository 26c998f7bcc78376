"""The way down: free fall to the charge, then under a drogue, a main, one parachute or a streamer, carried by the wind.

Under a device drag carries the weight, so that its speed grows with the root of the falling density (Knacke, Parachute
Recovery Systems Design Manual, 1991, chapter 5). What sinks moves with the wind at its height.
"""

from dataclasses import dataclass

import numpy as np

from fieldkit.physics.atmosphere import WIND_EXPONENT, WIND_HEIGHT, Air
from fieldkit.shapes import Array, Float
from fieldkit.units import STANDARD_GRAVITY

GRID = 401
"""Heights at which the integrals over the descent are tabulated. [1]"""
NO_SPEED = np.zeros(1)
"""No speed sideways. [m/s]"""
MAX_REACH = 300.0
"""Gravity times time over terminal speed, beyond which a fall is at terminal speed. [1]"""


@dataclass(frozen=True, slots=True)
class WindProfile:
    """Wind over height: at the pad [m/s], and if it is known aloft [m/s] at a height [m], turned by so much to the
    right [rad]. Between them it follows a power law through both; above it is even. Without a wind aloft the law is
    that of open ground (e.g. Panofsky and Dutton, 1984)."""

    surface: float = 0.0
    aloft: float | None = None
    aloft_height: float | None = None
    turn: float = 0.0

    def components(self, height: Float[Array, "level"]) -> tuple[Float[Array, "level"], Float[Array, "level"]]:
        """Wind along that at the pad and to its right, at heights above the pad. [m/s]"""
        height = np.maximum(height, 0.0)
        if self.aloft is None or self.aloft_height is None:
            speed = self.surface * (1 + height / WIND_HEIGHT) ** WIND_EXPONENT
            return np.asarray(speed), np.zeros_like(speed)
        place = np.minimum(height / self.aloft_height, 1.0)
        if self.surface > 0 and self.aloft > 0:
            power = np.log(self.aloft / self.surface) / np.log1p(self.aloft_height / WIND_HEIGHT)
            speed = self.surface * (1 + place * self.aloft_height / WIND_HEIGHT) ** power
        else:
            speed = self.surface + place * (self.aloft - self.surface)
        angle = self.turn * place
        return np.asarray(speed * np.cos(angle)), np.asarray(speed * np.sin(angle))


@dataclass(frozen=True, slots=True)
class Devices:
    """Descent speeds near the ground [m/s]: under what opens at the charge, and under a main that opens at a height
    above the pad [m], nan or 0 for none; each takes `opening` to open [s]."""

    first: Float[Array, "*#draw"]
    main: Float[Array, "*#draw"]
    main_altitude: float
    opening: float


@dataclass(frozen=True, slots=True)
class DescentResult:
    """From apogee to the ground: time [s], path downwind and to the right of it [m], height of the charge [m], height
    where the first device is open [m], speed at landing [m/s], and whether nothing opened."""

    time: Float[Array, "*draw"]
    along: Float[Array, "*draw"]
    across: Float[Array, "*draw"]
    eject_height: Float[Array, "*draw"]
    open_height: Float[Array, "*draw"]
    landing_speed: Float[Array, "*draw"]
    ballistic: Float[Array, "*draw"]


def fall_by(time: Float[Array, "*draw"], terminal: Float[Array, "*draw"]) -> Float[Array, "*draw"]:
    """How far a body falls from rest against a drag that holds it at a terminal speed [m/s], in a time [s]. [m]"""
    reach = np.minimum(STANDARD_GRAVITY * np.maximum(time, 0.0) / terminal, MAX_REACH)
    log_cosh = reach + np.log1p(np.exp(-2 * reach)) - np.log(2.0)
    beyond = np.maximum(STANDARD_GRAVITY * np.maximum(time, 0.0) / terminal - MAX_REACH, 0.0)
    return np.asarray(terminal**2 / STANDARD_GRAVITY * (log_cosh + beyond))


def fall_time(height: Float[Array, "*draw"], terminal: Float[Array, "*draw"]) -> Float[Array, "*draw"]:
    """The time in which a body falls from rest from a height [m], as in `fall_by`. [s]"""
    steep = np.minimum(np.maximum(height, 0.0) * STANDARD_GRAVITY / terminal**2, MAX_REACH)
    far = np.maximum(np.maximum(height, 0.0) * STANDARD_GRAVITY / terminal**2 - MAX_REACH, 0.0)
    grown = np.expm1(steep)
    return np.asarray(terminal / STANDARD_GRAVITY * (np.log1p(grown + np.sqrt(grown * (grown + 2))) + far))


def descend(
    apogee: Float[Array, "*draw"],
    wait: Float[Array, "*draw"],
    terminal: Float[Array, "*draw"],
    devices: Devices,
    air: Air,
    wind: WindProfile,
    sideways: tuple[Float[Array, "*#draw"], Float[Array, "*#draw"]] = (NO_SPEED, NO_SPEED),
) -> DescentResult:
    """Come down from an apogee above the pad [m]; the charge fires `wait` after it, before it if negative [s].

    `terminal` is the speed of the airframe alone [m/s]; `air` is one for all draws. A charge before apogee is taken to
    have opened its device by then. With `wait` nan nothing ever opens. An airframe that falls nose first keeps the
    speed downwind and across it that it has at apogee (`sideways`) [m/s]; once something is open that speed takes its
    terminal speed over gravity to become the wind's.
    """
    apogee = np.maximum(np.asarray(apogee, float), 0.0)
    after = np.asarray(wait, float)
    opens_after = np.where(after < 0, np.maximum(after + devices.opening, 0.0), after + devices.opening)
    charge = apogee - fall_by(np.maximum(after, 0.0), terminal)
    opened = apogee - fall_by(opens_after, terminal)
    ballistic = ~(opened > 0)
    opened = np.where(ballistic, 0.0, opened)
    table = _Table.of(float(np.max(apogee, initial=1.0)), air, wind)
    dual = devices.main_altitude > 0
    main_at = np.minimum(devices.main_altitude - devices.first * devices.opening, opened) if dual else 0.0 * opened
    main_at = np.maximum(main_at, 0.0)
    first, main = table.between(opened, main_at), table.between(main_at, np.zeros_like(opened))
    last = devices.main if dual else devices.first
    hard = fall_time(apogee, terminal)
    free_time = np.where(ballistic, hard, np.nan_to_num(opens_after))

    def total(which: int) -> Array:
        return np.asarray(first[which] / devices.first + main[which] / last)

    carried = [
        speed * free_time
        + np.where(ballistic, 0.0, (speed - np.interp(opened, table.height, blow)) * devices.first / STANDARD_GRAVITY)
        for speed, blow in zip(sideways, table.wind, strict=True)
    ]
    reached = dual & (main_at <= 0)
    return DescentResult(
        time=np.where(ballistic, hard, free_time + total(0)),
        along=carried[0] + np.where(ballistic, 0.0, total(1)),
        across=carried[1] + np.where(ballistic, 0.0, total(2)),
        eject_height=np.where(np.isfinite(after) & (charge > 0), charge, np.nan),
        open_height=np.where(ballistic, np.nan, opened),
        landing_speed=np.where(ballistic, terminal, np.where(reached, devices.first, last)),
        ballistic=ballistic.astype(float),
    )


@dataclass(frozen=True, slots=True)
class _Table:
    """Integrals from the ground up: of the root of the density ratio [m], of it times the wind along and
    across [m^2/s]; and the wind itself along and across [m/s]."""

    height: Array
    time: Array
    along: Array
    across: Array
    wind: tuple[Array, Array]

    @classmethod
    def of(cls, top: float, air: Air, wind: WindProfile) -> "_Table":
        height = np.linspace(0.0, 1.0, GRID) ** 2 * top  # finer near the ground, where the wind changes
        thin = np.sqrt(air.density_ratio(height))
        along, across = wind.components(height)

        def summed(values: Array) -> Array:
            return np.concatenate([[0.0], np.cumsum(0.5 * (values[1:] + values[:-1]) * np.diff(height))])

        columns = [summed(values) for values in (thin, thin * along, thin * across)]
        return cls(height, columns[0], columns[1], columns[2], (along, across))

    def between(self, high: Array, low: Array) -> tuple[Array, Array, Array]:
        """What is passed through between two heights, to be divided by a speed near the ground."""

        def part(values: Array) -> Array:
            return np.asarray(np.interp(high, self.height, values) - np.interp(low, self.height, values))

        return part(self.time), part(self.along), part(self.across)
