"""What the samples of a simulated flight would give: drag and impulse as in `fieldkit.analysis.drag_and_impulse`, and
a peak acceleration as in `fieldkit.analysis.peak`.

Derivation: that of `fieldkit.analysis.drag_and_impulse`, with the simulated accelerations instead of samples.
"""

import numpy as np

from fieldkit.flight.readout import PEAK_WINDOW
from fieldkit.physics.forces import EquationsOfMotion
from fieldkit.physics.standard_atmosphere import GRAVITY
from fieldkit.physics.state import FlightResult, Setup
from fieldkit.physics.thrust_steps import Curve, impulse_until, strictly_increasing
from fieldkit.shapes import Array, Float

_STARTS = 201
"""Number of evenly spaced starts at which the highest mean is looked for, beside those at the knots. [1]"""

_PARTS = (0.2, 0.4, 0.6, 0.8)
"""Fractions of the speed after burnout at which drag that is not proportional to v² is evaluated. [1]"""


def coast_drag(setup: Setup, flown: FlightResult) -> Float[Array, "*draw"]:
    """Drag of the coast b = rho Cd A / 2m at the pad's air density, with m the mass after burnout. [1/m]

    With effects that act in flight, it is the b for which b s(h) v² fits the deceleration best by least squares over
    the coast, at the heights of a rocket with constant deceleration.
    """
    setup = setup.after_burnout()
    mass = setup.dry_mass + setup.burns.casing_mass[setup.motor]
    plain = 0.5 * setup.drag_area * setup.air.density / mass
    if not setup.forces:
        return np.asarray(np.broadcast_to(plain, setup.draw_shape))
    acceleration = EquationsOfMotion(setup, burning=False)
    slowed, squares = np.zeros(setup.draw_shape), np.zeros(setup.draw_shape)
    begin = flown.apogee - 0.5 * flown.top_speed * flown.coast_to_apogee
    for part in _PARTS:
        speed = part * flown.top_speed
        height = flown.apogee - part**2 * (flown.apogee - np.maximum(begin, 0.0))
        shape = setup.air.density_ratio(height) * speed**2
        slowed += shape * acceleration.drag_like(height, speed, mass)
        squares += shape**2
    return np.asarray(slowed / np.where(squares > 0, squares, np.nan))


def climbed_drag(flown: FlightResult, drag: Float[Array, "*draw"]) -> Float[Array, "*draw"]:
    """Drag b of a coast that heights show [1/m], from that along the path [1/m]: a slanted path has more of it.

    Derivation: the upward speed w falls by g + b V w with V the speed along the path, so heights show b V/w, here
    weighted as in `coast_drag`. With V near w in the drag, the horizontal speed falls as the root of g + b w².
    """
    upward = _upward(flown)
    slant = (1 - upward**2) / upward**2  # squared ratio of horizontal to upward speed at burnout
    slowed = drag * flown.top_climb**2 / GRAVITY
    parts = np.array(_PARTS)
    across = slant[..., None] * (1 + slowed[..., None] * parts**2) / (1 + slowed[..., None])
    ratio = (np.sqrt(1 + across / parts**2) * parts**4).sum(axis=-1) / (parts**4).sum()
    return np.asarray(drag * ratio)


def climbed_impulse(flown: FlightResult, impulse: Float[Array, "*draw"]) -> Float[Array, "*draw"]:
    """Impulse over mass that heights show [m/s], from that along the path [m/s].

    Derivation: with c the upward part of the path's direction, the speed J - g t c - D shows as c times that, to which
    g t and the drag c D are added again.
    """
    upward = _upward(flown)
    return np.asarray(upward * impulse + GRAVITY * flown.burn_time * (1 - upward**2))


def climbed_peak(flown: FlightResult) -> Float[Array, "*draw"]:
    """Peak acceleration that heights show, at least a tenth of that along the path [m/s^2].

    Derivation: of the felt acceleration p + g c along the path, with c the upward part of its direction, heights show c
    times it, less g.
    """
    upward = _upward(flown)
    return np.asarray(np.maximum(upward * (flown.peak_accel + GRAVITY * upward) - GRAVITY, 0.1 * flown.peak_accel))


def felt_peak(peak: Float[Array, "draw flight"], part: Float[Array, "flight"]) -> Float[Array, "draw flight"]:
    """Peak acceleration that an accelerometer's samples show, from that of the thrust curve [m/s^2].

    `part` is as in `highest_mean`. Derivation: the mean of thrust over mass over a window in which the mass hardly
    changes, less gravity; a spike comes at ignition, without drag.
    """
    return np.asarray((peak + GRAVITY) * part - GRAVITY)


def highest_mean(motor: Curve, window: float = PEAK_WINDOW) -> float:
    """The highest mean thrust of a motor over a window [s], as a fraction of its highest thrust. [1]"""
    time, thrust = strictly_increasing(np.asarray(motor.time, float), np.asarray(motor.thrust, float))
    window = min(window, float(np.ptp(time)))
    latest = float(time[-1]) - window
    starts = np.clip(np.concatenate([time, time - window, np.linspace(time[0], latest, _STARTS)]), time[0], latest)
    gained = impulse_until(time, thrust, starts + window) - impulse_until(time, thrust, starts)
    return float(gained.max() / window / thrust.max())


def _upward(flown: FlightResult) -> Float[Array, "*draw"]:
    """Upward part of the path's direction at burnout, at least a tenth. [1]"""
    with np.errstate(invalid="ignore", divide="ignore"):
        found = np.where(flown.top_speed > 0, flown.top_climb / flown.top_speed, 1.0)
    return np.asarray(np.clip(found, 0.1, 1.0))


def burn_impulse(setup: Setup) -> Float[Array, "*draw"]:
    """Thrust over mass, integrated over the burn by Simpson's rule on the integrator's steps. [m/s]

    Includes the small impulse before lift-off, which a rocket waiting on the pad loses.
    """
    burns, motor = setup.burns, setup.motor
    gained = np.zeros(setup.draw_shape)
    for step, length in enumerate(np.diff(burns.edge, axis=0)):
        for place, weight in enumerate((1 / 6, 4 / 6, 1 / 6)):
            left = (1 - burns.spent[step, place])[motor] * burns.propellant_mass[motor]
            mass = setup.dry_mass + burns.casing_mass[motor] + left
            gained += weight * length[motor] * burns.thrust[step, place][motor] / mass
    return np.asarray(gained * setup.thrust_factor)
