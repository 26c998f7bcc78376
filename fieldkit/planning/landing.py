"""The landing point of a plan: draws of the path to apogee and of the descent, their ellipse, and the rail angle that
brings the landing closest to the pad."""

import math
from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from typing import Any

import numpy as np

from fieldkit.flight import Flight
from fieldkit.flight.recovery import DIRECTIONS
from fieldkit.forecast.prediction import Prediction
from fieldkit.physics.descent import DescentResult
from fieldkit.physics.history import recorded_wind
from fieldkit.physics.wind import WindProfile
from fieldkit.planning.air import air_of
from fieldkit.planning.descent import descents
from fieldkit.planning.descent_rate import Fall
from fieldkit.planning.flown_descent import landing_mass
from fieldkit.planning.forecasts import Plan
from fieldkit.planning.quantiles import Three, named, three, three_of_all
from fieldkit.quantities import ShownUnits
from fieldkit.shapes import Array, Bool, Flags, Float
from fieldkit.units import DEGREE, FOOT

WIND_SPEED_SD, WIND_DIRECTION_SD = 0.2, math.radians(15)
"""Standard deviation of the log of the actual wind speed relative to the declared one, as in the training of the
networks, and of its direction [rad], a judgment."""
CALM_WIND = 0.3
"""Wind below which air is called calm (Beaufort force 0); within this limit the wind is unknown. [m/s]"""
CLIMB_SD, CLIMB_SD_OF_UNKNOWN_STABILITY = 0.08, 0.16
"""Standard deviation of the log of the drift during the climb relative to its forecast, with and without a known static
margin: root mean square over 51 RocketPy flights with 1 to 6 calibers, `tests/planning/test_landing_interval.py`. [1]
"""
MAX_WIND_SD = 20.0
"""A stated standard deviation of the wind from here on is not used. [m/s]"""
ELLIPSE_LEVEL = 0.9
"""Fraction of the landings inside the ellipse. [1]"""
ANGLES = (0.0, 2.5, 5.0, 7.5, 10.0)
"""Rail angles that are tried. [deg]"""
MAX_RECOMMENDED_ANGLE = 10 * DEGREE
"""Largest recommended rail angle, below every code's limit, because it costs altitude. [rad]"""
TRIED_WINDS = np.arange(11.0)
"""Winds at the pad that are tried: beyond the 20 mph that the codes allow. [m/s]"""
TRIED_DRAWS = 300
"""Flights simulated for each rail angle or wind. [1]"""


@dataclass(frozen=True, slots=True)
class Landing:
    """The landing points of a forecast: draws downwind of the pad and to the right of that [m], and the descent.

    `down_in` gives the descent of the same draws in another wind. Without a `wind`, only `drift` is known, and `along`
    and `across` assume no wind.
    """

    along: Float[Array, "draw"]
    across: Float[Array, "draw"]
    duration: Float[Array, "draw"]
    down: DescentResult
    down_in: Callable[[WindProfile], DescentResult]
    wind: float | None

    @property
    def drift(self) -> Float[Array, "draw"]:
        """Drift of the descent per m/s of wind at the pad. [s]"""
        return _drift(self.down_in)

    @property
    def away(self) -> Float[Array, "draw"]:
        """Distance from the pad. [m]"""
        return np.hypot(self.along, self.across)

    @property
    def landing_speed(self) -> Three | None:
        """Landing speed of the draws with an open device, of all if none opens; None if none lifts off. [m/s]"""
        opened = self.down.ballistic < 1
        return three(self.down.landing_speed[opened] if opened.any() else self.down.landing_speed)

    def ellipse(self) -> "LandingEllipse":
        """The ellipse with a fraction `ELLIPSE_LEVEL` of the landings, for a normal distribution with their mean and
        covariance."""
        points = np.stack([self.along, self.across])
        variance, axes = np.linalg.eigh(np.cov(points))
        scale = math.sqrt(-2 * math.log(1 - ELLIPSE_LEVEL))
        low, high = scale * np.sqrt(np.maximum(variance, 1e-6))
        turned = math.atan2(axes[1, 1], axes[0, 1])
        along, across = (float(one.mean()) for one in points)
        return LandingEllipse(along, across, float(high), float(low), turned, ELLIPSE_LEVEL)

    def json(self) -> dict[str, Any]:
        """Ready for JSON, with the unit in the key."""
        known = self.wind is not None
        return {
            "away_m": named(three(self.away)) if known else None,
            "downwind_m": named(three(self.along)) if known else None,
            "right_of_wind_m": named(three(self.across)) if known else None,
            "drift_m_per_mps": named(three(self.drift)),
            "duration_s": named(three(self.duration)),
            "landing_speed_mps": named(self.landing_speed),
            "chance_ballistic": float(self.down.ballistic.mean()),
            "ellipse": self.ellipse().json() if known else None,
        }


