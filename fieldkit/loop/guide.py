"""Which motors fit a rocket, and where each would take it: the forecast of many motors at once."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from fieldkit.flight import Flight
from fieldkit.ledger import Ledger
from fieldkit.loop.desk import accepted_places, accepted_widening, completed, flown
from fieldkit.loop.predict import Prediction, predict
from fieldkit.loop.widen import widened
from fieldkit.motors import Catalogue, Found, Motor
from fieldkit.units import STANDARD_GRAVITY

SLACK = 0.0006
"""How much wider than its motors a mount may measure. [m]"""
MANY = 400
"""Flights flown for each motor of a long list: their 5 % quantile is good to a sixth of the spread. [1]"""
FEW = 40
"""Flights flown to choose a delay by its median. [1]"""
LEAST_THRUST = 2.0
"""Thrust over weight below which a motor is not offered at all: it would not clear a rod. [1]"""


@dataclass(frozen=True, slots=True)
class Choice:
    """A motor with the delay that suits it best, and the flight it would give.

    `ejections` are its delays on sale, and when each would fire after apogee, in the median. [s]
    """

    motor: Motor
    delay: float | None
    ejections: tuple[tuple[float, float], ...]
    prediction: Prediction

    @property
    def apogee(self) -> float:
        """The median of what the altimeter will show. [m]"""
        return float(np.median(self.prediction.apogee))

    @property
    def plan(self) -> Flight:
        """The planned flight, motor and delay and all."""
        return self.prediction.plan


def mount(history: Sequence[tuple[Flight, Found]], config: str) -> float | None:
    """The diameter of the widest motor that a rocket has flown on, its configuration's where known. [m]"""
    alike = [found.motor.diameter for flight, found in history if flight.config == config]
    every = alike or [found.motor.diameter for _, found in history]
    return max(every, default=None)


def fits(motor: Motor, diameter: float | None, dry_mass: float) -> bool:
    """Whether a motor on sale goes into a mount and lifts the rocket off a rod."""
    if not motor.available or (diameter is not None and motor.diameter > diameter + SLACK):
        return False
    weight = (dry_mass + motor.loaded_mass) * STANDARD_GRAVITY
    return motor.average_thrust > LEAST_THRUST * weight


def choices(
    ledger: Ledger, motors: Catalogue, plan: Flight, wanted: Sequence[Motor], draws: int = MANY
) -> list[Choice]:
    """The flight that a plan would become on each of some motors, in the same order; nothing is kept.

    A motor flies with the delay on sale that fires nearest to apogee. Raises ImpossibleFlight for a plan without a
    mass, which the rocket's flights do not tell either.
    """
    history = flown(ledger, motors, plan.rocket)
    plan = completed(plan, [flight for flight, _ in history])
    places, wider = accepted_places(ledger, plan.rocket), accepted_widening(ledger, plan.rocket)

    def fly(delays: Sequence[float | None], draws: int) -> list[Prediction]:
        planned = [(_on(plan, one, delay), Found(one, delay)) for one, delay in zip(wanted, delays, strict=True)]
        made = predict(history, planned, places, draws=draws) if planned else []
        return [widened(one, wider) for one in made]

    longest = [max((d for d in one.delays if np.isfinite(d)), default=None) for one in wanted]
    ejections = [
        _ejections(one, delay, said) for one, delay, said in zip(wanted, longest, fly(longest, FEW), strict=True)
    ]
    best = [min(each, key=lambda pair: abs(pair[1]))[0] if each else None for each in ejections]
    made = fly(best, draws)
    return [Choice(*each) for each in zip(wanted, best, ejections, made, strict=True)]


def _on(plan: Flight, motor: Motor, delay: float | None) -> Flight:
    return plan.with_changes(motor=f"{motor.maker} {motor.designation}", delay=delay)


def _ejections(motor: Motor, flown_with: float | None, said: Prediction) -> tuple[tuple[float, float], ...]:
    """Each delay on sale and when it would fire; a delay longer by a second fires a second later."""
    if flown_with is None or (last := said.median_eject) is None:
        return ()
    return tuple((delay, last + delay - flown_with) for delay in sorted(motor.delays) if np.isfinite(delay))


def by_closeness(found: Sequence[Choice], target: float | None) -> list[Choice]:
    """Nearest to a target first [m]; without one, the lowest first."""
    return sorted(found, key=lambda one: abs(one.apogee - target) if target is not None else one.apogee)
