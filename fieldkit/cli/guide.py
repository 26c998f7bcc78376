"""What `fieldkit motors --fit` prints: every motor that fits a rocket, and how it would fly."""

from collections.abc import Mapping
from typing import TYPE_CHECKING

import typer

from fieldkit.cli.screen import print_json, print_table, say
from fieldkit.cli.session import known_motors, open_ledger

if TYPE_CHECKING:
    from fieldkit.flight import Flight
    from fieldkit.ledger import Ledger
    from fieldkit.plan.guide import Choice

SHOWN = 12
"""How many motors have their checks told."""


def planned(ledger: "Ledger", rocket: str | None, given: Mapping[str, str | None]) -> "Flight":
    """The plan of a rocket of the ledger, its configuration as last flown where not said."""
    from fieldkit.entry import read_changes
    from fieldkit.flight import Flight
    from fieldkit.loop.desk import which_rocket

    name = which_rocket(ledger, rocket)
    last = ledger.latest(name)
    plan = Flight(rocket=name, config=last.config if last else "")
    changes = {key: text for key, text in given.items() if text is not None}
    return plan.with_changes(**read_changes(plan, changes))


def length(text: str | None, default: str) -> float | None:
    """A length typed with or without its unit, in m. Raises BadValue."""
    from fieldkit.units import parse

    return None if text is None else parse(text, "length", default)


def print_guide(
    context: typer.Context,
    rocket: str,
    given: Mapping[str, str | None],
    lengths: Mapping[str, str | None],
    classes: str,
    impulse: float | None,
    *,
    adapter: bool,
    retired: bool,
    json: bool,
) -> None:
    """Print the motor guide of a rocket, nearest to the target first."""
    import math

    from fieldkit.loop.desk import flown
    from fieldkit.places import data_folder
    from fieldkit.plan.desk import learn_rocket
    from fieldkit.plan.guide import Wanted, fitting, guide, mount_of
    from fieldkit.plan.limits import limits
    from fieldkit.plan.safety import DECIDES

    motors = known_motors()
    with open_ledger(context) as ledger:
        plan = planned(ledger, rocket, given)
        wanted = Wanted(
            mount=length(lengths["mount"], "mm") or mount_of([m for _, m in flown(ledger, motors, plan.rocket)]),
            length=length(lengths["max_length"], "mm") or math.inf,
            impulse=impulse or math.inf,
            classes=_classes(classes),
            retired=retired,
            adapter=adapter,
        )
        fits = fitting(motors, wanted)
        learnt = learn_rocket(ledger, motors, plan)
    target = length(lengths["target"], "m")
    choices = guide(learnt, fits, limits(data_folder() / "limits.toml"), target, length(lengths["waiver"], "m"))
    if json:
        document = {"rocket": plan.rocket, "mount_mm": wanted.mount * 1e3, "target_m": target}
        document |= {"flights": learnt.rests_on, "model": learnt.name, "decides": DECIDES}
        print_json({**document, "motors": [choice.json() for choice in choices]})
        return
    say(f"{plan.rocket} {plan.config}, {(learnt.plan.dry_mass or 0) * 1e3:.0f} g without the motor".replace(" ,", ","))
    say(f"{len(choices)} motors of {wanted.mount * 1e3:g} mm; rests on {learnt.rests_on} clean flights")
    say()
    _table(choices)
    for choice in choices[:SHOWN]:
        for line in choice.failed:
            say(f"  {choice.motor.designation}: {line.verdict}: {line.name}: {line.text}")
    say()
    say(f"eject: after apogee, with each delay on sale. {DECIDES}")


def _classes(text: str) -> tuple[str, str] | None:
    first, _, last = text.upper().replace(" ", "").partition("-")
    if not text:
        return None
    if not (first.isalpha() and len(first) == 1 and (not last or (last.isalpha() and len(last) == 1))):
        raise typer.BadParameter(f"found --class {text!r}, expected a letter such as D, or two such as D-F")
    return first, last or first


def _table(choices: "list[Choice]") -> None:
    headers = ("motor", "shown m", "5 %", "95 %", "true", "rail", "T/W", "avg", "top", "eject")
    rows = [
        (
            f"{choice.motor.designation}{'' if choice.flown else ' *'}",
            f"{choice.apogee[1]:.0f}",
            f"{choice.apogee[0]:.0f}",
            f"{choice.apogee[2]:.0f}",
            f"{choice.true_apogee[1]:.0f}",
            f"{choice.rail_speed:.0f}",
            f"{choice.first_thrust:.1f}",
            f"{choice.average_thrust:.1f}",
            f"{choice.top_speed:.0f}",
            " ".join(f"{delay:g}:{after:+.1f}" for delay, after in choice.ejections.items()) or "no delay",
        )
        for choice in choices
    ]
    print_table(headers, rows, numbers=headers[1:9])
    say("*: not flown by this rocket. rail, top: m/s. T/W: thrust to weight, first half second and average.")