@dataclass(frozen=True, slots=True)
class LandingEllipse:
    """Center downwind of the pad and to the right of that [m], half axes [m], and the angle of the long axis from
    downwind to the right [rad]; it contains a fraction `level` of the landings."""

    along: float
    across: float
    long: float
    short: float
    turned: float
    level: float

    def outline(self, points: int = 72) -> Float[Array, "point 2"]:
        """Points on the ellipse, downwind and to the right. [m]"""
        angle = np.linspace(0, 2 * np.pi, points, endpoint=True)
        u, v = self.long * np.cos(angle), self.short * np.sin(angle)
        c, s = math.cos(self.turned), math.sin(self.turned)
        return np.stack([self.along + c * u - s * v, self.across + s * u + c * v], axis=-1)

    def inside(self, along: Float[Array, "*any"], across: Float[Array, "*any"]) -> Bool[Flags, "*any"]:
        """Whether points, downwind and to the right [m], are inside the ellipse."""
        c, s = math.cos(self.turned), math.sin(self.turned)
        x, y = along - self.along, across - self.across
        return np.asarray(((c * x + s * y) / self.long) ** 2 + ((c * y - s * x) / self.short) ** 2 <= 1)

    def json(self) -> dict[str, float]:
        """Ready for JSON."""
        return {
            "level": self.level,
            "downwind_m": self.along,
            "right_of_wind_m": self.across,
            "long_half_axis_m": self.long,
            "short_half_axis_m": self.short,
            "turned_deg": self.turned / DEGREE,
        }


def landing(prediction: Prediction, fall: Fall, seed: int = 5) -> Landing:
    """Landing points and durations for the draws of a forecast, with random deviations of the wind from the declared
    one and of the climb's drift from its forecast.

    Without a wind, only the rail angle causes drift, and the landing point is unknown.
    """
    rng = np.random.default_rng(seed)
    count = len(prediction.apogee)
    speed = fall.speeds(
        rng, (count, 1), landing_mass(prediction.plan, prediction.found), air_of(prediction.plan).density
    )[:, 0]
    down_in = partial(descents, prediction, fall, speed)
    down = down_in()
    stronger = np.exp(log_wind_sd(prediction.plan) * rng.normal(size=count))
    turned = WIND_DIRECTION_SD * rng.normal(size=count)
    climb_sd = CLIMB_SD if prediction.plan.columns.stability else CLIMB_SD_OF_UNKNOWN_STABILITY
    climb = np.exp(climb_sd * rng.normal(size=count))
    along = climb * np.nan_to_num(prediction.drift) + stronger * (
        down.along * np.cos(turned) - down.across * np.sin(turned)
    )
    sideways = np.broadcast_to(np.nan_to_num(prediction.across), (count,))
    across = climb * sideways + stronger * (down.along * np.sin(turned) + down.across * np.cos(turned))
    if prediction.plan.wind is not None and prediction.plan.wind < CALM_WIND:
        drift, (ahead, aside) = _drift(down_in), _within_calm(rng, count)
        along, across = along + ahead * drift, across + aside * drift
    return Landing(along, across, prediction.rise_time + down.time, down, down_in, prediction.plan.wind)


def log_wind_sd(plan: Flight) -> float:
    """Standard deviation of the log of the actual wind speed relative to the declared one: the usual one, or that of a
    log-normal speed with the standard deviation that saved weather states (column `wind_sd_mps`) if it is more. [1]

    Derivation: a log-normal variable with the relative standard deviation c has the log variance ln(1 + c^2).
    """
    sd = plan.columns.sd.get("wind")
    if not plan.wind or sd is None or not 0 < sd < MAX_WIND_SD:
        return WIND_SPEED_SD
    return max(WIND_SPEED_SD, math.sqrt(math.log1p((sd / max(plan.wind, CALM_WIND)) ** 2)))


