"""The plan that the options of a command describe, completed from the rocket's last flight, a kit, or the mass weighed
with the motor."""

from collections.abc import Iterator, Mapping, Sequence
from contextlib import suppress
from typing import TYPE_CHECKING

import typer

from fieldkit.cli.options import FIELD
from fieldkit.cli.screen import complain, system
from fieldkit.cli.session import LIFT_OFF, dry_mass
from fieldkit.errors import LedgerError, UnknownMotor
from fieldkit.flight import BY_NAME, MOTOR_TEMPERATURE, Flight
from fieldkit.flight.plan import check_plan
from fieldkit.flight.plausibility import doubts, far_from_flown, implausible
from fieldkit.flight.recovery import RECOVERY_NAMES, recovery_header
from fieldkit.paths import data_file
from fieldkit.quantities import in_system, significant
from fieldkit.services.names import same_name
from fieldkit.settings import read_settings

if TYPE_CHECKING:
    from fieldkit.ledger import Ledger
    from fieldkit.motors import Catalogue
    from fieldkit.planning.kits import Kit

Given = Mapping[str, str | None]
"""Options of a plan as typed, None if not given."""


def kit_named(given: Given) -> "Kit | None":
    """The kit that is named; None if none is. Raises BadValue."""
    from fieldkit.planning.kits import kit_of

    name = given.get("kit")
    return kit_of(data_file("kits.toml"), name) if name else None


def plan_from_options(ledger: "Ledger", motors: "Catalogue", given: Given) -> "Flight":
    """The flight described by the options; rocket, configuration, mass, rail and site are by default as last flown.

    Raises BadValue, BadParameter.
    """
    from fieldkit.importing.manual_entry import read_changes
    from fieldkit.planning.kits import check_mount
    from fieldkit.services.plans import completed_plan

    if given.get("dry_mass") and given.get(LIFT_OFF):
        raise typer.BadParameter("found --dry-mass and --lift-off-mass, expected one of them")
    if given.get("main_speed") and given.get("parachute_diameter"):
        complain("note: --main-speed is used; --parachute-diameter only selects earlier flights on this parachute")
    changes = {
        name: text for name, text in given.items() if text is not None and name not in (*dict(FIELD), *RECOVERY_NAMES)
    }
    kit = kit_named(given)
    if kit:
        changes.setdefault("rocket", kit.name)
    if changes.get("rocket"):
        changes["rocket"] = same_name(changes["rocket"], ledger.names("rocket"))
    last = ledger.latest(changes.get("rocket") or next(iter(ledger.names("rocket")), None))
    plan = Flight(rocket=last.rocket if last else "", config=last.config if last else "")
    plan = plan.with_changes(**read_changes(plan, changes))
    if given.get("motor_temperature"):
        plan = plan.with_changes(extra={MOTOR_TEMPERATURE: given["motor_temperature"]})
    if kit:
        plan = plan.with_defaults(dry_mass=kit.dry_mass, diameter=kit.diameter)
        if plan.motor:
            check_mount(kit, motors.resolve_several(plan.motor).motor)
    if lift_off := given.get(LIFT_OFF):
        on_pad = plan.with_changes(motor=plan.motor or (last.motor if last else ""))
        plan = plan.with_changes(dry_mass=dry_mass(motors, on_pad, lift_off))
    typed = {recovery_header(name): text for name in RECOVERY_NAMES if (text := given.get(name))}
    plan = plan.with_columns(**typed)
    stated = plan
    plan = completed_plan(ledger, motors, plan, read_settings())
    check_plan(plan)
    for note in _doubts(ledger, motors, plan, given):
        complain(f"note: {note}")
    remember(ledger, motors, [stated])
    return plan


def remember(ledger: "Ledger", motors: "Catalogue", plans: "Sequence[Flight]") -> None:
    """Save the masses and diameters that plans state, unless they are impossible on their motors, and print them."""
    from fieldkit.services.plans import BODY, keep_bodies

    stated = []
    for plan in plans:
        with suppress(UnknownMotor):
            found = motors.resolve_several(plan.motor) if plan.motor else None
            stated += [plan] if found is None or not implausible(plan, found.motor) else []
    with suppress(LedgerError):  # a full or read-only disk: the plan is good without it
        for one in keep_bodies(ledger, stated):
            body = one.weighed_mass, one.measured_diameter
            figures = [
                f"{BY_NAME[name].title.lower()} {significant(BY_NAME[name], value, system())}"
                for name, value in zip(BODY, body, strict=True)
                if value is not None
            ]
            build = f"{one.rocket} {one.config}".strip()
            complain(f"note: saved {' and '.join(figures)} of {build}; `fieldkit undo` to undo")


def _doubts(ledger: "Ledger", motors: "Catalogue", plan: "Flight", given: Given) -> "Iterator[str]":
    """What looks mistyped in a plan: a name that is not known, a value that is unusual or impossible on the motor. The
    plan is forecast anyway."""
    from fieldkit.services.unknown_names import unknown_names

    yield from unknown_names(ledger, plan, given)
    flown = ledger.latest(plan.rocket, plan.config) if plan.rocket else None
    far = far_from_flown(plan, flown) if flown is not None else ()
    yield from (in_system(one, system()) for one in (*doubts(plan), *far))
    with suppress(UnknownMotor):
        if plan.motor and (reason := implausible(plan, motors.resolve_several(plan.motor).motor)):
            yield in_system(reason, system())
