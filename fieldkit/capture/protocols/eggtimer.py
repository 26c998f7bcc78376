"""Eggtimer Classic and TRS: records whatever text they print, unchanged; pressing their button starts the output.

No handshake is documented and none is attempted. A record ends with silence, or when the user stops the capture.

Sources: Serial_Connection.md (broofa/eggtimer_for_mac), Eggtimer manual release 1.48b.
"""

import re

from fieldkit.capture.captured import Captured, Log
from fieldkit.capture.line import PortSettings
from fieldkit.capture.link import Dialogue, Link
from fieldkit.capture.protocol import CaptureOptions, Protocol

WAIT = 180.0
"""How long the user may take to press the button. [s]"""
SILENCE = 30.0
"""A pause of this length ends the capture; it leaves time to press the button again. [s]"""

_HEADER = re.compile(rb"^T[,;\t ]Alt[,;\t ]", re.MULTILINE)
_ROW = re.compile(r"[-+]?\d[-+\d.,;\s]*")
_MARK = re.compile(r"[,;\s]+")
MIN_NUMBERS = 3
"""Minimum count of numbers in a row: time, height and speed. [1]"""


def recognizes_stream(heard: bytes) -> bool:
    """Whether the header of their tables is present."""
    return _HEADER.search(heard) is not None


def dialogue(link: Link, wishes: CaptureOptions, captured: Captured) -> Dialogue[bool]:
    """Record what the unit prints until it is silent; always returns True. Raises PortTrouble if it prints nothing."""
    wait = WAIT if wishes.wait is None else wishes.wait
    silence = SILENCE if wishes.silence is None else wishes.silence
    link.open_ended = True
    yield from link.first_word(wait, "press the unit's button; the Classic needs --baud 19200, the TRS --baud 9600")
    while (line := (yield from link.text_line(silence))) is not None:
        link.samples += _is_row(line)
    return True


def _is_row(line: str) -> bool:
    """Whether a line is a row of the table: numbers with separators."""
    return _ROW.fullmatch(line) is not None and len(_MARK.split(line)) >= MIN_NUMBERS


def logs(captured: Captured) -> list[Log]:
    """The text without NULs and without lines torn by the loss of the port, otherwise unchanged."""
    content = captured.untorn.replace(b"\0", b"")
    return [Log(captured.file.name, content)] if content.strip() else []


PROTOCOL = Protocol(
    "Eggtimer Classic, TRS (text, as printed)",
    PortSettings(9600),
    dialogue,
    logs,
    recognizes_stream,
    invites="press the unit's button for its summary, again for the detail; half a minute of silence ends the capture",
)
