"""Drag of a coast and impulse of a burn as an accelerometer on the axis feels them; static ports do not affect them.

In a coast nothing but drag acts along the axis, so the accelerometer shows

    a = c - b s(h) v²,    b = rho Cd A / (2 m),

with c the error of its zero, which the slow end of the coast shows, and the rest as in `drag_and_impulse`. Speed and
density ratio are those of the fitted ascent; the line is fitted by least squares with Student-t weights. In the burn it
shows thrust less drag, so the impulse over mass is

    j = integral of a + b integral of s v².

Derivation: Newton's second law along the axis, without gravity, which an accelerometer in free flight does not feel.
"""

import numpy as np

from fieldkit.analysis.ascent import Ascent
from fieldkit.analysis.ballistic import SCALE_HEIGHT
from fieldkit.analysis.channels import Push
from fieldkit.analysis.records import Event, Figure
from fieldkit.analysis.robust_statistics import student_weights
from fieldkit.physics.standard_atmosphere import GRAVITY
from fieldkit.shapes import Array, Float

_MIN_SAMPLES, _MIN_SPEED_RATIO = 12, 1.5
"""Minimum number of samples of a coast [1], and of the ratio of its first speed to its last. [1]"""
_ROUNDS, _MIN_NOISE = 8, 0.02
"""Number of updates of the weights [1], and smallest standard deviation of the error of a sample. [m/s^2]"""
_MAX_LOWEST = 3
"""Largest number of samples with the lowest value of a sensor that is not saturated. [1]"""
_MAX_ZERO = 1.5
"""Largest plausible error of an accelerometer's zero, as on the pad (`fieldkit.analysis.initial_guess`). [m/s^2]"""
_STEP = 0.005
"""Step of the integrals over a burn. [s]"""
_SCALE_SD, _SPEED_SD = 0.02, 0.02
"""Relative errors of an accelerometer's scale and of a speed for which heights and accelerometer agree. [1]"""


def felt_drag(push: Push, ascent: Ascent, begin: float, end: float) -> Figure | None:
    """Drag of the coast between two times [s] from an axial accelerometer. [1/m]

    None if it does not measure along the axis, was saturated, has an implausible zero, or the coast does not constrain
    drag.
    """
    inside = (push.time >= begin) & (push.time <= end)
    lowest = push.felt[inside].min(initial=np.inf)
    if np.sum(push.felt[inside] == lowest) > _MAX_LOWEST:
        inside &= push.felt > lowest
    if push.vertical or inside.sum() < _MIN_SAMPLES or (push.full is not None and push.full[inside].any()):
        return None
    time, felt = push.time[inside] - push.blur, push.felt[inside]
    speed, height = (np.interp(time, ascent.time, curve) for curve in (ascent.speed, ascent.height))
    if speed[0] < _MIN_SPEED_RATIO * max(float(speed[-1]), 1.0):
        return None
    shape = np.stack([-np.exp(-height / SCALE_HEIGHT) * speed**2, np.ones(time.size)], axis=-1)
    drag, zero, known = _line(shape, felt)
    if not drag > 0 or abs(zero) > _MAX_ZERO:
        return None
    return Figure(drag, float(np.linalg.norm([known, _SCALE_SD * drag, 2 * _SPEED_SD * drag])), push.source)


def felt_impulse(push: Push, ascent: Ascent, drag: Figure, lift: Event, end: float) -> Figure:
    """Impulse of the burn over mass, from lift-off to a moment of the coast [s], with a drag of the coast. [m/s]"""
    time = np.arange(lift.time, end, _STEP)
    felt = float(np.trapezoid(np.interp(time, push.time - push.blur, push.felt), time))
    speed, height = (np.interp(time, ascent.time, curve) for curve in (ascent.speed, ascent.height))
    lost = float(np.trapezoid(np.exp(-height / SCALE_HEIGHT) * speed**2, time))
    known = (
        _SCALE_SD * felt,
        push.missed_speed_sd,
        GRAVITY * lift.sd,
        np.hypot(drag.sd, 2 * _SPEED_SD * drag.value) * lost,
    )
    return Figure(felt + drag.value * lost, float(np.linalg.norm(known)), push.source)


def _line(shape: Float[Array, "time two"], felt: Float[Array, "time"]) -> tuple[float, float, float]:
    """Slope and zero of a robust line, and the standard deviation of the slope."""
    weight = np.ones(felt.size)
    for _ in range(_ROUNDS):
        precision = (shape.T * weight) @ shape
        values = np.linalg.solve(precision, shape.T @ (weight * felt))
        weight = student_weights(felt - shape @ values, 2, _MIN_NOISE)
    slope, zero = values.tolist()
    return slope, zero, float(np.sqrt(np.linalg.inv((shape.T * weight) @ shape)[0, 0]))
