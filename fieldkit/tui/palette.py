"""The command palette, which accepts keys immediately."""

from textual.await_complete import AwaitComplete
from textual.command import CommandList, CommandPalette
from textual.css.query import NoMatches


class Palette(CommandPalette):
    """Textual's palette moves in its list as soon as there are commands, which fails before the list is laid out."""

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
