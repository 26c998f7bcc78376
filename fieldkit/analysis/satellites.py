"""Satellite data of a climb with barometric heights: satellite heights and vertical speeds on the same scale.

A receiver measures true heights above some level, while an altimeter assumes the standard atmosphere, and both have a
delay. So a scale, a zero and a delay are fitted between the two where both are trusted, away from the speed of sound
and from gaps. What remains is the receiver's error. Its correlation time determines the weight of one sample: small
compared with a barometer in quiet air, and full where shocks make the barometer useless.

Derivation: an error k of dynamic pressure is, by the hydrostatic equation, an error k v²/2g of height.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from fieldkit.analysis.ascent import Ascent
from fieldkit.analysis.channels import CHANNEL_TITLES, MIN_SAMPLES, Heights
from fieldkit.analysis.phases import Outline
from fieldkit.analysis.process_noise import SPEED_OF_SOUND
from fieldkit.analysis.records import Sightings
from fieldkit.analysis.robust_statistics import lag_one, mad_sd, median_step
from fieldkit.flight import Series
from fieldkit.physics.standard_atmosphere import GRAVITY
from fieldkit.shapes import Array, Flags, Float

SOURCE = CHANNEL_TITLES["gps_altitude_msl"]
_TRUSTED_MACH = 0.75
"""Fraction of the speed of sound up to which a barometer is trusted when satellite data exist. [1]"""
_MAX_HOLE = 1.5
"""Longest gap between samples in which a barometer is trusted. [s]"""
_PRIOR = (0.06, 5.0, 0.04)
"""Prior standard deviations: of the scale, for a day's temperature [1], of the zero [m], and of the airframe's pressure
error [1]."""
_DELAY, _DELAYS = 0.4, np.arange(-0.2, 1.51, 0.05).tolist()
"""Standard deviation of a receiver's delay, and the delays to try. [s]"""
_LEAST_NOISE = 0.5
"""Smallest standard deviation of the residuals. [m]"""
_MAX_SCALE, _MAX_SD, _MAX_SPEED_SD = 0.18, 30.0, 5.0
"""Limits beyond which the two do not belong to one flight: scale [1], residuals of heights [m] and of speeds [m/s]."""
_DELAY_SD, _SPEED_SCALE_SD = 0.1, 0.03
"""Variation of a delay within a flight [s], and relative error of the scale of a speed [1]."""
_UNDER_THRUST = 3.0
"""Factor by which a receiver's error grows under thrust. [1]"""
_SIGNIFICANT_SDS = 2.0
"""Number of standard deviations from zero at which a pressure error is significant. [1]"""
_STUDENT_DOF, _ROUNDS = 4.0, 6
_FAST_COAST, _MIN_FAST = 0.3, 4
"""Fraction of a coast in which the speed is close to that at burnout, and the fewest samples needed there. [1]"""
_FASTEST_COMPARED = 1.5 * SPEED_OF_SOUND
"""Highest speed that is close enough to the speeds at which the two were compared. [m/s]"""
_SLOPE_REACH = 1.0
"""Time to both sides over which the barometer's speed is computed. [s]"""
_PAD_TIME = 30.0
"""Time on the pad over which a receiver's zero is computed. [s]"""


@dataclass(frozen=True, slots=True, eq=False)
class _Receiver:
    """Channels of a receiver: times [s], heights [m] and speeds [m/s], nan if it has none."""

    time: Float[Array, "sample"]
    height: Float[Array, "sample"]
    speed: Float[Array, "sample"]


@dataclass(frozen=True, slots=True, eq=False)
class _Alignment:
    """Alignment of a receiver's heights with the barometer.

    Cost, scale [1] and zero [m]; the fraction of the dynamic pressure by which the airframe's pressure is too high,
    with its standard deviation [1], and that of the scale [1]; the receiver's times without its delay [s], the
    barometer's speeds at those times [m/s], which samples were compared, and the residuals [m].
    """

    cost: float
    scale: float
    zero: float
    static: float
    static_sd: float
    scale_sd: float
    time: Float[Array, "sample"]
    climbs: Float[Array, "sample"]
    quiet: Flags
    residual: Float[Array, "compared"]


