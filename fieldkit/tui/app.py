"""The app: its pages, its colors, its notices, keys in order, undo from anywhere, and what it does after an unexpected
error, even one that ends it: it reopens in the same place."""

import asyncio
import sys
import time
from collections.abc import Callable, Iterable
from contextlib import suppress
from dataclasses import asdict, dataclass
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any, ClassVar

from rich.console import Console, RenderableType
from textual import events
from textual.app import App, SystemCommand
from textual.await_complete import AwaitComplete
from textual.binding import Binding, BindingType
from textual.command import CommandPalette, Provider
from textual.dom import DOMNode
from textual.message_pump import MessagePump
from textual.screen import Screen
from textual.scrollbar import ScrollBar
from textual.widget import AwaitMount
from textual.widgets import Input

from fieldkit.errors import FieldkitError
from fieldkit.flight import BY_NAME
from fieldkit.quantities import counted, measure, unit_of
from fieldkit.safe_text import printable
from fieldkit.settings import UNITS
from fieldkit.tui.asking import WAIT
from fieldkit.tui.computing import Turn
from fieldkit.tui.hangup import CHECK_INTERVAL, gone, nobody_looks, terminal
from fieldkit.tui.keys import in_capitals, pressed
from fieldkit.tui.memory import START_TIME, freeze_permanent, limit_malloc, resume_collection
from fieldkit.tui.page import PageScreen, pages
from fieldkit.tui.resources import Resources
from fieldkit.tui.themes import THEMES
from fieldkit.tui.widgets.bars import Notice, NoticeBar
from fieldkit.tui.widgets.scrollbar import SpacedBar

if TYPE_CHECKING:
    from fieldkit.ledger import Change, UndoStep
    from fieldkit.tui.crash import Crash
    from fieldkit.tui.flights.flights_page import FlightsScreen

ScrollBar.renderer = SpacedBar

PAUSE = 0.05
"""Pause between opening two pages off screen, so that keys are handled. [s]"""
EXPIRY = 15.0
"""How long a notice of success is shown. [s]"""
LOOKS = {"units", "theme", "target"}
"""Settings that only change the display."""
LOOK_INTERVAL = 3.0
"""Interval of checking for changes by other programs: terminals side by side report no change of focus. [s]"""
MAX_ANSWER = 1.0
"""Time limit for widgets to handle a key before the next one. [s]"""
MAX_OPENING = 30.0
"""Time limit for a screen to open before the next key. [s]"""
MAX_RESTARTS, RESTART_PERIOD = 3, 60.0
"""Maximum number of restarts after errors [1] within a time [s]."""


def finder() -> type[Provider]:
    """The provider of the palette's results, imported when the palette is first opened: after all pages in 3 ms."""
    from fieldkit.tui.finder import Finder

    return Finder


@dataclass(frozen=True, slots=True)
class Whereabouts:
    """The state before an error: the page, the row of its first table, and the error."""

    page: str
    row: Any
    crash: "Crash"


