"""Setup: motors, rockets, sites, kits and settings, edited in place.

The help of the Setup page.
"""

from collections.abc import Iterable, Sequence
from functools import partial
from shlex import quote
from typing import Any, ClassVar

from textual import on
from textual.binding import Binding, BindingType
from textual.containers import Container, Horizontal
from textual.widget import Widget
from textual.widgets import Input, Static

from fieldkit.flight.site import Site
from fieldkit.motors import Motor
from fieldkit.planning.kits import Kit
from fieldkit.services.kits import kits
from fieldkit.services.range_box import box_left
from fieldkit.services.sites import sites
from fieldkit.settings import THEMES, UNITS, BoxedMotors
from fieldkit.tui.help import Help
from fieldkit.tui.next import motor_facts
from fieldkit.tui.page import LEAVE_LINE, PageScreen
from fieldkit.tui.setup import kit_form, setup_card, setup_forms
from fieldkit.tui.setup.card_form import ask_card
from fieldkit.tui.setup.kit_form import ask_delete
from fieldkit.tui.setup.setting_card import of_setting
from fieldkit.tui.setup.setup_card import Facts, SetupCard
from fieldkit.tui.setup.setup_forms import ask_rail
from fieldkit.tui.setup.setup_lists import (
    ListContents,
    builds_listed,
    kits_listed,
    motors_listed,
    settings_listed,
    sites_listed,
)
from fieldkit.tui.widgets import cards
from fieldkit.tui.widgets.dialogs import HelpScreen
from fieldkit.tui.widgets.groups import LedgerNames, grouped, placed
from fieldkit.tui.widgets.line import Line
from fieldkit.tui.widgets.table import Table
from fieldkit.tui.widgets.tabs import TabLine

SETUP_HELP = Help(
    "Five lists: motors, rockets, sites, kits, settings. The left and right arrows, or a click, switch between them; "
    "Enter changes the row or the value under the cursor.",
    (
        ("motors", "The whole catalog; i adds your own .eng or .rse file."),
        ("rockets, sites", "From your flights: a change is made in every flight that has it, u to undo."),
        ("i, x", "Add a site before anything flies there, or a kit; remove a kit."),
        ("mm, N s, avg N", "Diameter, total impulse and average thrust of a motor."),
        ("burn s, grams", "Burn time of a motor, and its mass with propellant."),
        ("delays s", "Ejection delays on sale; P is plugged: no charge."),
        ("rocket, config", "A build of a rocket. Dry mass and diameter are those of its last flight."),
        ("last", "The last flight there, and for a build its last motor."),
        ("elevation", "Elevation of the site above sea level; air density depends on it and on the weather."),
        ("kit, mount", "A kit of yours, and the widest motor that its mount takes. Saved in kits.toml."),
        ("size, ceiling", "Size of the field, and its altitude limit."),
        ("units", "SI: meters and grams. US: feet and ounces. mixed: feet and grams. N changes them."),
        ("theme", "field: any room. sun: black on white. night: red on black. terminal: its own. T changes it."),
        ("target", "The target apogee for comparing motors on the Fly page."),
        ("sites", "Field size and ceiling are used in the safety checks of every plan at the site."),
        ("rail", "Length and angle of your usual rail, for plans without one."),
    ),
    (
        "fieldkit motors F24",
        "fieldkit motors --import FILE.eng",
        "fieldkit edit FLIGHT dry_mass=330g",
        "fieldkit sites FIELD --size 400m",
        "fieldkit kits NAME --dry-mass 80g",
    ),
)


KINDS = ("Motors", "Rockets", "Sites", "Kits", "Settings")
"""Names of the lists."""
ENTER = ("Details", "Edit rocket", "Edit site", "Edit kit", "Change")
"""What Enter does on a row of these lists."""
SEARCHES = ("motor: F24, aerotech 24mm, a case ...", "rocket, configuration, motor ...", "site ...", "kit ...", "")
"""What may be typed to find rows of these lists; empty for a list without a search."""
NOT_FOUND = "no row has all of these words; / changes them"

