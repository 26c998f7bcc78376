"""Setup: the motors, the rockets and sites of the ledger, and what was chosen for the app; edited where they stand."""

from collections.abc import Iterable, Sequence
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, ClassVar

from textual import on
from textual.binding import Binding, BindingType
from textual.containers import Horizontal
from textual.widget import Widget
from textual.widgets import Input, Static

from fieldkit.entry import Question
from fieldkit.flight import BY_NAME
from fieldkit.measures import measure, unit_of
from fieldkit.settings import THEMES, UNITS
from fieldkit.tui import site_form
from fieldkit.tui.bars import KeyBar
from fieldkit.tui.dialogs import AskText
from fieldkit.tui.fields import Form, Line
from fieldkit.tui.groups import Group, Kept, Place, grouped, placed
from fieldkit.tui.page import LEAVE_LINE, Help, Page, PageScreen
from fieldkit.tui.shelf_lists import (
    RAIL,
    Listed,
    answer_of,
    builds_listed,
    motors_listed,
    on_record,
    same,
    settings_listed,
    sites_listed,
)
from fieldkit.tui.table import Table
from fieldkit.tui.tabs import TabLine

if TYPE_CHECKING:
    from fieldkit.motors import Motor

KINDS = ("Motors", "Rockets", "Sites", "Settings")

BUILD = (
    Question("rocket", "Rocket", "Its name; a new name renames it in every flight of this build."),
    Question("config", "Configuration", "The name of this build."),
    Question("dry_mass", "Dry mass", f"{BY_NAME['dry_mass'].help} Changes every flight of this build."),
    Question("diameter", "Diameter", f"{BY_NAME['diameter'].help} Changes every flight of this build."),
)


