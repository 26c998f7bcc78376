"""The speed at which a rocket leaves its rail, from thrust, mass and weight.

Derivation: acceleration is constant within an integrator's step, so v² grows by twice the acceleration times the path.
"""

import numpy as np

from fieldkit.physics.state import Setup
from fieldkit.shapes import Array, Float


def rail_exit_speed(setup: Setup) -> Float[Array, "*draw"]:
    """Speed at the end of the rail without drag; the speed at burnout if burnout comes first. [m/s]"""
    burns, motor = setup.burns, setup.motor
    height = speed = np.zeros(setup.draw_shape)
    exit_speed = np.full(setup.draw_shape, np.nan)
    empty, propellant = setup.dry_mass + burns.casing_mass[motor], burns.propellant_mass[motor]
    for step in range(len(burns.thrust)):
        length = (burns.edge[step + 1] - burns.edge[step])[motor] * setup.burn_stretch
        thrust = burns.thrust[step, 1][motor] * setup.thrust_factor / setup.burn_stretch
        mass = empty + propellant * (1 - burns.spent[step, 1][motor])
        acceleration = np.maximum(
            thrust / mass - setup.gravity - setup.rail_friction, -speed / np.maximum(length, 1e-9)
        )
        reached = height + speed * length + acceleration * length**2 / 2
        leaves = np.isnan(exit_speed) & (reached >= setup.rail_length)
        squared = speed**2 + 2 * acceleration * np.maximum(setup.rail_length - height, 0.0)
        exit_speed = np.where(leaves, np.sqrt(np.maximum(squared, 0.0)), exit_speed)
        height, speed = reached, np.maximum(speed + acceleration * length, 0.0)
        if not np.isnan(exit_speed).any():
            break
    return np.asarray(np.where(np.isnan(exit_speed), speed, exit_speed))
