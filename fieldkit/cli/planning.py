"""Shared by the planning commands: setting up a plan, its field, and printing the safety checks."""

from collections.abc import Callable, Collection, Iterable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, replace
from datetime import date, datetime
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from fieldkit.cli.numbers import length
from fieldkit.cli.options import dashed
from fieldkit.cli.plan_options import Given, kit_named, plan_from_options
from fieldkit.cli.screen import complain, progress, say, say_wrapped, system
from fieldkit.cli.session import known_motors, open_ledger
from fieldkit.errors import DamagedLog, NoFlights, UnknownMotor, of_rocket
from fieldkit.flight.site import Site
from fieldkit.paths import data_file
from fieldkit.planning.check import ADVICE_NOTE, SafetyCheck
from fieldkit.planning.limits import Limit, limits

if TYPE_CHECKING:
    from fieldkit.flight import Flight
    from fieldkit.forecast.prediction import Prediction
    from fieldkit.ledger import Ledger
    from fieldkit.motors import Catalogue
    from fieldkit.planning.descent_rate import Fall
    from fieldkit.planning.forecasts import Plan, RocketData
    from fieldkit.rocket import Rocket

AllChecks = Annotated[bool, typer.Option("--checks", help="Print every safety check in full, with its rule.")]
"""The option of every command that prints the safety checks of a plan."""
UNFOLD = "--checks lists every check"
"""How to see the checks that are folded."""
RocketLength = Annotated[str | None, typer.Option(help="Length of the rocket, for the season's limit: 700mm, 28in.")]


@dataclass(frozen=True, slots=True)
class PlanContext:
    """A plan set up: the flight, its rocket in the ledger, the known motors, site and thresholds."""

    ledger: "Ledger"
    motors: "Catalogue"
    flight: "Flight"
    rocket: "RocketData"
    site: "Site"
    limits: "dict[str, Limit]"
    mount: float | None = None
    """Diameter of the kit's motor mount, if a kit was named. [m]"""

    def plan(self) -> "Plan":
        """The plan with its motor, by default that of the flight of the rocket entered last; notes on it are printed.

        Raises UnknownMotor.
        """
        from fieldkit.planning.forecasts import Plan

        last = self.ledger.latest(self.flight.rocket)
        if not self.flight.motor and last is None:
            raise UnknownMotor(of_rocket(self.flight.rocket, "found no flights to take a motor from, expected --motor"))
        found = self.motors.resolve_several(self.flight.motor or (last.motor if last else ""))
        for note in found.notes:
            complain(f"note: {note}")
        return Plan(self.rocket, self.flight, found)

    def safety(self, prediction: "Prediction", area: float = 1.0) -> "list[SafetyCheck]":
        """Every safety check of a forecast, with a fraction of the parachute's area. [1]"""
        from fieldkit.planning.descent_rate import fall_of
        from fieldkit.planning.safety import safety_lines

        fall = fall_of(self.rocket.history, prediction.plan, prediction.found).on_area(area)
        return safety_lines(prediction, self.site, fall, self.limits)


@contextmanager
def planning(context: typer.Context, given: Given) -> Iterator[PlanContext]:
    """A plan for a rocket that has flown, has a design, or is given by its mass or a kit; its ledger is open.

    Raises NoFlights, BadValue.
    """
    from fieldkit.services.forecasts import rocket_of

    motors = known_motors()
    with open_ledger(context) as ledger, progress("planning") as on_progress:
        name = known_rocket(ledger, given)
        on_progress(f"forecasting {name} from its flights", 0.3)
        flight = plan_from_options(ledger, motors, {**given, "rocket": name})
        rocket = rocket_of(ledger, motors, name)
        kit = kit_named(given)
        site = field_of(ledger, flight, given)
        yield PlanContext(ledger, motors, flight, rocket, site, own_limits(), kit.mount if kit else None)


MOST_PLANS = 200
"""Largest number of planned flights in a table: the drawing of each on a day sheet takes 0.4 s. [1]"""


def planned_table(file: Path, check: Callable[[str], str | None]) -> "list[Flight]":
    """The planned flights of a table. Raises DamagedLog for the first bad row, for none, or for more than
    `MOST_PLANS`."""
    from fieldkit.importing.read import read_plans
    from fieldkit.services.imports import read_file

    plans = read_plans(read_file(file), str(file), check)
    if not 0 < len(plans) <= MOST_PLANS:
        expected = f"expected at most {MOST_PLANS} at a time; split the table" if plans else "expected a row for each"
        raise DamagedLog(f"found {len(plans) or 'no'} planned flights, {expected}", source=str(file))
    return plans


OF_THE_FIELD = ("waiver", "field_size", "people", "bystanders", "rules")
"""Options of a plan that apply to every flight of a table."""


def check_given_with_table(given: Given, used: Collection[str]) -> None:
    """Raise BadParameter for an option that a table of planned flights replaces; `used` are those that it does not."""
    if unused := dashed({name: text for name, text in given.items() if name not in used}):
        raise typer.BadParameter(f"found {', '.join(unused)} with --flights, expected it in the table")


NEW_ROCKET = "new rocket"
"""Name of the rocket of a plan that gives only its mass."""


def known_rocket(ledger: "Ledger", given: Given) -> str:
    """The rocket of a plan: the named one, else the kit's, else that of the flight entered last; with a kit or a mass,
    it may be one that has not flown.

    Raises NoFlights, BadValue.
    """
    from fieldkit.services.forecasts import which_rocket
    from fieldkit.services.kits import kit_of_rocket

    kit = kit_named(given)
    name = given.get("rocket") or (kit.name if kit else None)
    try:
        return which_rocket(ledger, name)
    except NoFlights as error:
        if not (kit or (name and kit_of_rocket(name)) or given.get("dry_mass") or given.get("lift_off_mass")):
            raise NoFlights(f"{error} (a rocket that has not flown needs --dry-mass and --diameter)") from error
    return name or NEW_ROCKET


