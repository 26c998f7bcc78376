"""Drag from a coast and impulse from a burn: two figures that need neither the mass nor the size of the rocket.

**Drag of the coast** b [1/m]. A coast at an upward speed v climbs against gravity and drag,

    dv/dt = -g - b s(h) v²,    b = rho Cd A / (2 m),

with rho the air density at the pad, s(h) the density ratio above it, A the frontal area and m the mass without
propellant. The pad's density and the mass remain in b, so neither is needed here, and correcting either later leaves b
valid. If both are known, Cd = 2 m b / (rho A). Because g is known, b and the time and height of apogee determine the
whole curve; these are fitted to the samples of the coast. The scale of the heights is also free, within the errors that
the air and the airframe cause in a barometer, because a coast that seems too fast or too slow throughout does not
indicate a different drag. If drag is not quite proportional to v², or the rocket is tilted, b is the value that slows a
straight coast as much. Static ports that are off by a fraction s of the dynamic pressure move heights by s v²/2g, which
looks like another drag: b is off by `PORT_ERROR` s, in every flight of the rocket. An accelerometer on the axis shows b
without that error (`fieldkit.analysis.felt_drag`).

**Impulse of the burn** j [m/s]. Newton's law from lift-off to a moment t after burnout, with m falling as propellant
burns:

    j = integral of thrust / m = v(t) + g t + b integral of s v²,

with v(t) from the fitted coast and the last integral, 10 to 20% of the whole, over the smoothed climb. The time of
burnout does not matter. The mass in b is a few percent less than that of a rocket that is still burning, which makes j
too large by 1% at most. The expected j follows from the thrust curve and the masses, without a flight.

Derivation: Newton's second law with drag rho v² Cd A / 2, as above.
"""

from dataclasses import dataclass

import numpy as np

from fieldkit.analysis.ascent import Ascent
from fieldkit.analysis.ballistic import SCALE_HEIGHT, Coast, coast
from fieldkit.analysis.channels import Heights, Push
from fieldkit.analysis.felt_drag import felt_drag, felt_impulse
from fieldkit.analysis.process_noise import STATIC_SD
from fieldkit.analysis.records import Event, Figure
from fieldkit.analysis.robust_statistics import median_step, student_weights
from fieldkit.physics.standard_atmosphere import GRAVITY
from fieldkit.shapes import Array, Float

