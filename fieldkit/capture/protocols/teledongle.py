"""TeleDongle: packets from a flight computer's radio, as `.telem` lines, until the user stops or it is silent.

Source: AltosLink.java, AltosTelemetry.java, ao_telemetry.h (Altus Metrum).
"""

import re
import struct
from collections.abc import Mapping

from fieldkit.capture.altus import silence_echo, version
from fieldkit.capture.captured import Captured, Log
from fieldkit.capture.events import Instruction, Sample
from fieldkit.capture.line import PortSettings
from fieldkit.capture.link import Dialogue, Link
from fieldkit.capture.port import ALTUS_METRUM
from fieldkit.capture.protocol import CaptureOptions, Protocol
from fieldkit.errors import PortTrouble
from fieldkit.importing.tables.checksums import sum_256

STREAM = 1800.0
"""Longest time without a packet: rockets wait on pads. [s]"""
STATES = ("startup", "idle", "pad", "boost", "fast", "coast", "drogue", "main", "landed", "invalid", "stateless")
"""Flight states by number."""
SPEEDS: Mapping[int, int] = {1: 20, 2: 20, 3: 20, 9: 28, 10: 16, 16: 20, 17: 20}
"""Offset of the speed in 1/16 m/s, followed by the height in m, by packet type: TeleMetrum 1, TeleMini 1, TeleNano;
TeleMega; TeleMetrum 2; TeleMini 2 and 3."""
TICK = 0.01
"""Clock tick of a flight computer. [s]"""


def packet(line: str) -> bytes | None:
    """The packet in a `TELEM` line if its checksum and radio CRC are valid, else None."""
    match = re.fullmatch(r"TELEM ((?:[0-9a-fA-F]{2}){4,260})", line.strip())
    if not match:
        return None
    content = bytes.fromhex(match[1])
    if content[0] != len(content) - 2 or sum_256(content[1:-1], 0x5A) != content[-1]:
        return None
    return content[1:-3] if content[-2] & 0x80 else None


def sample(content: bytes) -> Sample | None:
    """Height, speed, time and state in a packet, None for packets without height and speed."""
    place = SPEEDS.get(content[4]) if len(content) == 32 else None
    if place is None:
        return None
    tick, state = struct.unpack_from("<HxB", content, 2)
    speed, height = struct.unpack_from("<hh", content, place)
    return Sample(float(height), tick * TICK, speed / 16, STATES[state] if state < len(STATES) else "")


def recognizes_stream(heard: bytes) -> bool:
    """Whether packets are already being forwarded."""
    return any(packet(line) for line in heard.decode("latin-1").splitlines()[:-1])


def dialogue(link: Link, wishes: CaptureOptions, captured: Captured) -> Dialogue[bool]:
    """Record radio packets until the user stops or the unit is silent; always returns True. Raises PortTrouble."""
    link.send(b"m 0\n")  # it may still forward packets for a program that was killed
    yield from silence_echo(link)
    if not (yield from version(link)):
        raise PortTrouble(
            f"{link.line.name}: no software-version in answer to v from a TeleDongle; is it the right port?"
        )
    if wishes.frequency is not None:
        link.send(b"c F %d\n" % round(wishes.frequency / 1000))
    link.open_ended = True
    link.send(b"m 20\n")
    yield Instruction("listening for packets; stop when the rocket is down")
    silence = STREAM if wishes.silence is None else wishes.silence
    try:
        while (line := (yield from link.text_line(silence))) is not None:
            _take(link, line)
    finally:
        link.last_command(b"m 0\n")
    return True


def _take(link: Link, line: str) -> None:
    content = packet(line)
    if content is not None:
        link.samples += 1
        link.sample = sample(content) or link.sample
    elif line.startswith(("TELEM", "CRC INVALID")):
        link.damaged += 1


def logs(captured: Captured) -> list[Log]:
    """The telemetry lines, in order."""
    lines = [line for line in captured.raw.splitlines() if line.startswith((b"TELEM ", b"CRC INVALID"))]
    return [Log(captured.file.name, b"\n".join(lines) + b"\n")] if lines else []


PROTOCOL = Protocol(
    "Altus Metrum TeleDongle (radio telemetry)",
    PortSettings(9600),
    dialogue,
    logs,
    recognizes_stream,
    usb=frozenset({(ALTUS_METRUM, 0x0C)}),
)