def field_of(ledger: "Ledger", plan: "Flight", given: Given) -> "Site":
    """The site of a plan, with ceiling, size, distances and rules as given. Raises BadValue."""
    from fieldkit.services.sites import site_of

    known = site_of(ledger, plan.site)
    ceiling, size = length("--waiver", given.get("waiver")), length("--field-size", given.get("field_size"))
    if ceiling:
        known = replace(known, name="", ceiling=ceiling)  # given for the day, not a property of the site
    people, bystanders = length("--people", given.get("people")), length("--bystanders", given.get("bystanders"))
    rules = given.get("rules")
    if rules is not None:
        check_rules(rules)
    return replace(
        known,
        size=size or known.size,
        people=people or known.people,
        bystanders=bystanders or known.bystanders,
        rules=known.rules if rules is None else rules,
    )


def check_rules(text: str) -> None:
    """Raise BadValue if a text names an authority without a known set of rules."""
    from fieldkit.planning.rules import governing, known_rules, read_authorities

    governing(known_rules(), read_authorities(text), False, date.today())


def season_year(year: int | None, flown: datetime | None = None) -> int:
    """The year of a season, by default that of a flight's date, or of today; the default is printed."""
    from fieldkit.planning.contest import season_of

    if year is None:
        year = season_of((flown or datetime.now()).date(), data_file("seasons"))
        date = "the date of the last flight" if flown else "today's date"
        complain(f"note: by the rule of season {year}, from {date}; --season for another")
    return year


def own_limits() -> "dict[str, Limit]":
    """The thresholds, with the user's own replacing the shipped ones."""
    return limits(data_file("limits.toml"))


def safety_of(
    ledger: "Ledger", motors: "Catalogue", predictions: "Sequence[Prediction]", given: Given
) -> "list[list[SafetyCheck]]":
    """Every safety check of several forecasts."""
    from fieldkit.planning.safety import safety_lines

    limits, falls = own_limits(), _falls(ledger, motors, predictions)
    sites = [field_of(ledger, one.plan, given) for one in predictions]
    return [safety_lines(one, site, fall, limits) for one, site, fall in zip(predictions, sites, falls, strict=True)]


def way_down(ledger: "Ledger", motors: "Catalogue", predictions: "Sequence[Prediction]") -> list[dict[str, Any]]:
    """The JSON of the descent of forecasts: duration and landing, fitted to each rocket's flights."""
    from fieldkit.planning.landing import landing

    falls = zip(predictions, _falls(ledger, motors, predictions), strict=True)
    return [{"landing": landing(one, fall).json(), "timed_flights": fall.flights} for one, fall in falls]


def _falls(ledger: "Ledger", motors: "Catalogue", predictions: "Sequence[Prediction]") -> "list[Fall]":
    """The descent of each forecast, fitted to its rocket's flights."""
    from fieldkit.planning.descent_rate import fall_of
    from fieldkit.services.forecasts import flown

    histories = {name: flown(ledger, motors, name) for name in {one.plan.rocket for one in predictions}}
    return [fall_of(histories[one.plan.rocket], one.plan, one.found) for one in predictions]


def about_plan(prediction: "Prediction", lines: "Sequence[SafetyCheck]") -> dict[str, Any]:
    """The JSON around a forecast: its conditions, the air, the safety checks and who decides."""
    from fieldkit.planning.air import air_of, conditions

    return {
        "conditions": conditions(prediction.plan),
        "air": air_of(prediction.plan).json(),
        "safety": [line.json() for line in lines],
        "decides": ADVICE_NOTE,
    }


def print_conditions(plan: "Flight", rocket: "Rocket", *, brief: bool = False) -> None:
    """Print the conditions of a plan and the design it starts from; `brief` leaves out what others would change."""
    from fieldkit.presentation.planning_text import conditions_in_words

    for text in conditions_in_words(plan, rocket, system(), brief=brief):
        say_wrapped(text, " " * 10)


def print_plan(
    words: Iterable[str], plan: "Flight", lines: "Sequence[SafetyCheck]", rocket: "Rocket", *, every: bool
) -> None:
    """Print the result of a plan, then its conditions and safety checks, in brief or `every` one in full."""
    for text in words:
        say_wrapped(text, " " * 10) if len(text) > _WIDTH else say(text)
    print_basis(plan, lines, rocket, every=every)


_WIDTH = 79
"""Maximum width of a line that is printed unwrapped. [character]"""


def print_basis(plan: "Flight", lines: "Sequence[SafetyCheck]", rocket: "Rocket", *, every: bool) -> None:
    """Print the conditions and safety checks of a plan, in brief or `every` one in full."""
    say()
    print_conditions(plan, rocket, brief=not every)
    print_safety(lines, every=every)


def print_safety(lines: "Sequence[SafetyCheck]", *, every: bool) -> None:
    """Print what the failed safety checks found and the number of the others, or `every` check in full; and who
    decides."""
    from fieldkit.presentation.safety_text import every_check, failed_checks, other_checks

    others = "; ".join([*other_checks(lines), UNFOLD])
    folded = (*failed_checks(lines, system()), others, ADVICE_NOTE)
    say("  safety")
    for text in every_check(lines, system()) if every else folded:
        say_wrapped(f"    {text}", "  ")
