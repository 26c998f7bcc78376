"""The form that maps the columns of a table, and the list of saved mappings."""

from collections.abc import Callable, Iterable, Sequence
from typing import ClassVar

from textual.app import ComposeResult
from textual.binding import Binding, BindingType
from textual.containers import Vertical
from textual.content import Content
from textual.widget import Widget
from textual.widgets import Static

from fieldkit.errors import FieldkitError
from fieldkit.flight import BY_NAME
from fieldkit.importing import ColumnChoice
from fieldkit.importing.manual_entry import Question
from fieldkit.importing.tables.headings import QUANTITIES
from fieldkit.importing.tables.mapping import FLIGHT_COLUMNS, LIFTOFF_MASS, MOTOR_MASS, remembered
from fieldkit.safe_text import printable
from fieldkit.services.imports.mappings import TableColumns, columns_of, edit, forget, in_words
from fieldkit.services.pickers import OfferedAnswer, Source, among
from fieldkit.tui.add.fields import Field, Form
from fieldkit.tui.help import Help
from fieldkit.tui.imports.import_help import MAPPING_ABOUT, MAPPINGS_HELP
from fieldkit.tui.widgets import cards
from fieldkit.tui.widgets.bars import KeyBar
from fieldkit.tui.widgets.dialogs import HelpedModal
from fieldkit.tui.widgets.table import Head, Table

_ABOUT = {
    "time": "The clock, in any unit: s, ms, us, 12:04:05.3.",
    "altitude": "Height above the pad.",
    "altitude_msl": "Height above sea level, or any height that is not zero on the pad.",
    "pressure": "Air pressure.",
    "felt": "Acceleration along the rocket as the sensor measures it: one g on the pad.",
    "acceleration": "Acceleration along the rocket without gravity: zero on the pad.",
    LIFTOFF_MASS: "Mass with the motor; the motor's mass is subtracted.",
    MOTOR_MASS: "Mass of the loaded motor.",
}
_HOW_TO_CHOOSE = "Type part of its name: ↓ and Enter choose from the list, Enter alone takes the only match."
FIRST_FIELDS = ("rocket", "motor", "apogee", "dry_mass", "date_time")
"""The fields of a flight that are asked first, because a forecast needs them."""
MAX_CELL = 16
"""Maximum width of a column in the preview of a table. [cell]"""
OTHER_ROWS = "rows"
"""The answer that reopens the form for the other kind of rows."""


class MappingForm(Form):
    """A line for each channel of samples, or each field of flights; empty if the table has no such column. After a
    column its unit is offered if its name states none, and the first cells are shown beside it."""

    ABOUT = MAPPING_ABOUT
    DEFAULT_CSS = """
    MappingForm Field > Input, MappingForm Field > Input:focus { width: 26; }
    MappingForm VerticalScroll { max-height: 40vh; }
    MappingForm > Vertical { max-width: 120; }
    MappingForm #table { height: auto; margin-bottom: 1; text-wrap: nowrap; text-overflow: ellipsis; }
    """
    BINDINGS: ClassVar[list[BindingType]] = [
        Binding("ctrl+t", "other_rows", "Samples/flights", key_display="^T", priority=True)
    ]

    def __init__(self, columns: TableColumns) -> None:
        names = tuple(dict.fromkeys([*FIRST_FIELDS, *FLIGHT_COLUMNS]) if columns.of == "flights" else QUANTITIES)
        questions = [Question(name, _title(name), f"{_about(name)} {_HOW_TO_CHOOSE}") for name in names]
        texts = {name: column for name, column in columns.read_as.items() if name in names}
        super().__init__(
            f"Each row is one of the {columns.of} of this table", questions, texts, {}, _reader(columns), None
        )
        self._columns = columns
        self._picker.sources = {name: _offered(columns, name) for name in names}

    def above(self) -> Iterable[Widget]:
        """The first rows of the table."""
        yield Static("", id="table")

    def on_descendant_focus(self) -> None:
        """Explain the current field, and show which columns are not used yet."""
        super().on_descendant_focus()
        used = {self._columns.place(field.answer) for field in self.query(Field) if field.answer}
        self.query_one("#table", Static).update(_first_rows(self._columns, used))

    async def action_go_on(self) -> None:
        """Move to the next line with the chosen column, or the only one offered; one without a unit first offers its
        units."""
        field = self.focused.parent if self.focused is not None else None
        if self._picker.take(only=True) and isinstance(field, Field):
            self._picker.offer_more(field.question.name)
            if self._picker.open:
                return
        await super().action_go_on()

    async def action_take(self) -> None:
        """Submit the columns. Flights with a column without a unit would be rejected, so it is asked for first."""
        for field in self.query(Field) if self._columns.of == "flights" else ():
            answer = field.answer
            if any(self._columns.cells(answer)) and self._columns.units(field.question.name, answer):
                self.set_focus(field.line)  # immediately, because the next key is for it
                self.call_after_refresh(self._picker.follow, field.line, field.question.name)
                return
        await super().action_take()

    def beside(self, field: Field, value: object, unit: str) -> str:
        """The first cells of the column, and whether its unit is missing."""
        cells = ", ".join(self._columns.cells(field.answer))
        lacks = self._columns.units(field.question.name, field.answer)
        return f"no unit · {cells}" if lacks else cells

    def action_other_rows(self) -> None:
        """Reopen the form for samples instead of flights, or for flights instead of samples."""
        self.dismiss({OTHER_ROWS: True})


