"""The lines of the Add page: set-up above, the current field large, the ten readouts, mass and diameter, the button,
the rest below."""

from collections.abc import Iterable, Mapping

from textual.containers import Container, Vertical, VerticalScroll
from textual.widget import Widget
from textual.widgets import Button, Input

from fieldkit.flight.makers import motor_name
from fieldkit.importing.manual_entry import Question, read_answer
from fieldkit.quantities import measure
from fieldkit.services.manual_entry import typed_unit
from fieldkit.tui.add.add_form import BODY, BY_NAME, MORE_FIELDS, READOUT_QUESTIONS, SETUP
from fieldkit.tui.add.add_hand import Hand
from fieldkit.tui.add.estimate_line import EstimateLine
from fieldkit.tui.add.fields import Field
from fieldkit.tui.page import PageScreen
from fieldkit.tui.setup.rocket_strip import RocketStrip
from fieldkit.tui.widgets.picker import Picker

FORM_CSS = """
    AddScreen #setup { layout: grid; grid-size: 4; grid-gutter: 0 1; height: auto; padding: 0 1; background: $panel; }
    AddScreen.-narrow #setup { grid-size: 2; }
    AddScreen.-narrow #big { width: 26; }
    AddScreen #current { height: auto; }
    AddScreen.-wide #current { layout: horizontal; }
    AddScreen.-wide Hand { width: 1fr; }
    AddScreen.-wide #big { width: 24; }
    AddScreen.-wide EstimateLine { width: 1fr; height: 5; padding: 0 1; color: $foreground;
        border: round $border-blurred; border-title-color: $foreground; }
    AddScreen #fields { padding: 0 1; height: 1fr; }
    AddScreen Button { min-width: 24; background: $panel; color: $foreground; text-style: bold; }
    AddScreen Button:focus { background: $block-cursor-background; color: $block-cursor-foreground; text-style: bold; }
    AddScreen #readouts, AddScreen #more { height: auto; width: 1fr; }
    AddScreen.-wide #readouts Field > Input { width: 15; }
    AddScreen.-wide #fields { layout: horizontal; }
    AddScreen.-wide #readouts { margin-right: 3; }
    AddScreen.-lofty.-normal, AddScreen.-lofty.-narrow {
        Hand, #save { margin: 1 0; }
        Field { height: 3; }
        Field > Label, Field > .note { margin-top: 1; }
        Field > Input { height: 3; border: round $border-blurred; padding: 0 1; }
        Field > Input:focus { height: 3; border: round $border; padding: 0 1; }
    }
    AddScreen.-wide #readouts { width: 3fr; }
    AddScreen.-wide #more { width: 2fr; }
    AddScreen.-wide.-high, AddScreen.-wide.-tall, AddScreen.-wide.-lofty {
        #fields { height: auto; margin-bottom: 1; }
        RocketStrip { height: 1fr; max-height: 100%; }
        RocketStrip.-shown { display: block; }
    }
    AddScreen.-saved RocketStrip { height: 0; }
    AddScreen.-saved.-high RocketStrip.-shown, AddScreen.-saved.-tall RocketStrip.-shown { display: none; }
"""
"""Layout of the form on the page, by its width and height."""


class Sheet:
    """The fields on a page; `touched` names the questions that the user has answered there, `typed_in` the units that
    applied when a number was typed without one."""

    def __init__(self, page: PageScreen) -> None:
        self._page = page
        self._held: Field | None = None
        self.touched: set[str] = set()
        self.typed_in: dict[str, str] = {}
        self.picker = Picker()

    def body(self) -> Iterable[Widget]:
        """The widgets, in their order."""
        with Container(id="setup"):
            for name in SETUP:
                yield Field(BY_NAME[name], short=True)
        with Container(id="current"):
            yield Hand()
            yield EstimateLine()
        with VerticalScroll(id="fields", can_focus=False):
            with Vertical(id="readouts"):
                for name in (*READOUT_QUESTIONS, *BODY):
                    yield Field(BY_NAME[name])
                yield SaveButton(self.touched)
            with Vertical(id="more"):
                for name in MORE_FIELDS:
                    yield Field(BY_NAME[name])
        yield RocketStrip()
        yield self.picker

    def widgets(self) -> Iterable[Widget]:
        """The form's own parts of the page, from top to bottom."""
        return (self._page.query_one(place) for place in ("#setup", "#current", "#fields"))

    def field(self, name: str) -> Field:
        """The field of a question."""
        return self._page.query_one(f"#field-{name}", Field)

    @property
    def button(self) -> Button:
        """The button that saves."""
        return self._page.query_one(SaveButton)

    def answers(self) -> dict[str, str]:
        """The text of each field, by question."""
        return {name: self.field(name).answer for name in BY_NAME}

    def fill(self, texts: Mapping[str, str], system: str = "") -> None:
        """Fill the lines in which nothing was typed, even if the message about a key is still queued; numbers are in
        the units of a system, if one is given."""
        with self._page.prevent(Input.Changed):
            for name in texts.keys() & BY_NAME.keys() - self.touched:
                if not self.field(name).typed:
                    self.field(name).fill(texts[name], self._shown(name, texts[name], system) if system else "")

    def _shown(self, name: str, text: str, system: str) -> str:
        """A default answer as the user reads it, a motor without its maker if its line is short."""
        width = self.field(name).line.size.width
        return motor_name(text, width) if name == "motor" and width else in_units(BY_NAME[name], text, system)

    def touch(self, field: Field, unit: str) -> None:
        """Note that a question was answered: a number without a unit keeps this one, whatever is typed elsewhere."""
        name = field.question.name
        self.touched.add(name)
        if field.answer and not typed_unit(field.answer):
            self.typed_in.setdefault(name, unit)
        else:
            self.typed_in.pop(name, None)

    def clear(self) -> None:
        """Clear every line."""
        self.touched.clear()
        self.typed_in.clear()
        with self._page.prevent(Input.Changed):
            for name in BY_NAME:
                self.field(name).fill("")

    def first_empty(self) -> Input:
        """The first empty field to ask about: rocket or motor, else the first readout without a value; the first
        readout if none is empty."""
        named = [name for name in ("rocket", "motor") if not self.field(name).line.value]
        unread = [name for name in READOUT_QUESTIONS if not self.field(name).line.value]
        return self.field((named or unread or READOUT_QUESTIONS)[0]).line

    def after_readouts(self) -> Widget:
        """Where Enter leads after the last readout: to a mass or diameter that is not known, else to the button."""
        return next((self.field(name).line for name in BODY if not self.field(name).line.value), self.button)

    def highlight(self, widget: Widget | None) -> Field | None:
        """Highlight the field that a line belongs to, and no other."""
        left, self._held = self._held, field_of(widget)
        for one in (left, self._held):
            if one is not None:
                one.set_class(one is self._held, "-hand")
        return self._held


def in_units(question: Question, text: str, system: str) -> str:
    """A default answer as the user reads it: `8.0 mph` for `3.57632 m/s`."""
    value = read_answer(question.name, text) if question.column is not None else None
    return measure(question.column, value, system) if question.column and isinstance(value, float) else text


def field_of(widget: Widget | None) -> Field | None:
    """The field that a line belongs to; None if it belongs to none."""
    return widget.parent if widget is not None and isinstance(widget.parent, Field) else None


class SaveButton(Button):
    """The button below the ten readouts, the mass and the diameter."""

    def __init__(self, touched: set[str]) -> None:
        super().__init__("Save this flight", id="save", compact=True)
        self._touched = touched

    @property
    def enter(self) -> str:
        """What Enter does, for the key bar."""
        return "Save" if self._touched else "Next"
