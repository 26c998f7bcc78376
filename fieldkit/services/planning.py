"""Plans for a rocket of a ledger: the rocket by name, and the plan completed from the ledger."""

from collections.abc import Sequence

from fieldkit.errors import BadValue
from fieldkit.flight import Flight
from fieldkit.flight.recovery import (
    DEVICES,
    STABILITY,
    check_recovery,
    device_of,
    recovery_column,
    recovery_of,
    stability,
)
from fieldkit.flight.recovery import LIMITS as RECOVERY_LIMITS
from fieldkit.flight.start import completed
from fieldkit.ledger import Ledger
from fieldkit.motors import Catalogue
from fieldkit.planning.forecasts import Rocket
from fieldkit.services.fleet import fleet_prior
from fieldkit.services.forecasts import accepted_average, earlier_forecasts, flown, start_of
from fieldkit.services.kits import kit_of_rocket
from fieldkit.services.plausible_flights import exclusions, plausible
from fieldkit.services.sites import site_of
from fieldkit.settings import Settings

SHORTLIST = "shortlist"
"""Name under which the ledger saves the shortlists of motors, by rocket."""


def rocket_of(ledger: Ledger, motors: Catalogue, name: str) -> Rocket:
    """A rocket's flights, designs and settings in a ledger, and the mount of its kit, read once. Raises BadValue,
    DamagedModel if the hyperprior cannot be read.
    """
    history = flown(ledger, motors, name)
    return Rocket(
        history=tuple(history),
        averaged=accepted_average(ledger, name, flights=[flight for flight, _ in history]),
        earlier=earlier_forecasts(ledger, motors),
        starts=tuple(ledger.starts(name)),
        shared=fleet_prior(ledger, motors, name),
        excluded=tuple(exclusions(ledger.flights(name), motors)),
        mount=kit.mount if (kit := kit_of_rocket(name)) else None,
    )


def completed_plan(ledger: Ledger, motors: Catalogue, plan: Flight, settings: Settings) -> Flight:
    """A plan with its missing values filled in: mass, diameter and rail as last flown, otherwise mass and diameter of
    the design or of the kit that the rocket is named after, and the flyer's usual rail; the last site and its
    elevation. Weather is that of the day if it was entered, and is never assumed here.

    Raises BadValue for a damaged file of kits.
    """
    history = plausible(ledger.flights(plan.rocket), motors)
    plan = _of_kit(completed(plan, history, start_of(ledger, plan)))
    last = ledger.latest()
    if not plan.site and plan.site_elevation is None and last is not None:
        plan = plan.with_changes(site=last.site)
    elevation = site_of(ledger, plan.site).elevation
    plan = plan.with_defaults(
        rail_length=settings.rail_length, rail_angle=settings.rail_angle, site_elevation=elevation
    )
    return _with_recovery(plan, history)


def _of_kit(plan: Flight) -> Flight:
    """A plan with the mass and the diameter of the kit that its rocket is named after, if it has none of its own."""
    if not plan.rocket or None not in (plan.dry_mass, plan.diameter):
        return plan
    kit = kit_of_rocket(plan.rocket)
    return plan.with_defaults(dry_mass=kit.dry_mass, diameter=kit.diameter) if kit else plan


INHERITED_RECOVERY = (
    ("recovery",),
    ("drogue_speed",),
    ("main_altitude",),
    ("main_speed", "parachute_diameter"),
    ("opening_time",),
    (STABILITY,),
)
"""The recovery and stability of a plan, from the last flight of its configuration that has them. Descent speed and
diameter of a parachute describe the same one, so a plan with either takes neither."""
OF_ANY_DEVICE = ("recovery", STABILITY)
"""Columns that a plan takes even from a flight on another device."""


def _with_recovery(plan: Flight, flights: Sequence[Flight]) -> Flight:
    """A plan with the recovery of its configuration's last flight, unless it has its own; on another device it takes
    nothing that describes the former one. Unreadable texts are skipped."""
    own = [flight for flight in reversed(flights) if flight.config == plan.config]
    for names in INHERITED_RECOVERY:
        if any(recovery_column(plan, name) for name in names):
            continue
        like = own if names[0] in OF_ANY_DEVICE else [flight for flight in own if _device(flight) == _device(plan)]
        last = next((flight for flight in like if _has(flight, names)), plan)
        found = {key: last.extra[key] for name in names if (key := recovery_column(last, name))}
        plan = plan.with_changes(extra={**plan.extra, **found}) if found else plan
    return plan


def _has(flight: Flight, names: Sequence[str]) -> bool:
    """Whether a flight has one of these recovery columns, and they can be read."""
    try:
        check_recovery(flight, [name for name in names if name in RECOVERY_LIMITS])
        if "recovery" in names:
            device_of(flight)
        if "drogue_speed" in names:
            recovery_of(flight)  # raised for a drogue without a main
        if STABILITY in names:
            stability(flight)
    except BadValue:
        return False
    return any(recovery_column(flight, name) for name in names)


def _device(flight: Flight) -> str:
    return flight.extra.get("recovery", "").strip().lower() or DEVICES[0]


def shortlist(ledger: Ledger, rocket: str) -> frozenset[str]:
    """The motors on a rocket's shortlist, by `label`."""
    return frozenset((ledger.draft(SHORTLIST) or {}).get(rocket, ()))


def keep_shortlist(ledger: Ledger, rocket: str, labels: frozenset[str]) -> None:
    """Save these motors as the shortlist of a rocket, as a change that can be undone."""
    ledger.change_draft(SHORTLIST, lambda saved: saved | {rocket: sorted(labels)}, "shortlist", f"of {rocket}")
