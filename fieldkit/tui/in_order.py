"""An app that handles keys in order, so that a key reaches the screen opened by the previous one."""

import asyncio
from contextlib import suppress

from rich.console import RenderableType
from textual import events
from textual.app import App
from textual.await_complete import AwaitComplete
from textual.dom import DOMNode
from textual.message_pump import MessagePump

from fieldkit.tui.asking import WAIT
from fieldkit.tui.keys import pressed
from fieldkit.tui.page import PageScreen

MAX_ANSWER = 1.0
"""Time limit for widgets to handle a key before the next one. [s]"""
MAX_OPENING = 30.0
"""Time limit for a screen to open before the next key. [s]"""


class InOrder(App[None]):
    """Textual passes a key to the focused widget and runs its binding when it bubbles up, behind keys typed in the
    meantime. Here the next key is handled only after all widgets have handled the previous one."""

    def __init__(self) -> None:
        super().__init__()
        self.turn = asyncio.Lock()
        """Held while a key is handled, and by code that keys must not interrupt."""
        self._is_leaving = False

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

    async def on_event(self, event: events.Event) -> None:
        """Handle a key, and wait for its effects."""
        if not isinstance(event, events.Key) or event.is_forwarded:
            await super().on_event(event)
            return
        async with self.turn:
            for key in () if self._is_leaving else pressed(event, typed=self._is_typed(event)):
                if not await self._did(key):
                    await super().on_event(key)
                await self.heard()

    def _is_typed(self, key: events.Key) -> bool:
        return self.focused is not None and self.focused.check_consume_key(key.key, key.character)

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


async def _answered(node: MessagePump | DOMNode) -> None:
    """Wait until a widget has handled what was sent to it so far."""
    done = asyncio.Event()
    if node.call_later(done.set):
        await done.wait()
