"""The static margin of a planned flight, from the design of its configuration with the planned motor loaded."""

from fieldkit.flight import Flight
from fieldkit.flight.recovery import MAX_STABILITY, STABILITY, STABILITY_SOURCE
from fieldkit.motors import Motor
from fieldkit.rocket import Rocket


def with_margin(plan: Flight, rocket: Rocket, motor: Motor | None) -> Flight:
    """A plan with the static margin of its design, unless it has its own: with a loaded motor if the design shows where
    it sits, otherwise with the design's. One that is not above zero counts as the least that can be stored."""
    design = rocket.design(plan.config)
    if design is None or (STABILITY in plan.columns.headers and not plan.text(STABILITY_SOURCE)):
        return plan
    own = None if motor is None else design.margin_on(motor.loaded_mass, motor.length, plan.dry_mass)
    margin = design.margin if own is None else own
    if margin is None:
        return plan
    stored = {STABILITY: f"{max(margin, 1 / MAX_STABILITY):.2f}", STABILITY_SOURCE: design.source or "design"}
    return plan.with_columns(**stored)
