"""A planned flight with its complete forecast: apogee, descent, safety lines, and the best rail angle."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

from fieldkit.flight.site import Site
from fieldkit.forecast.prediction import Prediction
from fieldkit.planning.check import UNSAFE_RISK, SafetyCheck
from fieldkit.planning.descent_rate import Fall
from fieldkit.planning.forecasts import Plan
from fieldkit.planning.landing import MAX_RECOMMENDED_ANGLE, Landing, RailChoice, landing, rail_choices, wind_that_holds
from fieldkit.planning.limits import Limits
from fieldkit.planning.safety import safety_lines

OF_EVERY_RAIL = ("ground wind", "thrust to weight", "rail exit speed")
"""Checks that no angle of the rail changes: no angle is recommended for a flight that fails one."""
OF_THE_PATH = ("ejection speed", "landing speed")
"""Checks that depend on the angle of the rail."""


@dataclass(frozen=True, slots=True)
class PlannedFlight:
    """A plan, its forecast, the basis of its descent, its landing, its safety lines, and safe rail settings from best
    to worst; none if the wind is not known, or for the reason in `no_rail`.

    `holds` is the result of `wind_that_holds` [m/s]; None with a wind, or without the size of the field.
    """

    prediction: Prediction
    fall: Fall
    down: Landing
    lines: tuple[SafetyCheck, ...]
    rail: tuple[RailChoice, ...]
    holds: float | None = None
    no_rail: str = ""

    @property
    def name(self) -> str:
        """The plan's id, or its rocket if it has none."""
        return self.prediction.plan.flight_id or self.prediction.plan.rocket or "plan"

    def json(self) -> dict[str, Any]:
        """Ready for JSON, with the unit in the key."""
        return {
            "landing": self.down.json(),
            "rail": [one.json() for one in self.rail],
            "no_rail": self.no_rail,
            "timed_flights": self.fall.flights,
        }


def planned_flight(plan: Plan, site: Site, limits: Limits) -> PlannedFlight:
    """The complete forecast of a plan at a site, with the draws of `predict`, so that both show the same
    figures. Raises BadValue, ImpossibleFlight.
    """
    prediction, fall, wind = plan.forecast(), plan.fall, plan.flight.wind
    down = landing(prediction, fall)
    lines = safety_lines(prediction, site, fall, limits)
    holds = wind_that_holds(plan, site.size) if wind is None and site.size is not None else None
    no_rail = _why_no_rail(down, lines)
    rail = () if no_rail else _safe_rails(plan, site, limits, lines)
    if not no_rail and not rail and wind is not None:
        no_rail = f"at every angle {' and '.join(_unsafe(lines, OF_THE_PATH))} would be unsafe"
    return PlannedFlight(prediction, fall, down, tuple(lines), rail, holds, no_rail)


def _unsafe(lines: Sequence[SafetyCheck], names: Sequence[str]) -> list[str]:
    """The checks with these names that are unsafe."""
    return [line.name for line in lines if line.name in names and line.verdict == "unsafe"]


def _why_no_rail(down: Landing, lines: Sequence[SafetyCheck]) -> str:
    """Why no rail setting makes a flight safe; empty if one may."""
    if down.down.ballistic.mean() >= UNSAFE_RISK:
        return "the rocket hits the ground before deployment"
    found = _unsafe(lines, OF_EVERY_RAIL)
    return f"unsafe at every angle: {', '.join(found)}" if found else ""


def _safe_rails(plan: Plan, site: Site, limits: Limits, lines: Sequence[SafetyCheck]) -> tuple[RailChoice, ...]:
    """The rail settings from best to worst, without those that are unsafe if the plan's own, judged by its safety
    lines, is."""
    choices = rail_choices(plan, MAX_RECOMMENDED_ANGLE)
    if not _unsafe(lines, OF_THE_PATH):
        return tuple(choices)
    fall = plan.fall
    return tuple(one for one in choices if not _unsafe(safety_lines(one.forecast, site, fall, limits), OF_THE_PATH))
