"""The Capture page before a capture: what to do, earlier captures, and the loggers that can be captured."""

from dataclasses import dataclass
from pathlib import Path

from fieldkit.capture import captured, known_devices
from fieldkit.errors import CaptureTrouble
from fieldkit.quantities import counted
from fieldkit.tui.widgets import cards
from fieldkit.tui.widgets.hanging import Hanging, stacked

MAX_CAPTURES = 8
"""Number of earlier captures that are listed, the newest first. [1]"""
STEPS = (
    ("1", "Plug in the logger or its adapter; r lists its port above."),
    ("2", "Enter captures from the port. h names the device first if it only answers commands."),
    ("3", "At the end you are asked whether to import its flights; k ends a stream."),
)
"""The steps of a capture: number and text."""


@dataclass(frozen=True, slots=True)
class Ready:
    """Earlier captures as name and state, the newest first, and the names and titles of known devices."""

    captures: tuple[tuple[str, str], ...]
    devices: tuple[tuple[str, str], ...]


def ready_in(folder: Path) -> Ready:
    """The latest captures in a folder, and the known devices."""
    files = captured.captures(folder)[: -MAX_CAPTURES - 1 : -1]
    states = tuple((file.name, _state(file)) for file in files)
    return Ready(states, tuple((name, device.title) for name, device in known_devices().items()))


def _state(file: Path) -> str:
    """The size of a capture and whether it is complete, or why it cannot be read."""
    try:
        one = captured.read_capture(file)
    except CaptureTrouble as error:
        return str(error)
    return f"{counted(len(one.raw), 'byte')}, " + ("complete" if one.whole else "INCOMPLETE; C continues the newest")


def ready_text(ready: Ready) -> Hanging:
    """The steps of a capture, earlier captures, and known devices."""
    blocks = [cards.lines("How to capture", list(STEPS), 2)]
    if ready.captures:
        blocks.append(cards.lines("Earlier captures", list(ready.captures), 34))
    blocks.append(cards.lines("Loggers that can be captured", list(ready.devices), 20))
    return stacked(blocks)
