"""The plan of the next flight: its questions, its form in the ledger, and the inputs of its forecasts."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from fieldkit.flight import BY_NAME, CONDITIONS, MOTOR_TEMPERATURE, SETUP, Flight
from fieldkit.flight.plan import check_plan
from fieldkit.flight.recovery import RECOVERY_COLUMNS, RECOVERY_TEXTS, STABILITY, recovery_header
from fieldkit.flight.short_name import has_derived_id
from fieldkit.flight.site import Site
from fieldkit.importing.manual_entry import Question, answer_text, read_answer
from fieldkit.ledger import Ledger
from fieldkit.motors import Found, Motor
from fieldkit.paths import data_file
from fieldkit.planning.forecasts import RocketData
from fieldkit.planning.limits import Limit, limits
from fieldkit.planning.motor_guide import MotorOrder, Wanted, label, lifts, motor_order, saved_delays, widest_motor
from fieldkit.quantities import SYSTEMS, counted, measure, unit_of
from fieldkit.safe_text import printable
from fieldkit.services import launch_day
from fieldkit.services.forecasts import rocket_of
from fieldkit.services.manual_entry import with_unit
from fieldkit.services.plans import completed_plan
from fieldkit.services.saved_forecasts import motors_with_open_forecast
from fieldkit.services.sites import site_of
from fieldkit.settings import Settings
from fieldkit.tui.resources import Resources
from fieldkit.tui.widgets import cards

BRIEFLY = {"Site elevation": "elevation", "Rail length": "rail"}
"""Conditions by their titles, and their names in the line of a plan."""
MAX_NAMED_FLIGHTS = 8
"""Maximum number of individually named flights of a forecast."""
MASS_UNKNOWN = """No forecast without the mass of the rocket.

p Plan    enter its dry mass
b Rocket  the next rocket that has flown"""
"""The text of the list for a rocket of unknown mass."""
PLAN = (*(c.name for c in SETUP if c.name != "delay"), *(c.name for c in CONDITIONS), "delay")
"""Editable numbers of a plan."""
MEANING_OF_EMPTY = {
    "delay": "For the motors that are sold or drilled with it. Empty: the one on sale nearest to apogee."
}
"""What an empty answer means, if it is not the last flight's or standard."""
QUESTIONS = (
    Question("rocket", "Rocket", "Its name, as in the ledger. The forecast is based on its normal flights."),
    Question(
        "config", "Configuration", "The build, such as A. Mass and diameter are those of the flight entered last."
    ),
    *(
        Question(
            name,
            BY_NAME[name].title,
            f"{BY_NAME[name].help} {MEANING_OF_EMPTY.get(name, 'Empty: as in the flight entered last, or standard.')}",
        )
        for name in PLAN
    ),
    Question("site", "Site", "Its elevation, size and ceiling are saved with `fieldkit sites`. Empty: the last site."),
    *(
        Question(name, title, about)
        for name, (title, about) in zip(
            launch_day.FURTHER,
            (
                ("Motor temperature", "Such as 15C or 60F. Used only for its safety check."),
                ("Stability", RECOVERY_TEXTS[STABILITY]),
                ("Parachute", RECOVERY_COLUMNS["parachute_diameter"][2]),
                ("Descent speed", RECOVERY_COLUMNS["main_speed"][2]),
                ("Drogue speed", RECOVERY_COLUMNS["drogue_speed"][2]),
                ("Main opens at", RECOVERY_COLUMNS["main_altitude"][2]),
                ("Wind aloft", "10m/s, 20mph; the same as the wind for one that does not grow with height."),
            ),
            strict=True,
        )
    ),
)


FURTHER_UNITS = {MOTOR_TEMPERATURE: "c"} | {
    recovery_header(name): {"mps": "m/s"}.get(unit, unit) for name, (_, unit, _) in RECOVERY_COLUMNS.items()
}
"""The units of numbers that the ledger has without one in further columns of a plan."""


def plan_units(system: str) -> dict[str, str]:
    """The units of numbers typed without one, by question."""
    own = {name: SYSTEMS[system].get(unit, unit) for name, unit in FURTHER_UNITS.items() if name in launch_day.FURTHER}
    return own | {name: unit_of(BY_NAME[name], system) for name in PLAN}


def further_text(plan: Flight, name: str) -> str:
    """A further column of a plan as a form shows it: with its unit."""
    return with_unit(plan.text(name), FURTHER_UNITS.get(name, ""))


def read_planned(name: str, text: str, unit: str) -> object:
    """The answer to a question about a plan; a further column is a text with its unit. Raises BadValue."""
    return with_unit(text, unit) if name in launch_day.FURTHER else read_answer(name, text, unit)