EMPTY_LISTS = (
    "No matching motor; / changes the search",
    "No rockets yet.\n\n0 Home  describe a rocket or load the demo rocket\n2 Add   type in what the altimeter shows",
    "No sites yet.\n\ni New   save the elevation, size and ceiling of a field\n2 Add   enter a flight with its site",
    "No kits yet.\n\ni New   save the mass, diameter and motor mount of a kit",
    "",
)
"""Texts of these lists if they are empty."""
EMPTY_CARDS = {
    "Sites": (
        ("elevation", "the density of the air in every forecast there"),
        ("size", "whether flights land on the field, and the size that the safety codes ask for"),
        ("ceiling", "which motors stay below it"),
    ),
    "Kits": (
        ("dry mass", "a rocket named after the kit starts with it"),
        ("diameter", "and with its diameter"),
        ("mount", "which motors fit before its first flight"),
    ),
}
"""What the figures of an empty list are for."""


class SetupScreen(PageScreen):
    """Five lists in one table; left and right switch between them."""

    NAME = "setup"
    ON_ENTER = ("Change", "Change this row, or see the details of a motor")
    TITLE = "Setup"
    ABOUT = SETUP_HELP
    BINDINGS: ClassVar[list[BindingType]] = [
        LEAVE_LINE,
        Binding("left", "turn(-1)", "Previous list", show=False),
        Binding("right", "turn(1)", "Views", key_display="←→", tooltip="The next list; ← previous"),
        Binding("slash", "find", "Find", key_display="/", tooltip="Find in the list"),
        Binding("i", "add_one", "New", tooltip="Add a kit, a site, or the motors of a .eng or .rse file"),
        Binding("x,delete", "delete_kit", "Remove", key_display="x", tooltip="Remove this kit"),
    ]
    DEFAULT_CSS = """
    SetupScreen #search { height: 1; }
    SetupScreen #search Static { width: auto; padding: 0 1; }
    SetupScreen #search Input { width: 1fr; }
    SetupScreen #split { layout: vertical; }
    SetupScreen SetupCard { height: 2fr; border-top: solid $border-blurred; }
    SetupScreen SetupCard.-motors { display: none; }
    SetupScreen Table.-settings { height: 8; }
    SetupScreen.-short.-normal SetupCard Plot, SetupScreen.-short.-narrow SetupCard Plot { height: 8; }
    SetupScreen.-wide Table { height: auto; min-height: 5; max-height: 40%; }
    SetupScreen.-wide SetupCard { height: 1fr; border: round $border-blurred; }
    SetupScreen.-wide SetupCard.-drawn Plot { dock: right; width: 50%; height: 100%; max-height: 100%;
        margin: 0 0 0 2; }
    SetupScreen.-wide #split.-motors { layout: horizontal; }
    SetupScreen.-wide #split.-motors Table { height: 1fr; max-height: 100%; }
    SetupScreen.-wide #split.-motors SetupCard { display: block; width: 40%; min-width: 62; }
    SetupScreen.-wide #split.-motors SetupCard Plot { dock: none; width: 1fr; height: 1fr; max-height: 30;
        margin: 1 0 0 0; }
    """

    def __init__(self) -> None:
        super().__init__()
        self._kind = 0
        self._texts = [""] * len(KINDS)
        self._names = LedgerNames((), ())
        self._found: Sequence[Motor] = ()
        self._kits: Sequence[Kit] = ()
        self._box: tuple[BoxedMotors, ...] = ()
        self._shown_facts: Facts

    def body(self) -> Iterable[Widget]:
        """The names of the lists, a search, the list, and the card of its current row."""
        yield TabLine(KINDS, "screen.kind")
        with Horizontal(id="search"):
            yield Static("/")
            yield Line(placeholder=SEARCHES[0], compact=True)
        with Container(id="split"):
            yield Table(empty="nothing yet", enter=self.ON_ENTER[0])
            yield SetupCard(id="card", classes="framed")

    def on_mount(self) -> None:
        """Focus the table."""
        self.set_focus(self.query_one(Table))

    def reload(self) -> None:
        """Read the rockets and sites of the flights, the kits, and the motors."""
        self._show()
        self.ask(self._read, self._have)
        self.ask(kits, self._have_kits, "kits")
        self.ask(self._read_box, self._have_box, "box")
        self._search_now()

    def redraw(self) -> None:
        """Show the current list in other units."""
        self._show()

    def _read(self) -> LedgerNames:
        flights = self.resources.ledger.flights()
        ids = self.resources.ledger.ids(flights)
        places = placed(grouped(ids, flights, "site"), sites(self.resources.ledger))
        rockets = self.resources.ledger.rockets()
        return LedgerNames(grouped(ids, flights, "rocket", "config"), places, tuple(rockets))

    def _have(self, names: LedgerNames) -> None:
        self._names = names
        self._show()

    def _have_kits(self, kits: Sequence[Kit]) -> None:
        self._kits = kits
        self._show()

    def _read_box(self) -> tuple[BoxedMotors, ...]:
        resources = self.resources
        return box_left(resources.settings.flyer.box, resources.ledger, resources.motors)

    def _have_box(self, box: tuple[BoxedMotors, ...]) -> None:
        self._box = box
        self._show()

    @on(Input.Changed)
    def _search_again(self) -> None:
        """Start a new search of the open list at its first row."""
        self.query_one(Table).by_hand = False
        self._texts[self._kind] = self.query_one(Input).value
        if self._kind == 0:
            self._search_now()
        else:
            self._show()

    def _search_now(self) -> None:
        text = self._texts[0]
        self.ask(lambda: self.resources.motors.search(text), self._have_motors, "motors")

    def _have_motors(self, motors: list[Motor]) -> None:
        self._found = motors
        for error in self.resources.complaints:
            self.complain(str(error))
        self.resources.complaints.clear()
        self._show()

    @on(Table.Sized)
    def _show(self) -> None:
        """Show the current list with the columns that fit, unless the app is closing and has removed the card."""
        if not self.query(SetupCard):
            return
        self.query_one(TabLine).front(self._kind)
        self.query_one("#search").display = bool(SEARCHES[self._kind])
        for part in ("#split", "#card"):
            self.query_one(part).set_class(self._kind == 0, "-motors")
        self.query_one(Table).set_class(KINDS[self._kind] == "Settings", "-settings")
        every, table = self._list(), self.query_one(Table)
        listed = every.matching(self._texts[self._kind]) if self._kind else every
        table.on_enter = ENTER[self._kind]
        table.empty = NOT_FOUND if every.keys and not listed.keys else EMPTY_LISTS[self._kind]
        table.show(listed.heads, listed.keys, listed.cells, name=listed.name)
        self.follow_keys()
        self._beside()

    @on(Table.Moved)
    def _beside(self) -> None:
        """Show the card of the row under the cursor, if there is room."""
        if self._kind == 0 and not self.has_class("-wide"):
            return
        kind, key, system = KINDS[self._kind], self.query_one(Table).current, self.resources.settings.units
        self.ask(partial(self._facts, kind, key, system), self._have_facts, "card")

    def _have_facts(self, facts: Facts) -> None:
        """Show the list first, then the card."""
        self._shown_facts = facts
        self.soon(self._show_facts)

    def _show_facts(self) -> None:
        self.query_one(SetupCard).show(self._shown_facts)

    def _facts(self, kind: str, key: Any, system: str) -> Facts:
        rules = self.resources.settings.rules
        if key is None:
            below = setup_card.for_sites(Site(""), rules, system) if kind == "Sites" else ()
            return Facts((cards.lines("What it is for", EMPTY_CARDS.get(kind, ())),), below=below)
        match kind:
            case "Motors":
                return setup_card.of_motor(key, system)
            case "Rockets":
                return setup_card.of_build(key, system, self._names.design(*key.names), self.resources.motors)
            case "Sites":
                return setup_card.of_site(key, rules, system)
            case "Kits":
                return setup_card.of_kit(key, system, self._names.builds, self.resources.motors)
            case _:
                return of_setting(key, self.resources, self._box)

    def _list(self) -> ListContents:
        """The current list with the columns that fit."""
        resources, width = self.resources, self.query_one(Table).size.width
        match KINDS[self._kind]:
            case "Motors":
                return motors_listed(self._found, resources.settings.units, width)
            case "Rockets":
                return builds_listed(self._names, resources.settings.units, width)
            case "Sites":
                return sites_listed(self._names, resources.settings.units, width)
            case "Kits":
                return kits_listed(self._kits, resources.settings.units)
            case _:
                return settings_listed(resources.settings, resources.name, self._box)

    def action_kind(self, kind: int) -> None:
        """Show another list."""
        self._kind = kind
        search = self.query_one(Input)
        with self.prevent(Input.Changed):
            search.value, search.placeholder = self._texts[kind], SEARCHES[kind]
        self.query_one(Table).by_hand = False
        self._show()
        self.set_focus(self.query_one(Table))

    def action_turn(self, by: int) -> None:
        """Show the next or previous list."""
        self.action_kind((self._kind + by) % len(KINDS))

    def action_find(self) -> None:
        """Type words to find in the open list."""
        self.set_focus(self.query_one(Input))

    @on(Table.Chosen)
    def _change(self, message: Table.Chosen) -> None:
        match KINDS[self._kind]:
            case "Motors":
                self._about_motor(message.key)
            case "Rockets":
                setup_forms.change_build(self, message.key)
            case "Sites":
                setup_forms.change_site(self, message.key)
            case "Kits":
                kit_form.ask_kit(self, message.key)
            case _:
                self._change_setting(message.key)

    def _about_motor(self, motor: Motor) -> None:
        text = f"{motor.maker} {motor.designation}"
        facts = motor_facts.facts(motor, self.resources.settings.units)
        about = Help("The catalog data of this motor.", facts, (f"fieldkit motors {quote(text)} --json",))
        self.app.push_screen(HelpScreen(text, about, (), "Catalog data"))

    def _change_setting(self, name: str) -> None:
        settings = self.resources.settings
        if name == "units":
            self.field_app.choose(units=UNITS[(UNITS.index(settings.units) + 1) % len(UNITS)])
        elif name == "theme":
            self.field_app.choose(theme=THEMES[(THEMES.index(settings.theme) + 1) % len(THEMES)])
        elif name == "target":
            self.field_app.action_ask_target()
        elif name == "rail":
            ask_rail(self)
        elif name == "card":
            ask_card(self)
        else:
            self.complain(f"{name} cannot be changed here; ? explains how")

    def check_action(self, action: str, parameters: tuple[object, ...]) -> bool | None:
        """Only kits are deleted here, only kits, sites and motors are added, and settings are too few to search."""
        if action == "find":
            return bool(SEARCHES[self._kind])
        if action == "delete_kit":
            return KINDS[self._kind] == "Kits" and self.row() is not None
        if action == "add_one":
            return KINDS[self._kind] in ("Kits", "Sites", "Motors")
        return super().check_action(action, parameters)

    def action_add_one(self) -> None:
        """Add a kit, a site, or the motors of a file."""
        if KINDS[self._kind] == "Kits":
            kit_form.ask_kit(self, None)
        elif KINDS[self._kind] == "Sites":
            setup_forms.add_site(self)
        else:
            setup_forms.ask_motors(self)

    def action_delete_kit(self) -> None:
        """Delete the kit under the cursor."""
        kit = self.query_one(Table).current
        if kit is not None:
            ask_delete(self, kit)

    def copied(self) -> str:
        """The row under the cursor."""
        return self.query_one(Table).current_text()
