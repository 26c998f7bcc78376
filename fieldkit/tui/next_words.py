"""The forecast of a motor in words and figures: its row among the motors, and the card beside them."""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

from fieldkit.flight import BY_NAME
from fieldkit.measures import measure, number, spelled, unit_of
from fieldkit.settings import Settings
from fieldkit.tui import cards
from fieldkit.tui.table import Head

if TYPE_CHECKING:
    from fieldkit.loop.prediction import Prediction
    from fieldkit.motors import Motor
    from fieldkit.plan.guide import Choice
    from fieldkit.plan.safety import Line, Verdict
    from fieldkit.tui.next_plan import Plan

Pairs = list[tuple[str, str]]


@dataclass(frozen=True, slots=True)
class Row:
    """A motor, whether it fits, and its forecast once there is one, in the flyer's units."""

    motor: "Motor"
    fits: bool
    choice: "Choice | None"
    settings: Settings

    @property
    def name(self) -> str:
        """Maker and designation, behind a cross where it does not fit."""
        return f"{'' if self.fits else '✗ '}{self.motor.maker} {self.motor.designation}"

    def brief(self) -> list[str]:
        """The cells of `BRIEF`."""
        if self.choice is None:
            return [self.name, "…", "", ""]
        apogee = number(cards.APOGEE, self.choice.apogee, self.settings.units)
        return [self.name, apogee, self._off(self.choice), _signed(self.choice.prediction.median_eject)]

    def full(self) -> list[str]:
        """The cells of `full_heads`."""
        size = [f"{self.motor.diameter * 1e3:g}", f"{self.motor.total_impulse:.3g}"]
        if self.choice is None:
            return [self.name, *size, "…", *[""] * 6]
        said, system = self.choice.prediction, self.settings.units
        low, _, high = (whole(float(x), system) for x in said.apogee_quantiles())
        return [
            self.name,
            *size,
            number(cards.APOGEE, self.choice.apogee, system),
            f"{low}-{high}",
            self._off(self.choice),
            "" if self.choice.delay is None else f"{self.choice.delay:g} s",
            _signed(said.median_eject),
            rail_speed(said, system).split(" ")[0],
            f"{self.choice.average_thrust:.1f}",
        ]

    def _off(self, choice: "Choice") -> str:
        """Forecast less target; from 100 on there is no room for a decimal."""
        target = self.settings.target
        if not target:
            return ""
        off = number(cards.APOGEE, abs(choice.apogee - target), self.settings.units)
        off = f"{float(off):.0f}" if len(off) > 4 else off
        return off if float(off) == 0 else f"{'+' if choice.apogee > target else '-'}{off}"


BRIEF = (Head("motor", 0), Head("apogee", 6, True), Head("off", 5, True), Head("eject", 5, True))
"""The columns beside a card."""


def full_heads(system: str) -> list[Head]:
    """The columns where there is room for all of them."""
    unit = spelled(unit_of(cards.APOGEE, system))
    heads = [Head("motor", 0), Head("mm", 3, True), Head("N s", 5, True), Head(unit, 6, True), Head("90 %", 11, True)]
    heads += [Head("off", 5, True), Head("delay", 5, True), Head("eject", 5, True), Head("rail", 5, True)]
    return [*heads, Head("T:W", 4, True)]


def whole(height: float, system: str) -> str:
    """A height [m] in whole units."""
    return number(cards.APOGEE, height, system).split(".")[0]


def rail_speed(said: "Prediction", system: str) -> str:
    """The speed at the end of the rail, in the middle of its distribution."""
    from fieldkit.loop.prediction import median

    return measure(BY_NAME["top_speed"], median(said.rail_speed), system)


def title(plan: "Plan", one: "Choice") -> str:
    """What would fly on what: `Astra A on AeroTech F24W-4`."""
    delay = "" if one.delay is None else f"-{one.delay:g}"
    build = f"{plan.flight.rocket} {plan.flight.config}".strip()
    return f"{build} on {one.motor.maker} {one.motor.designation}{delay}"


def interval(said: "Prediction", system: str) -> str:
    """What follows the large figure: `m on the altimeter, 90 % 179-317`."""
    low, _, high = (whole(float(x), system) for x in said.apogee_quantiles())
    return f"{spelled(unit_of(cards.APOGEE, system))} on the altimeter, 90 % {low}-{high}"


def figures(plan: "Plan", one: "Choice", system: str) -> Pairs:
    """What stands below the hill, name and value."""
    from fieldkit.loop.prediction import median
    from fieldkit.loop.told import narrows
    from fieldkit.plan.air import air_of

    said = one.prediction
    fires = [f"{delay:g} s {seconds:+.1f}" for delay, seconds in one.ejections]
    misfit = plan.misfit(one.motor)
    return [
        ("✗ fit", misfit),
        ("ejection", _ejection(said.median_eject)),
        ("by delay", "  ".join(fires)),
        ("off rail", rail_speed(said, system)),
        ("T:W", f"{one.first_thrust:.1f} at first, {one.average_thrust:.1f} average"),
        ("top speed", measure(BY_NAME["top_speed"], median(said.top_speed), system)),
        ("Cd", f"{said.cd.mean():.2f} ± {said.cd.std():.2f}"),
        ("alpha", f"{said.alpha.mean():.3f} ± {said.alpha.std():.3f}"),
        ("true", f"{measure(cards.APOGEE, median(said.true_apogee), system)} above the pad"),
        ("air", air_of(said.plan).words()),
        ("rests on", plan.rests_on),
        ("narrows", narrows(said)),
        ("note", "; ".join([*said.found.notes, *said.left_out])),
    ]


def checks(one: "Choice") -> Pairs:
    """The safety lines, each with its figures and its limit."""
    from fieldkit.plan.safety import DECIDES, MARKS

    lines = [(f"{MARKS[line.verdict]} {line.name}", f"{line.verdict}: {line.text}") for line in one.lines]
    return [*lines, ("", DECIDES)]


def kept_in_words(said: "Prediction", system: str) -> str:
    """That a forecast was kept, and what it says."""
    low, middle, high = (number(cards.APOGEE, float(x), system) for x in said.apogee_quantiles())
    unit = spelled(unit_of(cards.APOGEE, system))
    return f"kept: {said.plan.motor} to {middle} {unit} ({low} to {high}); the flight is measured against it"


def safety_in_brief(lines: "Sequence[Line]") -> Iterable[str]:
    """The names of all checks, those that fail first: `✗ rail exit speed`, `? ground wind, ceiling`."""
    from fieldkit.plan.safety import MARKS

    worst_first: tuple[Verdict, ...] = ("unsafe", "caution", "unknown", "ok")
    groups = ((verdict, [line.name for line in lines if line.verdict == verdict]) for verdict in worst_first)
    return (f"{MARKS[verdict]} {', '.join(names)}" for verdict, names in groups if names)


def _ejection(eject: float | None) -> str:
    if eject is None:
        return "no delay known for this motor"
    return f"{abs(eject):.1f} s {'after' if eject >= 0 else 'BEFORE'} apogee"


def _signed(seconds: float | None) -> str:
    return "" if seconds is None else f"{seconds:+.1f}"
