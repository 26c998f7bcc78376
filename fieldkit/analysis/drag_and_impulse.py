"""What a coast says of drag and a burn of impulse: two figures that need neither the mass nor the size of the rocket.

**Drag of the coast** b [1/m]. A coast at an upward speed v climbs against gravity and drag,

    dv/dt = -g - b s(h) v²,    b = rho Cd A / (2 m),

with rho the air density at the pad, s(h) how the air thins above it, A the frontal area and m the mass without
propellant. The pad's density and the mass stay in b, so that neither is needed here, and a later correction of either
leaves b right; who knows both has Cd = 2 m b / (rho A). As g is known, b with the time and the height of apogee makes
the whole curve; these are fitted to the samples of the coast. Heights are free in scale as well, within what the air
and the airframe make of a barometer, for a coast that seems too fast or too slow throughout is not one of other drag.
If drag is not quite proportional to v², or the rocket is tilted, b is the one that slows a straight coast as much.

**Impulse of the burn** j [m/s]. Newton's law from lift-off to a moment t after burnout, m falling as propellant burns:

    j = integral of thrust / m = v(t) + g t + b integral of s v²,

with v(t) of the fitted coast and the last integral, a tenth to a fifth of the whole, over the smoothed climb. Where
burnout was does not matter. The mass that b has is a few percent less than that of a rocket that burns still, which
makes j too large by a percent at most. Who knows thrust curve and masses has the expected j without a flight.

Derivation: Newton's second law with drag rho v² Cd A / 2, as above.
"""

from dataclasses import dataclass

import numpy as np

from fieldkit.analysis.ascent import Ascent
from fieldkit.analysis.ballistic import SCALE_HEIGHT, Coast, coast
from fieldkit.analysis.channels import Heights
from fieldkit.analysis.records import Event, Figure
from fieldkit.analysis.robust_statistics import lag_one, mad_sd, median_step
from fieldkit.physics.standard_atmosphere import GRAVITY
from fieldkit.shapes import Array, Float

_MAX_COAST_SPEED = 0.7 * 335.0
"""Mach 0.7: at higher speeds Cd grows with the Mach number. [m/s]"""
_TAIL_OF_THRUST = 0.15
"""How long after burnout, beside twice its standard deviation, the motor may still push: the tail of its thrust. [s]"""
_COAST_END_MARGINS = (2.0, 1.0, 0.5, 0.05)
"""How long before apogee, or before something was ejected, the coast ends: tried from the first on. [s]"""
_CHANCE_GROWTH = 6.0
"""Growth of weighted squares that four values make by chance once in five times (chi squared). [1]"""
_MIN_COAST_TIME, _MIN_COAST_SPEED, _MIN_COAST_SAMPLES = 1.2, 20.0, 8
"""A shorter or slower coast does not constrain drag: its length [s], its first speed [m/s], its samples [1]."""
_MAX_RELATIVE_SD = 0.3
"""A figure with a greater standard deviation, to it, is none. [1]"""
_MIN_DRAG_SD, _MIN_IMPULSE_SD = 0.025, 0.015
"""Errors of any, to it: air that thins otherwise than the standard atmosphere's or than by e in 9.5 km; a Cd that
changes a little with speed; a mass that is not burned evenly. Two altimeters in one airframe differed by more, 13 % in
drag: what an airframe does to pressure the model has as a discrepancy of the rocket. [1]"""
_SQUARED_SPEED_SD = 0.06
"""Error of the integral of v² over a burn, to it: twice that of speeds by heights. [1]"""
_HEIGHT_SCALE_SD = 0.05
"""Standard deviation of the scale of heights: the air is 12 K off the standard atmosphere, and the pressure in an
airframe off by 0.03 of the dynamic pressure (`fieldkit.analysis.forces`), so that heights are by that of v²/2g. [1]"""
_STUDENT_DOF, _MIN_SAMPLE_SD = 4.0, 0.02
"""Of the errors of samples: degrees of freedom [1], least standard deviation [m]."""
_MIN_LOG_DRAG, _MAX_LOG_DRAG = np.log(1e-5), np.log(0.1)
"""Of the logarithm of a drag that a rocket can have, b in 1/m. [1]"""
_START_LOG_DRAG = float(np.log(2e-3))
"""Of the logarithm of drag, where a fit begins: that of a rocket of 0.4 kg and 60 mm. [1]"""
_FIT_ROUNDS = 10
_MAX_STEPS = np.array([2.0, 200.0, 1.5, 0.3])
"""Of one round of the fit, in time [s], height [m], the logarithms of drag and of scale [1]."""
_DIFFERENCE_STEPS = np.array([0.02, 0.2, 0.02, 0.02])
"""Of the differences, in the same."""


@dataclass(frozen=True, slots=True, eq=False)
class _Fit:
    """Time [s] and height [m] of apogee, logarithms of drag in 1/m and of the scale of heights, with their covariance;
    and the samples that they are fitted to, with their weights [1/m^2]."""

    values: Float[Array, "four"]
    covariance: Float[Array, "four four"]
    time: Float[Array, "time"]
    height: Float[Array, "time"]
    weight: Float[Array, "time"]

    def misfit(self, other: "_Fit") -> float:
        """By how much it fits the samples of another worse than that does, in their weighted squares. [1]"""
        own, least = (other.height - _heights(fit.values, other.time) for fit in (self, other))
        return float(other.weight @ (own**2 - least**2))


