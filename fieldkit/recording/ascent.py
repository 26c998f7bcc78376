"""From the pad to just past apogee: height, speed and acceleration, with draws of them for the uncertainties.

A first guess of the acceleration, the accelerometer's or a coast against drag, is integrated twice; what the
barometer says beyond that is a curve whose acceleration wanders (`smooth`). How much it wanders under thrust and in
the coast, and how noisy the samples are, is what makes the samples most probable (type-II maximum likelihood).
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from fieldkit.recording.ballistic import Coast, fitted_coast
from fieldkit.recording.channels import Heights, Push
from fieldkit.recording.guess import Guess, fastest, first_guess
from fieldkit.recording.numbers import lag_one, mad_sd, median_step
from fieldkit.recording.outline import Outline
from fieldkit.recording.smooth import Design, Fit, Grid, apply, basis, design, fit
from fieldkit.shapes import Array, Flags, Float, Int, Integers
from fieldkit.standard_air import GRAVITY

DRAWS = 200
_STUDENT = 4.0
"""Degrees of freedom of the errors of a sample. [1]"""
_KNOTS = 1200
_AFTER = 2.0
"""How far past apogee the curve goes. [s]"""
_RAM = 0.006
"""Error of the pressure in a fast airframe, as a part of the dynamic pressure. [1]