class ShelfScreen(PageScreen):
    """Four lists in one table; left and right go from one to the next."""

    NAME = "shelf"
    TITLE = "Setup"
    LETTERS = ("search",)
    ABOUT = Help(
        "Four lists; the arrows left and right, or a click, go from one to the next. Motors: the whole catalogue; "
        "type / and a name to search it, i adds a .eng or .rse file of your own. Rockets and sites are those your "
        "flights name: Enter changes one in every flight that names it, and u takes that back. Settings: Enter "
        "changes the one under the cursor.",
        (
            ("units", "SI: metres and grams. US: feet and ounces. mixed: feet, and grams. N changes them anywhere."),
            ("theme", "field for any room, sun black on white, night red on black, terminal your own. T anywhere."),
            ("target", "The apogee that motors are compared against on the page Next."),
            ("sites", "Size of the field and its ceiling feed the safety lines of every plan flown there."),
            ("rail", "Length and tilt of the rail you usually have, for plans that name none."),
        ),
        (
            "fieldkit motors F24",
            "fieldkit motors --import FILE.eng",
            "fieldkit edit FLIGHT dry_mass=330g",
            "fieldkit sites FIELD --size 400m",
        ),
    )
    BINDINGS: ClassVar[list[BindingType]] = [
        LEAVE_LINE,
        Binding("left", "turn(-1)", "List before", show=False),
        Binding("right", "turn(1)", "Lists", key_display="←→"),
        Binding("slash", "search", "Search", key_display="/", priority=True),
        Binding("i", "import_motors", "Add motors", tooltip="Add the motors of a .eng or .rse file"),
    ]
    DEFAULT_CSS = """
    ShelfScreen #search { height: 1; }
    ShelfScreen #search Static { width: auto; padding: 0 1; }
    ShelfScreen #search Input { width: 1fr; }
    """

    def __init__(self) -> None:
        super().__init__()
        self._kind = 0
        self._kept = Kept((), ())
        self._found: Sequence[Motor] = ()

    def body(self) -> Iterable[Widget]:
        """The names of the lists, a search, the list."""
        yield TabLine(KINDS, "screen.kind")
        with Horizontal(id="search"):
            yield Static("/")
            yield Line(placeholder="motor: F24, aerotech 24mm, a case ...", compact=True)
        yield Table(empty="nothing here yet", enter="Change")

    def on_mount(self) -> None:
        """Keys go to the table."""
        self.set_focus(self.query_one(Table))

    def reload(self) -> None:
        """Read what the flights name."""
        self._show()
        self.ask(self._read, self._have)
        self._search_now()

    def redraw(self) -> None:
        """The list in front, in other units."""
        self._show()

    def _read(self) -> Kept:
        from fieldkit.ledger.sites import sites

        flights = self.desk.ledger.flights()
        ids = self.desk.ledger.ids(flights)
        places = placed(grouped(ids, flights, "site"), sites(self.desk.ledger))
        return Kept(grouped(ids, flights, "rocket", "config"), places)

    def _have(self, kept: Kept) -> None:
        self._kept = kept
        self._show()

    @on(Input.Changed)
    def _search_now(self) -> None:
        text = self.query_one(Input).value
        self.ask(lambda: self.desk.motors.search(text), self._have_motors, "motors")

    def _have_motors(self, motors: "list[Motor]") -> None:
        self._found = motors
        for error in self.desk.complaints:
            self.complain(str(error))
        self.desk.complaints.clear()
        self._show()

    def _show(self) -> None:
        """The list in front."""
        self.query_one(TabLine).front(self._kind)
        self.query_one("#search").display = self._kind == 0
        heads, keys, cells = self._list()
        table = self.query_one(Table)
        table.enter = ("About it", "Change", "Change", "Change")[self._kind]
        table.show(heads, keys, cells)
        self.query_one(KeyBar).follow()

    def _list(self) -> Listed:
        """The list in front, as wide as there is room for."""
        desk, wide = self.desk, self.size.width >= 100
        match KINDS[self._kind]:
            case "Motors":
                return motors_listed(self._found, wide)
            case "Rockets":
                return builds_listed(self._kept, desk.settings.units)
            case "Sites":
                return sites_listed(self._kept, desk.settings.units)
            case _:
                return settings_listed(desk.settings, desk.name, wide)

    def action_kind(self, kind: int) -> None:
        """Another list."""
        self._kind = kind
        self.query_one(Table).by_hand = False
        self._show()
        self.set_focus(self.query_one(Table))

    def action_turn(self, by: int) -> None:
        """The next list, or the one before."""
        self.action_kind((self._kind + by) % len(KINDS))

    def action_search(self) -> None:
        """Type a motor's name."""
        self.action_kind(0)
        self.set_focus(self.query_one(Input))

    @on(Table.Chosen)
    def _change(self, message: Table.Chosen) -> None:
        (self._about_motor, self._change_build, self._change_site, self._change_setting)[self._kind](message.key)

    def _about_motor(self, motor: "Motor") -> None:
        from fieldkit.tui.dialogs import HelpScreen

        text = f"{motor.maker} {motor.designation}"
        about = Help("What is on record of this motor.", on_record(motor), (f"fieldkit motors {text} --json",))
        self.app.push_screen(HelpScreen(text, about, (), "On record"))

    def _change_build(self, group: Group) -> None:
        self._edit(group, BUILD, " ".join(name for name in group.names if name))

    def _change_site(self, place: Place) -> None:
        """A form over a site: name and elevation are those of its flights, the rest is kept beside them."""
        system, site = self.desk.settings.units, place.site
        elevation = measure(BY_NAME["site_elevation"], site.elevation, system)
        texts = {"site": site.name, "site_elevation": elevation} | site_form.room(site, system)
        form = Form(
            f"{site.name}: {len(place.ids)} flights",
            site_form.QUESTIONS,
            texts,
            site_form.units(system),
            site_form.read,
        )
        self.app.push_screen(form, partial(self._site_edited, place, texts))

    def _site_edited(self, place: Place, texts: dict[str, str], values: dict[str, object] | None) -> None:
        if values is None:
            return
        system, was = self.desk.settings.units, place.site
        flown = {"site": values["site"], "site_elevation": values["site_elevation"]}
        changes = {name: new for name, new in flown.items() if not same(place.last, name, new, texts[name], system)}
        site = site_form.answered(was, values, texts, system)

        def work() -> int:
            from fieldkit.ledger.sites import SITES, with_site

            ledger = self.desk.ledger
            beside = {SITES: with_site(ledger, site, was.name)} if site != was else {}
            return ledger.edit_all(place.ids, was.name, beside, **changes)

        if changes or site != was:
            self.change(work, partial(self._changed, was.name))

    def _edit(self, group: Group, questions: Sequence[Question], what: str) -> None:
        """A form over a group; what is changed there is changed in every flight of it."""
        system = self.desk.settings.units
        texts = {question.name: answer_of(group.last, question, system) for question in questions}
        units = {question.name: unit_of(question.column, system) if question.column else "" for question in questions}
        title = f"{what}: {len(group.ids)} flights"
        self.app.push_screen(Form(title, questions, texts, units), partial(self._edited, group, what, texts))

    def _edited(self, group: Group, what: str, texts: dict[str, str], values: dict[str, object] | None) -> None:
        if values is None:
            return
        changes = {
            name: value
            for name, value in values.items()
            if not same(group.last, name, value, texts[name], self.desk.settings.units)
        }
        if changes:
            work = partial(self.desk.ledger.edit_all, group.ids, what, **changes)
            self.change(work, partial(self._changed, what))

    def _changed(self, what: str, count: int) -> None:
        self.tell(
            f"{what}: {count} flights changed; u takes it back" if count else f"{what} is changed; u takes it back"
        )
        self.field_app.changed()

    def _change_setting(self, name: str) -> None:
        settings = self.desk.settings
        if name == "units":
            self.field_app.choose(units=UNITS[(UNITS.index(settings.units) + 1) % len(UNITS)])
        elif name == "theme":
            self.field_app.choose(theme=THEMES[(THEMES.index(settings.theme) + 1) % len(THEMES)])
        elif name == "target":
            self.field_app.ask_target()
        elif name == "rail":
            self._ask_rail()
        else:
            self.complain(f"{name} is not changed here; ? says how")

    def _ask_rail(self) -> None:
        """Length and tilt of the rail that is used where a plan names none."""
        settings = self.desk.settings
        questions = [Question(name, BY_NAME[name].title, f"{BY_NAME[name].help} Empty: none.") for name in RAIL]
        texts = {name: measure(BY_NAME[name], getattr(settings, name), settings.units) for name in RAIL}
        units = {name: unit_of(BY_NAME[name], settings.units) for name in RAIL}
        self.app.push_screen(Form("Your usual rail", questions, texts, units), self._railed)

    def _railed(self, values: dict[str, object] | None) -> None:
        if values is not None:
            self.field_app.choose("the usual rail is kept", **values)

    def action_import_motors(self) -> None:
        """Add the motors of a file."""
        self.app.push_screen(AskText("Add motors", "", "The path of a .eng or .rse file."), self._import)

    def _import(self, text: str | None) -> None:
        if not text or not text.strip():
            return

        def work() -> "list[Motor]":
            from fieldkit.motors.own import import_file
            from fieldkit.places import motor_folder

            return import_file(Path(text.strip()).expanduser(), motor_folder())

        self.ask(work, self._imported, "import")

    def _imported(self, motors: "list[Motor]") -> None:
        self.desk.forget_motors()
        self.tell(f"{len(motors)} motors added: {', '.join(one.designation for one in motors[:4])}")
        self.field_app.changed()

    def copied(self) -> str:
        """The row under the cursor."""
        return self.query_one(Table).current_text()


PAGE = Page(6, "Setup", ShelfScreen)
