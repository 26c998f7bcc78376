"""The current field of the Add page: its number in large digits, its meaning, and the consistency of the readouts."""

from collections.abc import Iterable

from textual.containers import Horizontal
from textual.content import Content
from textual.widget import Widget
from textual.widgets import Static

from fieldkit.importing.manual_entry import Question, implausible_answers
from fieldkit.quantities import in_system, spelled
from fieldkit.safe_text import printable
from fieldkit.services.manual_entry import typed_number, typed_unit
from fieldkit.tui.add.add_form import Answered, summary, together
from fieldkit.tui.add.fields import Field
from fieldkit.tui.widgets.big import Big
from fieldkit.tui.widgets.hanging import marked


class Hand(Horizontal):
    """A frame with the question as its title, the number and the text."""

    DEFAULT_CSS = """
    Hand { height: 5; border: round $border; padding: 0 1; }
    Hand #big { width: 30; height: 3; color: $accent; }
    Hand #says { width: 1fr; height: 3; }
    """

    def compose(self) -> Iterable[Widget]:
        """The digits and the text."""
        yield Big(id="big")
        yield Static("", id="says")

    def show(self, field: Field, answered: Answered, unit: str, system: str) -> None:
        """Show a field, among all the answers; `unit` is that of a number without one."""
        self._enlarge(field, answered, unit)
        self._say(_meaning(field.question, field.answer, answered, system), answered, system)

    def rest(self, answered: Answered, system: str) -> None:
        """Show no field, but the flight in one line, and the action of Enter."""
        self.border_title = "Enter to save" if answered.flight.readouts() else "Enter to add the next flight"
        self.border_subtitle = ""
        self.query_one(Big).show("")
        self._say(summary(answered.flight), answered, system)

    def _say(self, first: str, answered: Answered, system: str) -> None:
        lines = dict.fromkeys([first, *together(answered.flight, system)])
        text = Content("\n").join(marked(printable(line)) for line in lines)
        self.query_one("#says", Static).update(text, layout=False)

    def _enlarge(self, field: Field, answered: Answered, unit: str) -> None:
        """Show the number in large digits, its unit in the frame."""
        question, text = field.question, field.line.value.strip()
        known = question.column is not None and answered.number(question) is not None
        asked = f" ({spelled(unit)})" if question.column else ""
        self.border_title = Content(f"{question.title}{asked}")
        self.border_subtitle = spelled(typed_unit(text)) if known else ""
        self.query_one(Big).show(typed_number(text) if known else "")


def _meaning(question: Question, answer: str, answered: Answered, system: str) -> str:
    """Why an answer cannot be read, what is implausible about it, or the meaning of the question."""
    trouble = answered.wrong.get(question.name)
    reason = implausible_answers(answered.flight, question.name, answered.usual)
    return f"✗ {trouble}" if trouble and answer else f"! {in_system(reason[0], system)}" if reason else question.help
