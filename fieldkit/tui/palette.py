"""The command palette, which accepts keys immediately and has help."""

from typing import ClassVar

from textual.await_complete import AwaitComplete
from textual.binding import Binding, BindingType
from textual.command import CommandList, CommandPalette
from textual.css.query import NoMatches

from fieldkit.tui.help import Help
from fieldkit.tui.widgets.dialogs import HelpScreen

PALETTE_HELP = Help(
    "Type any part of a name: a flight, a rocket, a motor, a page, a setting, a word of the help, a key's action or a "
    "command. ↓ and ↑ choose one of those listed, Enter opens it, Esc closes the list."
)


class Palette(CommandPalette):
    """Textual's palette moves in its list as soon as there are commands, which fails before the list is laid out."""

    DEFAULT_CSS = """
    Palette { background: $backdrop; }
    Palette #--input { border: hkey $border-blurred; }
    Palette > Vertical { margin-top: 1; width: 96%; max-width: 120; }
    Palette SearchIcon { display: none; }
    Palette CommandInput, Palette CommandInput:focus { border: none; padding: 0 2; height: 1; }
    Palette CommandList { text-wrap: nowrap; text-overflow: ellipsis; border-top: none; max-height: 80vh; }
    """
    BINDINGS: ClassVar[list[BindingType]] = [Binding("f1", "help", "Help", key_display="F1", priority=True)]

    def action_help(self) -> None:
        """Explain what can be found."""
        self.app.push_screen(HelpScreen("Help: find anything", PALETTE_HELP, ()))

    def check_action(self, action: str, parameters: tuple[object, ...]) -> bool | None:
        """Ignore paging in a list that is not on the screen yet."""
        if action == "command_list" and not self._is_laid_out():
            return False
        return super().check_action(action, parameters)

    def dismiss(self, result: None = None) -> AwaitComplete:
        """Close once: a second Enter would also close the page below."""
        return super().dismiss(result) if self in self.app.screen_stack else AwaitComplete()

    def _is_laid_out(self) -> bool:
        try:
            return bool(self.query_one(CommandList).size)
        except NoMatches:
            return False
