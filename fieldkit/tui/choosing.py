"""Notices, units, colors and the target."""

from asyncio import Lock
from dataclasses import asdict
from functools import partial
from typing import Any

from textual.app import App

from fieldkit.errors import FieldkitError
from fieldkit.flight import BY_NAME
from fieldkit.quantities import measure, unit_of
from fieldkit.settings import UNITS
from fieldkit.tui.in_order import InOrder
from fieldkit.tui.page import PageScreen
from fieldkit.tui.resources import Resources
from fieldkit.tui.themes import THEMES
from fieldkit.tui.widgets.bars import Notice, NoticeBar

EXPIRY = 15.0
"""How long a notice of success is shown. [s]"""
LOOKS = {"units", "theme", "target"}
"""Settings that only change the display."""


class Choosing(InOrder):
    """An app with notices and settings. `revision` counts changes in the ledger, `look` changes in the display."""

    def __init__(self, resources: Resources) -> None:
        super().__init__()
        self.resources = resources
        self.notices: list[Notice] = []
        self.revision = self.look = 0
        self._styled = False
        self.changing = Lock()
        """Held while the ledger is changed."""

    def start_in(self, theme: str) -> None:
        """Start in a theme. Textual reads all styles three more times if it is changed before the app runs (10 ms of
        220); a dark theme in true colors changes nothing else."""
        for one in THEMES.values():
            self.register_theme(one)
        self._styled = THEMES[theme].dark and not THEMES[theme].ansi
        if self._styled:
            self.set_reactive(App.theme, theme)
            self.stylesheet.set_variables(self.get_css_variables())
        else:
            self.theme = theme

    def refresh_css(self, animate: bool = True) -> None:
        """Read all styles again, but not for the first page, which Textual opens right after it has read them (6 ms of
        200)."""
        if self._styled:
            self._styled = False
        else:
            super().refresh_css(animate)

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
        for bar in self.screen.query(NoticeBar):
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

    def ask_target(self) -> None:
        """Ask for the target apogee for comparing motors."""
        now = measure(BY_NAME["apogee"], self.resources.settings.target, self.resources.settings.units)
        about = "Target apogee, such as 800ft or 250 m; empty for none. The motors nearest to it come first."
        from fieldkit.tui.widgets.dialogs import AskText  # takes 6 ms to import

        self.push_screen(AskText("Target", now, about, check=self._read_target), partial(self._targeted, now))

    def action_ask_target(self) -> None:
        """Ask for the target apogee."""
        self.ask_target()

    def _targeted(self, now: str, text: str | None) -> None:
        if text is None or text == now:  # what was shown is rounded
            return
        target, system = self._read_target(text), self.resources.settings.units
        self.choose(f"Target {measure(BY_NAME['apogee'], target, system)}" if target else "No target", target=target)

    def _read_target(self, text: str) -> float | None:
        """A typed target; None if it is empty. Raises BadValue. [m]"""
        apogee = BY_NAME["apogee"]
        return apogee.parse(text, unit_of(apogee, self.resources.settings.units)) if text.strip() else None