def _drift(down_in: Callable[[WindProfile], DescentResult]) -> Float[Array, "draw"]:
    """Drift of a descent per m/s of wind at the pad. [s]"""
    calm, breeze = (down_in(WindProfile(wind)).along for wind in (0.0, 1.0))
    return breeze - calm


def _within_calm(rng: np.random.Generator, count: int) -> tuple[Float[Array, "draw"], Float[Array, "draw"]]:
    """Components of the wind in calm air: evenly spread over a disk of radius `CALM_WIND`. [m/s]"""
    speed, angle = CALM_WIND * np.sqrt(rng.uniform(size=count)), rng.uniform(0, 2 * np.pi, count)
    return speed * np.cos(angle), speed * np.sin(angle)


@dataclass(frozen=True, slots=True)
class RailChoice:
    """A direction and an angle [rad] of the rail, the resulting distance of the landing from the pad [m], and the
    forecast."""

    direction: str
    angle: float
    away: Three
    forecast: Prediction

    def json(self) -> dict[str, Any]:
        """Ready for JSON."""
        return {"direction": self.direction, "angle_deg": self.angle / DEGREE, "away_m": named(self.away)}


def rail_choices(plan: Plan, most: float) -> list[RailChoice]:
    """Landing distances for rail directions and angles up to `most` [rad], closest to the pad first; empty if the wind
    is not known. Raises ImpossibleFlight for a plan without a mass."""
    if plan.flight.wind is None:
        return []
    ways = [("into", 0.0)]
    ways += [(name, angle * DEGREE) for name in DIRECTIONS for angle in ANGLES[1:] if angle * DEGREE <= most + 1e-9]
    leaning = [plan.flight.with_columns(rail_direction=name).with_changes(rail_angle=angle) for name, angle in ways]
    predictions, fall = plan.forecasts(leaning, draws=TRIED_DRAWS), plan.fall
    choices = [
        RailChoice(name, angle, three_of_all(landing(one, fall).away), one)
        for (name, angle), one in zip(ways, predictions, strict=True)
    ]
    return sorted(choices, key=lambda choice: (round(choice.away[1]), choice.angle))


def wind_that_holds(plan: Plan, size: float) -> float:
    """Wind at the pad up to which 95% of landings stay on a field of this size [m] with the pad in its center: 0 if
    they do not even in calm air, inf if they do in every tried wind. [m/s]

    Derivation: the wind at which the 95% quantile of the distance from the pad is half the field, linear between tried
    winds, each with the whole landing calculation. Raises ImpossibleFlight for a plan without a mass.
    """
    windy = [plan.flight.with_changes(wind=wind) for wind in TRIED_WINDS.tolist()]
    predictions, fall = plan.forecasts(windy, draws=TRIED_DRAWS), plan.fall
    beyond = np.array([three_of_all(landing(one, fall).away)[2] for one in predictions]) - size / 2
    off = np.flatnonzero(~(beyond <= 0))
    if not off.size:
        return math.inf
    if off[0] == 0:
        return 0.0
    around = slice(off[0] - 1, off[0] + 1)
    return float(np.interp(0.0, beyond[around], TRIED_WINDS[around]))


PROFILE_HEIGHTS = {"m": (0.0, 100.0, 300.0), "ft": (0.0, 300 * FOOT, 1000 * FOOT)}
"""Heights at which the wind is listed [m], round in the unit in which lengths are shown."""


def profile_in_words(wind: WindProfile, shown: ShownUnits) -> str:
    """The wind at several heights: `4.0 m/s at the pad, 7.0 m/s at 100 m, 8.2 m/s at 300 m`."""
    heights = PROFILE_HEIGHTS[shown.length_unit]
    along, across = wind.components(np.array(heights))
    speeds = np.hypot(along, across)
    aloft = zip(speeds[1:], heights[1:], strict=True)
    more = ", ".join(f"{shown.speed(speed)} at {shown.length(height)}" for speed, height in aloft)
    return f"{shown.speed(speeds[0])} at the pad, {more}"


__all__ = [
    "Landing",
    "LandingEllipse",
    "RailChoice",
    "landing",
    "profile_in_words",
    "rail_choices",
    "recorded_wind",
    "wind_that_holds",
]
