"""Import: choose a file, see its recognized format and rejected rows, then store it.

Asking for the meaning of a table's columns, for rows of the kind detected or chosen.

The contents of a file on the Import page; on a large screen also the climb in a log, and how the file was read.
"""

from collections.abc import Callable, Iterable, Sequence
from dataclasses import replace
from functools import partial
from os.path import isdir
from pathlib import Path
from typing import ClassVar

from textual import on
from textual.binding import Binding, BindingType
from textual.containers import Horizontal, Vertical, VerticalScroll
from textual.content import Content
from textual.widget import Widget
from textual.widgets import Static

from fieldkit.errors import FieldkitError
from fieldkit.importing import ColumnChoice
from fieldkit.importing.recognize import parsers
from fieldkit.importing.tables.mapping import is_of_flights
from fieldkit.paths import working_folder
from fieldkit.quantities import spelled, unit_of
from fieldkit.safe_text import printable
from fieldkit.services.imports import Receipt
from fieldkit.services.imports.mappings import TableColumns, table_columns
from fieldkit.services.pickers import OfferedAnswer
from fieldkit.tui.asking import or_why
from fieldkit.tui.flights.log_view import LogView, draw_height, file_facts, looks_at
from fieldkit.tui.imports.day_setup import is_open, waiting_setup
from fieldkit.tui.imports.given_form import ask_given
from fieldkit.tui.imports.import_help import IMPORT_HELP
from fieldkit.tui.imports.import_look import (
    PARENT_FOLDER,
    Look,
    ReadOptions,
    by_keys,
    check_format_name,
    check_path,
    folder_text,
    inside,
    left_out,
    listed,
    look_at,
    name_and_size,
    store,
    stored_in_words,
    typed_path,
    what_it_brings,
    what_it_holds,
)
from fieldkit.tui.imports.mapping_form import OTHER_ROWS, MappingForm, MappingList
from fieldkit.tui.imports.weather_file import ask_weather_file
from fieldkit.tui.page import PageScreen
from fieldkit.tui.widgets import cards
from fieldkit.tui.widgets.dialogs import AskText
from fieldkit.tui.widgets.hanging import Hanging, stacked
from fieldkit.tui.widgets.plots import Plot
from fieldkit.tui.widgets.table import Head, Table


class FilePanel(Vertical):
    """What is in a file; on a large screen above it the height against time, if it is a log, and below it the parser
    and the columns."""

    DEFAULT_CSS = """
    FilePanel, FilePanel Static { height: auto; }
    FilePanel .-large-only { display: none; }
    FilePanel Plot { height: 30vh; margin-bottom: 1; border-top: solid $border-blurred;
        border-title-color: $foreground; }
    FilePanel #how { margin-top: 1; }
    """

    def compose(self) -> Iterable[Widget]:
        """The plot, the contents, the facts."""

        yield Plot(classes="-large-only")
        yield Static("", id="more")
        yield Static("", id="how", classes="-large-only")

    def show(self, receipt: "Receipt | None", system: str) -> None:
        """Show the climb and the facts of the only file of a receipt, in the units of a system, else neither."""

        files = receipt.files if receipt is not None else ()
        file = files[0] if len(files) == 1 else None
        shown = next((one for one in file.shown if one.curve is not None), None) if file is not None else None
        plot, how = self.query_one(Plot), self.query_one("#how", Static)
        plot.set_class(shown is not None, "-filled")
        how.set_class(file is not None, "-filled")
        if shown is not None and shown.curve is not None:
            unit = spelled(unit_of(cards.APOGEE, system))
            plot.border_title = Content(printable(f"Height of {shown.flight.flight_id} [{unit}]"))
            plot.show(draw_height(shown.curve, system))
        if file is not None:
            how.update(stacked(file_facts(file, system)))