def drag_and_impulse(
    track: Heights, pad: float, ascent: Ascent, lift: Event, burnout: Event, free: float, source: str
) -> dict[str, Figure]:
    """Drag of the coast [1/m] and impulse of the burn over mass [m/s], those that show.

    Heights of `track` count from `pad` [m]. The coast begins after `burnout` below Mach 0.7 and ends at apogee or when
    something was ejected, `free`. [s] `source` names the channels that `burnout` rests on.
    """
    begin = burnout.time + max(_TAIL_OF_THRUST, 2 * burnout.sd)
    slow = ascent.time[(ascent.time >= begin) & (ascent.speed < _MAX_COAST_SPEED)]
    if not slow.size or np.interp(slow[0], ascent.time, ascent.speed) < _MIN_COAST_SPEED:
        return {}
    inside = (track.time >= slow[0]) & (track.time <= free - _COAST_END_MARGINS[-1])
    time, height = track.time[inside], track.height[inside] - pad
    top = int(np.argmax(ascent.height))
    found = _undisturbed(time, height, free, np.array([ascent.time[top], ascent.height[top], _START_LOG_DRAG, 0.0]))
    if found is None:
        return {}
    drag, relative = float(np.exp(found.values[2])), float(np.hypot(np.sqrt(found.covariance[2, 2]), _MIN_DRAG_SD))
    figures = {"coast_drag": Figure(drag, relative * drag, track.source)}
    if slow[0] - begin < _TAIL_OF_THRUST:  # a coast is not carried back through the speed of sound
        figures["burn_impulse"] = _impulse(found, ascent, lift, float(slow[0]), source)
    return {name: figure for name, figure in figures.items() if figure.sd < _MAX_RELATIVE_SD * figure.value}


def _undisturbed(
    time: Float[Array, "time"], height: Float[Array, "time"], free: float, start: Float[Array, "four"]
) -> _Fit | None:
    """The fit to the longest coast that ends before a parachute which no sensor felt seems to brake it.

    A coast is taken for longer if what it is fitted to besides makes the fit to the shorter one no worse than by
    chance.
    """
    best: _Fit | None = None
    for before in _COAST_END_MARGINS:
        early = time <= free - before
        if early.sum() < _MIN_COAST_SAMPLES or np.ptp(time[early]) < _MIN_COAST_TIME:
            continue
        found = _fitted(time[early], height[early], start if best is None else best.values)
        if found is None:
            continue
        if best is not None and found.misfit(best) > _CHANCE_GROWTH:
            break
        best = found
    return best


def _impulse(found: _Fit, ascent: Ascent, lift: Event, end: float, source: str) -> Figure:
    """Impulse over mass from lift-off to a moment of the coast."""
    inside = (ascent.time >= lift.time) & (ascent.time <= end)
    thinner = np.exp(-ascent.height[inside] / SCALE_HEIGHT)
    squares = float((thinner * ascent.speed[inside] ** 2).sum() * median_step(ascent.time))

    def impulse(values: Array) -> float:
        path = _path(values, end - 0.1)
        speed = float(np.interp(end, path.time, path.speed))
        return speed + GRAVITY * (end - lift.time) + float(np.exp(values[2])) * squares

    value = impulse(found.values)
    slope = np.array([impulse(found.values + step) - value for step in np.diag(_DIFFERENCE_STEPS)]) / _DIFFERENCE_STEPS
    known = np.sqrt(slope @ found.covariance @ slope)
    lost = _SQUARED_SPEED_SD * np.exp(found.values[2]) * squares
    return Figure(value, float(np.linalg.norm([known, GRAVITY * lift.sd, lost, _MIN_IMPULSE_SD * value])), source)


def _fitted(time: Float[Array, "time"], height: Float[Array, "time"], start: Float[Array, "four"]) -> _Fit | None:
    """The coast that fits samples, None if none does.

    Outliers among the samples count less (Student's t, by weights that are set again in each round). Errors with a
    lag-1 autocorrelation r are worth (1 - r) / (1 + r) of independent ones.
    """
    values, prior = start, np.diag([0.0, 0.0, 0.0, _HEIGHT_SCALE_SD**-2])
    freedom = np.sqrt(time.size / (time.size - len(start)))
    for _ in range(_FIT_ROUNDS):
        at = _heights(values, time)
        slope = np.stack(
            [(_heights(values + step, time) - at) / step.sum() for step in np.diag(_DIFFERENCE_STEPS)], axis=-1
        )
        left = height - at
        noise, lag1 = max(mad_sd(left) * freedom, _MIN_SAMPLE_SD), lag_one(left)
        weight = (_STUDENT_DOF + 1) / (_STUDENT_DOF + (left / noise) ** 2) * (1 - lag1) / (1 + lag1) / noise**2
        precision = (slope.T * weight) @ slope + prior
        step = np.linalg.solve(precision, slope.T @ (weight * left) - prior @ values)
        values = values + np.clip(step, -_MAX_STEPS, _MAX_STEPS)
        if not _MIN_LOG_DRAG < values[2] < _MAX_LOG_DRAG:
            return None
    return _Fit(values, np.linalg.inv(precision), time, height, weight)


def _path(values: Float[Array, "four"], begin: float, end: float = 0.0) -> Coast:
    """The coast from one time to another or to apogee, whichever is later, at its true scale."""
    apogee, top, drag = (float(value) for value in values[:3])
    return coast(apogee, top, float(np.exp(drag)), begin, max(end, apogee) + 0.2)


def _heights(values: Float[Array, "four"], time: Float[Array, "time"]) -> Float[Array, "time"]:
    """Heights of a coast as they are shown. [m]"""
    path = _path(values, float(time[0]), float(time[-1]))
    return np.asarray(values[1] - np.exp(values[3]) * (values[1] - np.interp(time, path.time, path.height)))