def _first_rows(columns: TableColumns, used: set[int | None]) -> Content:
    """The names of the columns above the first rows; columns that a field uses are dimmed, names of others bold."""
    lines = [columns.names, *columns.rows]
    widths = [
        min(MAX_CELL, max(len(printable(line[place])) for line in lines if place < len(line)))
        for place in range(len(columns.names))
    ]
    parts: cards.Styled = []
    for number, line in enumerate(lines):
        parts.append("\n" if number else "")
        for place, (cell, width) in enumerate(zip(line, widths, strict=False)):
            text = printable(cell)
            shown = text if len(text) <= width else f"{text[: width - 1]}…"
            style = "$text-muted" if place in used else "b" if number == 0 else ""
            parts.append((f"{shown:{width}}  ", style))
    return Content.assemble(*parts)


def _offered(columns: TableColumns, name: str) -> Source:
    """Offers the columns of a table, each with its first cells; for a whole name without a unit, its units."""
    named = among([OfferedAnswer(column, ", ".join(columns.cells(column)[:2])) for column in columns.names])

    def found(typed: str) -> Sequence[OfferedAnswer]:
        units = columns.units(name, typed)
        return [OfferedAnswer(f"{typed} [{unit}]") for unit in units] if units else named(typed)

    return found


def _reader(columns: TableColumns) -> Callable[[str, str, str], object]:
    """Reads an answer: a channel, a text, and no unit. Raises BadValue."""
    return lambda name, text, unit: columns.checked(name, text)


def _title(name: str) -> str:
    column = BY_NAME.get(name)
    if column and name not in QUANTITIES:
        return column.title
    spelled = name.replace("_", " ").replace("felt", "accelerometer").replace("msl", "MSL").replace("gps", "GPS")
    return spelled[:1].upper() + spelled[1:]


def _about(name: str) -> str:
    column = BY_NAME.get(name)
    return _ABOUT.get(name) or (column.help if column else "")


class MappingList(HelpedModal[None]):
    """The saved mappings, listed by the headings of their tables, to edit or delete."""

    DEFAULT_CSS = """
    MappingList { align: center middle; background: $backdrop; }
    MappingList > Vertical { width: 94%; height: 80%; background: $surface; border: solid $border; padding: 0 1; }
    """
    BINDINGS: ClassVar[list[BindingType]] = [
        Binding("x,delete", "forget", "Remove", key_display="x"),
        Binding("escape", "dismiss", "Close"),
    ]

    def __init__(self, complain: Callable[[str], object]) -> None:
        super().__init__()
        self._complain = complain
        self._known: Sequence[ColumnChoice] = ()

    def compose(self) -> ComposeResult:
        """The list and its keys."""
        with Vertical() as frame:
            frame.border_title = Content("Saved mappings")
            empty = "none yet: press m on the Import page to map the columns of a table"
            yield Table(id="mappings", empty=empty, enter="Edit mapping")
            yield KeyBar()

    def check_action(self, action: str, parameters: tuple[object, ...]) -> bool | None:
        """Without mappings there is none to remove."""
        return bool(self._known) if action == "forget" else super().check_action(action, parameters)

    def explained(self) -> tuple[str, Help]:
        """The columns and keys of the list."""
        return "Saved mappings", MAPPINGS_HELP

    def on_mount(self) -> None:
        """List the mappings."""
        self._show()
        self.set_focus(self.query_one(Table))

    def _show(self) -> None:
        self._known = remembered()
        heads = [Head("of", 8), Head("columns", 40), Head("headings of the table", 0)]

        def cells(number: int) -> tuple[str, str, str]:
            of, headings, columns = in_words(self._known[number - 1])
            return of, columns, headings

        self.query_one(Table).show(heads, list(range(1, len(self._known) + 1)), cells)

    def on_table_chosen(self) -> None:
        """Enter edits."""
        self.action_edit()

    def action_edit(self) -> None:
        """Change the columns of a mapping."""
        number = self.query_one(Table).current
        if number is None:
            return

        def answered(values: dict[str, object] | None) -> None:
            if values is not None and OTHER_ROWS not in values:
                self._try(lambda: edit(number, [f"{name}={column}" for name, column in values.items() if column]))

        self.app.push_screen(MappingForm(columns_of(self._known[number - 1])), answered)

    def action_forget(self) -> None:
        """Delete the mapping under the cursor."""
        number = self.query_one(Table).current
        if number is not None:
            self._try(lambda: forget(number))

    def _try(self, change: Callable[[], object]) -> None:
        try:
            change()
        except FieldkitError as error:
            self._complain(str(error))
        self._show()
