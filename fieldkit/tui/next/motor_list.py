"""The motors of the Fly page: their selection, order and forecasts."""

from collections.abc import Mapping, Sequence, Set
from dataclasses import dataclass, field
from math import inf

from fieldkit.forecast.prediction import Prediction
from fieldkit.motors import Catalogue, Motor
from fieldkit.planning.check import Verdict
from fieldkit.planning.motor_guide import MotorChoice, MotorOrder
from fieldkit.planning.quick_guide import QuickChoice
from fieldkit.quantities import spelled, unit_of
from fieldkit.tui.next.next_plan import NextPlan
from fieldkit.tui.widgets import cards

AT_ONCE = 40
"""Number of motors forecast together, so that the first results appear before the others."""
MAX_FORECAST_MOTORS = 200
"""Maximum number of motors to forecast in a search, besides the current and the preferred ones; a longer word narrows
the search. [1]"""

MAX_STORED_FORECASTS = 250
"""Maximum number of forecasts that are kept when the next search asks for others: all of a search, and those wanted
without one. Each takes 0.08 MB, those of the whole catalog 80 MB. [1]"""


@dataclass(slots=True)
class MotorList:
    """The results of a search for a `plan`, and the forecasts `known` so far; until the fit of a motor is known, the
    quick forecast is in `quick`. `fitting` shows only motors that fit unless there is a search."""

    plan: NextPlan | None = None
    found: Sequence[Motor] = ()
    known: dict[Motor, MotorChoice] = field(default_factory=dict)
    quick: dict[Motor, QuickChoice] = field(default_factory=dict)
    fitting: bool = True
    box: Mapping[Motor, int] | None = None
    """How many of each motor are in the flyer's range box, to list only these, each with the delays that are there;
    None lists all."""
    exact: set[Motor] = field(default_factory=set)
    """Motors with a forecast at full precision, as it would be saved; the others have fewer draws."""

    def find(self, motors: Catalogue, text: str) -> list[Motor]:
        """All matches of a text, those that fit first; without a text, only those that fit unless all are requested."""
        found, plan = motors.search(text), self.plan
        if self.box is not None:
            names = {(motor.maker, motor.designation) for motor in found}
            found = [motor for motor in self.box if (motor.maker, motor.designation) in names]
        if plan is None:
            return found
        if self.fitting and self.box is None and not text.strip():
            return [motor for motor in found if plan.wanted.fits(motor)]
        return sorted(found, key=lambda motor: not plan.wanted.fits(motor))

    def waiting(self, current: Motor | None) -> list[Motor]:
        """The next few motors without a fit: the current one if there is one, then those preferred, then in the order
        found."""
        return [motor for motor in self._wanted(current) if motor not in self.known][:AT_ONCE]

    def unanswered(self, current: Motor | None) -> list[Motor]:
        """All motors of a search with neither a fit nor a quick answer."""
        return [motor for motor in self._wanted(current) if self.shown(motor) is None]

    def _wanted(self, current: Motor | None) -> list[Motor]:
        """The motors to forecast, in order."""
        preferred = [motor for motor in (self.plan.order(None).preferred if self.plan else ()) if motor in self.found]
        return list(dict.fromkeys([*([current] if current else []), *preferred, *self.found[:MAX_FORECAST_MOTORS]]))

    def shown(self, motor: Motor | None) -> MotorChoice | QuickChoice | None:
        """The forecast of a motor: of the fit, or until then the quick one; None if there is none yet."""
        return None if motor is None else self.known.get(motor) or self.quick.get(motor)

    @property
    def every_shown(self) -> dict[Motor, MotorChoice | QuickChoice]:
        """All results of `shown`."""
        return {**self.quick, **self.known}

    def turn_to(self, plan: NextPlan | None) -> None:
        """Set another plan, without forecasts unless they are the same; without a plan, no motors."""
        if plan is None or self.plan is None or not plan.same_forecasts(self.plan):
            self.known, self.quick, self.exact = {}, {}, set()
        else:
            self._drop_other_delays(plan, self.plan)
        self.plan = plan
        self.found = self.found if plan is not None else ()

    def _drop_other_delays(self, plan: NextPlan, before: NextPlan) -> None:
        """Drop forecasts of motors that now have an open forecast with another delay, or none any more."""
        for motor, one in list(self.known.items()):
            now = plan.saved_delay(motor)
            if now not in (before.saved_delay(motor), one.delay):
                del self.known[motor]
                self.exact.discard(motor)

    def put(self, plan: NextPlan, found: Sequence[MotorChoice]) -> None:
        """Add forecasts of a plan, unless it has been replaced in the meantime; drop the oldest of other searches if
        there are too many."""
        if plan is self.plan:
            self.known |= {one.motor: one for one in found}
            if len(self.known) > MAX_STORED_FORECASTS:
                self._drop_oldest({one.motor for one in found}.union(self._wanted(None)))

    def _drop_oldest(self, wanted: Set[Motor]) -> None:
        """Drop the oldest forecasts of motors that are not wanted now, as many as there are too many."""
        others = [motor for motor in self.known if motor not in wanted]
        for motor in others[: len(self.known) - MAX_STORED_FORECASTS]:
            del self.known[motor]
            self.exact.discard(motor)

    def put_quick(self, plan: NextPlan, found: Sequence[QuickChoice]) -> None:
        """Add quick forecasts of a plan, unless it has been replaced in the meantime."""
        if plan is self.plan:
            self.quick |= {one.motor: one for one in found}

    def put_exact(self, motor: Motor, made: Prediction) -> None:
        """Replace the forecast of a motor by one with all draws."""
        if (one := self.known.get(motor)) is not None:
            self.known[motor] = one.with_forecast(made)
            self.exact.add(motor)

    def fits(self, motor: Motor) -> bool:
        """Whether a motor fits the mount and is safe and sensible by its forecast, if there is one yet; by its thrust
        while there is only a quick one."""
        one = self.known.get(motor)
        sensible = self._quick_thrust(motor) != "unsafe" if one is None else one.fits
        return sensible and (self.plan is None or self.plan.wanted.fits(motor))

    def weak(self, motor: Motor) -> bool:
        """Whether the thrust of a motor asks for caution at this weight."""
        one = self.known.get(motor)
        return self._quick_thrust(motor) in ("caution", "unsafe") if one is None else one.weak

    def _quick_thrust(self, motor: Motor) -> Verdict:
        """The verdict on the thrust of a motor with a quick forecast."""
        one = self.quick.get(motor)
        if one is None or self.plan is None:
            return "unknown"
        return one.thrust_verdict(self.plan.limits)

    def ordered(self, target: float | None) -> list[Motor]:
        """Those that fit first, then those that only their forecast excludes, as in `MotorOrder`; those without a
        forecast are last, so that no key acts on one of them."""
        places = self.plan.order(target) if self.plan else MotorOrder(target)

        def order(motor: Motor) -> tuple[bool, bool, bool, float, bool, float]:
            one = self.shown(motor)
            wide = self.plan is not None and not self.plan.wanted.fits(motor)
            apogee = inf if one is None else one.apogee
            return one is None, not self.fits(motor), wide, *places.place(motor, apogee, weak=self.weak(motor))

        return sorted(self.found, key=order)

    def counted(self, system: str) -> str:
        """The numbers of motors, of those that fit, and of fits still to come: `12 of 57 fit, 45 quick · apogee in m`;
        `left` instead of `quick` if some have no quick forecast either."""
        fit = sum(map(self.fits, self.found))
        left = min(len(self.found), MAX_FORECAST_MOTORS) - sum(motor in self.known for motor in self.found)
        every = "" if fit == len(self.found) else f" of {len(self.found)}"
        unit = spelled(unit_of(cards.APOGEE, system))
        word = "quick" if left <= sum(isinstance(self.shown(motor), QuickChoice) for motor in self.found) else "left"
        boxed = "" if self.box is None else " · your box"
        return f"{fit}{every} fit{boxed}" + (f", {left} {word}" if left > 0 else "") + f" · apogee in {unit}"
