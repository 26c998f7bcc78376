"""Next flight: every motor that fits, where each would take the rocket, the forecast of the one under the cursor."""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from typing import TYPE_CHECKING, Any, ClassVar

from textual import events, on
from textual.binding import Binding, BindingType
from textual.containers import Horizontal, VerticalScroll
from textual.content import Content
from textual.widget import Widget
from textual.widgets import Digits, Input, Static

from fieldkit.entry import Question, answer_text, read_answer
from fieldkit.errors import BadValue
from fieldkit.flight import BY_NAME, CONDITIONS, MOTOR_TEMPERATURE, SETUP, Flight
from fieldkit.measures import measure, number, spelled, unit_of
from fieldkit.safe_text import printable
from fieldkit.tui import cards
from fieldkit.tui.fields import Form
from fieldkit.tui.page import Help, Page, PageScreen
from fieldkit.tui.table import Head, Table

if TYPE_CHECKING:
    from fieldkit.ledger.sites import Site
    from fieldkit.loop.predict import Prediction
    from fieldkit.motors import Motor
    from fieldkit.plan.desk import Rocket
    from fieldkit.plan.guide import Choice, Wanted
    from fieldkit.plan.limits import Limit
    from fieldkit.plan.safety import Line, Verdict

DRAFT = "plan"
"""Name under which the ledger keeps the plan."""
AT_ONCE = 40
"""Motors forecast together: the first are in sight before the others are worked out."""
DRAWS = 400
"""Flights flown for each motor: the hill is drawn of them. [1]"""
MOST = 200
"""Motors that a search forecasts; a longer word narrows it."""
PLAN = (*(c.name for c in SETUP if c.name != "delay"), *(c.name for c in CONDITIONS))
"""Numbers of a plan that can be changed; the delay is chosen with the motor."""
QUESTIONS = (
    Question("rocket", "Rocket", "Its name, as in the ledger. Its clean flights are what the forecast rests on."),
    Question(
        "config", "Configuration", "Which build of it, such as A. Mass and diameter are those of its last flight."
    ),
    *(Question(name, BY_NAME[name].title, f"{BY_NAME[name].help} Empty: as last flown, or standard.") for name in PLAN),
    Question("site", "Site", "Its elevation, size and ceiling are as saved with `fieldkit sites`. Empty: as last."),
    Question(MOTOR_TEMPERATURE, "Motor temperature", "In °C, or with its unit: 60F. For its safety line alone."),
)


@dataclass(frozen=True, slots=True)
class Plan:
    """What is to be flown, as changed and in full, and what is known of its rocket and of the site; the builds at
    hand, what motors fit, and what the forecast rests on."""

    flight: Flight
    full: Flight
    rocket: "Rocket"
    site: "Site"
    limits: "dict[str, Limit]"
    builds: tuple[Flight, ...]
    wanted: "Wanted"
    rests_on: str

    @property
    def flown(self) -> list["Motor"]:
        """The motors that the rocket has flown on, the last first, each once."""
        return list(dict.fromkeys(found.motor for found in reversed(self.rocket.motors)))


