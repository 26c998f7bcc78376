"""A plan completed from what is known: earlier flights, the rocket's configurations, kits, sites and settings."""

from collections.abc import Sequence
from contextlib import suppress

from fieldkit.errors import FieldkitError
from fieldkit.flight import Flight
from fieldkit.flight.plan import STAGED_TAG
from fieldkit.flight.recovery import DEVICES, STABILITY
from fieldkit.flight.typed_columns import POSITIVE
from fieldkit.ledger import Ledger
from fieldkit.motors import Catalogue, Motor
from fieldkit.motors.several import names_stages
from fieldkit.planning.margin import with_margin
from fieldkit.rocket import Configuration, Rocket
from fieldkit.services.kits import kit_of_rocket
from fieldkit.services.plausible_flights import plausible
from fieldkit.services.sites import site_of
from fieldkit.settings import Settings

BODY = ("dry_mass", "diameter")
"""Figures of a configuration that every flight of it shares."""


def completed(
    ledger: Ledger, motors: Catalogue, plans: Sequence[Flight], settings: Settings | None = None
) -> list[Flight]:
    """Plans with their missing values filled in: mass and diameter as in `body`, the rail as last flown or the flyer's
    usual or longest one, the last site, the elevation of the site, and the recovery as last flown. No weather is
    assumed.

    Raises BadValue for a damaged file of kits.
    """
    last, settings = ledger.latest(), settings or Settings()
    flown = {name: plausible(ledger.flights(name), motors) for name in {plan.rocket for plan in plans}}
    rockets = {name: ledger.rocket(name) for name in flown}
    elevations: dict[str, float | None] = {}
    found = []
    for plan in plans:
        flights, rocket = flown[plan.rocket], rockets[plan.rocket]
        own = [flight for flight in flights if flight.config == plan.config]
        plan = plan.with_defaults(**body(plan, flights, rocket, other_builds=True))
        plan = plan.with_defaults(rail_length=_latest(own or flights, "rail_length"))
        if not plan.site and plan.site_elevation is None and last is not None:
            plan = plan.with_changes(site=last.site)
        if plan.site not in elevations:
            elevations[plan.site] = site_of(ledger, plan.site).elevation
        plan = plan.with_defaults(
            rail_length=settings.rail_length or max(settings.flyer.rails, default=None),
            rail_angle=settings.rail_angle,
            site_elevation=elevations[plan.site],
        )
        found.append(with_margin(_with_recovery(plan, own), rocket, _motor(plan, motors)))
    return found


def _motor(plan: Flight, motors: Catalogue) -> Motor | None:
    """The motor of a plan; None if it has none that is known, or several."""
    with suppress(FieldkitError):
        return motors.resolve(plan.motor).motor
    return None


def completed_plan(ledger: Ledger, motors: Catalogue, plan: Flight, settings: Settings) -> Flight:
    """One plan, as in `completed`. Raises BadValue for a damaged file of kits."""
    return completed(ledger, motors, [plan], settings)[0]


def body(
    flight: Flight, flights: Sequence[Flight], rocket: Rocket, *, other_builds: bool = False
) -> dict[str, float | None]:
    """Dry mass [kg] and diameter [m] of a flight of a rocket, None if unknown: each as in the last of its `flights` in
    this configuration, else as known of the configuration, else of the kit that the rocket is named after.

    The mass of a flight with boosters is that of another one with boosters. The diameter, and with `other_builds` the
    mass too, may be that of another configuration before that of a kit. Raises BadValue for a damaged file of kits.
    """
    staged = names_stages(flight.motor)
    masses = [one for one in flights if (STAGED_TAG in one.tags) == staged]
    known, found = rocket.body(flight.config), dict[str, float | None]()
    for name, like in (("dry_mass", masses), ("diameter", flights)):
        own = _latest([one for one in like if one.config == flight.config], name)
        other = _latest(like, name) if other_builds or name == "diameter" else None
        found[name] = next((value for value in (own, known[name], other) if value is not None), None)
    if rocket.name and None in found.values() and (kit := kit_of_rocket(rocket.name)):
        found = {name: getattr(kit, name) if value is None else value for name, value in found.items()}
    return found


def stated_bodies(ledger: Ledger, plans: Sequence[Flight]) -> list[Configuration]:
    """The masses and diameters that plans state, of configurations without a flight that has them: to be saved, so that
    the next plan and the first flight have them.

    Left out are figures on which the plans of a configuration differ, those of a flight on several stages, and those of
    a rocket without a name.
    """
    stated: dict[tuple[str, str], list[Flight]] = {}
    for plan in plans:
        if plan.rocket and not names_stages(plan.motor):
            stated.setdefault((plan.rocket, plan.config), []).append(plan)
    found = []
    for (rocket, config), own in stated.items():
        flown, known = [one for one in ledger.flights(rocket) if one.config == config], dict[str, float | None]()
        for name in BODY:
            values = {one.number(name) for one in own} - {None}
            known[name] = values.pop() if len(values) == 1 and _latest(flown, name) is None else None
        if known != dict.fromkeys(BODY):
            found.append(
                Configuration(rocket, config, weighed_mass=known["dry_mass"], measured_diameter=known["diameter"])
            )
    return found


def keep_bodies(ledger: Ledger, plans: Sequence[Flight]) -> list[Configuration]:
    """Save what plans state, as in `stated_bodies`, as a change that can be undone; returns it, none if it is known."""
    stated = stated_bodies(ledger, plans)
    named = ", ".join(f"{one.rocket} {one.config}".strip() for one in stated)
    return stated if stated and ledger.change_drafts({}, "rocket", named, stated) else []


def _latest(flights: Sequence[Flight], name: str) -> float | None:
    """A number of the last of these flights that has it."""
    return next((value for one in reversed(flights) if (value := one.number(name)) is not None), None)


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


def _with_recovery(plan: Flight, own: Sequence[Flight]) -> Flight:
    """A plan with the recovery of the last of its configuration's flights, unless it has its own; on another device it
    takes nothing that describes the former one. Unreadable texts are skipped."""
    for names in INHERITED_RECOVERY:
        if any(name in plan.columns.headers for name in names):
            continue
        like = [flight for flight in own if names[0] in OF_ANY_DEVICE or _device(flight) == _device(plan)]
        last = next((flight for flight in reversed(like) if _has(flight, names)), plan)
        plan = plan.with_columns(**last.columns.as_recorded(names))
    return plan


def _has(flight: Flight, names: Sequence[str]) -> bool:
    """Whether a flight has one of these recovery columns, and they can be read."""
    together = ("recovery", *POSITIVE) if "drogue_speed" in names else names
    columns = flight.columns
    return columns.readable(*names, *together) and any(name in columns.headers for name in names)


def _device(flight: Flight) -> str:
    return flight.text("recovery").strip().lower() or DEVICES[0]
