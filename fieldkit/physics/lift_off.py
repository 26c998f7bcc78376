"""Lift-off: when thrust exceeds what holds a rocket on its rail.

Derivation: Newton's second law at rest, with the thrust linear between two points of its curve.
"""

import numpy as np

from fieldkit.physics.state import Setup
from fieldkit.shapes import Array, Float


def lift_off_time(setup: Setup) -> Float[Array, "draw"]:
    """Time at which thrust first exceeds weight and friction on the rail; inf if it never does. [s]"""
    burns, motor = setup.burns, setup.motor
    mass = setup.dry_mass + burns.casing_mass[motor] + burns.propellant_mass[motor]
    weight = mass * (setup.gravity + setup.rail_friction)
    needed = weight * setup.burn_stretch / setup.thrust_factor
    result = np.where(burns.rise_thrust[0][motor] > needed, burns.rise_time[0][motor], np.inf)
    for knot in range(len(burns.rise_time) - 1):
        before, after = burns.rise_thrust[knot][motor], burns.rise_thrust[knot + 1][motor]
        crosses = (after > needed) & np.isinf(result)
        if crosses.any():
            share = np.clip((needed - before) / np.where(after > before, after - before, np.inf), 0.0, 1.0)
            start, end = burns.rise_time[knot][motor], burns.rise_time[knot + 1][motor]
            result = np.where(crosses, start + share * (end - start), result)
        if not np.isinf(result).any():
            break
    return np.asarray(result * setup.burn_stretch)
