"""StratoLogger live telemetry: one altitude in feet per line, which the unit sends unprompted in flight.

The lines have no time stamp, so each gets its arrival time. If the unit already sends on the pad, its first line is the
pad's elevation above sea level and the others are above the pad. The protocol for its memory is not public.

Source: docs/telem.md (UND-ARC/StratoLogger).
"""

import re

from fieldkit.capture.captured import Captured, Log
from fieldkit.capture.events import Sample
from fieldkit.capture.line import PortSettings
from fieldkit.capture.link import Dialogue, Link
from fieldkit.capture.protocol import CaptureOptions, Protocol
from fieldkit.units import FOOT

WAIT = 3600.0
"""How long a unit may wait on the pad before it sends anything. [s]"""
STREAM = 120.0
"""Longest pause after that. [s]"""
TITLE = "StratoLogger live telemetry, captured by fieldkit"

_NUMBER = re.compile(r"-?\d{1,6}")


def recognizes_stream(heard: bytes) -> bool:
    """Whether there are at least six lines of one integer each, with the unit's line ends, and nothing else after the
    first line, which may be torn."""
    whole = heard[: heard.rfind(b"\n") + 1]
    return re.fullmatch(rb"[^\n]*\n(?:-?\d{1,6}\r\n){6,}", whole) is not None


def dialogue(link: Link, wishes: CaptureOptions, captured: Captured) -> Dialogue[bool]:
    """Record live telemetry until it is silent; always returns True. Raises PortTrouble without any."""
    wait = WAIT if wishes.wait is None else wishes.wait
    silence = STREAM if wishes.silence is None else wishes.silence
    link.open_ended = True
    yield from link.first_word(wait, "its telemetry must be enabled in its settings")
    while (line := (yield from link.text_line(silence))) is not None:
        if _NUMBER.fullmatch(line):
            link.samples += 1
            link.sample = Sample(int(line) * FOOT) if link.samples > 1 else None
        else:
            link.damaged += 1
    return True


def logs(captured: Captured) -> list[Log]:
    """A table of seconds and feet, with arrival times; a line that is not a number becomes a row without a height.

    Lines torn by the loss of the port are left out.
    """
    rows = [TITLE]
    if captured.began is not None:
        rows.append(f"began,{captured.began.replace(tzinfo=None).isoformat(timespec='seconds')}")
    rows.append("seconds,feet")
    lines = list(captured.lines())
    for (_, line), time in zip(lines, captured.received_at(end for end, _ in lines), strict=True):
        text = line.decode("latin-1").rstrip("\r")
        rows.append(f"{time:.3f},{text if _NUMBER.fullmatch(text) else ''}")
    return [Log(captured.file.name, "\n".join([*rows, ""]).encode())] if lines else []


PROTOCOL = Protocol(
    "PerfectFlite StratoLogger live telemetry (its memory is read by the vendor's program only)",
    PortSettings(9600),
    dialogue,
    logs,
    recognizes_stream,
    invites="switch the unit on; the capture continues until it is stopped or the unit goes silent",
)
