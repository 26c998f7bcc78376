"""The lag of heights behind the flight: a filter in the logger, or vents too small for the bay.

A lag cannot be seen in a coast, which it only shifts in time. It shows at lift-off and burnout: if the heights are
corrected for too small a lag, thrust seems to fade over seconds after burnout, and for too large a lag, the drag seems
to be much greater just after burnout than later. So each lag has a likelihood (`fieldkit.analysis.ascent`), and the
figures are averaged over the lags. Where shocks or gaps hide it, its prior widens the standard deviations: the heights
h(t) = H - g t^2/2 around an apogee H at t = 0, behind a first-order lag T, are H - g (t - T)^2/2 - g T^2/2. So they are
late by T, and their apogee is low by g T^2/2.

A filter in the logger also takes the noise of its sensor away. At rest the steps from one height to the next have the
lag-one autocorrelation -1/2 if that noise is as usual, and -(1 - exp(-s/T))/2 behind a first-order filter T at a time
step s. So steps that are hardly correlated make lags more probable. They also show that the noise is not independent
from sample to sample, and then the likelihood of a lag counts for as much less.

Source: the BMP280 datasheet (Bosch, BST-BMP280-DS001, 3.3.3), whose filters have time constants of 0.06 to 0.6 s at 25
samples per second. A bay with one port of 1/4 inch per 100 cubic inches, the rule of altimeter manuals, has far less:
by Bernoulli's equation its heights are low by w^2 / 2g at the speed w = v V / (A H) of the air in the port, with V/A =
52 m and H = 12 km, the scale height of adiabatic changes. That is 0.1 ms at v = 100 m/s, and it grows as 1/A^2.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from fieldkit.analysis.boost_length import burn_time, mean_acceleration
from fieldkit.analysis.channels import TYPICAL_LAG, Heights
from fieldkit.analysis.liftoff import earlier_liftoffs
from fieldkit.analysis.phases import Outline
from fieldkit.analysis.possible import known_well, possible
from fieldkit.analysis.records import Event, Figure, Recorded
from fieldkit.analysis.robust_statistics import mad_sd
from fieldkit.physics.standard_atmosphere import GRAVITY
from fieldkit.shapes import Array, Float

_USUAL_LAGS = (0.0, 0.06, 0.12, 0.2, 0.28, 0.36, 0.45, 0.55, 0.7)
"""Lags of altimeters. [s]"""
_LAGS = (*_USUAL_LAGS, 0.85, 1.05, 1.3, 1.6)
"""Lags to try: software of flyers has slower filters than altimeters. [s]"""
_REST_MARGIN, _REST_SEEN, _AT_REST = 0.3, 2.0, (8.0, 1.0)
"""Time before lift-off that does not count as rest, and time at the end of a log that shows where it rests [s]; how far
heights are from there, in their noise [1] or, if more, in m."""
_MIN_STEPS, _MAX_STEP_TIME = 30, 0.2
"""Fewest steps at rest that show noise [1], and the largest time between samples for which motion does not. [s]"""
_MIN_SIZES = 6
"""Fewest different sizes of steps that show noise: with fewer, the resolution of the heights hides it. [1]"""
_FILTER_PROBABILITY = 1 / 3
"""Probability that a lag is of a filter in the logger, of any order of magnitude, rather than of small vents, which
leave the noise of the sensor. [1]"""
_NOISE_PARTS = np.linspace(0.02, 1.0, 50)
"""Parts of the sensor's noise in the variance of the steps without a filter; their probability is proportional to them:
the rest is from gusts. [1]"""


@dataclass(frozen=True, slots=True)
class Lag:
    """A lag that heights may have [s], its prior probability [1], and lift-off if they have it.

    `counts` is the number of independent samples that one height is worth. [1]
    """

    lag: float
    prior: float
    lift: Event | None = None
    counts: float = 1.0


MAX_HEIGHT_GAP = 1.3
"""Largest spacing of heights that still show a boost: beyond it a receiver lost its satellites, or a radio its rocket.
Once per second is enough, because the coast that follows shows how fast it began. [s]"""
NO_LAG = Lag(0.0, 1.0)
"""Heights without a lag."""


def possible_lags(track: Heights, seen: Outline, lift: Event | None) -> list[Lag]:
    """The lags that heights may have if only they show the boost; shocks near the speed of sound or a gap hide them."""
    if lift is None or not track.is_barometric or seen.transonic or burnout_is_hidden(track, seen):
        return [replace(NO_LAG, lift=lift)]
    lifts = earlier_liftoffs(lift, track, seen, _LAGS)
    priors, counts = _by_noise(track, lift.time, _prior(_LAGS))
    return [Lag(*one, counts) for one in zip(_LAGS, priors.tolist(), lifts, strict=True)]


def _by_noise(track: Heights, lift: float, prior: Float[Array, "lag"]) -> tuple[Float[Array, "lag"], float]:
    """Probabilities of the lags given the noise of heights at rest, and the number of independent samples that one
    height is worth. [1]"""
    steps, step_time = _steps_at_rest(track, lift)
    spread = mad_sd(steps)
    if steps.size < _MIN_STEPS or step_time > _MAX_STEP_TIME or spread == 0:
        return prior, 1.0
    if np.unique(np.round(np.abs(steps) / spread, 1)).size < _MIN_SIZES:
        return prior, 1.0
    steps, sd = np.clip(steps, -5 * spread, 5 * spread), float(1 / np.sqrt(steps.size))
    correlation = float(np.clip(np.mean(steps[1:] * steps[:-1]) / np.mean(steps**2), -0.5, 0.0))
    by_sensor = np.exp(-(((correlation + _NOISE_PARTS / 2) / sd) ** 2) / 2) @ _NOISE_PARTS / _NOISE_PARTS.sum()
    expected = -(1 - np.exp(-step_time / np.maximum(_LAGS, 1e-3))) / 2
    by_filter = np.exp(-(((correlation - expected) / sd) ** 2) / 2)
    filters = np.append(0.0, np.gradient(np.log(_LAGS[1:])))
    filters *= _FILTER_PROBABILITY / filters.sum()
    found = filters * by_filter + (1 - _FILTER_PROBABILITY) * prior * by_sensor
    part = min(2 * (sd - correlation), 1.0)
    return found / found.sum(), part / (2 - part)


def _steps_at_rest(track: Heights, lift: float) -> tuple[Float[Array, "step"], float]:
    """Steps between different heights on the pad, and at the end of the log if it rests there [m], and the usual time
    between such heights [s].

    A barometer that is read less often than its log is written repeats a height.
    """
    time, height = track.time, track.height
    level = float(np.median(height[time > time[-1] - _REST_SEEN]))
    away = np.flatnonzero(np.abs(height - level) > max(_AT_REST[0] * track.noise, _AT_REST[1]))
    landed = int(away[-1]) + 1 if away.size else height.size
    steps, times = [np.empty(0)], [np.empty(0)]
    for part in (slice(0, int(np.searchsorted(time, lift - _REST_MARGIN))), slice(landed, None)):
        changes = np.flatnonzero(np.diff(height[part], prepend=np.nan) != 0)
        if changes.size > 1:
            found = np.diff(height[part][changes])
            steps.append(found - np.median(found))
            times.append(np.diff(time[part][changes]))
    between = np.concatenate(times)
    return np.concatenate(steps), float(np.median(between)) if between.size else np.inf


def _prior(lags: tuple[float, ...]) -> Float[Array, "lag"]:
    """Prior probability of each of some lags [s]. [1]"""
    edges = np.append((np.array(lags[1:]) + lags[:-1]) / 2, np.inf)
    return np.diff(np.arctan(edges / TYPICAL_LAG) * 2 / np.pi, prepend=0.0)


def widened_by_unseen_lag(found: Recorded) -> Recorded:
    """Results from heights whose lag is unknown: apogee and landing may be late, and the apogee low. A coast may be
    long if another sensor shows the burnout; one seen in the heights is as late as the apogee."""
    lag, prior = np.array(_USUAL_LAGS), _prior(_USUAL_LAGS)
    late, low = float(np.sqrt(prior @ lag**2)), GRAVITY / 2 * float(np.sqrt(prior @ lag**4))
    figures, events = dict(found.figures), dict(found.events)
    times = ["time_to_apogee", "apogee_to_eject", "duration"]
    if "coast_to_apogee" in figures and "apogee" in events:
        times += ["coast_to_apogee"] * (figures["coast_to_apogee"].source != events["apogee"].source)
    for name, error in {"apogee": low, **dict.fromkeys(times, late)}.items():
        if name in figures:
            figures[name] = replace(figures[name], sd=float(np.hypot(figures[name].sd, error)))
    for name in events.keys() & {"apogee", "landing"}:
        events[name] = replace(events[name], sd=float(np.hypot(events[name].sd, late)))
    return replace(found, figures=figures, events=events)


def widened_by_filter(found: Recorded, lag: float) -> Recorded:
    """Results from heights behind a filter with a time constant [s], for which they are not corrected: what follows the
    boost is late, and the apogee low."""
    figures, events = dict(found.figures), dict(found.events)
    times = ("time_to_apogee", "coast_to_apogee", "apogee_to_eject", "duration")
    errors = {"apogee": GRAVITY * lag**2 / 2, **dict.fromkeys(times, lag)}
    if {"descent_speed", "duration", "time_to_apogee"} <= figures.keys():
        speed, falls = figures["descent_speed"].value, figures["duration"].value - figures["time_to_apogee"].value
        errors |= {"descent_speed": speed * lag / max(falls, lag), "eject_altitude": speed * lag}
    for name in errors.keys() & figures.keys():
        figures[name] = replace(figures[name], sd=float(np.hypot(figures[name].sd, errors[name])))
    for name in events.keys() & {"apogee", "landing"}:
        events[name] = replace(events[name], sd=float(np.hypot(events[name].sd, lag)))
    return replace(found, figures=figures, events=events)


def burnout_is_hidden(track: Heights, seen: Outline) -> bool:
    """Whether samples are missing between lift-off and the time when the heights would have followed a burnout."""
    begin = seen.lift if seen.lift is not None else seen.fastest
    first, last = np.searchsorted(track.time, (begin, seen.fastest + _USUAL_LAGS[-1]))
    return float(np.diff(track.time[max(first - 1, 0) : last + 1]).max(initial=0.0)) > MAX_HEIGHT_GAP


def averaged(every: Sequence[Recorded], weights: Sequence[float], time: Float[Array, "time"]) -> Recorded:
    """The most probable of some measurements of one flight, with figures and events averaged over all of them.

    `time` are the times of the samples that show the boost. [s]
    """
    best, each = every[int(np.argmax(weights))], [_with_few_samples(one, time) for one in every]
    figures = {name: _mean([one.get(name) for one in each], weights) for name in best.figures}
    events = {name: _moment([one.events.get(name) for one in every], weights) for name in best.events}
    if {"avg_accel", "top_speed", "burn_time"} <= figures.keys():
        known_in = [(one, w) for one, w in zip(each, weights, strict=True) if {"top_speed", "burn_time"} <= one.keys()]
        speeds, burns = ([one[name] for one, _ in known_in] for name in ("top_speed", "burn_time"))
        value = figures["top_speed"].value / figures["burn_time"].value
        mean = mean_acceleration(value, speeds, burns, [weight for _, weight in known_in])
        figures["avg_accel"] = replace(mean, source=figures["avg_accel"].source)
    known, impossible = possible(figures)
    known, unknown = known_well(known)
    return replace(best, figures=known, events=events, notes=(*best.notes, *impossible, *unknown))


def _with_few_samples(found: Recorded, time: Float[Array, "time"]) -> dict[str, Figure]:
    """Figures with an error of the burn time that holds for samples at few times [s]."""
    figures = dict(found.figures)
    if "burn_time" in figures:
        figures["burn_time"] = burn_time(figures["burn_time"], found.events["liftoff"], found.events["burnout"], time)
    return figures


def _mean(every: Sequence[Figure | None], weights: Sequence[float]) -> Figure:
    """Mean and standard deviation of a mixture of figures; those that lack it do not count."""
    known = [(one, weight) for one, weight in zip(every, weights, strict=True) if one is not None and weight > 0]
    probability = np.array([weight for _, weight in known]) / sum(weight for _, weight in known)
    value, sd = (np.array([getattr(one, part) for one, _ in known]) for part in ("value", "sd"))
    mean = float(probability @ value)
    source = max(known, key=lambda pair: pair[1])[0].source
    return Figure(mean, float(np.sqrt(probability @ (sd**2 + (value - mean) ** 2))), source)


def _moment(every: Sequence[Event | None], weights: Sequence[float]) -> Event:
    """Mean and standard deviation of a mixture of events."""
    found = _mean([Figure(one.time, one.sd, one.source) if one else None for one in every], weights)
    return Event(found.value, found.sd, found.source)
