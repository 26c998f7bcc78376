"""Runs the app until the user quits, and reopens it in the same place after a bug."""

import time

from fieldkit.errors import FieldkitError
from fieldkit.tui.app import FieldkitApp, Whereabouts
from fieldkit.tui.hangup import gone, terminal

MAX_RESTARTS, RESTART_PERIOD = 3, 60.0
"""Maximum number of restarts after errors [1] within a time [s]."""


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
