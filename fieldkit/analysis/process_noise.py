"""A curve through heights with a separate process noise for each phase of a flight, and estimates of these noises.

The process noise under thrust and in the coast, and the noise of the samples, maximize the marginal likelihood (type-II
maximum likelihood) with priors as wide as loggers and rockets differ.

Derivation: the marginal likelihood of the smoother in `fieldkit.analysis.smooth`.
"""

from dataclasses import dataclass, replace

import numpy as np

from fieldkit.analysis.initial_guess import SHORTEST_BURN, Guess, lagged
from fieldkit.analysis.optimize import nelder_mead
from fieldkit.analysis.robust_statistics import lag_one, mad_sd, median_step
from fieldkit.analysis.samples import Marks, Samples
from fieldkit.analysis.smooth import CurvePosterior, Grid, apply, basis, fit
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
"""Smallest part of this error that changes within a flight, as a fraction of the dynamic pressure. [1]"""
_CORRELATION_TIME = 0.3
"""Correlation time of the changing part. [s]"""
_BOOST_TIME = 1.0
"""How long the dynamic pressure stays near its maximum. [s]"""
_GAS, _GAS_LASTS = 4.0, 0.7
"""Effect of ejection gas on the pressure in an airframe, as height [m], and its duration [s]."""
THRUST_NOISE, THRUST_NOISE_SPREAD = 0.30, 1.0
"""Process noise of thrust around its typical decrease, in units of its mean squared per burn time: median over the
catalog, and interquartile range of the logarithm in those of a standard normal, each impulse class weighted equally (a
test recomputes them). [1]"""
_COAST_NOISE, _FUSED_NOISES = 5.0, (3.0, 0.3)
"""Typical process noise of the acceleration in a coast, and with an accelerometer under thrust and in the coast.
[m^2/s^5]"""
_PAD_NOISE, _DESCENT_NOISE = 0.01, 300.0
"""Process noise of the acceleration on the pad, and once a parachute may be out. [m^2/s^5]"""
_FOLLOWED_TIMES = 5.0
"""Time constants after which a first-order lag has followed a step to 1%. [1]"""
_FELT_LATER = 2.0
"""How long after a parachute may be out a shock is still that of the first one [s]."""
_SINK, _MAX_BRAKING = 8.0, 20 * GRAVITY
"""Speed at which a typical parachute decelerates the rocket by one g (by four at twice that) [m/s], and the largest
deceleration that an airframe survives [m/s^2]."""
_OPENING_TIME, _HARDEST_BRAKING_FRACTION = 1.0, 0.3
"""How long a parachute may take to open [s], and in what fraction of that time it decelerates hardest [1]."""


def phases(grid: Grid, marks: Marks) -> Int[Integers, "interval"]:
    """Phase of each interval: 0 on the pad, 1 thrust, 2 coast, 3 parachute may be out, 4 ejected parachute opening.

    Until the first felt shock nothing brakes a rocket, if that is soon after its top.
    """
    middle = grid.middles
    thrust = middle < marks.burnout + max(0.15, 2 * grid.step)
    pad = middle < (marks.lift - max(0.05, grid.step) if marks.lift is not None else -np.inf)
    felt_soon = marks.charge < marks.released + _FELT_LATER
    free = max(marks.released, marks.charge - 2 * grid.step) if felt_soon else marks.released
    opens = (middle > marks.charge - 2 * grid.step) & (middle < marks.charge + _OPENING_TIME)
    return np.select([pad, thrust, opens, middle < free], [0, 1, 4, 2], 3)