def ask_columns(
    page: PageScreen, path: Path, answer: Callable[[Sequence[str]], None], earlier: Sequence[str] = (), of: str = ""
) -> None:
    """Ask for the meaning of a file's columns; its rows are `of` samples or flights, or of the kind detected if it is
    empty. `answer` gets a text NAME=COLUMN for each column; the form shows the `earlier` ones of this table, so that a
    mistake in them can be corrected."""

    def show(columns: TableColumns | str) -> None:
        if isinstance(columns, str):
            page.complain(columns)
        else:
            page.ask_form(MappingForm(_with(columns, earlier)), partial(answered, columns))

    def answered(columns: TableColumns, values: dict[str, object]) -> None:
        if OTHER_ROWS in values:
            ask_columns(page, path, answer, earlier, "flights" if columns.of == "samples" else "samples")
        else:
            answer([f"{name}={column}" for name, column in values.items() if column])

    page.ask(or_why(partial(table_columns, path, of)), show, "columns")


def _with(columns: TableColumns, earlier: Sequence[str]) -> TableColumns:
    """The columns of a table with their meaning as typed earlier, if it was for this table and this kind of rows."""
    typed = dict(text.split("=", 1) for text in earlier)
    named = all(columns.place(column) is not None for column in typed.values())
    same_kind = bool(typed) and is_of_flights(ColumnChoice(typed)) == (columns.of == "flights")
    return replace(columns, read_as=typed) if named and same_kind else columns


def readable() -> Hanging:
    """The kinds of files that the page reads, shown beside a folder."""
    loggers = [one for one in parsers().values() if not one.simulates]
    loggers.sort(key=lambda one: (one.fallback, one.title.lower()))
    logs = ", ".join(one.title for one in loggers)
    simulated = ", ".join(one.title.removesuffix(" simulation (CSV)") for one in parsers().values() if one.simulates)
    kinds = (
        ("logs", logs),
        ("simulations", f"{simulated} (CSV)"),
        ("designs", "OpenRocket .ork, RockSim .rkt, RASAero .CDX1"),
        ("weather", "saved weather, for flights at its site"),
    )
    return cards.lines("Files that can be read", kinds)