In four logs with an accelerometer beside the barometer the heights in boost were off by 0.006 to 0.03 of v²/2g.
"""
_LASTING = 0.3
"""How long such an error stays alike. [s]"""
_SOUND, _NEAR_SOUND = 335.0, 0.13
"""Speed of sound [m/s], and how near to it, as a part of it, no sample is believed once some seemed to fall. [1]"""
_MARGIN = 0.4
"""How long before and after a seeming fall its samples are not believed. [s]"""
_SLOW, _BLOWN = 8.0, 2.0
"""Nearer to the top than this a coast is far too slow for shocks of the air [s]: what seems to fall there is gas of a
charge in the airframe, which comes and goes for so long [s]"""
_GAS, _GAS_LASTS = 4.0, 0.7
"""What the gas of an ejection charge does to the pressure in an airframe [m], and for how long [s]"""
_FREE = 300.0
"""How much acceleration wanders once a parachute may be out. [m^2/s^5]"""


@dataclass(frozen=True, slots=True, eq=False)
class Ascent:
    """The ascent on even knots, and draws of it from the posterior; heights above the pad, vertical, SI."""

    time: Float[Array, "knot"]
    height: Float[Array, "knot"]
    speed: Float[Array, "knot"]
    acceleration: Float[Array, "knot"]
    heights: Float[Array, "draw knot"]
    speeds: Float[Array, "draw knot"]
    accelerations: Float[Array, "draw knot"]
    noise: float
    """Of a sample, as the fit has it. [m]"""
    burnout_sd: float
    """Of the time of burnout as heights alone have it; 0 where an accelerometer saw it. [s]"""
    fused: bool
    """Whether an accelerometer shaped the curve."""


def ascend(
    track: Heights, push: Push | None, seen: Outline, lift: float | None, blow: float | None, marked: float | None
) -> Ascent | None:
    """The ascent, or None where it has too few samples.

    `blow` is when the charge was felt, `marked` where the logger saw apogee, after which it may have fired one. [s]
    """
    free = blow if blow is not None else marked
    climb = track.time[(track.time > seen.fastest - 2) & (track.time < seen.top + 1)][:4000]
    if climb.size < 2:
        return None
    step = median_step(climb)
    begin = max(float(track.time[0]), (lift if lift is not None else float(track.time[0])) - 1.5)
    end = min(float(track.time[-1]), seen.top + max(_AFTER, 4 * step))
    fallen = _dip(track, seen, lift)
    near = (track.time >= begin) & (track.time <= end) & ~fallen
    if near.sum() < 10:
        return None
    pace = float(np.clip(step, max(0.02, (end - begin) / _KNOTS), 0.1))
    grid = Grid(begin, pace, int(np.ceil((end - begin) / pace)))
    released = min(seen.top, free if free is not None and free > seen.fastest + 0.5 else np.inf) - 0.05
    burnout = seen.fastest
    for disturbed in (False, True):
        time, height = track.time[near], track.height[near] - seen.pad
        coast = fitted_coast(time, height, begin, burnout, released)
        guess, fused = first_guess(grid, coast, push, lift, burnout, released)
        speed = np.interp(track.time, grid.time, guess.speed)
        sonic = near & (np.abs(speed / _SOUND - 1) < _NEAR_SOUND)
        if disturbed or not fallen.any() or not sonic.any() or (near & ~sonic).sum() < 10:
            break
        near &= ~sonic
    samples = design(grid, time)
    charge = blow if blow is not None else np.inf
    gas = np.where((time >= charge - 0.05) & (time < charge + _GAS_LASTS), _GAS, 0.0)
    if fused:
        burnout = fastest(grid, guess, lift, released)
    found = _fitted(samples, time, height, guess, _phases(grid, lift, burnout, released), track.noise, fused, gas)
    if not fused and lift is not None:
        burnout, spread = _likeliest(samples, time, height, coast, found, lift, burnout, released)
        guess, _ = first_guess(grid, coast, None, lift, burnout, released)
        found = _fitted(samples, time, height, guess, _phases(grid, lift, burnout, released), track.noise, fused, gas)
        return _drawn(grid, guess, found, fused, spread)
    return _drawn(grid, guess, found, fused, 0.0)


def _likeliest(
    samples: Design,
    time: Float[Array, "time"],
    height: Float[Array, "time"],
    coast: Coast | None,
    settled: "_Settled",
    lift: float,
    about: float,
    released: float,
) -> tuple[float, float]:
    """The burnout that makes heights alone most probable, and its standard deviation: there acceleration jumps. [s]"""
    grid, reach = samples.grid, max(0.4, 0.25 * (about - lift))
    every = np.linspace(max(lift + 0.1, about - reach), min(about + reach, released - 0.1), 25)
    evidence = []
    for burnout in every:
        guess, _ = first_guess(grid, coast, None, lift, burnout, released)
        phases = _phases(grid, lift, burnout, released)
        evidence.append(settled.again(samples, height - np.interp(time, grid.time, guess.height), phases).evidence)
    share = np.exp(np.array(evidence) - np.max(evidence))
    share /= share.sum()
    mean = float(share @ every)
    return mean, float(np.sqrt(share @ (every - mean) ** 2))


def _dip(track: Heights, seen: Outline, lift: float | None) -> Flags:
    """Samples of a climb in which the rocket seems to fall: shocks of the air near the speed of sound, or a charge."""
    climb = np.flatnonzero((track.time > (lift if lift is not None else -np.inf)) & (track.time < seen.top - 1))
    low = np.zeros(track.time.size, bool)
    if climb.size:
        height = track.height[climb]
        fallen = np.maximum.accumulate(height) - height > max(12 * track.noise, 5.0)
        first = np.searchsorted(track.time, track.time[climb[fallen]] - _MARGIN)
        slow = max(seen.top - _SLOW, (seen.fastest + seen.top) / 2)
        lasts = np.where(track.time[climb[fallen]] > slow, _BLOWN, _MARGIN)
        last = np.searchsorted(track.time, track.time[climb[fallen]] + lasts)
        edges = np.zeros(track.time.size + 1)
        np.add.at(edges, first, 1)
        np.add.at(edges, last, -1)
        low = np.cumsum(edges[:-1]) > 0
    return low


def _phases(grid: Grid, lift: float | None, burnout: float, released: float) -> Int[Integers, "interval"]:
    """0 on the pad, 1 under thrust, 2 in the coast, 3 once a parachute may be out."""
    middle = grid.middles
    thrust = middle < burnout + max(0.15, 2 * grid.step)
    pad = middle < (lift - max(0.05, grid.step) if lift is not None else -np.inf)
    return np.where(pad, 0, np.where(thrust, 1, np.where(middle < released, 2, 3)))


@dataclass(frozen=True, slots=True, eq=False)
class _Settled:
    """What a fit came to: the curve, and the variances and the wander it was made with."""

    curve: Fit
    noise: float
    variance: Float[Array, "time"]
    thrust: float
    coast: float

    def again(self, samples: Design, rest: Float[Array, "time"], phases: Int[Integers, "interval"]) -> Fit:
        """The curve through another rest with the same settings."""
        return fit(samples, rest, 1 / self.variance, np.choose(phases, [0.01, self.thrust, self.coast, _FREE]))


def _fitted(
    samples: Design,
    time: Float[Array, "time"],
    height: Float[Array, "time"],
    guess: Guess,
    phases: Int[Integers, "interval"],
    noise: float,
    fused: bool,
    gas: Float[Array, "time"],
) -> _Settled:
    """The most probable curve through what the guess leaves, robustly, and the noise of a sample.

    Where an accelerometer gives the shape, the error of the pressure in a fast airframe counts as noise too; `gas`
    is what a charge adds to the noise of each sample.
    """
    from scipy.optimize import minimize

    grid, rows = samples.grid, samples.rows
    rest = height - np.interp(time, grid.time, guess.height)
    centre = np.log([3.0 if fused else 2000.0, 0.3 if fused else 5.0, noise, 1.5])
    spread = np.array([0.3, 0.5, 0.35, 0.7]) if fused else np.array([0.7, 0.8, 0.35, 0.7])
    weight = np.ones(rest.size)
    early = phases[np.minimum(rows.first, phases.size - 1)] == 1
    lasting = np.sqrt(max(1.0, _LASTING / median_step(time))) if fused else 0.15
    speed = np.clip(np.interp(time, grid.time, guess.speed), 0, 4 * _SOUND)
    ram = lasting * _RAM * speed**2 / (2 * GRAVITY) * (1 + fused * (speed / (0.75 * _SOUND)) ** 6)
    known = ram**2 + gas**2

    def variance(settings: Float[Array, "four"]) -> Float[Array, "time"]:
        return np.asarray(np.exp(2 * settings[2]) * np.where(early, max(np.exp(2 * settings[3]), 1.0), 1.0) + known)

    def curve(settings: Float[Array, "four"], share: float = 1.0) -> Fit:
        wander = np.choose(phases, [0.01, np.exp(settings[0]), np.exp(settings[1]), _FREE])
        return fit(samples, rest, share * weight / variance(settings), wander)

    def cost(settings: Float[Array, "four"]) -> float:
        far = (settings - centre) / spread
        far[2] *= 1.0 if far[2] < 0 else 0.35  # filtered samples scatter less from one to the next than they err
        if np.any(np.abs(far) > 6):
            return 1e12
        return float(-curve(settings).evidence + 0.5 * (far**2).sum())

    settings = centre
    for tries in (45, 30, 20):
        for _ in range(4):
            left = (rest - apply(rows, curve(settings).mean)) / np.sqrt(variance(settings))
            weight = (_STUDENT + 1) / (_STUDENT + left**2)
        settings = _searched(minimize, cost, settings, tries)
    left = rest - apply(rows, curve(settings).mean)
    alike = lag_one(left[(weight > 0.5) & ~early])
    share = (1 - alike) / (1 + alike)
    return _Settled(
        curve(settings, share),
        max(float(np.exp(settings[2])), mad_sd(left[~early])),
        variance(settings) / weight / share,
        float(np.exp(settings[0])),
        float(np.exp(settings[1])),
    )


def _searched(
    minimize: Callable[..., object], cost: Callable[[Float[Array, "four"]], float], start: Array, tries: int
) -> Array:
    """The least of a cost from a start, by Nelder and Mead's simplex."""
    options = {"maxfev": tries, "initial_simplex": start + np.vstack([np.zeros(4), np.diag([0.7, 1.0, 0.3, 0.5])])}
    return np.asarray(minimize(cost, start, method="Nelder-Mead", options=options).x)  # type: ignore[attr-defined]


def _drawn(grid: Grid, guess: Guess, settled: _Settled, fused: bool, spread: float) -> Ascent:
    """The curve, guess and rest together, and draws of it."""
    knots = grid.time
    coefficients = settled.curve.draws(DRAWS, np.random.default_rng(0))
    shapes = [basis(grid, knots, order) for order in range(3)]
    mean = [apply(rows, settled.curve.mean) for rows in shapes]
    drawn = [apply(rows, coefficients) for rows in shapes]
    return Ascent(
        knots,
        guess.height + mean[0],
        guess.speed + mean[1],
        guess.acceleration + mean[2],
        guess.height + drawn[0],
        guess.speed + drawn[1],
        guess.acceleration + drawn[2],
        settled.noise,
        spread,
        fused,
    )
