"""Starting values of a planned flight: its design, and the previous flight."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from datetime import timedelta
from typing import Any

from fieldkit.flight.flight import Flight

STAGED_TAG = "staged"
"""The tag of a flight on several stages, whose dry mass may include boosters that another plan does not carry."""
INHERITED_FIELDS = ("dry_mass", "diameter", "rail_length")
"""Fields that a plan inherits from earlier flights if it has no value of its own."""


@dataclass(frozen=True, slots=True)
class Start:
    """What is known about a rocket's configuration before it has flown, and the source file; None if unknown. SI.

    `cg` and `cp` are the centers of gravity and of pressure as it leaves the launch rod, from the tip of the nose.
    """

    rocket: str
    config: str
    dry_mass: float | None = None
    diameter: float | None = None
    length: float | None = None
    cd: float | None = None
    source: str = ""
    cg: float | None = None
    cp: float | None = None

    @property
    def margin(self) -> float | None:
        """Static stability margin: the center of pressure behind the center of gravity, in diameters. [1]"""
        if self.cg is None or self.cp is None or not self.diameter:
            return None
        return (self.cp - self.cg) / self.diameter


def completed(plan: Flight, history: Sequence[Flight], start: Start | None = None) -> Flight:
    """A plan with missing mass, diameter and rail length filled in, each from the last flight that recorded it; not the
    mass of a flight with boosters.

    `history` are the flights of its rocket in order; only those of its configuration count if there are any. For a
    configuration that has not flown, `start` supplies mass and diameter first.
    """
    if start is not None and all(flight.config != plan.config for flight in history):
        plan = plan.with_defaults(dry_mass=start.dry_mass, diameter=start.diameter)
    same_config = [flight for flight in history if flight.config == plan.config] or list(history)
    missing: dict[str, Any] = {}
    for name in INHERITED_FIELDS:
        like = [flight for flight in same_config if name != "dry_mass" or STAGED_TAG not in flight.tags]
        value = next((v for flight in reversed(like) if (v := flight.number(name)) is not None), None)
        if plan.number(name) is None and value is not None:
            missing[name] = value
    return plan.with_changes(**missing)


def start_among(known: Sequence[Start], plan: Flight) -> Start | None:
    """The starting configuration that a plan names, or the only one that is known; otherwise None."""
    named = [one for one in known if one.config == plan.config]
    return (named or list(known))[0] if named or len(known) == 1 else None


def design_cds(known: Sequence[Start], flights: Sequence[Flight]) -> dict[str, float]:
    """Starting Cd of each configuration of some flights of a rocket, if a design gives one. [1]"""
    starts = {flight.config: start_among(known, flight) for flight in flights}
    return {config: start.cd for config, start in starts.items() if start and start.cd}


def repeated(flight: Flight) -> Flight:
    """A plan to repeat the flight a week later, or at the same time if there is no later date."""
    name = f"{flight.flight_id} again"  # a plan needs an id of its own
    plan = flight.unflown(flight_id=name, sd={}, source={}, tags=())
    try:
        return replace(plan, date_time=flight.date_time + timedelta(days=7) if flight.date_time else None)
    except OverflowError:
        return replace(plan, date_time=flight.date_time)