class ImportScreen(PageScreen):
    """The files on the left, the preview of the one under the cursor on the right."""

    NAME = "import_files"
    ON_ENTER = ("Import", "Read this file or the marked ones, or open this folder")
    TITLE = "Import"
    ROW_REQUESTS = ("list",)
    ABOUT = IMPORT_HELP
    BINDINGS: ClassVar[list[BindingType]] = [
        Binding("backspace", "up", "Folder up", key_display="⌫", tooltip="Open the folder above"),
        Binding("F", "format", "Format", tooltip="Choose the parser"),
        Binding("e", "set", "Values", tooltip="Values that the file lacks: rocket, motor, mass"),
        Binding("l", "look", "Look", tooltip="The log as a plot, with its columns, readouts and events"),
        Binding("m", "columns", "Columns", tooltip="Map the columns of a table"),
        Binding("M", "mappings", "Mappings", tooltip="Saved mappings: change or delete them", show=False),
        Binding("space", "mark", "Mark", tooltip="Mark files to read together", show=False),
        Binding("r", "reload", "Reload", tooltip="Reload the folder and the file", show=False),
        Binding("o", "folder", "Go to", tooltip="Type the path of a folder or a file"),
    ]
    DEFAULT_CSS = """
    ImportScreen #where { height: 1; padding: 0 1; background: $panel; text-wrap: nowrap; text-overflow: ellipsis; }
    ImportScreen #files { width: 34; }
    ImportScreen.-wide #files { width: 60; }
    ImportScreen.-wide #look { border: round $border-blurred; }
    ImportScreen #look { width: 1fr; padding: 0 1; border-left: solid $border-blurred; }
    ImportScreen #preview { height: auto; margin-bottom: 1; }
    ImportScreen.-wide.-tall .-large-only.-filled { display: block; }
    ImportScreen.-narrow #split { layout: vertical; }
    ImportScreen.-narrow #files { width: 1fr; height: 7; }
    """

    def __init__(self) -> None:
        super().__init__()
        self._folder = working_folder()
        self._chosen_options: dict[Path, ReadOptions] = {}  # by file: what suits one may not suit the next
        self._marked: tuple[Path, ...] = ()
        self._look: Look | None = None
        self._answered: dict[str, str] = {}  # what was last entered on storing a file

    @property
    def _reading(self) -> ReadOptions:
        """How to read the file under the cursor, with the marked files."""
        path = self.query_one("#files", Table).current
        return replace(self._chosen_options.get(path, ReadOptions()), marked=self._marked)

    def body(self) -> Iterable[Widget]:
        """The folder, the files, and the preview; on a large screen also the climb, and how the file was read."""
        yield Static("", id="where")
        with Horizontal(id="split"):
            yield Table(id="files", empty="empty", enter=self.ON_ENTER[0])
            with VerticalScroll(id="look", classes="framed"):
                yield Static("", id="preview")
                yield FilePanel()

    def on_mount(self) -> None:
        """Focus the files."""
        self.set_focus(self.query_one("#files", Table))

    def resting_place(self) -> Widget:
        """The files."""
        return self.query_one("#files", Table)

    def reload(self) -> None:
        """List the folder again."""
        self.go(self._folder)

    def go(self, folder: Path, mark: Path | None = None) -> None:
        """Show a folder, the cursor on one of its files."""
        self.ask(partial(listed, folder), partial(self._listed, folder, mark), "list")

    def _listed(self, folder: Path, mark: Path | None, paths: list[Path]) -> None:
        self._folder = folder
        self.query_one("#where", Static).update(Content(printable(folder_text(folder))))
        rows = {path: name_and_size(path) for path in paths}
        self._marked = tuple(path for path in self._marked if path in rows)
        table = self.query_one("#files", Table)

        def cells(path: Path) -> tuple[str, str]:
            name, size = rows[path]
            return ("+ " if path in self._marked else "") + name, size

        table.show([Head("file", 0, middle=True), Head("size", 7, True)], paths, cells)
        if mark is not None:
            table.move_to(mark)
        self._examine()

    @on(Table.Moved, "#files")
    def _examine(self) -> None:
        """Read the file under the cursor without storing anything."""
        table = self.query_one("#files", Table)
        path = table.current
        is_folder = path is None or path == PARENT_FOLDER or isdir(path)
        table.on_enter = "Open" if is_folder else self.ON_ENTER[0]
        self.follow_keys()
        self._look = None
        self.query_one("#more", Static).update(readable() if is_folder else "")
        self.query_one(FilePanel).show(None, "")
        if is_folder:
            self.query_one("#preview", Static).update("Enter to open the folder")
            if path is not None:
                folder = self._folder.parent if path == PARENT_FOLDER else path
                self.ask(partial(inside, folder), self._have_inside, "look")
            return
        self.query_one("#preview", Static).update("reading ...")
        self.ask(partial(look_at, self.resources, path, self._reading), self._examined, "look")

    def _have_inside(self, content: Hanging) -> None:
        self.query_one("#more", Static).update(stacked(part for part in (readable(), content) if part.lines))

    def _examined(self, look: Look) -> None:
        self._look = look
        system = self.resources.settings.units
        self.query_one("#preview", Static).update(what_it_brings(look, self._reading.given, system))
        parts = (left_out(look), what_it_holds(look, system))
        self.query_one("#more", Static).update(stacked(part for part in parts if part.lines))
        self.query_one(FilePanel).show(look.receipt, system)

    @on(Table.Chosen, "#files")
    async def _chosen(self) -> None:
        """Open the folder, or store the file."""
        path = self.query_one("#files", Table).current
        if path == PARENT_FOLDER:
            self.action_up()
        elif path is not None and isdir(path):
            self.go(path)
        elif self._look is not None and self._look.path == path and (start := self._look.start) is not None:
            self.change(lambda: self.resources.ledger.keep_design(start), self._kept)
        elif self._look is not None and self._look.path == path and (weather := self._look.weather) is not None:
            ask_weather_file(self, weather)
        elif self._look is not None and self._look.path == path and self._look.receipt is not None:
            await self._store(path, self._look)
        elif self._look is not None:
            self.complain(self._look.trouble)
        else:
            self.show_notice("Still reading the file; Enter again imports it")

    async def _store(self, path: Path, look: Look) -> None:
        """Store a file; if it lacks a rocket or a motor, ask first, with those of an open forecast, or else the last
        answers, filled in."""
        if self._reading.given or not is_open(look.flights):
            self._store_with(path, self._reading)
        else:
            self.ask(partial(waiting_setup, self.resources), partial(self._ask_setup, path), "setup")
            await self.settled("setup")

    def _ask_setup(self, path: Path, known: dict[str, str]) -> None:
        def answered(given: dict[str, str]) -> None:
            self._answered = given
            self._store_with(path, replace(self._reading, given=given))

        ask_given(self, known or self._answered, answered)

    def _store_with(self, path: Path, reading: ReadOptions) -> None:
        self.change(partial(store, self.resources, path, reading), self._stored)

    def action_mark(self) -> None:
        """Mark or unmark the file under the cursor for reading together with others."""
        path, marked = self.query_one("#files", Table).current, self._marked
        if path is None or path == PARENT_FOLDER or isdir(path):
            return
        self._marked = tuple(one for one in marked if one != path) if path in marked else (*marked, path)
        self.query_one("#files", Table).refresh()
        self._examine()

    def _stored(self, receipt: Receipt) -> None:
        self._marked = ()
        self.show_change(stored_in_words(receipt))

    def _kept(self, new: bool) -> None:
        self.show_change("Saved as this rocket's starting point. u to undo" if new else "Saved already")

    def action_reload(self) -> None:
        """List new and changed files; the cursor stays on its file."""
        self.go(self._folder, self.query_one("#files", Table).current)

    def action_up(self) -> None:
        """Open the folder above."""
        self.go(self._folder.parent, self._folder)

    def action_look(self) -> None:
        """Show the file under the cursor as it was read: plots with a cursor, columns, readouts, events."""
        look = self._look
        if look is None or look.receipt is None or not look.receipt.files:
            self.complain(look.trouble if look is not None and look.trouble else "No file under the cursor")
            return
        system = self.resources.settings.units
        self.app.push_screen(LogView([one for file in look.receipt.files for one in looks_at(file, system)], system))

    def action_format(self) -> None:
        """Name a parser."""
        picks = [OfferedAnswer(name, parser.title) for name, parser in parsers().items()]
        about = "The format; ↓ chooses one. Empty: by its content."
        self.app.push_screen(
            AskText("Read it as", self._reading.format or "", about, picks, check_format_name), self._named
        )

    def _named(self, text: str | None) -> None:
        if text is not None:
            self._read_as(replace(self._reading, format=text.strip() or None))

    def _read_as(self, reading: ReadOptions) -> None:
        """Read the file under the cursor, and files marked with it, with these options; show why if it fails."""
        try:
            reading.how()
        except FieldkitError as error:
            self.complain(by_keys(str(error)))
            return
        path = self.query_one("#files", Table).current
        if path is not None:
            self._chosen_options |= dict.fromkeys(reading.together(path), reading)
        self._examine()

    def action_set(self) -> None:
        """Enter values that the file lacks."""
        ask_given(self, self._reading.given or self._answered, self._set)

    def _set(self, given: dict[str, str]) -> None:
        self._answered = given
        self._read_as(replace(self._reading, given=given))

    async def action_columns(self) -> None:
        """Map the columns of a table."""
        path = self.query_one("#files", Table).current
        if path is None or path == PARENT_FOLDER or isdir(path):
            self.complain("No table under the cursor")
            return
        ask_columns(self, path, self._columns_named, self._reading.columns)
        await self.settled("columns")

    def _columns_named(self, columns: Sequence[str]) -> None:
        self._read_as(replace(self._reading, columns=tuple(columns)))

    def action_mappings(self) -> None:
        """List the saved column mappings."""
        self.app.push_screen(MappingList(self.complain), lambda _: self._examine())

    def action_folder(self) -> None:
        """Type a path."""
        self.app.push_screen(AskText("Go to", str(self._folder), "A folder, or a file.", check=check_path), self._went)

    def _went(self, text: str | None) -> None:
        if not text:
            return
        path = typed_path(text)
        self.go(path) if isdir(path) else self.go(path.parent, path)

    def copied(self) -> str:
        """The preview as text."""
        return "\n".join(str(self.query_one(name, Static).content) for name in ("#preview", "#more"))