def sightings(clocks: Sequence[Series], track: Heights, seen: Outline) -> Sightings | None:
    """Satellite data that complement heights from another sensor; None if unusable or of another flight."""
    receiver = _receiver(clocks)
    if receiver is None or track.source == SOURCE:
        return None
    pad = _pad(receiver, seen)
    height = receiver.height - pad
    every = [_aligned(track, seen, receiver.time - late, height, late) for late in _DELAYS]
    found = min(every, key=lambda one: one.cost)
    time, residual = found.time, found.residual
    if residual.size < MIN_SAMPLES:
        return None
    sd = max(float(np.sqrt(np.mean(np.clip(residual, -4 * mad_sd(residual), 4 * mad_sd(residual)) ** 2))), track.noise)
    if abs(found.scale - 1) > _MAX_SCALE or sd > _MAX_SD:
        return None
    climbs = found.climbs
    pushed = np.where((time > _begin(seen)) & (time < seen.fastest + 0.5), _UNDER_THRUST, 1.0)
    static, delay_sd = _static_error_over_delays(every, found)
    heights_sd = np.hypot(
        _correlation_factor(residual) * sd * pushed, np.hypot(_DELAY_SD, delay_sd) * np.abs(climbs) * pushed
    )
    parts = [(time, found.scale * height + found.zero, 0, heights_sd**2)]
    speeds = _speeds(receiver, found, pushed)
    if speeds is not None:
        there = np.isfinite(receiver.speed)
        parts.append((time[there], found.scale * receiver.speed[there], 1, speeds[there]))
    return Sightings(
        np.concatenate([part[0] for part in parts]),
        np.concatenate([part[1] for part in parts]),
        np.concatenate([np.full(part[0].size, part[2]) for part in parts]),
        np.concatenate([part[3] for part in parts]),
        static,
        (found.scale, found.scale_sd),
    )


def _static_error_over_delays(every: Sequence[_Alignment], best: _Alignment) -> tuple[float, float]:
    """The fraction of the dynamic pressure by which the airframe's pressure is off [1], 0 if the delay could explain
    the observations, and the standard deviation of the delay [s]."""
    fitted = [(delay, one) for delay, one in zip(_DELAYS, every, strict=True) if np.isfinite(one.cost)]
    costs = np.array([one.cost for _, one in fitted])
    weight = np.exp(-(costs - best.cost) / _correlation_factor(best.residual) ** 2)
    weight /= weight.sum()
    delays, static = np.array([delay for delay, _ in fitted]), np.array([one.static for _, one in fitted])
    mean = float(weight @ static)
    within = weight @ np.array([one.static_sd**2 for _, one in fitted])
    sd = float(np.sqrt(within + weight @ (static - mean) ** 2))
    delay_sd = float(np.sqrt(weight @ (delays - weight @ delays) ** 2))
    return (best.static if abs(mean) > _SIGNIFICANT_SDS * sd else 0.0), delay_sd


def _receiver(clocks: Sequence[Series]) -> _Receiver | None:
    """The receiver of a log; None if it has none or too few samples."""
    for series in clocks:
        height = series.gps_altitude_msl
        if height is None:
            continue
        there = np.isfinite(height) & np.isfinite(series.time)
        there &= np.concatenate(([True], np.diff(series.time) > 0))
        speed = series.gps_speed if series.gps_speed is not None else np.full(height.size, np.nan)
        time, height, speed = series.time[there], height[there], speed[there]
        is_new = np.concatenate(([True], (np.diff(height) != 0) | (np.diff(time) > _MAX_HOLE)))  # no repeated fix
        if is_new.sum() >= MIN_SAMPLES:
            return _Receiver(time[is_new], height[is_new], speed[is_new])
    return None


def _begin(seen: Outline) -> float:
    return seen.lift if seen.lift is not None else seen.fastest - 5


def _pad(receiver: _Receiver, seen: Outline) -> float:
    """The receiver's height on the pad, otherwise its first height. [m]"""
    begin = _begin(seen)
    waits = receiver.height[(receiver.time < begin) & (receiver.time > begin - _PAD_TIME)]
    return float(np.median(waits)) if waits.size else float(receiver.height[0])


def _barometer(
    track: Heights, seen: Outline, time: Float[Array, "sample"]
) -> tuple[Float[Array, "sample"], Float[Array, "sample"]]:
    """The barometer's heights above the pad and its speeds at some times. [m], [m/s]"""
    calm = seen.calm - seen.pad
    before, at, after = (np.interp(time + away, track.time, calm) for away in (-_SLOPE_REACH, 0.0, _SLOPE_REACH))
    return at, np.asarray((after - before) / (2 * _SLOPE_REACH))


def _is_quiet(track: Heights, seen: Outline, time: Float[Array, "sample"], climbs: Float[Array, "sample"]) -> Flags:
    """Samples at which a barometer is trusted: within its log, slow enough, not in a gap, and not under thrust."""
    place = np.clip(np.searchsorted(track.time, time), 1, track.time.size - 1)
    has_samples = track.time[place] - track.time[place - 1] < max(_MAX_HOLE, 3 * median_step(track.time))
    inside = (time > track.time[0]) & (time < track.time[-1])
    pushed = (time > _begin(seen) - 0.5) & (time < seen.fastest + 1)
    return np.asarray(has_samples & inside & ~pushed & (np.abs(climbs) < _TRUSTED_MACH * SPEED_OF_SOUND))


