"""The motors of the page Next: which are listed, in what order, and what has been forecast of them."""

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from math import inf
from typing import TYPE_CHECKING

from fieldkit.quantities import spelled, unit_of
from fieldkit.tui.widgets import cards

if TYPE_CHECKING:
    from fieldkit.forecast.prediction import Prediction
    from fieldkit.motors import Catalogue, Motor
    from fieldkit.planning.motor_guide import MotorChoice
    from fieldkit.tui.next.next_plan import Plan

AT_ONCE = 40
"""Motors forecast together: the first are in sight before the others are worked out."""
MAX_FORECAST_MOTORS = 200
"""Motors that a search forecasts; a longer word narrows the search."""

TOO_WEAK = "thrust to weight"
"""The safety line that a motor fails which does not lift the rocket well."""


@dataclass(slots=True)
class MotorList:
    """What a search found for a `plan`, and the forecasts that are `known` by now; `fitting` leaves out the rest of the
    catalog until something is searched."""

    plan: "Plan | None" = None
    found: "Sequence[Motor]" = ()
    known: "dict[Motor, MotorChoice]" = field(default_factory=dict)
    fitting: bool = True
    exact: "set[Motor]" = field(default_factory=set)
    """Motors whose forecast is what saving it would save; the others are flown less often."""

    def find(self, motors: "Catalogue", text: str) -> "list[Motor]":
        """All that a text finds, what fits first; without a text, and until all is asked for, only what fits."""
        found, plan = motors.search(text), self.plan
        if plan is None:
            return found
        if self.fitting and not text.strip():
            return [motor for motor in found if plan.wanted.fits(motor)]
        return sorted(found, key=lambda motor: not plan.wanted.fits(motor))

    def waiting(self) -> "list[Motor]":
        """The next few motors without a forecast, in the order found."""
        return [motor for motor in self.found[:MAX_FORECAST_MOTORS] if motor not in self.known][:AT_ONCE]

    def turn_to(self, plan: "Plan | None") -> None:
        """Another plan: nothing is known of it yet."""
        self.plan, self.known, self.exact = plan, {}, set()

    def put_exact(self, motor: "Motor", made: "Prediction") -> None:
        """The forecast of a motor with all draws, in place of the one that filled the list."""
        if (one := self.known.get(motor)) is not None:
            self.known[motor] = replace(one, prediction=made)
            self.exact.add(motor)

    def fits(self, motor: "Motor") -> bool:
        """Whether the rocket can fly on it: it goes in, and what is known by now does not say that it is too weak."""
        one = self.known.get(motor)
        weak = one is not None and any(line.name == TOO_WEAK for line in one.why_not)
        return not weak and (self.plan is None or self.plan.wanted.fits(motor))

    def ordered(self, target: float | None) -> "list[Motor]":
        """What fits first; the nearest to the target [m] before others, without one those flown last."""
        if target is not None:
            places = {motor: abs(one.apogee - target) for motor, one in self.known.items()}
        else:
            places = {motor: place for place, motor in enumerate(self.plan.flown if self.plan else ())}
        return sorted(self.found, key=lambda motor: (not self.fits(motor), places.get(motor, inf)))

    def counted(self, system: str) -> str:
        """How many motors there are, how many fit, and how many forecasts are still to come: `12 of 57 fit · m`."""
        fit = sum(map(self.fits, self.found))
        left = min(len(self.found), MAX_FORECAST_MOTORS) - sum(motor in self.known for motor in self.found)
        every = "" if fit == len(self.found) else f" of {len(self.found)}"
        unit = spelled(unit_of(cards.APOGEE, system))
        return f"{fit}{every} fit" + (f", {left} left" if left > 0 else "") + f" · {unit}"