class NextScreen(PageScreen):
    """On the left the motors, on the right the forecast of the one under the cursor."""

    NAME = "next_flight"
    TITLE = "Next flight"
    LETTERS = ("search",)
    ABOUT = Help(
        "What the rocket would do next. The table holds every motor on sale that fits it (as wide as the widest it has "
        "flown, and strong enough to lift it), and where each would take it; move the cursor and the forecast follows. "
        "Type / and a name, a maker or a size such as 24mm to search the whole catalogue. With a target set (g), the "
        "motors that come nearest to it are on top. Enter keeps a forecast, and the flight is measured against it "
        "when you add it. Forecasts are advice: the range safety officer decides.",
        (
            ("apogee", "What your altimeter will show, in the middle of the distribution."),
            ("90 %", "Nine flights of ten should end between these two."),
            ("hill", "How likely each apogee is: most where it is high. The upright lines are 5 %, middle and 95 %."),
            ("true", "The height in fact; on a hot day a barometric altimeter shows less than that, in the cold more."),
            ("ejection", "When the charge fires for each delay on sale, in seconds after apogee; - is before."),
            (
                "✓ ! ✗ ?",
                "Safety checks: well, caution, unsafe, not known; each with its figures and limit further down.",
            ),
            ("off rail", "Speed at the end of the rail. Below 15 m/s fins may not hold the rocket straight."),
            ("T:W", "Thrust over weight, first half second and average: 5 is good, below 3 is not safe."),
            ("Cd, alpha", "Drag of the rocket and thrust of the motor that the flight is forecast with, and how sure."),
            *((question.title, question.help) for question in QUESTIONS),
        ),
        ("fieldkit predict --motor F24-4W --config A --wind 8mph", "fieldkit motors --fit ROCKET --target 800ft"),
    )
    BINDINGS: ClassVar[list[BindingType]] = [
        Binding("slash", "search", "Motor", key_display="/", priority=True, tooltip="Search a motor"),
        Binding("p", "plan", "Plan", tooltip="Rocket, mass and conditions"),
        Binding("b", "build", "Build", tooltip="The next rocket and configuration"),
        Binding("g", "app.ask_target", "Target", tooltip="The height to hit"),
        Binding("d", "decide", "Decide", tooltip="Delay, ballast and contest points with this motor"),
        Binding("c", "compare", "Compare", tooltip="All figures of all motors side by side"),
        Binding("f", "fitting", "All", show=False, tooltip="Only motors that fit, or all of the catalogue"),
    ]
    DEFAULT_CSS = """
    NextScreen #plan { height: auto; padding: 0 1; background: $panel; }
    NextScreen #search { height: 1; }
    NextScreen #search Static { width: auto; padding: 0 1; }
    NextScreen #search Input, NextScreen #search Input:focus { width: 1fr; height: 1; border: none; padding: 0; }
    NextScreen #motors { width: 5fr; }
    NextScreen #card { width: 40; padding: 0 1; border-left: solid $border-blurred; }
    NextScreen.-wide #card { width: 64; }
    NextScreen.-narrow #split { layout: vertical; }
    NextScreen.-narrow #motors { height: 7; width: 1fr; }
    NextScreen.-narrow #card { width: 1fr; height: 1fr; border-left: none; border-top: solid $border-blurred; }
    NextScreen.-narrow.-comparing #motors { height: 1fr; }
    NextScreen.-comparing #card { display: none; }
    NextScreen #card Static { height: auto; }
    NextScreen #big { height: 3; width: auto; color: $accent; }
    NextScreen #hill { height: 6; }
    NextScreen.-tall #hill { height: 11; }
    """

    def __init__(self) -> None:
        super().__init__()
        self._plan: Plan | None = None
        self._known: dict[Any, Choice] = {}
        self._motors: list[Motor] = []
        self._fitting = True
        self._text = ""

    def body(self) -> Iterable[Widget]:
        """The plan in a line, a search, the motors, the forecast."""
        from fieldkit.tui.plots import Plot

        yield Static("reading the ledger ...", id="plan")
        with Horizontal(id="search"):
            yield Static("/")
            yield Input(placeholder="motor: F24, aerotech 24mm, a case ...", compact=True)
            yield Static("", id="count")
        with Horizontal(id="split"):
            yield Table(id="motors", empty="no motor fits; f shows them all", enter="Keep")
            with VerticalScroll(id="card"):
                yield Static("", id="title")
                yield Digits("", id="big")
                yield Static("", id="range")
                yield Static("", id="safety")
                yield Plot(id="hill")
                yield Static("", id="more")

    def on_mount(self) -> None:
        """Keys go to the motors."""
        self.query_one(Input).cursor_blink = False
        self.set_focus(self.query_one(Table))

    def reload(self) -> None:
        """Read the plan, and forecast every motor anew."""
        self.ask(self._read_plan, self._have_plan, "plan")

    def redraw(self) -> None:
        """Other units or another target leave the forecasts as they are: they are sorted and written at once."""
        if self._plan is None:
            self.reload()
            return
        self._show_plan(self._plan)
        self._refill()

    def _read_plan(self) -> Plan:
        from fieldkit.errors import ImpossibleFlight, NoFlights
        from fieldkit.ledger.sites import site_of
        from fieldkit.places import data_folder
        from fieldkit.plan.desk import begun, rocket_of
        from fieldkit.plan.guide import Wanted, mount_of
        from fieldkit.plan.limits import limits

        ledger, motors = self.desk.ledger, self.desk.motors
        last, draft = ledger.latest(), ledger.draft(DRAFT) or {}
        if last is None and not draft:
            raise NoFlights("no flights yet: import or add some, or p plans a rocket by its name and mass")
        plan = Flight(rocket=last.rocket, config=last.config) if last is not None else Flight()
        plan = plan.with_changes(**plan_changes(draft))
        rocket = rocket_of(ledger, motors, plan.rocket)
        full = begun(ledger, plan, self.desk.settings)
        if full.dry_mass is None:
            raise ImpossibleFlight(f"{plan.rocket or 'the rocket'}: no dry mass known; p sets one")
        clean = [flight.flight_id for flight in rocket.flights if flight.clean and flight.apogee is not None]
        version = ledger.active_version(plan.rocket)
        model = f"version {version.number}" if version else "the plain model"
        some = ", ".join(clean[:8]) + (f" and {len(clean) - 8} more" if len(clean) > 8 else "")
        builds = {(f.rocket, f.config): f for f in ledger.flights()}
        return Plan(
            plan,
            full,
            rocket,
            site_of(ledger, full.site),
            limits(data_folder() / "limits.toml"),
            tuple(builds.values()),
            Wanted(mount_of(rocket, plan.config), adapter=True, dry_mass=full.dry_mass),
            f"{len(clean)} clean flights ({some}), {model}"
            if clean
            else "no flight of it: priors alone, so it is wide",
        )

    def _have_plan(self, plan: Plan) -> None:
        self._plan, self._known = plan, {}
        self._show_plan(plan)
        self._search_now()

    def _show_plan(self, plan: Plan) -> None:
        system, flight = self.desk.settings.units, plan.flight
        numbers = [(c.title, measure(c, plan.full.number(c.name), system)) for c in CONDITIONS]
        said = [f"{name.lower()} {value}" for name, value in numbers if value]
        mass = measure(BY_NAME["dry_mass"], plan.full.dry_mass, system)
        target = self.desk.settings.target
        parts = [
            f"{flight.rocket} {flight.config}".strip(),
            f"{mass} without motor",
            *(said or ["standard air, no wind"]),
        ]
        parts.append(f"target {measure(cards.APOGEE, target, system)}" if target else "no target")
        self.query_one("#plan", Static).update(Content(printable(" · ".join(parts))))

    @on(Input.Changed)
    def _search_anew(self) -> None:
        """Another search begins at its first motor."""
        self.query_one(Table).by_hand = False
        self._search_now()

    def _search_now(self) -> None:
        """Look up the motors and forecast those that are not known yet."""
        self.ask(partial(self._find, self.query_one(Input).value), self._found, "find")

    def _find(self, text: str) -> "list[Motor]":
        plan = self._plan
        found = self.desk.motors.search(text)
        if plan is not None and self._fitting:
            found = [motor for motor in found if plan.wanted.fits(motor)]
        return found

    def _found(self, motors: "list[Motor]") -> None:
        self._motors = motors
        self._refill()
        self._forecast()

    def _forecast(self) -> None:
        """The next few motors without a forecast, in the order shown."""
        plan = self._plan
        waiting = [motor for motor in self._motors[:MOST] if motor not in self._known][:AT_ONCE]
        if plan is None or not waiting:
            return

        def work() -> "list[Choice]":
            from fieldkit.plan.guide import guide

            return guide(plan.rocket, plan.full, waiting, plan.limits, plan.site, DRAWS)

        self.ask(work, self._have, "forecast")

    def _have(self, found: "Sequence[Choice]") -> None:
        self._known |= {one.motor: one for one in found}
        self._refill()
        self._forecast()

    def _columns(self) -> list[Head]:
        unit = spelled(unit_of(cards.APOGEE, self.desk.settings.units))
        if not self._everything():
            return [Head("motor", 0), Head(f"apogee {unit}", 9, True), Head("off", 5, True), Head("eject", 5, True)]
        heads = [
            Head("motor", 0),
            Head("mm", 3, True),
            Head("N s", 5, True),
            Head(unit, 5, True),
            Head("90 %", 11, True),
        ]
        heads += [Head("off", 5, True), Head("delay", 5, True), Head("eject", 5, True), Head("rail", 5, True)]
        return [*heads, Head("T:W", 4, True)]

    def _everything(self) -> bool:
        return self.has_class("-comparing") or self.size.width >= 150

    def _cells(self, motor: "Motor") -> list[str]:
        """A row: what is known of a motor, and what its forecast says."""
        one, system, target = self._known.get(motor), self.desk.settings.units, self.desk.settings.target
        name = f"{motor.maker} {motor.designation}"
        heads = len(self._columns())
        if one is None:
            return [name, *["…" if place == 3 or heads == 4 else "" for place in range(1, heads)]]
        said = one.prediction
        apogee = number(cards.APOGEE, one.apogee, system)
        off = number(cards.APOGEE, one.apogee - target, system) if target else ""
        off = f"{float(off):.0f}" if len(off.strip("-")) > 4 else off  # from 100 on there is no room for more
        off = "0" if off and float(off) == 0 else f"+{off}" if target and one.apogee > target else off
        eject = said.median_eject
        fires = "" if eject is None else f"{eject:+.1f}"
        if heads == 4:
            return [name, apogee, off, fires]
        low, _, high = (number(cards.APOGEE, float(x), system).split(".")[0] for x in said.apogee_quantiles())
        return [
            name,
            f"{motor.diameter * 1e3:g}",
            f"{motor.total_impulse:.3g}",
            apogee,
            f"{low}-{high}",
            off,
            "" if one.delay is None else f"{one.delay:g} s",
            fires,
            self._rail(said).split(" ")[0],
            f"{one.average_thrust:.1f}",
        ]

    def _rail(self, said: "Prediction") -> str:
        from fieldkit.loop.predict import median

        return measure(BY_NAME["top_speed"], median(said.rail_speed), self.desk.settings.units)

    def _refill(self) -> None:
        """The motors: the nearest to the target first, those not forecast yet last; without one, those flown first."""
        target = self.desk.settings.target
        order = list(self._motors)
        if target is None and self._plan is not None:
            flown = {motor: place for place, motor in enumerate(self._plan.flown)}
            order.sort(key=lambda motor: flown.get(motor, len(flown)))
        elif target is not None:
            order.sort(key=lambda motor: abs(self._known[motor].apogee - target) if motor in self._known else 1e9)
        self.query_one(Table).show(self._columns(), order, self._cells)
        done = sum(motor in self._known for motor in self._motors)
        fit = "fit" if self._fitting else "in all"
        left = min(len(self._motors), MOST) - done
        said = f"{len(self._motors)} {fit}" + (f", {left} to do" if left > 0 else "")
        self.query_one("#count", Static).update(Content(said))
        self._show_card()

    @on(Table.Moved)
    def _show_card(self) -> None:
        """The forecast of the motor under the cursor, from what is known already."""
        from fieldkit.tui.plots import Plot, draw_density

        one = self._known.get(self.query_one(Table).current)
        if one is None or self._plan is None:
            for name in ("title", "range", "safety", "more"):
                self.query_one(f"#{name}", Static).update("")
            self.query_one("#big", Digits).update("")
            self.query_one(Plot).show(None)
            return
        said, system = one.prediction, self.desk.settings.units
        low, middle, high = (float(x) for x in said.apogee_quantiles())
        delay = "" if one.delay is None else f"-{one.delay:g}"
        plan = self._plan.flight
        title = f"{plan.rocket} {plan.config} on {one.motor.maker} {one.motor.designation}{delay}"
        unit = spelled(unit_of(cards.APOGEE, system))
        self.query_one("#title", Static).update(Content(printable(title)).stylize("bold"))
        self.query_one("#big", Digits).update(number(cards.APOGEE, middle, system))
        ends = [number(cards.APOGEE, one, system).split(".")[0] for one in (low, high)]
        text = f"{unit} on the altimeter, 90 % {'-'.join(ends)}"
        self.query_one("#range", Static).update(Content(text).stylize("bold"))
        marks = [(place, "") for place in (low, middle, high)]
        if target := self.desk.settings.target:
            marks.append((target, "◎"))
        self.query_one(Plot).show(
            draw_density(said.apogee, marks, lambda value: number(cards.APOGEE, value, system).split(".")[0])
        )
        self.query_one("#safety", Static).update(Content(safety_in_brief(one.lines)))
        more = self._figures(one)
        self.query_one("#more", Static).update(cards.lines("", more, 9))
        self._text = cards.as_text(f"{title}: {number(cards.APOGEE, middle, system)} {text}", more)

    def _figures(self, one: "Choice") -> list[tuple[str, str]]:
        """The figures below the hill."""
        from fieldkit.loop.predict import median
        from fieldkit.plan.air import air_of
        from fieldkit.plan.safety import DECIDES, MARKS

        assert self._plan is not None
        said, system = one.prediction, self.desk.settings.units
        fires = [f"{delay:g} s {seconds:+.1f}" for delay, seconds in one.ejections]
        return [
            ("ejection", _ejection(said.median_eject)),
            ("by delay", "  ".join(fires)),
            ("off rail", self._rail(said)),
            ("T:W", f"{one.first_thrust:.1f} at first, {one.average_thrust:.1f} average"),
            ("top speed", measure(BY_NAME["top_speed"], median(said.top_speed), system)),
            ("Cd", f"{said.cd.mean():.2f} ± {said.cd.std():.2f}"),
            ("alpha", f"{said.alpha.mean():.3f} ± {said.alpha.std():.3f}"),
            ("true", f"{measure(cards.APOGEE, median(said.true_apogee), system)} above the pad"),
            ("air", air_of(said.plan).words()),
            ("rests on", self._plan.rests_on),
            ("note", "; ".join([*said.found.notes, *said.left_out])),
            *((f"{MARKS[line.verdict]} {line.name}", f"{line.verdict}: {line.text}") for line in one.lines),
            ("", DECIDES),
        ]

    def action_search(self) -> None:
        """Type a motor's name."""
        self.set_focus(self.query_one(Input))

    @on(Input.Submitted)
    def _to_table(self) -> None:
        self.set_focus(self.query_one(Table))

    def action_fitting(self) -> None:
        """Only what fits, or everything."""
        self._fitting = not self._fitting
        self._search_anew()

    def action_compare(self) -> None:
        """All figures instead of the card, and back."""
        self.toggle_class("-comparing")
        self._refill()

    def on_resize(self, _event: events.Resize) -> None:
        """A wide screen has room for everything."""
        if self._plan is not None:
            self._refill()

    def action_build(self) -> None:
        """The next rocket and configuration that have flown."""
        plan = self._plan
        if plan is None or not plan.builds:
            return
        names = [(build.rocket, build.config) for build in plan.builds]
        now = (plan.flight.rocket, plan.flight.config)
        rocket, config = names[(names.index(now) + 1) % len(names)] if now in names else names[0]
        self._keep_plan(plan.flight.with_changes(rocket=rocket, config=config, dry_mass=None, diameter=None))

    def action_decide(self) -> None:
        """What is left to decide with the motor under the cursor."""
        from fieldkit.plan.guide import label
        from fieldkit.tui.plan_screen import PlanScreen

        plan, motor = self._plan, self.query_one(Table).current
        if plan is not None and motor is not None:
            full = plan.full.with_changes(motor=label(motor))
            self.app.push_screen(PlanScreen(full, plan.rocket, plan.site, plan.limits, motor))

    def action_plan(self) -> None:
        """Change the plan."""
        plan = self._plan.flight if self._plan is not None else Flight()
        system = self.desk.settings.units
        texts = {q.name: _plan_text(plan, q.name) for q in QUESTIONS if q.column is None}
        texts |= {name: measure(BY_NAME[name], plan.number(name), system) for name in PLAN}
        units = {name: unit_of(BY_NAME[name], system) for name in PLAN}
        self.app.push_screen(Form("The plan", QUESTIONS, texts, units), self._planned)

    def _planned(self, values: dict[str, object] | None) -> None:
        if values is None:
            return
        from fieldkit.plan.safety import motor_temperature

        warm = str(values.pop(MOTOR_TEMPERATURE, "") or "")
        plan = Flight(extra={MOTOR_TEMPERATURE: warm} if warm else {}).with_changes(**values)
        try:
            motor_temperature(plan)
        except BadValue as error:
            self.complain(str(error))
            return
        self._keep_plan(plan)

    def _keep_plan(self, plan: Flight) -> None:
        texts = {q.name: _plan_text(plan, q.name) for q in QUESTIONS}
        self.ask(
            lambda: self.desk.ledger.keep_draft(DRAFT, {n: t for n, t in texts.items() if t}),
            lambda _: self.reload(),
            "keep-plan",
        )

    @on(Table.Chosen)
    def _keep_forecast(self) -> None:
        """Keep the forecast of the motor under the cursor, made with care."""
        one = self._known.get(self.query_one(Table).current)
        if one is None:
            return

        def work() -> "list[Prediction]":
            from fieldkit.loop.desk import predict_plans

            return predict_plans(self.desk.ledger, self.desk.motors, [one.plan])

        self.ask(work, self._kept, "keep")

    def _kept(self, made: "list[Prediction]") -> None:
        said, system = made[0], self.desk.settings.units
        low, middle, high = (number(cards.APOGEE, float(x), system) for x in said.apogee_quantiles())
        unit = spelled(unit_of(cards.APOGEE, system))
        self.tell(f"kept: {said.plan.motor} to {middle} {unit} ({low} to {high}); the flight is measured against it")
        self.changed_for_others()

    def copied(self) -> str:
        """The forecast as text."""
        return self._text