def _aligned(
    track: Heights, seen: Outline, time: Float[Array, "sample"], height: Float[Array, "sample"], late: float
) -> _Alignment:
    """Scale and zero that map a receiver's heights to the barometer's for a given delay, fitted robustly.

    The airframe's pressure error, a fraction of the dynamic pressure that shifts heights by v²/2g, is fitted too.
    """
    calm, climbs = _barometer(track, seen, time)
    quiet = _is_quiet(track, seen, time, climbs)
    rows = np.stack([height, np.ones(time.size), climbs * np.abs(climbs) / (2 * GRAVITY)], axis=1)[quiet]
    target = (calm - height)[quiet]
    if target.size < MIN_SAMPLES:
        return _Alignment(np.inf, 1.0, 0.0, 0.0, np.inf, np.inf, time, climbs, quiet, target)
    noise, weight = max(mad_sd(np.diff(target, 2)) / np.sqrt(6), track.noise, _LEAST_NOISE), np.ones(target.size)
    prior = np.diag(1 / np.array(_PRIOR) ** 2)
    for _ in range(_ROUNDS):
        counted = rows.T * weight
        values = np.linalg.solve(counted @ rows / noise**2 + prior, counted @ target / noise**2)
        residual = np.asarray(target - rows @ values)
        weight = (_STUDENT_DOF + 1) / (_STUDENT_DOF + (residual / noise) ** 2)
    cost = (_STUDENT_DOF + 1) / 2 * np.log1p((residual / noise) ** 2 / _STUDENT_DOF).sum() + (late / _DELAY) ** 2 / 2
    spread = np.linalg.inv(counted @ rows / (noise * _correlation_factor(residual)) ** 2 + prior)
    scale_sd, static_sd = np.sqrt(np.diag(spread)[[0, 2]]).tolist()
    scale, zero, static = 1 + float(values[0]), float(values[1]), -float(values[2])
    return _Alignment(float(cost), scale, zero, static, static_sd, scale_sd, time, climbs, quiet, residual)


def _correlation_factor(residual: Float[Array, "sample"]) -> float:
    """Factor by which the standard deviation of a sample grows because its neighbors' errors are correlated. [1]"""
    correlation = lag_one(residual)
    return float(np.sqrt((1 + correlation) / (1 - correlation)))


def _speeds(receiver: _Receiver, found: _Alignment, pushed: Float[Array, "sample"]) -> Float[Array, "sample"] | None:
    """Variance of the receiver's own vertical speeds; None if it has none or they do not match this flight.
    [m^2/s^2]"""
    both = found.quiet & np.isfinite(receiver.speed)
    if both.sum() < MIN_SAMPLES:
        return None
    residual = (found.climbs - found.scale * receiver.speed)[both]
    sd = max(float(np.sqrt(np.mean(np.clip(residual, -4 * mad_sd(residual), 4 * mad_sd(residual)) ** 2))), 0.3)
    if sd > _MAX_SPEED_SD:
        return None
    return np.asarray(
        (np.hypot(_correlation_factor(residual) * sd, _SPEED_SCALE_SD * np.abs(found.climbs)) * pushed) ** 2
    )


def sighted_speed(
    sighted: Sightings | None, ascent: Ascent, fastest: float, static: float, expected: float = 0.0
) -> tuple[float, float, float]:
    """Error of a top speed from pressure [m/s], its remaining uncertainty [m/s], and the satellites' weight [1].

    The airframe's pressure error is an unknown fraction of v²/2g, which shifts the speed of the curve by about the same
    amount throughout the fast coast. The slope of satellite heights minus the curve, and the satellite speeds,
    determine that shift there, with `expected` as its prior mean and `static` as its prior standard deviation [m/s].
    """
    top_speed = float(np.interp(fastest, ascent.time, ascent.speed))
    if sighted is None or static <= 0 or top_speed > _FASTEST_COMPARED:
        return expected, static, 0.0
    top = float(ascent.time[int(np.argmax(ascent.height))])
    near = (sighted.time > fastest) & (sighted.time < fastest + _FAST_COAST * (top - fastest))
    weighted_sum, weight = expected * static**-2, static**-2
    for order, curve in enumerate((ascent.height, ascent.speed)):
        those = near & (sighted.order == order)
        if those.sum() < _MIN_FAST:
            continue
        residual = sighted.value[those] - np.interp(sighted.time[those], ascent.time, curve)
        counts = 1 / sighted.variance[those]
        since = sighted.time[those] - counts @ sighted.time[those] / counts.sum()
        leverage = since if order == 0 else np.ones(since.size)
        weighted_sum += float((counts * leverage) @ residual)
        weight += float(counts @ leverage**2)
    return weighted_sum / weight, weight**-0.5, 1 - static**-2 / weight
