"""The forces on a rocket going up: thrust along its axis, drag along the wind, gravity, and the effects'."""

import numpy as np

from fieldkit.physics.atmosphere import wind_at
from fieldkit.physics.state import Setup, State
from fieldkit.shapes import Array, Flags

TURN_LENGTH = 4.0
"""Path off the rail over which a rocket turns into the relative wind: about a quarter of the pitching
wavelength of a stable model (Mandell, Caporaso and Bengen, Topics in Advanced Model Rocketry, 1973). [m]"""


def planar(setup: Setup) -> Flags:
    """Which draws need more than the vertical: wind, tilt or a rail that holds on. One flag where all are alike."""
    return np.asarray((setup.wind != 0) | (setup.rail_angle != 0) | (setup.rail_friction != 0))


class EquationsOfMotion:
    """Acceleration of all draws: thrust, drag and whatever the effects add, less gravity. [m/s^2]

    `thrust` [N] and `mass` [kg] belong to a stage of a step; position and velocity are [axis draw].
    """

    def __init__(self, setup: Setup, *, burning: bool) -> None:
        self.setup = setup
        self.burning = burning
        self.half_drag_area = 0.5 * setup.drag_area * setup.air.density
        self.planar = bool(planar(setup).any())
        if self.planar:
            self.rail = np.stack([np.cos(setup.rail_angle), np.sin(setup.rail_angle)])
            self.turned = setup.rail_length + TURN_LENGTH

    def drag_like(self, height: Array, speed: Array, mass: Array) -> Array:
        """Deceleration along the path through the air. [m/s^2]"""
        drag = self._drag(height, speed)
        drag /= mass
        if self.setup.forces:
            state = State(height, speed, drag, self.burning, self.setup.air)
            drag = drag - sum(force(state, strength) for force, strength in self.setup.forces)
        return drag

    def _drag(self, height: Array, speed: Array) -> Array:
        """Force of drag. [N]"""
        drag = self.setup.air.density_ratio(height)
        drag *= self.half_drag_area
        drag *= np.abs(speed)
        drag *= speed
        return drag

    def __call__(self, position: Array, velocity: Array, thrust: Array | float, mass: Array) -> Array:
        if self.planar:
            return self._planar(position, velocity, thrust, mass)
        if self.setup.forces:
            pull = thrust / mass - self.drag_like(position[0], velocity[0], mass)
        else:
            pull = np.asarray(thrust - self._drag(position[0], velocity[0]))
            pull /= mass
        pull -= self.setup.gravity
        return np.asarray(pull[None])

    def _planar(self, position: Array, velocity: Array, thrust: Array | float, mass: Array) -> Array:
        height = position[0]
        path = self._path(position)
        if (path >= self.turned).all():
            return self._turned(height, velocity, thrust, mass)
        free = smooth_step((path - self.setup.rail_length) / TURN_LENGTH)
        through_air = velocity.copy()
        through_air[1] -= free * wind_at(height, self.setup.wind)
        speed = np.maximum(np.hypot(through_air[0], through_air[1]), 1e-9)
        heading = through_air / speed
        axis = self.rail + free * (heading - self.rail)
        pull = axis * (thrust / mass) - heading * self.drag_like(height, speed, mass)
        pull[0] -= self.setup.gravity
        along = self._path(pull) - self.setup.rail_friction * (path < self.setup.rail_length)
        return np.asarray(free * pull + (1 - free) * self.rail * along)

    def _turned(self, height: Array, velocity: Array, thrust: Array | float, mass: Array) -> Array:
        """The same where every draw has long left its rail: thrust and drag along the path through the air."""
        up, sideways = velocity[0], velocity[1] - wind_at(height, self.setup.wind)
        speed = np.maximum(np.hypot(up, sideways), 1e-9)
        along = (thrust / mass - self.drag_like(height, speed, mass)) / speed
        pull = np.empty_like(velocity)
        pull[0], pull[1] = up * along - self.setup.gravity, sideways * along
        return pull

    def _path(self, position: Array) -> Array:
        return np.asarray(position[0] * self.rail[0] + position[1] * self.rail[1])


def smooth_step(x: Array) -> Array:
    """0 below 0, 1 above 1, and smooth between. [1]"""
    x = np.clip(x, 0.0, 1.0)
    return np.asarray(x * x * (3 - 2 * x))