class FieldkitApp(App[None]):
    """The pages of one ledger, with notices and settings; it continues after a failing key. `revision` counts changes
    of the ledger, `look` changes of the display. If it `stays`, it has its own process, and prepares in the background
    what keys would otherwise wait for; `back` is the state to return to after an error.

    Textual passes a key to the focused widget and runs its binding when it bubbles up, behind keys typed in the
    meantime. Here the next key is handled only after all widgets have handled the previous one, so that a key reaches
    the screen opened by the previous one.
    """

    TITLE = "fieldkit"
    ENABLE_COMMAND_PALETTE = True
    DEFAULT_MODE = "home"  # shown first, without an empty screen before it
    COMMANDS: ClassVar[set[type[Provider] | Callable[[], type[Provider]]]] = {finder}
    BINDINGS: ClassVar[list[BindingType]] = [
        *(Binding(str(n), f"page_number({n})", show=False, priority=True) for n in range(10)),
        Binding("ctrl+z", "undo", "Undo", show=False),
        Binding("U", "redo", "Redo", show=False, tooltip="Redo what was undone"),
        Binding("T", "next_theme", "Colors", show=False, tooltip="Next colors: field, sun, night, terminal"),
        Binding("N", "next_units", "Units", show=False, tooltip="Next units: SI, US, mixed"),
        Binding("W", "whole_notice", "Full notice", show=False, tooltip="The full notice, with full file paths"),
        Binding("ctrl+p", "command_palette", "Palette", show=False, tooltip="Find anything by its name"),
        Binding("ctrl+q", "quit", "Quit", show=False),
        Binding("q", "quit", "Quit"),
    ]

    def __init__(
        self,
        where: str | Path | None = None,
        settings_file: Path | None = None,
        *,
        stays: bool = False,
        back: Whereabouts | None = None,
    ) -> None:
        super().__init__()
        self.resources = Resources(where, settings_file)
        self.notices: list[Notice] = []
        self.revision = self.look = 0
        self.turn = asyncio.Lock()
        """Held while a key is handled, and by code that keys must not interrupt."""
        self._is_leaving = False
        self.changing = asyncio.Lock()
        """Held while the ledger is changed."""
        self.computing = Turn()
        """Of computations that take much memory."""
        self.error_console = Console(stderr=True, quiet=True)  # a failure is reported in one line
        self.place: Whereabouts | None = None
        """The state when an error ended the app."""
        self.errors: list[Exception] = []
        """Unexpected errors after which the app continued."""
        self._crashes: dict[str, "Crash"] = {}
        self._back = back
        self._stays = stays
        if stays:
            limit_malloc()
        self._opened: dict[str, PageScreen] = {}
        self._length: int | None = None
        self._first_length: int | None = None
        """Number of changes when the app was opened."""
        self._hides = True
        self.unseen = self._readied = False
        self.animation_level = "none"
        for theme in THEMES.values():
            self.register_theme(theme)
        self.theme = self.resources.settings.theme
        self.stylesheet.set_variables(self.get_css_variables())
        for name in pages():
            self.add_mode(name, partial(self._page, name))

    def on_mount(self) -> None:
        """Open the page where an error ended the last app, and start the timers."""
        if self._back:
            self.switch_mode(self._back.page)
            self.show_notice(self._back.crash.line(), error=True)
        if not self.is_headless and (held := terminal()) is not None:
            self.set_interval(CHECK_INTERVAL, partial(self._leave_if_gone, held))
        self.set_interval(LOOK_INTERVAL, self.look_round)
        self.set_timer(START_TIME, resume_collection)

    def _leave_if_gone(self, held: int) -> None:
        """Quit if the terminal was closed."""
        if gone(held):
            self._leave_unseen()

    def _leave_unseen(self) -> None:
        """Quit although messages about keys may still wait; what was typed is saved as it stands."""
        self._keep_typed()
        self.exit()

    def _keep_typed(self) -> None:
        with suppress(Exception):  # an app that is failing may have no fields left
            for page in self._opened.values():
                page.keep_typed()

    def _page(self, name: str) -> PageScreen:
        """The prepared page, or a new one."""
        if name not in self._opened:
            self._opened[name] = pages()[name].screen()
        return self._opened[name]

    def switch_mode(self, mode: str) -> AwaitMount:
        """Show a page; one that was drawn before appears immediately, although Textual would hide it for a moment."""
        self._hides = mode not in self._opened or not self._opened[mode].size
        return super().switch_mode(mode)

    def refresh_css(self, animate: bool = True) -> None:
        """Style the screens again. Textual does so before the first one has widgets, and parses all styles twice."""
        if any(screen.is_mounted for screen in self.screen_stack):
            super().refresh_css(animate)

    def delay_update(self, delay: float = 0.05) -> None:
        """Hide changes until the layout is done, if there is something to hide."""
        if self._hides:
            super().delay_update(delay)

    def settled(self, page: str) -> None:
        """Called when the page of this name has read the flights: return to the row before an error, and prepare the
        other pages."""
        if self._length is None:
            self.look_round()
        if self._back is not None and self._back.page == page:
            self._page(page).go_to_row(self._back.row)
            self._back = None
        if self._stays and not self._readied:
            self._readied = True
            self.run_worker(self._make_ready, group="ready")  # type: ignore[arg-type]  # narrower than it takes

    async def _make_ready(self) -> None:
        """Open every page twice behind the visible one, so that the first key for a page is as fast as later ones.
        Opening a page takes 110 to 180 ms of processor time, styling it the second time 40 ms, and later visits 15 to
        25 ms."""
        for name in (*pages(), *pages()):
            await asyncio.sleep(PAUSE)
            await pages()[name].imported()
            await self._open_unseen(name)
        freeze_permanent()

    async def _open_unseen(self, name: str) -> None:
        """Open a page and the screens above it, and switch back before anything is painted; keys wait until then."""
        async with self.turn:
            front = self.current_mode
            self.unseen = True
            try:
                with self.batch_update():
                    await self.switch_mode(name)
                    for screen in self._opened[name].above():
                        await self.push_screen(screen)
                        await self.pop_screen()
                    await self.switch_mode(front)
            finally:
                self.unseen = False

    def on_unmount(self) -> None:
        """Close the ledger after the last keys are saved: after an error pages are not unmounted first."""
        for page in self._opened.values():
            page.finish()
        self.resources.close()

    def action_command_palette(self) -> None:
        """Find anything by name."""
        if not isinstance(self.screen, CommandPalette):
            from fieldkit.tui.palette import Palette  # takes 7 ms to import

            self.push_screen(Palette(id="--command-palette"))

    def changed(self) -> None:
        """The ledger has changed: reload the pages."""
        self.count_change()
        self._refresh_page()

    def count_change(self) -> None:
        """The app itself has changed the ledger."""
        self.revision += 1
        self._length = None
        self.look_round()

    def look_round(self) -> None:
        """Reload pages if another program has changed the ledger: a second app, a command."""
        if self.screen_stack and isinstance(self.screen, PageScreen):  # none while the app closes
            self.screen.ask(self._journal_length, self._seen_round, "others")

    def _journal_length(self) -> int | None:
        """The number of changes so far; None if the ledger cannot be read now, which the pages report."""
        with suppress(FieldkitError):
            return self.resources.ledger.length()
        return None

    def _seen_round(self, length: int | None) -> None:
        before, self._length = self._length, length
        self._first_length = length if self._first_length is None else self._first_length
        if None not in (before, length) and before != length:
            self.revision += 1
            self._refresh_page()

    def on_app_focus(self) -> None:
        """The terminal has the focus again."""
        self.look_round()

    async def action_page(self, name: str) -> None:
        """Show a page, or close what was opened over it if it is shown already; keys typed ahead wait until it is ready
        for them."""
        if name == self.current_mode:
            await self._close_above()
        else:
            self.drop_success()
        if name not in self._opened:
            await pages()[name].imported()
        await self.switch_mode(name)
        await self.heard()
        if isinstance(self.screen, PageScreen):
            self.screen.came()
            self.look_round()

    async def action_fly(self) -> None:
        """Show the motors, and no decision that was left open over them."""
        await self.action_page("next_flight")
        await self._close_above()

    async def _close_above(self) -> None:
        """Close the screens over the current page, but no form."""
        while len(self.screen_stack) > 1 and isinstance(self.screen, PageScreen):
            await self.pop_screen()

    async def action_page_number(self, number: int) -> None:
        """Bring the page with this number to the front, if there is one."""
        for name, page in pages().items():
            if page.number == number:
                await self.action_page(name)

    def check_action(self, action: str, parameters: tuple[object, ...]) -> bool | None:
        """Digits open pages, but not while something is typed or asked."""
        if action == "page_number":
            return isinstance(self.screen, PageScreen) and not isinstance(self.screen.focused, Input)
        return super().check_action(action, parameters)

    def action_press(self, key: str) -> None:
        """Press a key that was clicked in the key bar."""
        self.simulate_key(key)

    def action_undo(self) -> None:
        """Undo the last change; ask first if it would remove more than one flight, or if another program made it."""
        if isinstance(page := self.screen, PageScreen):
            page.change(lambda: self.resources.ledger.undo_step(), self._undo)

    def _undo(self, step: "UndoStep") -> None:
        others = not step.own and self._first_length is not None and step.change.number > self._first_length
        undo = partial(self._journal, lambda: self.resources.ledger.undo(step.change.number), "Undone", ". U to redo")
        if step.flights <= 1 and not others:
            undo()
            return
        from fieldkit.tui.widgets.dialogs import AskYes  # takes 6 ms to import

        who = " by another program" if others else ""
        count = f" ({counted(step.flights, 'flight')})" if step.flights > 1 else ""
        question = printable(f"Undo the last change{who}: {step.change.command} {step.change.what}{count}?")
        self.push_screen(AskYes(question), lambda yes: undo() if yes else None)

    def action_redo(self) -> None:
        """Redo what was undone last."""
        self._journal(lambda: self.resources.ledger.redo(), "Redone", ". u to undo")

    def _journal(self, work: "Callable[[], Change]", done: str, back: str) -> None:
        page = self.screen
        if isinstance(page, PageScreen):
            page.change(work, partial(self._journalled, done, back))

    def _journalled(self, done: str, back: str, change: Any) -> None:
        self.show_notice(f"{done}: {change.command} {change.what}{back}")
        self.changed()

    async def open_flight(self, id: str) -> None:
        """Open a flight over the Flights page."""
        if (page := await self._flights_page()) is not None:
            page.open_flight(id)

    async def decide(self, view: int, write: str = "") -> None:
        """Open a decision for the motor selected on the page of the next flight, and ask for the page to `write`."""
        from fieldkit.tui.next.next_page import NextScreen  # before the first paint it would take 0.7 s

        await self.action_page("next_flight")
        await self._close_above()
        if isinstance(page := self.screen, NextScreen):
            await page.settled("plan", "find")
            await page.action_decide(view, write)

    async def show_flights(self, words: str) -> None:
        """Show only the flights that match all of these words."""
        if (page := await self._flights_page()) is not None:
            page.show_only(words)

    async def _flights_page(self) -> "FlightsScreen | None":
        """The Flights page, brought to the front."""
        from fieldkit.tui.flights.flights_page import FlightsScreen  # before the first paint it would take 0.7 s

        await self.action_page("flights")
        await self._close_above()
        return page if isinstance(page := self.screen, FlightsScreen) else None

    def get_key_display(self, binding: Binding) -> str:
        """A key as it is printed on keyboards and as notices have it: `Esc`, `F1`, `^Q`."""
        return "Esc" if binding.key == "escape" else in_capitals(super().get_key_display(binding))

    def get_system_commands(self, screen: Screen[Any]) -> Iterable[SystemCommand]:
        """Commands of the palette: pages, colors, units, and the actions of the current page."""
        for name, page in pages().items():
            yield SystemCommand(page.title, f"Go to {page.title} ({page.number})", partial(self.action_page, name))
        for theme in THEMES:
            yield SystemCommand(f"Colors: {theme}", "Change the colors", partial(self.choose, theme=theme))
        for units in UNITS:
            yield SystemCommand(f"Units: {units}", "Change the units", partial(self.choose, units=units))
        seen = set[str]()
        for active in screen.active_bindings.values():
            binding = active.binding
            label, key = binding.tooltip or binding.description, self.get_key_display(binding)
            if active.enabled and label not in seen and (binding.tooltip or (binding.description and binding.show)):
                seen.add(label)
                yield SystemCommand(label, f"Key {key}", partial(self.action_press, binding.key))

    async def on_event(self, event: events.Event) -> None:
        """Handle an event; an error in it is reported, and the app continues."""
        try:
            if isinstance(event, events.Key) and not event.is_forwarded:
                await self._press(event)
            else:
                await super().on_event(event)
        except Exception as error:
            self.survive(error)

    async def _press(self, event: events.Key) -> None:
        """Handle a key, and wait for its effects."""
        typed = self.focused is not None and self.focused.check_consume_key(event.key, event.character)
        async with self.turn:
            for key in () if self._is_leaving else pressed(event, typed=typed):
                if not await self._did(key):
                    await super().on_event(key)
                await self.heard()

    async def _did(self, key: events.Key) -> bool:
        """Run the binding of a key immediately, if there is one; letters for the focused input are not bindings."""
        active = self.screen.active_bindings.get(key.key)
        return active is not None and active.enabled and await self.run_action(active.binding.action, active.node)

    async def heard(self) -> None:
        """Wait until messages have reached their widgets and a newly opened screen accepts keys."""
        with suppress(TimeoutError):
            async with asyncio.timeout(MAX_ANSWER):
                for node in (self.focused or self.screen).ancestors_with_self[:-1]:
                    await _answered(node)
        with suppress(TimeoutError):
            async with asyncio.timeout(MAX_OPENING):
                while not (self.screen.is_mounted and (not isinstance(self.screen, PageScreen) or self.screen.ready)):
                    await asyncio.sleep(WAIT)

    def exit(self, result: None = None, return_code: int = 0, message: RenderableType | None = None) -> None:
        """Leave the app. Keys typed after that are dropped, and no page is prepared any more: none can open while all
        are closed."""
        self._is_leaving = True
        self.workers.cancel_group(self, "ready")
        super().exit(result, return_code, message)

    def pop_screen(self) -> AwaitComplete:
        """Close the front screen, and free what it has drawn: a cache of Textual holds the last 1,024 widgets drawn,
        removed ones too."""
        for widget in self.screen.walk_children(with_self=True):
            widget.refresh()
        return super().pop_screen()

    def survive(self, error: Exception) -> None:
        """Log an unexpected error, once for each place that it comes from, and show a notice."""
        if nobody_looks(error):
            self._leave_unseen()
            return
        self.errors.append(error)
        self.show_notice(self._crash(error).line(), error=True)

    def _crash(self, error: BaseException) -> "Crash":
        from fieldkit.tui.crash import place_of, record

        crash = record(error) if (known := self._crashes.get(place_of(error))) is None else known
        return self._crashes.setdefault(crash.where, crash)

    def bell(self) -> None:
        """Save the state before an error ends the app: Textual rings the bell only then."""
        error = sys.exception()
        if error is not None:
            self._keep_typed()
        if error is not None and self.place is None and not nobody_looks(error):
            self.place = Whereabouts(self.current_mode, self._row(), self._crash(error))
        super().bell()

    def _row(self) -> Any:
        try:
            return page.row() if isinstance(page := self.screen_stack[0], PageScreen) else None
        except Exception:  # an app that is failing may have no screen left
            return None

    def show_notice(self, text: str, *, error: bool = False) -> None:
        """Show a notice over earlier ones; errors stay until they are dismissed, successes for a while, but not longer
        than until the next notice or page."""
        notice = Notice(text, error)
        if not error:
            self.set_timer(EXPIRY, partial(self._expire, notice))
        self.notices = [notice, *(one for one in self.notices if one.error and one != notice)]
        self._show_notices()

    def _expire(self, notice: Notice) -> None:
        """Remove this notice, but not a later one with the same text."""
        if any(one is notice for one in self.notices):
            self.withdraw(notice.text)

    def withdraw(self, text: str) -> None:
        """Remove a notice that no longer holds."""
        self.notices = [notice for notice in self.notices if notice.text != text]
        self._show_notices()

    def drop_success(self) -> None:
        """Remove a notice of success: the flyer has gone on."""
        self.notices = [notice for notice in self.notices if notice.error]
        self._show_notices()

    def action_read(self) -> None:
        """Dismiss the current notice."""
        self.notices = self.notices[1:]
        self._show_notices()

    def action_whole_notice(self) -> None:
        """Show the full current notice, with full file paths."""
        self._show_notices(whole=True)

    def action_help_quit(self) -> None:
        """The action of ^C if nothing can be copied: show how to quit."""
        self.show_notice("q quits; so does ^Q, even in a field")

    def _show_notices(self, whole: bool = False) -> None:
        for bar in self.screen.query(NoticeBar) if self.screen_stack else ():  # no screen while the app closes
            bar.show_notice(self.notices, whole)

    def _refresh_page(self) -> None:
        if isinstance(self.screen, PageScreen):
            self.screen.refresh_if_changed()

    def get_theme_variable_defaults(self) -> dict[str, str]:
        """The background under an open dialog, in themes without one."""
        return {"backdrop": "black 60%"}

    def action_next_theme(self) -> None:
        """Switch to the next colors."""
        names = list(THEMES)
        self.choose(theme=names[(names.index(self.theme) + 1) % len(names)])

    def action_next_units(self) -> None:
        """Switch to the next system of units."""
        self.choose(units=UNITS[(UNITS.index(self.resources.settings.units) + 1) % len(UNITS)])

    def choose(self, done: str = "", **changes: Any) -> None:
        """Change settings, apply them, and save them; if they cannot be saved, they still apply. `done` is the notice,
        by default the names and values of the changes."""
        before = self.resources.settings
        try:
            self.resources.choose(**changes)
        except FieldkitError as error:
            self.show_notice(str(error), error=True)
        else:
            self.show_notice(done or "; ".join(f"{name} {value}" for name, value in changes.items()))
        now = self.resources.settings
        self.theme = now.theme
        if {name for name in asdict(now) if getattr(now, name) != getattr(before, name)} <= LOOKS:
            self.look += 1
        else:
            self.revision += 1
        self._refresh_page()

    def action_ask_target(self) -> None:
        """Ask for the target apogee for comparing motors."""
        now = measure(BY_NAME["apogee"], self.resources.settings.target, self.resources.settings.units)
        about = "Target apogee, such as 800ft or 250 m; empty for none. The motors nearest to it come first."
        from fieldkit.tui.widgets.dialogs import AskText  # takes 6 ms to import

        self.push_screen(AskText("Target", now, about, check=self._read_target), partial(self._targeted, now))

    def _targeted(self, now: str, text: str | None) -> None:
        if text is None or text == now:  # what was shown is rounded
            return
        target, system = self._read_target(text), self.resources.settings.units
        self.choose(f"Target {measure(BY_NAME['apogee'], target, system)}" if target else "No target", target=target)

    def _read_target(self, text: str) -> float | None:
        """A typed target; None if it is empty. Raises BadValue. [m]"""
        apogee = BY_NAME["apogee"]
        return apogee.parse(text, unit_of(apogee, self.resources.settings.units)) if text.strip() else None


async def _answered(node: MessagePump | DOMNode) -> None:
    """Wait until a widget has handled what was sent to it so far."""
    done = asyncio.Event()
    if node.call_later(done.set):
        await done.wait()


def run(where: str | None) -> None:
    """Open the app on a ledger until the user quits; after a bug, reopen it in the same place.

    Raises FieldkitError if errors repeat, or after the first one if the app is served to a browser.
    """
    began: list[float] = []
    place: Whereabouts | None = None
    held = terminal()
    while True:
        app = FieldkitApp(where, stays=True, back=place)
        app.run()
        place, ended = app.place, time.monotonic()
        began = [one for one in began if ended - one < RESTART_PERIOD] + [ended]
        if place is None or (held is not None and gone(held)):  # drawing on a closed terminal is also an error
            return
        if len(began) > MAX_RESTARTS or app.is_web:
            raise FieldkitError(place.crash.line())
