"""What `fieldkit motors --fit --quick` prints: the network's forecasts on every motor that fits a rocket."""

from typing import TYPE_CHECKING

from fieldkit.cli.planning import PlanContext
from fieldkit.cli.screen import print_json, print_table, say, say_wrapped, system
from fieldkit.errors import NoFlights
from fieldkit.quantities import ShownUnits, counted

if TYPE_CHECKING:
    from fieldkit.motors import Motor
    from fieldkit.planning.motor_guide import Wanted


def print_quick_guide(
    plan: PlanContext,
    wanted: "Wanted",
    target: float | None,
    motors: "list[Motor]",
    names: "dict[Motor, str]",
    *,
    json: bool,
) -> None:
    """Print the network's forecasts. Raises NoFlights for a rocket that has not flown."""
    from fieldkit.planning.motor_guide import by_closeness
    from fieldkit.planning.quick_guide import quick_guide
    from fieldkit.presentation.quick_look import EVALUATION

    if not plan.rocket.history:
        raise NoFlights(f"{plan.flight.rocket}: found no flights, expected at least one for a quick forecast")
    found = by_closeness(quick_guide(plan.rocket, plan.flight, motors), target)
    if json:
        document = {"rocket": plan.flight.rocket, "mount_mm": (wanted.mount or 0.0) * 1e3, "target_m": target}
        print_json({**document, "evaluation": EVALUATION, "motors": [choice.json() for choice in found]})
        return
    shown = ShownUnits(system())
    name = " ".join(part for part in (plan.flight.rocket, plan.flight.config) if part)
    say(f"{name}: quick forecasts by the network on {counted(len(found), 'motor')}; nothing is saved")
    headers = ("motor", "shown", "90%", "T:W", "avg", "top")
    rows = []
    for one in found:
        low, middle, high = (shown.length(value).split()[0] for value in one.interval)
        top = "" if one.top_speed is None else shown.speed(one.top_speed, 0).split()[0]
        thrust = (f"{one.first_thrust:.1f}", f"{one.average_thrust:.1f}")
        rows.append((f"{names[one.motor]}{'' if one.flown else ' *'}", middle, f"{low}-{high}", *thrust, top))
    print_table(headers, rows, numbers=headers[1:])
    say_wrapped(
        f"*: not flown by this rocket. shown: apogee on the altimeter [{shown.length_unit}]. "
        f"top: top speed [{shown.speed(0.0).split()[1]}]. T:W, avg: thrust to weight in the first half second and on "
        "average. Not checked by the fit, without delays and safety checks: leave out --quick for those."
    )