def lags(grid: Grid, marks: Marks, lag: float) -> Float[Array, "interval"]:
    """Lag that counts in each interval: from lift-off until the samples have followed the rocket after burnout. [s]

    In the smooth parts of a flight, what lags is as smooth as what does not.
    """
    follows = (grid.middles > (marks.lift or grid.start)) & (grid.middles < marks.burnout + _FOLLOWED_TIMES * lag)
    return np.where(follows, lag, 0.0)


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
    """Result of a fit: the curve, and the variances and process noise it was fitted with.

    `noise` is that of a sample [m], `variance` that of each sample [m^2]; `thrust`, `coast` and `opening` are process
    noises [m^2/s^5], and `prior` is the log prior density of the first two up to a constant.
    """

    curve: CurvePosterior
    noise: float
    variance: Float[Array, "time"]
    thrust: float
    coast: float
    opening: float
    prior: float

    def again(
        self, samples: Samples, guess: Guess, marks: Marks, lag: float, error: Float[Array, "time"] | None = None
    ) -> "FittedCurve":
        """Fit the curve around another guess and for another lag of the samples [s], with the same settings.

        `error` is one that the samples may have in common. [m]
        """
        variances = noise_variance(phases(samples.grid, marks), self.thrust, self.coast, self.opening) + samples.hidden
        height, late = samples.above(guess, lag), lags(samples.grid, marks, lag)
        return replace(self, curve=fit(samples.splines, height, 1 / self.variance, variances, late, error))

    def with_ports(self, samples: Samples, guess: Guess, marks: Marks, lag: float, static: float) -> CurvePosterior:
        """The curve around another guess and for another lag of the samples [s], with the same settings.

        `static` is the standard deviation of the airframe's pressure error, as a fraction of the dynamic pressure.
        Raises LinAlgError if no curve fits.
        """
        error = static * dynamic_height(samples, guess.speed, marks, lag) if static > 0 else None
        return self.again(samples, guess, marks, lag, error).curve

    def with_process_of(self, other: "FittedCurve") -> "FittedCurve":
        """The same samples and errors with the process noises of another fit."""
        return replace(self, thrust=other.thrust, coast=other.coast, prior=other.prior)


def dynamic_height(samples: Samples, speed: Float[Array, "knot"], marks: Marks, lag: float) -> Float[Array, "time"]:
    """Height of the dynamic pressure at each sample, v²/2g behind a lag [s], by the speed at the knots [m/s]. [m]"""
    shown = lagged(speed**2 / (2 * GRAVITY), 0.0, samples.grid.step, lag)
    flies = samples.is_own & (samples.time < marks.released)
    return np.asarray(flies * np.interp(samples.time, samples.grid.time, shown))


def settled(samples: Samples, guess: Guess, fused: bool, marks: Marks, lag: float = 0.0) -> FittedCurve:
    """The most probable curve through the residuals of the guess, fitted robustly, and the noise of a sample.

    `fused` if the guess has the shape of an accelerometer; `lag` is the time constant by which samples are late [s].
    """
    model = _model(samples, guess, fused, marks, lag)
    settings, weight = model.centre, np.ones(samples.time.size)
    if fused and samples.is_barometric:
        weight = model.weighed(settings, weight)
        speed = guess.speed + apply(basis(samples.grid, samples.grid.time, 1), model.curve(settings, weight).mean)
        model = replace(model, error=STATIC_SD * dynamic_height(samples, speed, marks, lag))
    for tries in (45, 30, 20):
        weight = model.weighed(settings, weight)
        settings = model.searched(settings, weight, tries)
    residual = model.residual(settings, weight)
    own = samples.is_own
    lag1 = lag_one(residual[(weight > 0.5) & ~model.early & own])
    independent = np.where(own, (1 - lag1) / (1 + lag1), 1.0)
    return FittedCurve(
        model.curve(settings, independent * weight),
        max(float(np.exp(settings[2])), mad_sd(residual[~model.early & own])),
        model.variance(settings) / weight / independent,
        float(np.exp(settings[0])),
        float(np.exp(settings[1])),
        model.opening,
        -0.5 * float((((settings - model.centre) / model.spread)[:2] ** 2).sum()),
    )


@dataclass(frozen=True, slots=True, eq=False)
class _Model:
    """Sample errors and process noise of a curve as functions of four settings.

    The settings are logarithms: of the process noise under thrust and in the coast [m^2/s^5], of the noise of a sample
    [m], and of the factor by which it grows under thrust [1]. `centre` and `spread` are their prior; `known` are known
    variances of each sample, `opening` the process noise of an opening parachute, and `error` is what static ports that
    are off by one standard deviation add to each sample [m].
    """

    samples: Samples
    rest: Float[Array, "time"]
    phase: Int[Integers, "interval"]
    early: Flags
    known: Float[Array, "time"]
    opening: float
    late: Float[Array, "interval"]
    error: Float[Array, "time"] | None
    centre: Float[Array, "four"]
    spread: Float[Array, "four"]

    def variance(self, settings: Float[Array, "four"]) -> Float[Array, "time"]:
        """Variance of each sample. [m^2]"""
        inflation = np.where(self.early, max(np.exp(2 * settings[3]), 1.0), 1.0)
        own = np.exp(2 * settings[2]) * inflation + self.known
        return np.where(self.samples.is_own, own, self.samples.variance)

    def curve(self, settings: Float[Array, "four"], weight: Float[Array, "time"]) -> CurvePosterior:
        """The curve through the residuals."""
        variances = noise_variance(self.phase, float(np.exp(settings[0])), float(np.exp(settings[1])), self.opening)
        return fit(
            self.samples.splines,
            self.rest,
            weight / self.variance(settings),
            variances + self.samples.hidden,
            self.late,
            self.error,
        )

    def residual(self, settings: Float[Array, "four"], weight: Float[Array, "time"]) -> Float[Array, "time"]:
        """Residuals after the curve and the error in common. [m]"""
        curve = self.curve(settings, weight)
        left = self.rest - apply(self.samples.splines.rows, curve.mean)
        return left if self.error is None else left - curve.shared * self.error

    def weighed(self, settings: Float[Array, "four"], weight: Float[Array, "time"]) -> Float[Array, "time"]:
        """Weights of the samples by Student's t, from previous ones. [1]"""
        for _ in range(4):
            residual = self.residual(settings, weight) / np.sqrt(self.variance(settings))
            weight = (_STUDENT + 1) / (_STUDENT + residual**2)
        return weight

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


