"""Blue Raven over USB: text frames, `@ KIND length date time sync fields... CRC: XXXX`, requested by sample rate.

No mark ends a download, so silence does. A frame can be overwritten by the next one; then only the first is lost.

Sources: Blue Raven USB Interface Guide (Revised), third party; the CRC is derived from a real capture, in which it is
valid for every high-rate frame that was not overwritten.
"""

import re
import time

from fieldkit.capture.captured import Captured, Log
from fieldkit.capture.events import Instruction
from fieldkit.capture.line import PortSettings
from fieldkit.capture.link import NOISE, Dialogue, Link
from fieldkit.capture.protocol import CaptureOptions, Protocol
from fieldkit.errors import PortTrouble
from fieldkit.importing.tables.checksums import crc_buypass

SILENCE = 5.0
"""A download is over after this long without a flight data frame: the slower rate is 50 per second. [s]"""
DOWNLOADS = {"LOW": b"download l\r\n", "HIR": b"download h\r\n"}
"""Commands by the kind of frame they request. The line end of a command is not documented; frames end with CR LF."""

_CRC = re.compile(rb" CRC: ([0-9A-Fa-f]{4})\s*$")


def frame(line: bytes) -> bytes | None:
    """The frame at the end of a line, starting at its last `@ `, if its checksum is valid."""
    start = line.rfind(b"@ ")
    match = _CRC.search(line)
    if start < 0 or not match or crc_buypass(line[start : match.start()]) != int(match[1], 16):
        return None
    return line[start:].rstrip()


def recognizes_stream(heard: bytes) -> bool:
    """Whether there is a frame with a valid checksum, such as the live status."""
    return any(frame(line) for line in heard.splitlines()[:-1])


def dialogue(link: Link, wishes: CaptureOptions, captured: Captured) -> Dialogue[bool]:
    """Download low- and high-rate data; always returns True, because only silence ends a download. Raises PortTrouble
    if the unit does not answer."""
    silence = SILENCE if wishes.silence is None else wishes.silence
    done = {str(mark.facts["done"]) for mark in captured.marks if "done" in mark.facts}
    came = bool(done)
    for place, (kind, command) in enumerate(DOWNLOADS.items()):
        link.fraction = place / len(DOWNLOADS)
        if kind not in done:
            link.send(command)
            frames = yield from _downloaded(link, kind, silence)
            link.line.tape.note(done=kind)
            came = came or frames > 0
            if not frames:
                yield Instruction(f"the unit sent no {'low' if kind == 'LOW' else 'high'}-rate data")
    link.fraction = 1.0
    if not came:
        raise PortTrouble(f"{link.line.name}: no frame in answer to download l and download h from a Blue Raven")
    return True


def _downloaded(link: Link, kind: str, silence: float) -> Dialogue[int]:
    """Count frames of one kind until none arrive for `silence` [s], or for four times that in noise, which hides them;
    live status in between does not count."""
    wanted = f"@ LOG_{kind}".encode()
    last = quiet_since = time.monotonic()
    frames = 0
    while (line := (yield from link.piece(b"\n", silence))) is not None:
        now = time.monotonic()
        if wanted in line:
            last = quiet_since = now
            good = frame(line) is not None
            frames += good
            link.samples += good
            link.damaged += not good
        elif b"@ " not in line:
            quiet_since = now
        if now - quiet_since >= silence or now - last >= NOISE * silence:
            break
    return frames


def logs(captured: Captured) -> list[Log]:
    """The longest answer to each download, in one log; without any, all bytes. Nothing if there is no frame."""
    kept = []
    for command in DOWNLOADS.values():
        answers = [answer.content for answer in captured.answers() if answer.command == command]
        if answers:
            kept.append(max(answers, key=len))
    content = b"".join(kept) if kept else captured.raw
    return [Log(captured.file.name, content)] if b"@ " in content else []


PROTOCOL = Protocol("Featherweight Blue Raven (USB)", PortSettings(115_200), dialogue, logs, recognizes_stream)
