"""Check the lift-off that the first heights show against the whole climb: in a hard boost they may disagree.

Static ports that are off by a fraction s of the dynamic pressure lower heights by s v²/2g. In a boost with constant
acceleration a, that is s a/g of the height itself: at 25 g and s = 0.04 heights remain constant until burnout and then
appear to jump. So lift-off, burnout, the coast and s are fitted together, with the spread of s between rockets as a
prior.
"""

from dataclasses import dataclass, replace
from math import erf, sqrt

import numpy as np

from fieldkit.analysis.ballistic import Coast, coast, fitted_coast
from fieldkit.analysis.channels import Heights
from fieldkit.analysis.optimize import least_soft_squares
from fieldkit.analysis.phases import Outline
from fieldkit.analysis.process_noise import SPEED_OF_SOUND, STATIC_SD
from fieldkit.analysis.records import Event, Figure
from fieldkit.physics.standard_atmosphere import GRAVITY
from fieldkit.shapes import Array, Float

_HARD_BOOST = 0.25 / STATIC_SD * GRAVITY
"""Mean boost acceleration at which a typical static port error hides a quarter of the height. [m/s^2]"""
_PAD_TIME, _COAST_TIME, _TOP_MARGIN = 4.0, 6.0, 0.3
"""Range of the fit: time before the first rise, time after burnout, and margin before the very top. [s]"""
BOOST_SHAPE, BOOST_SHAPE_SD = 0.56, 0.05
"""Height at burnout as a fraction of burnout speed times burn time, by thrust alone: mean and standard deviation over
the catalog, each impulse class weighted equally (a test recomputes them). [1]"""
_BURNOUT_SD = 0.4
"""Standard deviation of the burnout time from the outline of the heights. [s]"""
_MODEL_ERROR, _MIN_ERROR = 0.006, 0.2
"""Error of this climb model, as a fraction of v²/2g [1] and at least [m]."""
_SOUND_MARGIN, _SHOCK_FACTOR = 0.15, 10.0
"""Range around the speed of sound, as a fraction of it, and the factor by which errors of heights grow there. [1]"""
_MAX_SAMPLES, _MIN_SAMPLES, _ROUNDS = 300, 20, 16
_LEAD_STEP, _MOST_LEAD, _LEAST_CHANCE = 0.15, 3.0, 6.0
"""Step and longest of the times before the first rise at which lift-off is tried [s], and how much less probable than
the best one, as a logarithm, two in a row are if longer ones are not tried [1]."""
_USUAL_CHANGE = np.array([1.0, 10.0, 0.3, 0.3, 0.3, STATIC_SD])
_LIMITS = np.array([8.0, 1500.0, 2.0, 1.5, _LEAD_STEP / 2, 4 * STATIC_SD])
"""Limits of the change in time [s] and height [m] of apogee, logarithm of drag, times of burnout and lift-off [s], and
error of ports [1]."""
_SPEED_MODEL, _DRAG_RISE_SPEED, _MOST_LATER = 0.08, 0.7 * SPEED_OF_SOUND, 0.45
"""Relative error of the speed of this climb model, the root mean square over 60 flights of the recorder bench above 8 g
with ports of -0.06 to 0.06, most of it from the shape of the thrust [1]; the speed above which drag grows faster than
v² [m/s], and by how much the fitted lift-off may be later than the known one [s]."""
BURN_TIME, BURN_SPREAD = 2.14, 0.83
"""Burn time of the motors of the catalog, each impulse class weighted equally: geometric mean [s] and standard
deviation of the logarithm [1] (a test recomputes them)."""
_LONGEST_LEAD, _LEAST_RISE, _NOISES = 3.0, 2.0, 4.0
"""Longest time for which ports hide a boost [s]; smallest rise that shows, in meters and in standard deviations of a
sample."""


