"""The pad checklist over the Home page, with the timer of contests."""

from datetime import datetime, timedelta
from functools import partial
from typing import ClassVar

from textual.app import ComposeResult
from textual.binding import Binding, BindingType
from textual.containers import Vertical
from textual.content import Content
from textual.widgets import OptionList, Static

from fieldkit.planning.pad import CONTEST_MINUTES
from fieldkit.quantities import in_system
from fieldkit.safe_text import printable
from fieldkit.services.pad import Checklist, waiting_checklist
from fieldkit.tui.help import Help
from fieldkit.tui.page import PageScreen
from fieldkit.tui.widgets.bars import KeyBar
from fieldkit.tui.widgets.dialogs import HelpedModal


class PadTimer:
    """The timer, which keeps counting while its screen is closed, and the steps that are ticked off: `ends` is None
    while it is stopped."""

    def __init__(self) -> None:
        self.ends: datetime | None = None
        self.ticked: set[str] = set()

    def toggle(self, now: datetime) -> None:
        """Start the timer, or stop it."""
        self.ends = now + timedelta(minutes=CONTEST_MINUTES) if self.ends is None else None

    def text(self, now: datetime) -> str:
        """What is left, `42:10`; `over by 0:30` after the end."""
        if self.ends is None:
            return f"timer {CONTEST_MINUTES}:00, t starts it; the length is unverified, ask at the event"
        left = round((self.ends - now).total_seconds())
        minutes, seconds = divmod(abs(left), 60)
        return f"{minutes}:{seconds:02d} left" if left >= 0 else f"over by {minutes}:{seconds:02d}"


class PadScreen(HelpedModal[None]):
    """Steps to tick off, and a timer."""

    DEFAULT_CSS = """
    PadScreen { align: center middle; background: $backdrop; }
    PadScreen > Vertical { width: 94%; max-width: 100; height: auto; background: $surface; border: solid $border; }
    PadScreen #timer { height: 1; padding: 0 1; text-style: bold; }
    PadScreen OptionList, PadScreen OptionList:focus { height: auto; max-height: 70vh; border: none;
        background: $surface; }
    """
    BINDINGS: ClassVar[list[BindingType]] = [
        Binding("escape", "dismiss", "Close", priority=True),
        Binding("space", "tick", "Tick", priority=True, tooltip="Tick off this line, or clear it"),
        Binding("t", "timer", "Timer", tooltip="Start or stop the timer of contests"),
    ]

    def __init__(self, found: Checklist, system: str, timer: PadTimer) -> None:
        super().__init__()
        self._found, self._system, self._timer = found, system, timer

    def compose(self) -> ComposeResult:
        """The timer, and the steps."""
        with Vertical() as frame:
            frame.border_title = Content(printable(f"At the pad: {self._found.title}"))
            yield Static(id="timer")
            yield OptionList(*map(self._line, range(len(self._found.steps))))
            yield KeyBar()

    def on_mount(self) -> None:
        """Count seconds."""
        self.set_interval(1.0, self._count)
        self._count()

    def _count(self) -> None:
        self.query_one("#timer", Static).update(self._timer.text(datetime.now()))

    def explained(self) -> tuple[str, Help]:
        """What the list and the timer are."""
        about = (
            "What to check at the pad of the flight whose forecast was saved last: the rocket, the safety checks that "
            "failed or that only you can make, the launch. Space ticks a step off and goes to the next."
        )
        timer = f"Counts {CONTEST_MINUTES} minutes down, also while this list is closed; ask at the event for its rule."
        return "At the pad", Help(about, (("timer", timer),))

    def action_timer(self) -> None:
        """Start or stop the timer."""
        self._timer.toggle(datetime.now())
        self._count()

    def action_tick(self) -> None:
        """Tick off the step under the cursor, or not, and go to the next."""
        steps = self.query_one(OptionList)
        if steps.highlighted is not None:
            self._timer.ticked ^= {self._found.steps[steps.highlighted]}
            steps.replace_option_prompt_at_index(steps.highlighted, self._line(steps.highlighted))
            steps.highlighted = min(steps.highlighted + 1, steps.option_count - 1)

    def _line(self, place: int) -> Content:
        """A step, with its box."""
        step = self._found.steps[place]
        box = "[x]" if step in self._timer.ticked else "[ ]"
        return Content(f"{box} {printable(in_system(step, self._system))}")


def show_pad(page: PageScreen, timer: PadTimer) -> None:
    """Read the checklist and show it."""
    resources = page.resources

    def shown(found: Checklist) -> None:
        page.app.push_screen(PadScreen(found, resources.settings.units, timer))

    page.ask(partial(waiting_checklist, resources.ledger, resources.motors, resources.settings), shown, "pad")
