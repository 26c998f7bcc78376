"""The forces on a climbing rocket: thrust along its axis, drag along the relative wind, gravity, and effects.

Derivation: Newton's second law; drag is rho v² Cd A / 2 against the velocity through the air.
"""

import numpy as np

from fieldkit.physics.atmosphere import wind_at
from fieldkit.physics.state import Setup, State
from fieldkit.shapes import Array, Flags


def planar(setup: Setup) -> Flags:
    """Which draws need more than vertical motion: wind, launch angle or rail friction. One flag if all are the same."""
    slanted = (setup.rail_angle != 0) | (setup.rail_across != 0)
    return np.asarray((setup.wind != 0) | slanted | (setup.rail_friction != 0))


class EquationsOfMotion:
    """Acceleration of all draws: thrust, drag and the effects' forces, less gravity. [m/s^2]

    `thrust` [N] and `mass` [kg] belong to one stage of a step. Position and velocity are [axis draw]: upward, downwind
    in a planar flight, and to the right of the wind for a rail with a crosswind angle; `axes` is their number, by
    default as many as any draw needs.
    """

    def __init__(self, setup: Setup, *, burning: bool, axes: int | None = None) -> None:
        self.setup = setup
        self.burning = burning
        self.half_drag_area = 0.5 * setup.drag_area * setup.air.density
        across = bool((setup.rail_across != 0).any())
        self.axes = axes or 1 + int(bool(planar(setup).any())) + int(across)
        self.planar = self.axes > 1
        if self.planar:
            self.rail = rail_axis(setup)[: self.axes]
            self.turned = setup.rail_length + setup.turn_length

    def drag_like(self, height: Array, speed: Array, mass: Array) -> Array:
        """Deceleration along the path through the air by drag and effects; one entry per draw, in SI. [m/s^2]"""
        drag = self._drag(height, speed)
        drag /= mass
        if self.setup.forces:
            state = State(height, speed, drag, self.burning, self.setup.air)
            drag = drag - sum(force(state, strength) for force, strength in self.setup.forces)
        return drag

    def _drag(self, height: Array, speed: Array) -> Array:
        """Drag force. [N]"""
        drag = self.setup.air.density_ratio(height)
        drag *= self.half_drag_area
        drag *= np.abs(speed)
        drag *= speed
        return drag

    def __call__(self, position: Array, velocity: Array, thrust: Array | float, mass: Array) -> Array:
        if self.planar:
            return self._planar(position, velocity, thrust, mass)
        if self.setup.forces:
            acceleration = thrust / mass - self.drag_like(position[0], velocity[0], mass)
        else:
            acceleration = np.asarray(thrust - self._drag(position[0], velocity[0]))
            acceleration /= mass
        acceleration -= self.setup.gravity
        return np.asarray(acceleration[None])

    def _planar(self, position: Array, velocity: Array, thrust: Array | float, mass: Array) -> Array:
        height = position[0]
        path = self.along_rail(position)
        if (path >= self.turned).all():
            return self._turned(height, velocity, thrust, mass)
        free = smooth_step((path - self.setup.rail_length) / self.setup.turn_length)
        held = 1 - free
        through_air = velocity.copy()
        through_air[1] -= free * self._wind(height)
        speed = np.maximum(length_of(through_air), 1e-9)
        push, drag = thrust / mass, self.drag_like(height, speed, mass)
        acceleration = through_air * ((free * push - drag) / speed)
        acceleration += self.rail * (held * push)
        acceleration[0] -= self.setup.gravity
        along = self.along_rail(acceleration) - self.setup.rail_friction * (path < self.setup.rail_length)
        acceleration *= free
        acceleration += self.rail * (held * along)
        return np.asarray(acceleration)

    def _turned(self, height: Array, velocity: Array, thrust: Array | float, mass: Array) -> Array:
        """Acceleration when every draw has long left its rail: thrust and drag act along the path through the air."""
        if self.axes == 3:
            through_air = velocity.copy()
            through_air[1] -= self._wind(height)
            speed = np.maximum(length_of(through_air), 1e-9)
            acceleration = through_air * ((thrust / mass - self.drag_like(height, speed, mass)) / speed)
            acceleration[0] -= self.setup.gravity
            return np.asarray(acceleration)
        up, sideways = velocity[0], velocity[1] - self._wind(height)
        speed = np.maximum(np.sqrt(up * up + sideways * sideways), 1e-9)
        along = (thrust / mass - self.drag_like(height, speed, mass)) / speed
        acceleration = np.empty_like(velocity)
        acceleration[0], acceleration[1] = up * along - self.setup.gravity, sideways * along
        return acceleration

    def _wind(self, height: Array) -> Array:
        """Wind at a height [m]. [m/s]"""
        return wind_at(height, self.setup.wind, self.setup.wind_power, self.setup.wind_top)

    def along_rail(self, vector: Array) -> Array:
        """The part of a vector [axis draw] along the rail, in its unit; only for planar flights."""
        path = vector[0] * self.rail[0] + vector[1] * self.rail[1]
        return np.asarray(path + vector[2] * self.rail[2] if self.axes == 3 else path)


def rail_axis(setup: Setup) -> Array:
    """Direction of the rail as a unit vector: upward, downwind and crosswind. [axis draw], [1]"""
    angle = np.hypot(setup.rail_angle, setup.rail_across)
    sideways = np.sinc(angle / np.pi)  # sin(angle) / angle
    return np.stack(np.broadcast_arrays(np.cos(angle), setup.rail_angle * sideways, setup.rail_across * sideways))


def length_of(vector: Array) -> Array:
    """Length of a vector [axis draw] with two or three axes, in its unit; `np.hypot` would take three times as long."""
    square = vector[0] ** 2 + vector[1] ** 2
    return np.asarray(np.sqrt(square + vector[2] ** 2 if len(vector) == 3 else square))


def smooth_step(x: Array) -> Array:
    """Smooth step, elementwise: 0 below 0, 1 above 1, smooth in between. [1]"""
    x = np.minimum(np.maximum(x, 0.0), 1.0)
    return np.asarray(x * x * (3 - 2 * x))
