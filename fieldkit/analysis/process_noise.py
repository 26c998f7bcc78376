"""A curve through heights with a separate process noise for each phase of a flight, and estimates of these noises.

The process noise under thrust and in the coast, and the noise of the samples, maximize the marginal likelihood (type-II
maximum likelihood) with priors as wide as loggers and rockets differ.

Derivation: the marginal likelihood of the smoother in `fieldkit.analysis.smooth`.
"""

from dataclasses import dataclass

import numpy as np

from fieldkit.analysis.channels import Push
from fieldkit.analysis.initial_guess import Guess
from fieldkit.analysis.optimize import nelder_mead
from fieldkit.analysis.records import Sightings
from fieldkit.analysis.robust_statistics import lag_one, mad_sd, median_step
from fieldkit.analysis.smooth import CurvePosterior, Grid, SplineDesign, apply, design, fit
from fieldkit.physics.standard_atmosphere import GRAVITY
from fieldkit.shapes import Array, Flags, Float, Int, Integers

SPEED_OF_SOUND = 335.0
"""Speed of sound. [m/s]"""
_STUDENT = 4.0
"""Degrees of freedom of the errors of a sample. [1]"""
STATIC_SD = 0.03
"""Standard deviation of the airframe's pressure error in subsonic flight, as a fraction of the dynamic pressure, and so
of the height error as a fraction of v²/2g. In real logs with an accelerometer it was -0.06 to 0.04. [1]
"""
_RAM = 0.006
"""Smallest part of it that changes within a flight. [1]"""
_CORRELATION_TIME = 0.3
"""Correlation time of this error. [s]"""
_BOOST_TIME = 1.0
"""How long the dynamic pressure stays near its maximum. [s]"""
_GAS, _GAS_LASTS = 4.0, 0.7
"""Effect of ejection gas on the pressure in an airframe, as height [m], and its duration [s]."""
_PAD_NOISE, _DESCENT_NOISE = 0.01, 300.0
"""Process noise of the acceleration on the pad, and once a parachute may be out. [m^2/s^5]"""
_SINK, _MAX_BRAKING = 8.0, 20 * GRAVITY
"""Speed at which a typical parachute decelerates the rocket by one g (by four at twice that) [m/s], and the largest
deceleration that an airframe survives [m/s^2]."""
_OPENING_TIME, _HARDEST_BRAKING_FRACTION = 1.0, 0.3
"""How long a parachute may take to open [s], and in what fraction of that time it decelerates hardest [1]."""


@dataclass(frozen=True, slots=True)
class Marks:
    """Boundaries of the flight phases [s].

    Lift-off, None if the log begins later; burnout; the earliest time a parachute may be out; and the time a charge was
    felt, infinite if none was.
    """

    lift: float | None
    burnout: float
    released: float
    charge: float


@dataclass(frozen=True, slots=True, eq=False)
class Samples:
    """Height samples above the pad that count [m], their times [s], their splines, and the noise of one [m].

    The first `own` samples are the heights of the log's main source. The rest are satellite data, heights and speeds by
    their `order`, with their `variance`, and the `static` error of the heights that they imply. The heights are delayed
    by `lag` [s]. `hidden` is the extra process noise of the acceleration if an accelerometer was saturated [m^2/s^5].
    """

    time: Float[Array, "time"]
    height: Float[Array, "time"]
    splines: SplineDesign
    noise: float
    hidden: Float[Array, "interval"]
    own: int
    order: Int[Integers, "time"]
    variance: Float[Array, "time"]
    static: float = 0.0
    lag: float = 0.0

    @property
    def grid(self) -> Grid:
        """The knots of the splines."""
        return self.splines.grid

    def above(self, guess: Guess) -> Float[Array, "time"]:
        """The samples minus a guess. [m], [m/s]"""
        height, speed = (np.interp(self.time, self.grid.time, one) for one in (guess.height, guess.speed))
        return np.asarray(self.height - np.where(self.order == 1, speed, height))

    @property
    def is_own(self) -> Flags:
        """Which samples are heights of the log's main source."""
        return np.arange(self.time.size) < self.own


def samples_on(
    grid: Grid,
    time: Float[Array, "time"],
    height: Float[Array, "time"],
    noise: float,
    push: Push | None = None,
    sighted: Sightings | None = None,
    lag: float = 0.0,
) -> Samples:
    """Prepare heights above the pad for fits on a grid, with satellite data and an accelerometer that shapes the curve.

    `height` and `noise` are in m, `time` and `lag` in s.
    """
    own = time.size
    order, variance, static = np.zeros(own, np.int64), np.zeros(own), 0.0
    if sighted is not None:
        near = (sighted.time > grid.time[0]) & (sighted.time < grid.time[-1])
        time, height = np.append(time, sighted.time[near]), np.append(height, sighted.value[near])
        order, variance = np.append(order, sighted.order[near]), np.append(variance, sighted.variance[near])
        static = sighted.static
    return Samples(
        time, height, design(grid, time, order), noise, _hidden(grid, push), own, order, variance, static, lag
    )


