"""The forecast of a motor in words and figures, for the card next to the motors."""

from collections.abc import Iterator, Sequence

from textual.binding import Binding

from fieldkit.flight import BY_NAME
from fieldkit.forecast.prediction import Prediction, median
from fieldkit.messages import marked, message
from fieldkit.planning.air import air_of
from fieldkit.planning.check import ADVICE_NOTE, MARKS, SafetyCheck, Verdict, worst_first
from fieldkit.planning.motor_guide import MotorChoice
from fieldkit.planning.quantiles import Three
from fieldkit.planning.quick_guide import QuickChoice
from fieldkit.presentation.forecast_text import narrows, when_it_fires
from fieldkit.presentation.safety_text import every_check, failed_checks, other_checks
from fieldkit.quantities import in_system, measure, number, spelled, unit_of, with_sd
from fieldkit.tui.next import motor_rows
from fieldkit.tui.next.next_plan import NextPlan
from fieldkit.tui.widgets import cards

UNFOLD = "Press ! for every check"
"""How to see the checks that are folded."""
UNFOLD_KEY = Binding(
    "exclamation_mark",
    "unfold",
    "Safety",
    key_display="!",
    tooltip="All safety checks in full, or in brief",
)
KEYS_OF_COMMANDS = {
    "fieldkit flyer --certification 1": "Ctrl+P, Your card",
    "fieldkit flyer --born": "Ctrl+P, Your card",
    "--stability-cal, or its design": "p Plan, or its design",
    "not given: use --wind for the pad, --wind-aloft for higher up": "not given: press p on the Fly page to enter it",
}
"""What messages of commands name, and the keys that do the same."""


def rail_speed(prediction: Prediction, system: str) -> str:
    """The median speed at the end of the rail."""
    return measure(BY_NAME["top_speed"], median(prediction.rail_speed), system)


def title(plan: NextPlan, motor: str) -> str:
    """Rocket and motor: `Astra A on AeroTech F24W-4`."""
    build = f"{plan.flight.rocket} {plan.flight.config}".strip()
    return f"{build} on {motor}"


def interval(apogee: Three, system: str) -> str:
    """The text after the large figure: `m on the altimeter, 90% 179-317`."""
    low, _, high = (motor_rows.whole(x, system) for x in apogee)
    return f"{spelled(unit_of(cards.APOGEE, system))} on the altimeter, 90% {low}-{high}"


def figures(plan: NextPlan, one: MotorChoice, system: str) -> list[tuple[str, str]]:
    """The figures below the density, name and value."""
    prediction = one.prediction
    fires = [f"{delay:g}:{motor_rows.signed(seconds)}" for delay, seconds in one.ejections]
    misfit = plan.misfit(one.motor) or ", ".join(line.name for line in one.why_not)
    return [
        ("✗ fit", misfit),
        ("ejection", _ejection(prediction.median_eject)),
        ("by delay", " ".join(fires) + " s" if fires else ""),
        ("off rail", rail_speed(prediction, system)),
        ("T:W", f"{one.first_thrust:.1f} at first, {one.average_thrust:.1f} average"),
        ("top speed", measure(BY_NAME["top_speed"], median(prediction.top_speed), system)),
        ("next Cd", with_sd(prediction.cd.mean(), prediction.cd.std())),
        ("thrust", with_sd(prediction.alpha.mean(), prediction.alpha.std())),
        ("true", f"{measure(cards.APOGEE, median(prediction.true_apogee), system)} above the pad"),
        ("air", air_of(prediction.plan).words(system)),
        ("based on", plan.rests_on),
        ("narrows", narrows(prediction)),
        ("note", in_system(message("; ".join(map(marked, [*prediction.found.notes, *prediction.left_out]))), system)),
    ]


def quick_figures(plan: NextPlan, one: QuickChoice, system: str) -> list[tuple[str, str]]:
    """The figures of a quick answer, name and value."""
    return [
        ("✗ fit", plan.misfit(one.motor)),
        ("T:W", f"{one.first_thrust:.1f} at first, {one.average_thrust:.1f} average"),
        ("top speed", measure(BY_NAME["top_speed"], one.top_speed, system)),
        ("based on", plan.rests_on),
    ]


def checks(one: MotorChoice, system: str) -> list[tuple[str, str]]:
    """The safety checks, each with its figures and its limit, in the units of a system."""
    lines = [
        (f"{MARKS[line.verdict]} {line.name}", by_keys(f"{line.verdict}: {in_system(message(line.finding), system)}"))
        for line in worst_first(one.lines)
    ]
    return [*lines, ("", ADVICE_NOTE)]


def saved_in_words(prediction: Prediction, system: str) -> str:
    """The notice of a saved forecast with its values."""
    low, middle, high = (number(cards.APOGEE, float(x), system) for x in prediction.apogee_quantiles())
    unit = spelled(unit_of(cards.APOGEE, system))
    return (
        f"Saved forecast: {prediction.plan.motor} to {middle} {unit} ({low} to {high}). a to add the flight, u to undo"
    )


def safety_in_brief(lines: Sequence[SafetyCheck]) -> Iterator[str]:
    """The names of the checks that fail, and how many others there are: `⊘ rail exit speed`, `! ground wind`,
    `? 12 not given, 6 to check yourself`, `✓ 5 passed`."""
    failed: tuple[Verdict, ...] = ("unsafe", "caution")
    for verdict in failed:
        if found := [line for line in lines if line.verdict == verdict]:
            yield f"{MARKS[verdict]} {', '.join(line.name for line in found)}"
    yield from other_checks(lines)


def folded(lines: Sequence[SafetyCheck], system: str) -> Iterator[str]:
    """What the failed checks found, the numbers of the others, and the key that shows all with rules and sources."""
    yield from map(by_keys, failed_checks(lines, system))
    yield from other_checks(lines)
    yield UNFOLD
    yield ADVICE_NOTE


def unfolded(lines: Sequence[SafetyCheck], system: str) -> Iterator[str]:
    """Every check in full, those that failed first, with rules and sources."""
    yield from map(by_keys, every_check(lines, system))


def by_keys(text: str) -> str:
    """A text with the keys of the app instead of the commands that it names."""
    for command, keys in KEYS_OF_COMMANDS.items():
        text = text.replace(command, keys)
    return text


def _ejection(eject: float | None) -> str:
    if eject is None:
        return "no delay known for this motor"
    return when_it_fires(eject)
