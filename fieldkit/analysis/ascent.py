"""From the pad to just past apogee: height, speed and acceleration, with posterior draws for the uncertainties.

An initial guess of the acceleration, from the accelerometer or from a coast with drag, is integrated twice. The
barometer adds a correction whose acceleration is a random walk (`process_noise`, `smooth`).
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import zip_longest

import numpy as np

from fieldkit.analysis.ballistic import Coast, fitted_coast
from fieldkit.analysis.burnout import Burnout, FitStart, guess_for, likeliest_burnout
from fieldkit.analysis.channels import Heights, Push
from fieldkit.analysis.height_lag import NO_LAG, Lag, burnout_is_hidden
from fieldkit.analysis.initial_guess import Guess, fastest, first_guess
from fieldkit.analysis.phases import LONGEST_CLIMB, Outline
from fieldkit.analysis.process_noise import SPEED_OF_SOUND, STATIC_SD, FittedCurve, settled
from fieldkit.analysis.records import Event, Sightings
from fieldkit.analysis.robust_statistics import mad_sd, median_step
from fieldkit.analysis.samples import Marks, Samples, samples_on
from fieldkit.analysis.smooth import Grid, apply, unlagged
from fieldkit.physics.standard_atmosphere import GRAVITY
from fieldkit.shapes import Array, Flags, Float

DRAWS = 200
_KNOTS = 1200
_TIME_AFTER_APOGEE, _LONG_AFTER = 2.0, 20.0
"""How far past apogee the curve extends, and how far for a log with few samples. [s]"""
_MAX_SPACING_SAMPLES = 4000
"""Largest number of samples of a climb used to find their spacing. [1]"""
_MIN_SAMPLES = 10
"""Fewest samples for which a curve is fitted. [1]"""
_NEAR_SOUND = 0.13
"""Half-width of the range around Mach 1, as a fraction of the speed of sound, in which samples are not trusted if some
appear to fall. [1]
"""
_MARGIN = 0.4
"""How long before and after an apparent fall the samples are not trusted. [s]"""
_MAX_COAST_PART = 2.0
"""A log that ends before apogee, or has a gap around burnout, shows too little of the coast to fit if the coast starts
faster than this multiple of the highest climb rate in its heights. [1]"""
_SHOCK_FREE_TIME, _GAS_DURATION = 8.0, 2.0
"""Closer to apogee than this a coast is far too slow for shocks [s]. An apparent fall there is ejection gas in the
airframe, which lasts this long [s]."""
_ROUNDS = 12
"""Rounds of a fixed-point iteration whose error shrinks to a third in each. [1]"""
_MIN_WEIGHT = 0.02
"""Smallest probability of a lag that counts. [1]"""
_LONG_LAG = 0.2
"""Shortest lag that makes a boost look much smoother: process noises are also estimated for one of these. [s]"""
_ON_COURSE, _OPENED, _OPENED_SAMPLES = 2.0, 5.0, 3
"""How far below their coast heights may be that are on it, and how far they are in the median after a parachute opened,
in their noise; and the fewest of those. [1]"""
_OPENING_ROUNDS = 6
"""Rounds in which the opening of a parachute is located. [1]"""
_SEEN_OPENING = 0.5
"""How long after the highest heights an earlier opening is still looked for. [s]"""
_MAX_EVIDENCE_LOSS = 10.0
"""Log evidence by which two lags in a row are behind the most probable one if longer lags are not tried. [1]"""


@dataclass(frozen=True, slots=True, eq=False)
class Ascent:
    """The ascent on evenly spaced knots, with posterior draws. Heights are above the pad and vertical; SI units."""

    time: Float[Array, "knot"]
    height: Float[Array, "knot"]
    speed: Float[Array, "knot"]
    acceleration: Float[Array, "knot"]
    heights: Float[Array, "draw knot"]
    speeds: Float[Array, "draw knot"]
    accelerations: Float[Array, "draw knot"]
    noise: float
    """Standard deviation of one sample according to the fit. [m]"""
    burnout_sd: float
    """Standard deviation of the burnout time from heights alone; 0 if an accelerometer recorded it. [s]"""
    fused: bool
    """Whether an accelerometer shaped the curve."""
    resolution: float = 0.0
    """Shortest thrust whose magnitude the curve resolves. [s]"""
    sighted: Sightings | None = None
    """Satellite data that complement the heights."""
    ended: Event | None = None
    """Burnout as felt by an accelerometer that did not shape the curve."""
    burnout: Burnout | None = None
    """Burnout according to the heights, if ports disturb them and no accelerometer recorded it."""


@dataclass(frozen=True, slots=True, eq=False)
class LaggedAscent:
    """The ascent if the heights have one of several lags, and the probability of that lag. [1]"""

    weight: float
    lag: Lag
    ascent: Ascent


def ascend(
    track: Heights,
    push: Push | None,
    seen: Outline,
    lift: float | None,
    blow: float | None,
    marked: float | None,
    sighted: Sightings | None = None,
    lags: Sequence[Lag] = (NO_LAG,),
    ended: Event | None = None,
) -> list[LaggedAscent]:
    """Fit the ascent for each of the `lags` that the heights may have, most probable first. Empty if too few samples.

    Without a lag it is always fitted.

    `sighted` is the satellite data that complement the heights; `blow` is the time when the charge was felt [s];
    `marked` is the time when the logger detected apogee, after which it may have fired a charge [s]; `ended` is burnout
    as felt by an accelerometer that does not shape the curve.
    """
    climb = track.time[(track.time > seen.fastest - 2) & (track.time < seen.top + 1)][:_MAX_SPACING_SAMPLES]
    if climb.size < 2:
        return []
    begin = max(float(track.time[0]), lift - 1.5 if lift is not None else seen.top - LONGEST_CLIMB)
    end = min(float(track.time[-1]), seen.top + float(np.clip(4 * median_step(climb), _TIME_AFTER_APOGEE, _LONG_AFTER)))
    fallen = _dip(track, seen, lift)
    near = (track.time >= begin) & (track.time <= end) & ~fallen
    if near.sum() < _MIN_SAMPLES:
        return []
    grid = _grid(begin, end, median_step(climb))
    marks = Marks(
        lift, ended.time if ended else seen.fastest, _released(seen, blow, marked), blow if blow is not None else np.inf
    )
    start = _fit_start(track, seen, grid, near, push, marks, sighted)
    for _ in range(_OPENING_ROUNDS):  # without the samples after the opening the coast fits those before it better
        opened = _opened(start, marks, seen)
        if opened > marks.released - grid.step:
            break
        marks = replace(marks, released=opened, charge=min(marks.charge, opened))
        start = _fit_start(track, seen, grid, near, push, marks, sighted)
    slow = near & ~_near_sound(track, grid, start.guess)
    shocked = track.is_barometric and seen.transonic and not start.fused
    disturbed = fallen.any() or track.disturbed or shocked
    if disturbed and (near & ~slow).any() and slow.sum() >= _MIN_SAMPLES:
        start = _fit_start(track, seen, grid, slow, push, marks, sighted)
    if ended is not None and not start.fused:
        settings = settled(start.samples, start.guess, False, marks)
        found = [LaggedAscent(1.0, lags[0], _drawn(start.samples, start.guess, settings, False, ended.sd))]
    else:
        found, ended = _fitted(start, marks, lags, STATIC_SD if track.is_barometric else 0.0), None
    return [replace(one, ascent=replace(one.ascent, sighted=sighted, ended=ended)) for one in found]


def _grid(begin: float, end: float, step: float) -> Grid:
    """Knots spaced about as widely as the samples, within a minimum and a maximum number. [s]"""
    spacing = float(np.clip(step, max(0.02, (end - begin) / _KNOTS), 0.1))
    return Grid(begin, spacing, int(np.ceil((end - begin) / spacing)))


def _released(seen: Outline, blow: float | None, marked: float | None) -> float:
    """Earliest time when a parachute may be out: a felt charge, a marked apogee, or the top. [s]"""
    free = blow if blow is not None else marked
    return min(seen.top, free if free is not None and free > seen.fastest + 0.5 else np.inf) - 0.05


def _opened(start: FitStart, marks: Marks, seen: Outline) -> float:
    """When heights leave their coast downward and stay below it past their top, because a parachute opened that
    early; the known release if they do not. [s]

    In the second half of a coast nothing else slows a rocket down that much.
    """
    coast, own = start.coast, start.samples.is_own
    if coast is None or not seen.down:
        return marks.released
    time, height = start.samples.time[own], start.samples.height[own]
    coasts = (time > (marks.burnout + seen.top) / 2) & (time < seen.top + _SEEN_OPENING)
    left = height[coasts] - np.interp(time[coasts], coast.time, coast.height)
    if left.size < _MIN_SAMPLES:
        return marks.released
    noise = max(start.samples.noise, mad_sd(left))
    on_course = np.flatnonzero(left > -_ON_COURSE * noise)
    begins = int(on_course[-1]) + 1 if on_course.size else 0
    below = left[begins:]
    if begins == 0 or below.size < _OPENED_SAMPLES or float(np.median(below)) > -_OPENED * noise:
        return marks.released
    seen_after = float(np.sqrt(_ON_COURSE * noise / GRAVITY))  # at a braking of 2 g
    return min(marks.released, float(time[coasts][begins - 1]) - seen_after)


def _fit_start(
    track: Heights,
    seen: Outline,
    grid: Grid,
    counts: Flags,
    push: Push | None,
    marks: Marks,
    sighted: Sightings | None,
) -> FitStart:
    """Select the samples that count on a grid, and make an initial guess from them and an accelerometer."""
    time, height = track.time[counts], track.height[counts] - seen.pad
    coast = fitted_coast(time, height, grid.start, marks.burnout, marks.released)
    is_partial = not seen.down or burnout_is_hidden(track, seen)
    if coast is not None and is_partial and _speed(coast, marks.burnout) > _MAX_COAST_PART * seen.climbs:
        coast = None
    guess, fused = first_guess(grid, coast, push, marks.lift, marks.burnout, marks.released)
    shaping, lag = push if fused else None, (track.lag, track.lag_sd)
    samples = samples_on(grid, time, height, track.noise, shaping, sighted, lag, is_barometric=track.is_barometric)
    return FitStart(samples, coast, guess, fused)


def _speed(coast: Coast, moment: float) -> float:
    """Speed of a coast at a time. [m/s]"""
    return float(np.interp(moment, coast.time, coast.speed))


def _near_sound(track: Heights, grid: Grid, guess: Guess) -> Flags:
    """Samples at which the guess is close to the speed of sound."""
    return np.asarray(np.abs(np.interp(track.time, grid.time, guess.speed) / SPEED_OF_SOUND - 1) < _NEAR_SOUND)


def _fitted(start: FitStart, marks: Marks, lags: Sequence[Lag], static: float) -> list[LaggedAscent]:
    """Fit the curve from an initial guess. With heights only, burnout is then estimated and the curve fitted again.

    `static` is the standard deviation of the airframe's pressure error, as a fraction of the dynamic pressure.
    """
    samples, grid = start.samples, start.samples.grid
    if start.fused:
        marks = replace(marks, burnout=fastest(grid, start.guess, marks.lift, marks.released))
    found = settled(samples, start.guess, start.fused, marks)
    if start.fused or marks.lift is None:
        return [LaggedAscent(1.0, lags[0], _drawn(samples, start.guess, found, start.fused, 0.0))]
    tried = _tried(start, found, marks, lags, static)
    longer = max((one for one in tried if one.lag >= _LONG_LAG), key=lambda one: one.evidence, default=None)
    if longer is not None and longer.evidence > max(one.evidence for one in tried) - _MAX_EVIDENCE_LOSS:
        smoother = settled(samples, guess_for(start, longer.marks, longer.lag), False, longer.marks, longer.lag)
        also = _tried(start, found.with_process_of(smoother), marks, lags, static)
        tried = _likelier(tried, also)
    most = max(one.evidence for one in tried)
    if not np.isfinite(most):
        raise np.linalg.LinAlgError("no curve can be fitted to these samples")
    weights = np.exp([one.evidence - most for one in tried])
    weights /= weights.sum()
    likely = [place for place in np.argsort(-weights).tolist() if weights[place] > _MIN_WEIGHT or not lags[place].lag]
    total = float(weights[likely].sum())
    best = tried[likely[0]]
    settings = settled(samples, guess_for(start, best.marks, best.lag), False, best.marks, best.lag)
    return [
        LaggedAscent(weights[place] / total, lags[place], _again(start, settings, tried[place])) for place in likely
    ]


def _tried(start: FitStart, found: FittedCurve, marks: Marks, lags: Sequence[Lag], static: float) -> list[Burnout]:
    """Burnout for each lag, shortest first, until two in a row are far less probable than the best one."""
    every: list[Burnout] = []
    for lag in lags:
        every.append(likeliest_burnout(start, found, marks, lag, static))
        bar = max(one.evidence for one in every) - _MAX_EVIDENCE_LOSS
        if all(one.evidence < bar for one in every[-2:]):
            break
    return every


def _likelier(every: Sequence[Burnout], others: Sequence[Burnout]) -> list[Burnout]:
    """The more probable of two burnouts for each lag; a lag that only one of two lists has is kept."""
    pairs = zip_longest(every, others)
    return [max((one for one in pair if one is not None), key=lambda one: one.evidence) for pair in pairs]


def _again(start: FitStart, found: FittedCurve, burnout: Burnout) -> Ascent:
    """The curve for a burnout and a lag, with known settings."""
    guess = guess_for(start, burnout.marks, burnout.lag)
    curve = found.again(start.samples, guess, burnout.marks, burnout.lag)
    drawn = _drawn(start.samples, guess, curve, False, burnout.sd, burnout.lag)
    return replace(drawn, burnout=burnout if start.samples.is_barometric else None)


def _dip(track: Heights, seen: Outline, lift: float | None) -> Flags:
    """Samples of a climb in which the rocket appears to fall: shocks near the speed of sound, or a charge."""
    climb = np.flatnonzero((track.time > (lift if lift is not None else -np.inf)) & (track.time < seen.top - 1))
    low = np.zeros(track.time.size, bool)
    if climb.size:
        height = track.height[climb]
        fallen = np.maximum.accumulate(height) - height > max(12 * track.noise, 5.0)
        first = np.searchsorted(track.time, track.time[climb[fallen]] - _MARGIN)
        slow = max(seen.top - _SHOCK_FREE_TIME, (seen.fastest + seen.top) / 2)
        lasts = np.where(track.time[climb[fallen]] > slow, _GAS_DURATION, _MARGIN)
        last = np.searchsorted(track.time, track.time[climb[fallen]] + lasts)
        edges = np.zeros(track.time.size + 1)
        np.add.at(edges, first, 1)
        np.add.at(edges, last, -1)
        low = np.cumsum(edges[:-1]) > 0
    return low


def _drawn(samples: Samples, guess: Guess, found: FittedCurve, fused: bool, spread: float, lag: float = 0.0) -> Ascent:
    """The curve (guess plus correction) and draws of it."""
    grid = samples.grid
    knots = grid.time
    coefficients = found.curve.draws(DRAWS, np.random.default_rng(0))
    shapes = [unlagged(grid, knots, order, lag) for order in range(3)]
    mean = [apply(rows, found.curve.mean) for rows in shapes]
    drawn = [apply(rows, coefficients) for rows in shapes]
    return Ascent(
        knots,
        guess.height + mean[0],
        guess.speed + mean[1],
        guess.acceleration + mean[2],
        guess.height + drawn[0],
        guess.speed + drawn[1],
        guess.acceleration + drawn[2],
        found.noise,
        spread,
        fused,
        _resolution(samples, found, lag),
    )


def _resolution(samples: Samples, found: FittedCurve, lag: float) -> float:
    """Width of the uniform window over which the fitted acceleration is effectively averaged. [s]

    With process noise q of the acceleration and heights of spectral density r and a first-order lag T, a curve passes
    the fraction 1 / (1 + w^6 (1 + (w T)^2) r/q) of an acceleration of frequency w. The window has width 3.79 / w at the
    w where this fraction is one half: there a uniform window passes half as well.
    """
    own = samples.is_own
    density = float(np.median(found.variance[own])) * median_step(samples.time[own])
    half = 0.0
    for _ in range(_ROUNDS):
        half = float((found.thrust / density / (1 + (half * lag) ** 2)) ** (1 / 6))
    return 3.79 / half
