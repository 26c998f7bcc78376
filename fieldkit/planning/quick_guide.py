"""The motor guide at once: quick forecasts of a plan on many motors from one linear pass, which no fit has checked."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from fieldkit.flight import Flight
from fieldkit.forecast.at_once import forecasts_at_once
from fieldkit.inference.history.quick_forecast import QuickAnswer
from fieldkit.motors import Found
from fieldkit.motors.motor import Motor
from fieldkit.planning.check import Verdict
from fieldkit.planning.forecasts import RocketData
from fieldkit.planning.limits import Limit
from fieldkit.planning.motor_guide import MotorOrder, label, lifts
from fieldkit.planning.quantiles import Three, named
from fieldkit.planning.safety import thrust_line, thrust_to_weight

LEVELS = (0.05, 0.5, 0.95)
QUICK_ERROR = "provisional: off by up to 10% either way, more if flights disagree"
"""How far quick apogees are from those of the full forecast, of motors that fit."""


@dataclass(frozen=True, slots=True)
class QuickChoice:
    """A motor with a quick forecast, without delay and safety checks.

    `interval` are the 5, 50 and 95% quantiles of the altimeter's apogee reading [m], `top_speed` is the median, None if
    it is not known [m/s]. `flown` is whether this rocket has flown the motor. Thrust to weight is for the first half
    second and for the average [1].
    """

    motor: Motor
    interval: Three
    top_speed: float | None
    flown: bool
    first_thrust: float
    average_thrust: float

    @property
    def apogee(self) -> float:
        """Median of the altimeter's apogee reading. [m]"""
        return self.interval[1]

    def thrust_verdict(self, limits: Mapping[str, Limit]) -> Verdict:
        """The verdict on its thrust for the weight."""
        return thrust_line({"at first": self.first_thrust, "on average": self.average_thrust}, limits).verdict

    def json(self) -> dict[str, Any]:
        """Ready for JSON, with the unit in the key."""
        return {
            "maker": self.motor.maker,
            "motor": self.motor.designation,
            "class": self.motor.impulse_class,
            "apogee_m": named(self.interval),
            "top_speed_mps": self.top_speed,
            "thrust_to_weight": {"first_half_second": self.first_thrust, "average": self.average_thrust},
            "flown": self.flown,
        }


def sorted_quickly(found: Sequence[QuickChoice], order: MotorOrder, limits: Mapping[str, Limit]) -> list[QuickChoice]:
    """In the order of the guide; those too weak last."""

    def place(one: QuickChoice) -> tuple[bool, float, bool, float]:
        verdict = one.thrust_verdict(limits)
        return verdict == "unsafe", *order.place(one.motor, one.apogee, weak=verdict == "caution")

    return sorted(found, key=place)


def quick_guide(rocket: RocketData, plan: Flight, motors: Sequence[Motor]) -> list[QuickChoice]:
    """Quick forecasts of a plan on motors, in the same order, from one batch; nothing is saved.

    Left out are clusters, motors that would not lift the rocket off a rod (`lifts`), and all motors if the rocket has
    not flown: for these there is no quick answer. Raises ImpossibleFlight for a flight without a dry mass, DamagedModel
    if the hyperprior cannot be read.
    """
    mass = plan.dry_mass or math.nan
    single = [motor for motor in motors if not motor.parts and lifts(motor, mass)]
    if not rocket.history or not single:
        return []
    planned = [(plan.with_changes(motor=label(motor), delay=None), Found(motor, None)) for motor in single]
    answers = forecasts_at_once(rocket.history, planned, shared=rocket.shared)
    flown = {label(found.motor) for found in rocket.motors}
    made = (_choice(motor, one, plan, flown) for motor, one in zip(single, answers, strict=True))
    return [one for one in made if all(map(math.isfinite, one.interval))]


def _choice(motor: Motor, answer: QuickAnswer, plan: Flight, flown: set[str]) -> QuickChoice:
    low, middle, high = (answer.apogee_at(level) for level in LEVELS)
    top_speed = answer.readouts.get("top_speed")
    return QuickChoice(
        motor,
        (low, middle, high),
        None if top_speed is None else top_speed[1],
        label(motor) in flown,
        *thrust_to_weight(motor, plan.dry_mass or math.nan),
    )
