"""An app that takes keys one after the other, and whose next key finds what the one before has opened."""

import asyncio

from textual import events
from textual.app import App

from fieldkit.tui.page import WAIT, PageScreen

MOST_WAITS = 6000
"""How often at most a page that is opened is asked whether it can take keys."""
MAX_LOOP_CYCLES = 200
"""How often at most it is looked whether a key has reached all that it is for. [1]"""


class InOrder(App[None]):
    """Textual hands a key down to the widget in focus, and does what it is bound to when it has come up again, behind
    keys typed in the meantime. Here the next is looked at when all have heard of the one before."""

    async def on_event(self, event: events.Event) -> None:
        """Do what a key is bound to at once; a key that a line in focus would take as a letter is not bound."""
        if not isinstance(event, events.Key) or event.is_forwarded:
            await super().on_event(event)
            return
        key = event.key
        if not (await self._check_bindings(key, priority=True) or await self._check_bindings(key)):
            await super().on_event(event)
        await self.heard()

    async def heard(self) -> None:
        """Wait until messages have reached the widgets they are for, and a screen that was opened can take keys."""
        for _ in range(MAX_LOOP_CYCLES):
            pumps = (self.focused or self.screen).ancestors_with_self[:-1]
            if all(pump._message_queue.empty() for pump in pumps):
                break
            await asyncio.sleep(0)
        for _ in range(MOST_WAITS):
            page = self.screen
            if page.is_mounted and (page.ready if isinstance(page, PageScreen) else page._message_queue.empty()):
                break
            await asyncio.sleep(WAIT)