@dataclass(frozen=True, slots=True)
class NextPlan:
    """The plan, as edited and complete, with its rocket and site; the available configurations, the motors that fit,
    and the basis of the forecast."""

    flight: Flight
    full: Flight
    rocket: RocketData
    site: Site
    limits: dict[str, Limit]
    builds: tuple[Flight, ...]
    wanted: Wanted
    rests_on: str
    saved: tuple[Found, ...] = ()
    """Motors with an open forecast of this rocket, with their delays, the latest first."""

    def same_forecasts(self, other: "NextPlan") -> bool:
        """Whether every motor has the same forecast and the same safety checks as in another plan."""
        same = (self.full, self.site, self.limits) == (other.full, other.site, other.limits)
        return same and self.rocket.same_as(other.rocket)

    def saved_delay(self, motor: Motor) -> float | None:
        """The delay of a motor in its open forecast; None without one. [s]"""
        return saved_delays(self.saved).get(label(motor))

    def order(self, target: float | None) -> MotorOrder:
        """The order in which motors are listed, with or without a target [m]."""
        return motor_order(self.rocket, self.full.config, target, self.saved)

    def misfit(self, motor: Motor) -> str:
        """Why the rocket cannot fly on a motor, empty if it can."""
        if self.wanted.fits(motor):
            return ""
        if not motor.available:
            return "no longer made"
        if self.full.dry_mass is not None and not lifts(motor, self.full.dry_mass):
            return "too weak to lift the rocket"
        unflown = "the mount of the kit has" if self.rocket.mount else "the body has"
        widest = "the widest flown is" if self.rocket.motors else unflown
        return f"{motor.diameter * 1e3:g} mm, and {widest} {(self.wanted.mount or 0.0) * 1e3:g} mm"

    def line(self, settings: Settings) -> str:
        """The plan in a line: `Astra B · 448 g dry · wind 2.1 m/s · target 244 m`."""
        system, target = settings.units, settings.target
        numbers = [(c.title, measure(c, self.full.number(c.name), system)) for c in CONDITIONS]
        parts = [
            f"{self.flight.rocket} {self.flight.config}".strip(),
            f"{measure(BY_NAME['dry_mass'], self.full.dry_mass, system)} dry",
            *([] if self.full.delay is None else [f"delay {self.full.delay:g} s"]),
            *(
                [f"{BRIEFLY.get(name, name.lower())} {value}" for name, value in numbers if value]
                or ["standard air, wind not given"]
            ),
            f"target {measure(cards.APOGEE, target, system)}" if target else "no target",
        ]
        return printable(" · ".join(parts))


@dataclass(frozen=True, slots=True)
class PlanWithoutMass:
    """A plan for a rocket of unknown mass, which cannot be forecast, and the available configurations."""

    flight: Flight
    builds: tuple[Flight, ...]

    @property
    def why(self) -> str:
        """What is missing, and the key to enter it."""
        build = f"{self.flight.rocket} {self.flight.config}".strip() or "the rocket"
        return printable(f"{build}: no dry mass known; p to enter one")


def next_build(plan: NextPlan | PlanWithoutMass) -> Flight | None:
    """The plan for the next rocket and configuration that have flown; None if none has."""
    names = [(build.rocket, build.config) for build in plan.builds]
    if not names:
        return None
    now = (plan.flight.rocket, plan.flight.config)
    rocket, config = names[(names.index(now) + 1) % len(names)] if now in names else names[0]
    other = plan.flight.without_columns(launch_day.OF_THE_ROCKET)
    return other.with_changes(rocket=rocket, config=config, dry_mass=None, diameter=None)


def read_plan(resources: Resources) -> NextPlan | PlanWithoutMass | None:
    """The saved plan, or else one for the last flown rocket with a known mass or, without flights, for a designed one;
    without forecasts if its mass is unknown; None without plan, flights and designs.

    Raises LedgerError if the ledger cannot be read, BadValue if the saved plan cannot.
    """
    ledger = resources.ledger
    flights = ledger.flights()
    plan = launch_day.planned(ledger, flights)
    if plan is None:
        return None
    rocket = rocket_of(ledger, resources.motors, plan.rocket)
    full = completed_plan(ledger, resources.motors, plan, resources.settings)
    builds = {(flight.rocket, flight.config): flight for flight in flights if flight.rocket}
    if full.dry_mass is None:
        return PlanWithoutMass(plan, tuple(builds.values()))
    return NextPlan(
        plan,
        full,
        rocket,
        site_of(ledger, full.site),
        limits(data_file("limits.toml")),
        tuple(builds.values()),
        Wanted(widest_motor(rocket, full), adapter=True, dry_mass=full.dry_mass),
        rests_on(ledger, plan.rocket, rocket.flights),
        tuple(motors_with_open_forecast(ledger, resources.motors, plan.rocket, plan.config)),
    )


def rests_on(ledger: Ledger, rocket: str, flights: Sequence[Flight]) -> str:
    """The flights and the model of a forecast, in words."""
    clean = [flight for flight in flights if flight.clean and flight.apogee is not None]
    if not clean:
        return "no flights of it, only other rockets"
    version = ledger.active_version(rocket)
    model = f"version {version.number}" if version else "no correction"
    named = [flight.flight_id for flight in clean if not has_derived_id(flight)][:MAX_NAMED_FLIGHTS]
    more = f" and {len(clean) - len(named)} more" if len(clean) > len(named) else ""
    which = f" ({', '.join(named)}{more})" if named else ""
    return f"{counted(len(clean), 'normal flight')}{which}, {model}"


def planned(values: Mapping[str, object]) -> Flight:
    """The plan from a filled-in form. Raises BadValue for a further column that cannot be read."""
    further = {name: text for name in launch_day.FURTHER if (text := str(values.get(name) or ""))}
    rest = {name: value for name, value in values.items() if name not in launch_day.FURTHER}
    plan = Flight(extra=further).with_changes(**rest)
    check_plan(plan)
    return plan


def plan_texts(plan: Flight, system: str | None = None) -> dict[str, str]:
    """The answers of a plan by question: as saved in the ledger, or with numbers as in a form in the units of a
    system."""
    texts = {q.name: plan.text(q.name) or _answer(plan, q.name) for q in QUESTIONS}
    if system is None:
        return {name: text for name, text in texts.items() if text}
    texts |= {name: further_text(plan, name) for name in launch_day.FURTHER}
    return texts | {name: measure(BY_NAME[name], plan.number(name), system) for name in PLAN}


def _answer(plan: Flight, name: str) -> str:
    return "" if name in launch_day.FURTHER else answer_text(plan, name)