@dataclass(frozen=True, slots=True, eq=False)
class _Climb:
    """Samples of a climb: times [s], heights above the pad [m], the error of each [m], and the time of the fastest
    climb [s]."""

    time: Float[Array, "time"]
    height: Float[Array, "time"]
    sd: Float[Array, "time"]
    fastest: float

    def misfit(self, values: Float[Array, "six"]) -> Float[Array, "_"]:
        """Deviation of each sample from a climb, followed by the priors of thrust, ports and burnout, in standard
        deviations. [1]"""
        apogee, top, drag, burnout, lift, static = values.tolist()
        burn = max(burnout - lift, 0.05)
        free = coast(apogee, top, float(np.exp(drag)), burnout, apogee)
        height, speed = (float(np.interp(burnout, free.time, channel)) for channel in (free.height, free.speed))
        first, jerk = _push(height, speed, burn)
        since, boost = np.clip(self.time - lift, 0, burn), self.time < burnout
        way = np.where(boost, (first + jerk * since / 3) * since**2 / 2, np.interp(self.time, free.time, free.height))
        fast = np.where(boost, (first + jerk * since / 2) * since, np.interp(self.time, free.time, free.speed))
        away = (way - static * fast * np.abs(fast) / (2 * GRAVITY) - self.height) / self.sd
        uneven = (height / max(speed * burn, 1.0) - BOOST_SHAPE) / BOOST_SHAPE_SD
        return np.append(away, (uneven, static / STATIC_SD, (burnout - self.fastest) / _BURNOUT_SD))

    def cost(self, values: Float[Array, "six"]) -> float:
        """Negative log probability of a climb, with the burn times of the catalog as a prior, up to a constant. [1]"""
        burn = max(float(values[3] - values[4]), 0.05)
        usual = (np.log(burn / BURN_TIME) / BURN_SPREAD) ** 2 / 2
        return float(np.sqrt(1 + self.misfit(values) ** 2).sum() + usual)


def hidden_lead(speed: float, burn: float, noise: float, sd: float) -> float:
    """Root mean square of the time by which a lift-off may precede the first rise of barometric heights. [s]

    `speed` is that at burnout [m/s]; `burn` the time to it from the first rise, and `sd` the error of that moment [s];
    `noise` the error of a sample [m].

    Derivation: Bayes' theorem. If lift-off is earlier by t, the motor burns for burn + t, which has the spread of the
    catalog as its prior, and the mean acceleration is a = speed / (burn + t). It is hidden if the rise that ports
    leave, (1 - s a/g) a t²/2, does not show and is at most half of the rise; the probability of that is the prior of s
    between the two limits. What hides the rise of an even thrust hides most of it: t is at least `burn`.
    """
    leads = burn + np.linspace(0.0, _LONGEST_LEAD, 301)
    mean = speed / (burn + leads)
    prior = np.exp(-((np.log((burn + leads) / BURN_TIME) / BURN_SPREAD) ** 2) / 2) / (burn + leads)
    rise = max(_LEAST_RISE, _NOISES * noise) / np.maximum(mean * leads**2 / 2, 1e-9)
    hides, width = GRAVITY / mean / STATIC_SD, np.minimum(rise, 0.5)
    weight = prior * (_below(hides * (1 + width)) - _below(hides * (1 - width))) * (leads[1] - leads[0])
    shown = float(np.exp(-((np.log(burn / BURN_TIME) / BURN_SPREAD) ** 2) / 2)) / burn
    total = float(weight.sum()) + shown * sd * float(np.sqrt(2 * np.pi))
    return float(np.sqrt(weight @ leads**2 / total)) if total > 0 else 0.0


def _below(deviates: Float[Array, "_"]) -> Float[Array, "_"]:
    """The standard normal distribution function; importing scipy's takes longer than measuring a log. [1]"""
    return np.array([(1 + erf(one / sqrt(2))) / 2 for one in deviates.tolist()])


def checked_by_climb(corner: Event, track: Heights, seen: Outline) -> Event:
    """A lift-off from the first rise of the heights, moved to where the whole of a hard climb has it on average.

    Derivation: its time before the rise has the marginal likelihood of the climb, by the most probable other values for
    each, with the burn times of the catalog as a prior. Such a climb has no shocks near the speed of sound: if there
    may be some, the lift-off is kept, and its error includes the difference.
    """
    if seen.climbs < _HARD_BOOST * max(seen.fastest - corner.time, 0.0):
        return corner
    found = _leads(corner, track, seen)
    if found is None:
        return corner
    leads, weight, _ = found
    mean = 0.0 if seen.transonic else float(weight @ leads)
    return replace(corner, time=corner.time - mean, sd=float(np.sqrt(corner.sd**2 + weight @ (leads - mean) ** 2)))


