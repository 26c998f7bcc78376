"""Drag and impulse that the samples of a simulated flight would give, as in `fieldkit.analysis.drag_and_impulse`.

Derivation: that of `fieldkit.analysis.drag_and_impulse`, with the simulated accelerations instead of samples.
"""

import numpy as np

from fieldkit.physics.forces import EquationsOfMotion
from fieldkit.physics.state import FlightResult, Setup
from fieldkit.shapes import Array, Float

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
