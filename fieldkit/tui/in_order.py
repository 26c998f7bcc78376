"""An app that takes keys one after the other, and whose next key finds what the one before has opened."""

import asyncio
from contextlib import suppress

from textual import events
from textual.app import App
from textual.dom import DOMNode
from textual.message_pump import MessagePump

from fieldkit.tui.asking import WAIT
from fieldkit.tui.keys import pressed
from fieldkit.tui.page import PageScreen

MAX_ANSWER = 1.0
"""How long the next key waits for widgets to hear of the one before. [s]"""
MAX_OPENING = 30.0
"""How long the next key waits for a screen to open. [s]"""


class InOrder(App[None]):
    """Textual hands a key down to the widget in focus, and does what it is bound to when it has come up again, behind
    keys typed in the meantime. Here the next is looked at when all have heard of the one before."""

    def __init__(self) -> None:
        super().__init__()
        self.turn = asyncio.Lock()
        """Held by who handles a key, and by who must not be interrupted by one."""

    async def on_event(self, event: events.Event) -> None:
        """Handle a key, and wait for what comes of it."""
        if not isinstance(event, events.Key) or event.is_forwarded:
            await super().on_event(event)
            return
        async with self.turn:
            for key in pressed(event, typed=self._is_typed(event)):
                if not await self._did(key):
                    await super().on_event(key)
                await self.heard()

    def _is_typed(self, key: events.Key) -> bool:
        return self.focused is not None and self.focused.check_consume_key(key.key, key.character)

    async def _did(self, key: events.Key) -> bool:
        """Do what a key is bound to at once, if it is; a letter that the line in focus takes is not."""
        active = self.screen.active_bindings.get(key.key)
        return active is not None and active.enabled and await self.run_action(active.binding.action, active.node)

    async def heard(self) -> None:
        """Wait until messages have reached the widgets they are for, and a screen that was opened can take keys."""
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