_MAX_COAST_SPEED = 0.7 * 335.0
"""Mach 0.7: at higher speeds Cd grows with the Mach number. [m/s]"""
_TAIL_OF_THRUST = 0.15
"""How long after burnout, in addition to twice its standard deviation, the tail of the thrust may last. [s]"""
_COAST_END_MARGINS = (2.0, 1.0, 0.5, 0.05)
"""How long before apogee, or before an ejection, the coast ends; tried in this order. [s]"""
_CHANCE_GROWTH = 6.0
"""Growth of the weighted sum of squares that four parameters cause by chance one time in five (chi-squared). [1]"""
_MIN_COAST_TIME, _MIN_COAST_SPEED, _MIN_COAST_SAMPLES = 1.2, 20.0, 8
"""Minimum duration [s], initial speed [m/s] and number of samples [1] for a coast to constrain drag."""
_MAX_RELATIVE_SD = 0.3
"""Largest relative standard deviation of a figure that is reported. [1]"""
_MIN_DRAG_SD, _MIN_IMPULSE_SD = 0.025, 0.015
"""Smallest relative errors: density profiles other than the standard atmosphere's or a scale height of 9.5 km; a Cd
that changes slightly with speed; a mass that does not burn evenly. Two altimeters in one airframe differed by more, 13
% in drag: the model describes the effect of an airframe on pressure as a discrepancy of the rocket. [1]"""
PORT_ERROR = 4.0
"""Relative error of a drag from heights per error of the static ports, as a fraction of the dynamic pressure: 3.2 to
4.9 in nine of ten sport flights of `bench.recorders`. A test computes it again. [1]"""
PORTS_SD = 0.21
"""Standard deviation of the logarithm of a drag from a barometer in every flight of a rocket: 0.12 from `PORT_ERROR`
and ports that are off by 0.03, and more from real flights with an accelerometer (`python -m tools.drags`). [1]"""
_SQUARED_SPEED_SD = 0.06
"""Relative error of the integral of v² over a burn: twice that of speeds derived from heights. [1]"""
_HEIGHT_SCALE_SD = 0.05
"""Standard deviation of the scale of heights: the air is 12 K off the standard atmosphere, and the airframe's pressure
is off by 0.03 of the dynamic pressure (`fieldkit.analysis.forces`), which biases heights by 0.03 v²/2g. [1]
"""
_MIN_SAMPLE_SD = 0.02
"""Smallest standard deviation of the error of a sample. [m]"""
_MIN_LOG_DRAG, _MAX_LOG_DRAG = np.log(1e-5), np.log(0.1)
"""Bounds of the logarithm of a rocket's drag, b in 1/m. [1]"""
_START_LOG_DRAG = float(np.log(2e-3))
"""Logarithm of drag at which a fit starts: a rocket of 0.4 kg and 60 mm. [1]"""
_FIT_ROUNDS, _LAST_STEP = 10, 1e-6
"""Most iterations of a fit, and the squared step, in standard deviations of the fit, after which it ends. [1]"""
_MAX_STEPS = np.array([2.0, 200.0, 1.5, 0.3])
"""Largest step of one fit iteration in time [s], height [m], and the logarithms of drag and of scale [1]."""
_DIFFERENCE_STEPS = np.array([0.02, 0.2, 0.02, 0.02])
"""Steps of the finite differences, in the same units."""


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
        """How much worse it fits the samples of another fit than that fit does, in weighted squares. [1]"""
        own, least = (other.height - _heights(fit.values, other.time) for fit in (self, other))
        return float(other.weight @ (own**2 - least**2))


def drag_and_impulse(
    track: Heights, pad: float, ascent: Ascent, push: Push | None, marks: tuple[Event, Event, float], source: str
) -> dict[str, Figure]:
    """Drag of the coast [1/m] and impulse of the burn over mass [m/s], each only if the samples constrain it.

    Heights of `track` are relative to `pad` [m]; `push` is an accelerometer that is trusted for its size. `marks` are
    lift-off, burnout, and the apogee or ejection at which the coast ends [s]. The coast begins after burnout below Mach
    0.7. `source` names the channels that burnout is based on.
    """
    lift, burnout, free = marks
    begin = burnout.time + max(_TAIL_OF_THRUST, 2 * burnout.sd)
    slow = ascent.time[(ascent.time >= begin) & (ascent.speed < _MAX_COAST_SPEED)]
    if not slow.size or np.interp(slow[0], ascent.time, ascent.speed) < _MIN_COAST_SPEED:
        return {}
    inside = (track.time >= slow[0]) & (track.time <= free - _COAST_END_MARGINS[-1])
    time, height = track.time[inside], track.height[inside] - pad
    top = int(np.argmax(ascent.height))
    found = _undisturbed(time, height, free, np.array([ascent.time[top], ascent.height[top], _START_LOG_DRAG, 0.0]))
    felt = felt_drag(push, ascent, float(slow[0]), float(time[-1])) if push is not None and time.size else None
    seen = None if found is None else _drag(found, track.source)
    drag = _better_known(seen, felt, track.is_barometric)
    if drag is None:
        return {}
    figures = {"coast_drag": drag}
    subsonic = slow[0] - begin < _TAIL_OF_THRUST  # a coast is not extrapolated back through the speed of sound
    if subsonic and drag is felt and push is not None:
        figures["burn_impulse"] = felt_impulse(push, ascent, drag, lift, float(slow[0]))
    elif subsonic and found is not None:
        figures["burn_impulse"] = _impulse(found, ascent, lift, float(slow[0]), source, track.is_barometric)
    return {name: figure for name, figure in figures.items() if figure.sd < _MAX_RELATIVE_SD * figure.value}


def _drag(found: _Fit, source: str) -> Figure:
    drag = float(np.exp(found.values[2]))
    return Figure(drag, float(np.hypot(np.sqrt(found.covariance[2, 2]), _MIN_DRAG_SD)) * drag, source)