def _hidden(grid: Grid, push: Push | None) -> Float[Array, "interval"]:
    """Process noise of the acceleration around the values filled in during saturation: as large as their average, for
    as long as the saturation lasted. [m^2/s^5]"""
    if push is None or push.full is None or not push.full.any():
        return np.zeros(grid.count)
    reach = max(grid.step, median_step(push.time))
    near = np.interp(grid.middles, push.time, push.full) + sum(
        np.interp(grid.middles + away, push.time, push.full) for away in (-reach, reach)
    )
    lasts = float(push.full.sum()) * median_step(push.time)
    return np.where(near > 0, max(push.missed, GRAVITY) ** 2 / max(lasts, 2 * reach), 0.0)


def phases(grid: Grid, marks: Marks) -> Int[Integers, "interval"]:
    """Phase of each interval: 0 on the pad, 1 thrust, 2 coast, 3 parachute may be out, 4 ejected parachute opening."""
    middle = grid.middles
    thrust = middle < marks.burnout + max(0.15, 2 * grid.step)
    pad = middle < (marks.lift - max(0.05, grid.step) if marks.lift is not None else -np.inf)
    opens = (middle > marks.charge - 2 * grid.step) & (middle < marks.charge + _OPENING_TIME)
    return np.select([pad, thrust, opens, middle < marks.released], [0, 1, 4, 2], 3)


def noise_variance(
    phase: Int[Integers, "interval"], thrust: float, coast: float, opening: float
) -> Float[Array, "interval"]:
    """Variance that the acceleration gains per second, by interval. [m^2/s^5]"""
    return np.asarray(np.choose(phase, [_PAD_NOISE, thrust, coast, _DESCENT_NOISE, opening]))


def _opening(grid: Grid, guess: Guess, charge: float) -> float:
    """Process noise of the acceleration while a parachute opens after ejection at speed. [m^2/s^5]"""
    speed = float(np.interp(charge, grid.time, guess.speed))
    return max(_DESCENT_NOISE, min(GRAVITY * (speed / _SINK) ** 2, _MAX_BRAKING) ** 2 / _HARDEST_BRAKING_FRACTION)


@dataclass(frozen=True, slots=True, eq=False)
class FittedCurve:
    """Result of a fit: the curve, and the variances and process noise it was fitted with."""

    curve: CurvePosterior
    noise: float
    variance: Float[Array, "time"]
    thrust: float
    coast: float
    opening: float

    def again(self, samples: Samples, guess: Guess, marks: Marks) -> CurvePosterior:
        """Fit the curve around another guess with the same settings."""
        wander = noise_variance(phases(samples.grid, marks), self.thrust, self.coast, self.opening)
        return fit(samples.splines, samples.above(guess), 1 / self.variance, wander + samples.hidden)


def settled(samples: Samples, guess: Guess, fused: bool, marks: Marks) -> FittedCurve:
    """The most probable curve through the residuals of the guess, fitted robustly, and the noise of a sample.

    `fused` if the guess has the shape of an accelerometer.
    """
    model = _model(samples, guess, fused, marks)
    settings, weight = model.centre, np.ones(samples.time.size)
    for tries in (45, 30, 20):
        for _ in range(4):
            left = model.left(settings, weight) / np.sqrt(model.variance(settings))
            weight = (_STUDENT + 1) / (_STUDENT + left**2)
        settings = model.searched(settings, weight, tries)
    left = model.left(settings, weight)
    own = samples.is_own
    lag1 = lag_one(left[(weight > 0.5) & ~model.early & own])
    share = np.where(own, (1 - lag1) / (1 + lag1), 1.0)
    return FittedCurve(
        model.curve(settings, share * weight),
        max(float(np.exp(settings[2])), mad_sd(left[~model.early & own])),
        model.variance(settings) / weight / share,
        float(np.exp(settings[0])),
        float(np.exp(settings[1])),
        model.opening,
    )


