"""The simulator against an independent integration by an adaptive method with tight tolerances."""

from typing import Any

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.optimize import brentq

from fieldkit.motors import Motor, catalogue
from fieldkit.physics import paper
from fieldkit.physics.flight import apogees, fly
from tests.physics.simulated import rocket

GRAVITY = 9.80665
LAPSE, TEMPERATURE, PRESSURE, GAS = 0.0065, 288.15, 101325.0, 287.05287
CLOSE = 0.1
"""Maximum difference between the two. [m]"""
MOTORS = 40
"""Size of the sample if not all are simulated."""


class Reference:
    """A vertical flight integrated by DOP853, restarted at every knot of the thrust curve.

    Written from the equations alone: thrust linear between knots, mass falling with the impulse delivered, drag with
    the square of speed in the standard atmosphere; the rocket stays on the pad until thrust exceeds weight.
    """

    def __init__(self, motor: Any, dry_mass: float, drag_area: float, alpha: float, *, as_paper: bool = False) -> None:
        self.time, self.thrust = np.asarray(motor.time, float), alpha * np.asarray(motor.thrust, float)
        pieces = np.diff(self.time) * (self.thrust[1:] + self.thrust[:-1]) / 2
        self.delivered = np.concatenate([[0.0], np.cumsum(pieces)])
        self.empty, self.propellant, self.area = dry_mass + motor.casing_mass, motor.propellant_mass, drag_area
        self.as_paper, self.gravity = as_paper, 9.81 if as_paper else GRAVITY

    def push(self, time: float, knot: int) -> tuple[float, float]:
        """Thrust [N] and mass [kg] at a time between a knot and the next."""
        since = time - self.time[knot]
        slope = (self.thrust[knot + 1] - self.thrust[knot]) / (self.time[knot + 1] - self.time[knot])
        spent = (self.delivered[knot] + since * (self.thrust[knot] + slope * since / 2)) / self.delivered[-1]
        if self.as_paper:
            spent = time / self.time[-1]
        return self.thrust[knot] + slope * since, self.empty + self.propellant * (1 - spent)

    def density(self, height: float) -> float:
        if self.as_paper:
            return float(1.225 * np.exp(-height / 8500))
        return float(
            PRESSURE / (GAS * TEMPERATURE) * (1 - LAPSE * height / TEMPERATURE) ** (GRAVITY / (GAS * LAPSE) - 1)
        )

    def slopes(self, time: float, state: Any, knot: int | None) -> list[float]:
        height, speed = state
        thrust, mass = (0.0, self.empty) if knot is None else self.push(time, knot)
        drag = 0.5 * self.density(height) * self.area * speed * abs(speed)
        return [speed, (thrust - drag) / mass - self.gravity]

    def lift_off(self) -> tuple[float, int]:
        """Time at which thrust first exceeds weight, and the knot before it."""

        def net(time: float, knot: int) -> float:
            thrust, mass = self.push(time, knot)
            return thrust - mass * self.gravity

        for knot in range(len(self.time) - 1):
            if net(self.time[knot + 1], knot) > 0:
                start = self.time[knot]
                return (start if net(start, knot) > 0 else brentq(net, start, self.time[knot + 1], args=(knot,))), knot
        raise AssertionError("the motor does not lift its rocket")

    def leg(self, start: float, end: float, state: Any, knot: int | None, *, to_apogee: bool) -> tuple[Any, float]:
        """State at the end, and the apogee if it is on the way."""

        def ends_climb(time: float, state: Any, knot: int | None) -> float:
            return float(state[1])

        ends_climb.terminal, ends_climb.direction = to_apogee, -1  # type: ignore[attr-defined]
        options = {"method": "DOP853", "rtol": 1e-10, "atol": 1e-10, "events": ends_climb, "args": (knot,)}
        result = solve_ivp(self.slopes, (start, end), state, **options)
        return result.y[:, -1], max([0.0, *(state[0] for state in result.y_events[0])])

    def apogee(self) -> float:
        """Height of the highest point. [m]"""
        time, first = self.lift_off()
        state, highest = np.zeros(2), 0.0
        for knot in range(first, len(self.time) - 1):
            state, top = self.leg(time, self.time[knot + 1], state, knot, to_apogee=False)
            time, highest = self.time[knot + 1], max(highest, top)
        if state[1] > 0:
            state, top = self.leg(time, time + 600, state, None, to_apogee=True)
            highest = max(highest, top)
        return highest


def sample(motor: Motor, draws: int, rng: np.random.Generator) -> tuple[Any, Any, Any]:
    """Dry mass, drag area and alpha over the whole prior: thrust 3 to 20 times weight, Cd 0.3 to 1.2."""
    loaded = motor.average_thrust / (GRAVITY * rng.uniform(3, 20, draws))
    dry_mass = np.maximum(loaded - motor.loaded_mass, 0.25 * motor.loaded_mass)
    diameter = motor.diameter * rng.uniform(1.1, 2.5, draws)
    return dry_mass, rng.uniform(0.3, 1.2, draws) * np.pi / 4 * diameter**2, rng.uniform(0.8, 1.2, draws)


def worst(motors: list[Motor], draws: int, rng: np.random.Generator) -> float:
    """The greatest difference from the reference over some motors, with some draws of each. [m]"""
    drawn = [sample(motor, draws, rng) for motor in motors]
    mass, area, alpha = (np.stack(values) for values in zip(*drawn, strict=True))
    row = np.arange(len(motors))[:, None]
    here = apogees(rocket(motors, motor=row, dry_mass=mass, drag_area=area, thrust_factor=alpha))
    there = [
        [Reference(motor, mass[i, j], area[i, j], alpha[i, j]).apogee() for j in range(draws)]
        for i, motor in enumerate(motors)
    ]
    return float(np.abs(here - np.array(there)).max())


def test_a_sample_of_motors_agrees_with_the_reference() -> None:
    rng = np.random.default_rng(11)
    motors = catalogue().motors
    picked = [motors[i] for i in rng.choice(len(motors), MOTORS, replace=False)]
    assert worst(picked, 1, rng) < CLOSE


@pytest.mark.slow
def test_every_motor_agrees_with_the_reference() -> None:
    assert worst(catalogue().motors, 4, np.random.default_rng(12)) < CLOSE


def test_the_papers_physics_agrees_with_the_reference() -> None:
    rng, draws = np.random.default_rng(13), 24
    motor, mass = rng.integers(0, 3, draws), rng.choice([0.322, 0.448], draws)
    cd, alpha = rng.uniform(0.3, 0.9, draws), rng.uniform(0.8, 1.2, draws)
    area = cd * np.pi / 4 * paper.DIAMETER**2
    there = [
        Reference(paper.MOTORS[m], mass[i], area[i], alpha[i], as_paper=True).apogee() for i, m in enumerate(motor)
    ]
    np.testing.assert_allclose(apogees(paper.paper_setup(motor, mass, cd, alpha)), there, atol=CLOSE)


def test_fly_and_apogees_agree_in_any_batch_of_motors() -> None:
    motors = catalogue().motors[::60]
    mass, area, alpha = sample(motors[0], 1, np.random.default_rng(1))
    setup = rocket(motors, motor=np.arange(len(motors)), dry_mass=mass + 0.2, drag_area=area, thrust_factor=alpha)
    alone = [float(apogees(rocket(m, dry_mass=mass + 0.2, drag_area=area, thrust_factor=alpha))[0]) for m in motors]
    np.testing.assert_allclose(apogees(setup), alone, rtol=1e-12)
    np.testing.assert_allclose(fly(setup).apogee, alone, rtol=1e-12)