def _better_known(seen: Figure | None, felt: Figure | None, barometric: bool) -> Figure | None:
    """A drag from heights, which static ports distort if they come from a barometer, or from an accelerometer."""
    if seen is None or felt is None:
        return seen or felt
    ports = PORTS_SD * seen.value if barometric else 0.0
    return felt if felt.sd < np.hypot(seen.sd, ports) else seen


def _undisturbed(
    time: Float[Array, "time"], height: Float[Array, "time"], free: float, start: Float[Array, "four"]
) -> _Fit | None:
    """Fit the longest coast that ends before a parachute, which no sensor detected, appears to brake it.

    The coast is extended if the additional samples do not worsen the fit to the shorter one by more than chance.
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


def _impulse(found: _Fit, ascent: Ascent, lift: Event, end: float, source: str, barometric: bool) -> Figure:
    """Impulse over mass from lift-off to a moment of the coast.

    Static ports that are off by s move heights by s v²/2g, and so change the speed by s v (1 + b v²/g).
    """
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
    drag = float(np.exp(found.values[2]))
    speed = value - GRAVITY * (end - lift.time) - drag * squares
    ports = STATIC_SD * speed * (1 + drag * speed**2 / GRAVITY) if barometric else 0.0
    errors = (known, GRAVITY * lift.sd, _SQUARED_SPEED_SD * drag * squares, _MIN_IMPULSE_SD * value, ports)
    return Figure(value, float(np.linalg.norm(errors)), source)


def _fitted(time: Float[Array, "time"], height: Float[Array, "time"], start: Float[Array, "four"]) -> _Fit | None:
    """Fit a coast to samples, with weights that are updated in each iteration. None if no coast fits."""
    values, prior = start, np.diag([0.0, 0.0, 0.0, _HEIGHT_SCALE_SD**-2])
    for _ in range(_FIT_ROUNDS):
        at, slope = _linearized(values, time)
        left = height - at
        weight = student_weights(left, len(start), _MIN_SAMPLE_SD)
        precision = (slope.T * weight) @ slope + prior
        step = np.linalg.solve(precision, slope.T @ (weight * left) - prior @ values)
        values = values + np.clip(step, -_MAX_STEPS, _MAX_STEPS)
        if not _MIN_LOG_DRAG < values[2] < _MAX_LOG_DRAG:
            return None
        if step @ precision @ step < _LAST_STEP:
            break
    return _Fit(values, np.asarray(np.linalg.inv(precision), np.float64), time, height, weight)


def _linearized(
    values: Float[Array, "four"], time: Float[Array, "time"]
) -> tuple[Float[Array, "time"], Float[Array, "time four"]]:
    """Heights as the altimeter reports them [m] and their derivatives.

    A later apogee shifts the coast and the scale stretches it; only for apogee height and drag is it integrated again.
    """
    path = _path(values, float(time[0]), float(time[-1]))
    stretch, below = np.exp(values[3]), values[1] - np.interp(time, path.time, path.height)
    at = np.asarray(values[1] - stretch * below)
    by_time, by_scale = -stretch * np.interp(time, path.time, path.speed), -stretch * below
    by_top, by_drag = ((_heights(values + step, time) - at) / step.sum() for step in np.diag(_DIFFERENCE_STEPS)[1:3])
    return at, np.stack([by_time, by_top, by_drag, by_scale], axis=-1)


def _path(values: Float[Array, "four"], begin: float, end: float = 0.0) -> Coast:
    """The coast from one time to another or to apogee, whichever is later, at its true scale."""
    apogee, top, drag = (float(value) for value in values[:3])
    return coast(apogee, top, float(np.exp(drag)), begin, max(end, apogee) + 0.2)


def _heights(values: Float[Array, "four"], time: Float[Array, "time"]) -> Float[Array, "time"]:
    """Heights of a coast as the altimeter reports them. [m]"""
    path = _path(values, float(time[0]), float(time[-1]))
    return np.asarray(values[1] - np.exp(values[3]) * (values[1] - np.interp(time, path.time, path.height)))