def speed_by_climb(lift: Event, track: Heights, seen: Outline) -> Figure | None:
    """Top speed of a hard boost by the whole of its climb, from a known lift-off; None if ports hide little of it, if
    shocks near the speed of sound disturb it, or if the log contains too little of it. [m/s]

    The curve of a boost by heights alone has the error of static ports. Here lift-off, burnout and the height there
    show it. Derivation: thrust gives the height at burnout by the speed and the burn time (`BOOST_SHAPE`), heights lack
    s v²/2g of that, so they show s to 0.05 t 2g/v, five times better than its prior; and the coast, which ports that
    are off by s make faster by s times its deceleration in g, is corrected for it.
    """
    if seen.transonic or seen.climbs < _HARD_BOOST * max(seen.fastest - lift.time, 0.0):
        return None
    latest = replace(lift, time=lift.time + min(2 * lift.sd, _MOST_LATER))
    found = _leads(latest, track, seen)
    if found is None:
        return None
    _, weight, speeds = found
    mean = float(weight @ speeds)
    if mean > _DRAG_RISE_SPEED:
        return None
    return Figure(mean, float(np.hypot(np.sqrt(weight @ (speeds - mean) ** 2), _SPEED_MODEL * mean)), track.source)


def _push(height: float, speed: float, burn: float) -> tuple[float, float]:
    """Initial acceleration [m/s^2] and jerk [m/s^3] of a linearly changing thrust, given burnout height, speed and
    time."""
    first = 6 * height / burn**2 - 2 * speed / burn
    return first, (2 * speed / burn - 2 * first) / burn


def _leads(
    corner: Event, track: Heights, seen: Outline
) -> tuple[Float[Array, "lead"], Float[Array, "lead"], Float[Array, "lead"]] | None:
    """Times by which lift-off may precede the first rise, not before the log begins [s], with their probabilities by
    the whole climb, and the speeds at burnout [m/s]; None if the log contains too little of it."""
    inside = (track.time > corner.time - _PAD_TIME) & (
        track.time < min(seen.top, seen.fastest + _COAST_TIME) - _TOP_MARGIN
    )
    every = max(1, int(inside.sum()) // _MAX_SAMPLES)
    time, height = track.time[inside][::every], track.height[inside][::every] - seen.pad
    free = fitted_coast(track.time, track.height - seen.pad, seen.fastest, seen.fastest, seen.top - _TOP_MARGIN)
    if free is None or time.size < _MIN_SAMPLES:
        return None
    climb = _Climb(time, height, _errors(time, free, corner, seen, track.noise), seen.fastest)
    top = int(np.argmax(free.height))
    start = np.array([free.time[top], free.height[top], np.log(1e-3), seen.fastest, corner.time, 0.0])
    starts = [start, start + 2 * STATIC_SD * np.eye(6)[5], start - 2 * STATIC_SD * np.eye(6)[5]]
    found, costs, speeds = start, list[float](), list[float]()
    recorded = max(corner.time - float(track.time[0]), 0.0)
    leads = np.arange(0.0, min(_MOST_LEAD, recorded + _LEAD_STEP), _LEAD_STEP)
    for lead in leads.tolist():
        known = (*starts[:2], found) if costs else starts  # the later ones begin at the one before, too
        here = [np.where(np.arange(6) == 4, corner.time - lead, values) for values in known]
        tried = [least_soft_squares(climb.misfit, one, _USUAL_CHANGE, _LIMITS, _ROUNDS) for one in here]
        found = min(tried, key=climb.cost)
        costs.append(climb.cost(found))
        speeds.append(_speed_at_burnout(found))
        if min(costs[-2:]) > min(costs) + _LEAST_CHANCE:
            break
    weight = np.exp(min(costs) - np.array(costs))
    return leads[: weight.size], weight / weight.sum(), np.array(speeds)


def _speed_at_burnout(values: Float[Array, "six"]) -> float:
    """Speed of a climb at its burnout. [m/s]"""
    apogee, top, drag, burnout, *_ = values.tolist()
    free = coast(apogee, top, float(np.exp(drag)), burnout, apogee)
    return float(np.interp(burnout, free.time, free.speed))


def _errors(
    time: Float[Array, "time"], free: Coast, corner: Event, seen: Outline, noise: float
) -> Float[Array, "time"]:
    """Error of each sample: noise, airframe pressure at high speed, and the error of this model. [m]"""
    burn = max(seen.fastest - corner.time, 0.3)
    gained = np.clip((time - corner.time) / burn, 0, 1) * np.interp(seen.fastest, free.time, free.speed)
    speed = np.where(time < seen.fastest, gained, np.interp(time, free.time, free.speed))
    shocked = np.where(np.abs(speed / SPEED_OF_SOUND - 1) < _SOUND_MARGIN, _SHOCK_FACTOR, 1.0)
    return np.asarray(np.hypot(noise, _MODEL_ERROR * shocked * speed**2 / (2 * GRAVITY)) + _MIN_ERROR)