@dataclass(frozen=True, slots=True, eq=False)
class _Model:
    """Sample errors and process noise of a curve as functions of four settings.

    The settings are logarithms: of the process noise under thrust and in the coast [m^2/s^5], of the noise of a sample
    [m], and of the factor by which it grows under thrust [1]. `centre` and `spread` are their prior; `known` are known
    variances of each sample, `opening` the process noise of an opening parachute.
    """

    samples: Samples
    rest: Float[Array, "time"]
    phase: Int[Integers, "interval"]
    early: Flags
    known: Float[Array, "time"]
    opening: float
    centre: Float[Array, "four"]
    spread: Float[Array, "four"]

    def variance(self, settings: Float[Array, "four"]) -> Float[Array, "time"]:
        """Variance of each sample. [m^2]"""
        noisier = np.where(self.early, max(np.exp(2 * settings[3]), 1.0), 1.0)
        own = np.exp(2 * settings[2]) * noisier + self.known
        return np.where(self.samples.is_own, own, self.samples.variance)

    def curve(self, settings: Float[Array, "four"], weight: Float[Array, "time"]) -> CurvePosterior:
        """The curve through the residuals."""
        wander = noise_variance(self.phase, float(np.exp(settings[0])), float(np.exp(settings[1])), self.opening)
        return fit(self.samples.splines, self.rest, weight / self.variance(settings), wander + self.samples.hidden)

    def left(self, settings: Float[Array, "four"], weight: Float[Array, "time"]) -> Float[Array, "time"]:
        """Residuals after the curve. [m]"""
        return self.rest - apply(self.samples.splines.rows, self.curve(settings, weight).mean)

    def cost(self, settings: Float[Array, "four"], weight: Float[Array, "time"]) -> float:
        """Negative log posterior of the settings; filtered samples scatter less than their true error."""
        far = (settings - self.centre) / self.spread
        far[2] *= 1.0 if far[2] < 0 else 0.35
        if np.any(np.abs(far) > 6):
            return 1e12
        return float(-self.curve(settings, weight).evidence + 0.5 * (far**2).sum())

    def searched(self, start: Array, weight: Float[Array, "time"], tries: int) -> Array:
        """The most probable settings near a start, by the Nelder-Mead simplex."""
        simplex = start + np.vstack([np.zeros(4), np.diag([0.7, 1.0, 0.3, 0.5])])
        return nelder_mead(lambda settings: self.cost(settings, weight), simplex, tries)


def _model(samples: Samples, guess: Guess, fused: bool, marks: Marks) -> _Model:
    """The model of a flight; if an accelerometer gives the shape, the process noise is smaller."""
    phase = phases(samples.grid, marks)
    return _Model(
        samples,
        samples.above(guess),
        phase,
        phase[np.minimum(samples.splines.rows.first, phase.size - 1)] == 1,
        _ram(samples, guess, fused) ** 2 + _blur(samples, guess, marks) ** 2 + _gas(samples.time, marks.charge) ** 2,
        _opening(samples.grid, guess, marks.charge),
        np.log([3.0 if fused else 2000.0, 0.3 if fused else 5.0, samples.noise, 1.5]),
        np.array([0.3, 0.5, 0.35, 0.7]) if fused else np.array([0.7, 0.8, 0.35, 0.7]),
    )


def _ram(samples: Samples, guess: Guess, fused: bool) -> Float[Array, "time"]:
    """Error of each height from the pressure in a fast airframe, relevant if an accelerometer is more precise. [m]

    Above about Mach 0.8, where shocks disturb the pressure, it is also relevant if there are satellite data. If these
    show a pressure error, it is that fraction of the dynamic pressure throughout the flight, shared by all samples of a
    boost.
    """
    step = median_step(samples.time[: samples.own])
    lasting = np.sqrt(max(1.0, _CORRELATION_TIME / step)) if fused else 0.15
    speed = np.clip(np.interp(samples.time, samples.grid.time, guess.speed), 0, 4 * SPEED_OF_SOUND)
    if not fused and samples.static:
        lasting = max(lasting, abs(samples.static) / _RAM * np.sqrt(max(1.0, _BOOST_TIME / step)))
    shocks = (fused or samples.own < samples.time.size) * (speed / (0.75 * SPEED_OF_SOUND)) ** 6
    return np.asarray(lasting * _RAM * speed**2 / (2 * GRAVITY) * (1 + shocks))


def _blur(samples: Samples, guess: Guess, marks: Marks) -> Float[Array, "time"]:
    """Error of each height after correction for a first-order filter's delay. [m]

    A filter with delay d leaves an error of a d²/2 at acceleration a; a 50 % uncertainty of the delay leaves v d/2 at
    speed v. Both are shared by all samples of a boost.
    """
    if not samples.lag or marks.lift is None:
        return np.zeros(samples.time.size)
    pushed = (samples.time > marks.lift) & (samples.time < marks.burnout + 3 * samples.lag)
    inflation = np.sqrt(max(1.0, _BOOST_TIME / median_step(samples.time[: samples.own])))
    blurred = pushed * samples.lag**2 / 2 * float(np.abs(guess.acceleration).max())
    shifted = samples.lag / 2 * np.interp(samples.time, samples.grid.time, guess.speed)
    return np.asarray(inflation * np.hypot(blurred, shifted))


def _gas(time: Float[Array, "time"], charge: float) -> Float[Array, "time"]:
    """Error of each height from the gas of a charge. [m]"""
    return np.where((time >= charge - 0.05) & (time < charge + _GAS_LASTS), _GAS, 0.0)