def _ejection(eject: float | None) -> str:
    if eject is None:
        return "no delay known for this motor"
    return f"{abs(eject):.1f} s {'after' if eject >= 0 else 'BEFORE'} apogee"


def safety_in_brief(lines: "Sequence[Line]") -> str:
    """The names of all checks, those that fail first: `✗ rail exit speed  ? ground wind, ceiling`."""
    from fieldkit.plan.safety import MARKS

    worst_first: tuple[Verdict, ...] = ("unsafe", "caution", "unknown", "ok")
    groups = ((verdict, [line.name for line in lines if line.verdict == verdict]) for verdict in worst_first)
    return "\n".join(f"{MARKS[verdict]} {', '.join(names)}" for verdict, names in groups if names)


def plan_changes(texts: Mapping[str, str]) -> dict[str, object]:
    """The fields of a plan from what was typed, as the ledger keeps it; the motor's temperature beside them."""
    values = {name: read_answer(name, text) for name, text in texts.items() if name != MOTOR_TEMPERATURE}
    warm = texts.get(MOTOR_TEMPERATURE, "")
    return values | ({"extra": {MOTOR_TEMPERATURE: warm}} if warm else {})


def _plan_text(plan: Flight, name: str) -> str:
    return plan.extra.get(name, "") if name == MOTOR_TEMPERATURE else answer_text(plan, name)


PAGE = Page(4, "Next", NextScreen)