def _model(samples: Samples, guess: Guess, fused: bool, marks: Marks, lag: float) -> _Model:
    """The model of a flight; if an accelerometer gives the shape, the process noise is smaller."""
    phase = phases(samples.grid, marks)
    noises = _FUSED_NOISES if fused else (_thrust_noise(guess, marks, samples.grid.start), _COAST_NOISE)
    return _Model(
        samples,
        samples.above(guess, lag),
        phase,
        phase[np.minimum(samples.splines.rows.first, phase.size - 1)] == 1,
        _ram(samples, guess, fused) ** 2 + _blur(samples, guess, marks) ** 2 + _gas(samples.time, marks.charge) ** 2,
        _opening(samples.grid, guess, marks.charge),
        lags(samples.grid, marks, lag),
        None,
        np.log([*noises, samples.noise, 1.5]),
        np.array([0.3, 0.5, 0.35, 0.7]) if fused else np.array([THRUST_NOISE_SPREAD, 0.8, 0.35, 0.7]),
    )


def _thrust_noise(guess: Guess, marks: Marks, start: float) -> float:
    """Typical process noise of the acceleration in the boost of a guess on a grid that begins at `start` [s].
    [m^2/s^5]"""
    burn = max(marks.burnout - (start if marks.lift is None else marks.lift), SHORTEST_BURN)
    return THRUST_NOISE * (float(guess.speed.max()) / burn + GRAVITY) ** 2 / burn


def _ram(samples: Samples, guess: Guess, fused: bool) -> Float[Array, "time"]:
    """Error of each height from the pressure in a fast airframe, relevant if an accelerometer is more precise. [m]

    Heights of a receiver have none.
    Above about Mach 0.8, where shocks disturb the pressure, it is also relevant if there are satellite data. If these
    show a pressure error, it is that fraction of the dynamic pressure throughout the flight, shared by all samples of a
    boost.
    """
    if not samples.is_barometric:
        return np.zeros(samples.time.size)
    step = median_step(samples.time[: samples.own])
    lasting = np.sqrt(max(1.0, _CORRELATION_TIME / step)) if fused else 0.15
    speed = np.clip(np.interp(samples.time, samples.grid.time, guess.speed), 0, 4 * SPEED_OF_SOUND)
    if not fused and samples.static:
        lasting = max(lasting, abs(samples.static) / _RAM * np.sqrt(max(1.0, _BOOST_TIME / step)))
    shocks = (fused or samples.own < samples.time.size) * (speed / (0.75 * SPEED_OF_SOUND)) ** 6
    return np.asarray(lasting * _RAM * speed**2 / (2 * GRAVITY) * (1 + shocks))


def _blur(samples: Samples, guess: Guess, marks: Marks) -> Float[Array, "time"]:
    """Error of each height after correction for a first-order filter's delay. [m]

    A filter with delay d leaves an error of a d²/2 at acceleration a; an error of the delay leaves that times the
    speed. Both are shared by all samples of a boost.
    """
    if not samples.lag or marks.lift is None:
        return np.zeros(samples.time.size)
    pushed = (samples.time > marks.lift) & (samples.time < marks.burnout + 3 * samples.lag)
    inflation = np.sqrt(max(1.0, _BOOST_TIME / median_step(samples.time[: samples.own])))
    blurred = pushed * samples.lag**2 / 2 * float(np.abs(guess.acceleration).max())
    shifted = samples.lag_sd * np.interp(samples.time, samples.grid.time, guess.speed)
    return np.asarray(inflation * np.hypot(blurred, shifted))


def _gas(time: Float[Array, "time"], charge: float) -> Float[Array, "time"]:
    """Error of each height from the gas of a charge. [m]"""
    return np.where((time >= charge - 0.05) & (time < charge + _GAS_LASTS), _GAS, 0.0)
