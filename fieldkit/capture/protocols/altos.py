"""Altus Metrum flight computers over USB: their identity, their list of flights, and the flights, block by block.

A block is 256 bytes and arrives as 32 lines of nine hex numbers: the offset in the block and eight bytes. A line that
is missing or incomplete leaves 0xff, like erased memory; the block is then requested again.

Source: AltosLink.java, AltosEepromDownload.java, AltosEepromBlock.java (Altus Metrum).
"""

import json
import re
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass

from fieldkit.capture.altus import ANSWER, silence_echo, version
from fieldkit.capture.captured import Captured, Log
from fieldkit.capture.events import FlightsListed, Instruction, Stored
from fieldkit.capture.line import PortSettings
from fieldkit.capture.link import Dialogue, Link
from fieldkit.capture.port import ALTUS_METRUM
from fieldkit.capture.protocol import CaptureOptions, Protocol
from fieldkit.errors import PortTrouble
from fieldkit.quantities import counted

TRIES = 3
"""Number of times that a command is sent until the answer is complete. [1]"""
BLOCK, ROW, LINE = 256, 8, 32
"""Bytes of a block, of a line from a unit, and of a line of a file. [bytes]"""
ERASED_BLOCK = b"\xff" * BLOCK
MOST_LINES = 5000
"""Upper limit on the lines of a list of flights. [1]"""
MAX_BLOCKS = 100_000
"""Upper limit on the blocks of a flight; a line with more is damaged. [1]"""


@dataclass(frozen=True, slots=True)
class Extent:
    """A flight's location in memory: blocks from `start` up to, but not including, `end`."""

    number: int
    start: int
    end: int


@dataclass(frozen=True, slots=True)
class Block:
    """A block as received, and the number of missing lines."""

    content: bytes
    missing: int


def dialogue(link: Link, wishes: CaptureOptions, captured: Captured) -> Dialogue[bool]:
    """Download the chosen flights, block by block; returns whether all arrived. Raises PortTrouble."""
    yield from silence_echo(link)
    identity = yield from _identity(link)
    _same_unit(link, identity, captured)
    flights = yield from _flights(link)
    listed = [
        Stored(one.number, f"flight {one.number}, {(one.end - one.start) * BLOCK // 1024} KiB") for one in flights
    ]
    wanted = set(wishes.choose(listed)) if listed else set()
    chosen = [one for one in flights if one.number in wanted]
    yield FlightsListed(tuple(listed), tuple(one.number for one in chosen))
    have = {number: block for number, block in blocks(captured).items() if not block.missing}
    return (yield from _downloaded(link, chosen, have))


def _identity(link: Link) -> Dialogue[dict[str, str]]:
    """What a unit reports about itself. Raises PortTrouble if it does not answer."""
    for _ in range(TRIES):
        link.send(b"c s\n")
        link.send(b"f\n")
        found = yield from version(link)
        if found:
            return found
    raise PortTrouble(
        f"{link.line.name}: no software-version in answer to v from an Altus Metrum unit; is it switched on?"
    )


def _same_unit(link: Link, identity: dict[str, str], captured: Captured) -> None:
    """Raise PortTrouble if a resumed capture is from another unit."""
    before = set(re.findall(rb"^serial-number +(\d+)", captured.raw, re.MULTILINE))
    mine = identity.get("serial-number", "")
    if before and mine and mine.encode("latin-1") not in before:
        known = ", ".join(sorted(one.decode() for one in before))
        raise PortTrouble(
            f"{link.line.name}: found serial number {mine}, expected {known} of the capture; start a new one"
        )


def _flights(link: Link) -> Dialogue[list[Extent]]:
    for _ in range(TRIES):
        link.send(b"l\n")
        lines: list[str] = []
        while len(lines) < MOST_LINES and (line := (yield from link.text_line(ANSWER))) is not None:
            if line.strip() == "done":
                return extents(lines)
            lines.append(line)
    raise PortTrouble(f"{link.line.name}: no list of flights in answer to l, expected lines and `done`")


def extents(lines: Iterable[str]) -> list[Extent]:
    """The flights in a list from the unit, without empty ones and lines that are not valid."""
    found = []
    for line in lines:
        match = re.fullmatch(r"flight (\d+) start ([0-9a-fA-F]{1,6}) end ([0-9a-fA-F]{1,6})", line.strip())
        if match and 0 < int(match[3], 16) - int(match[2], 16) <= MAX_BLOCKS:
            found.append(Extent(int(match[1]), int(match[2], 16), int(match[3], 16)))
    return found


def _downloaded(link: Link, flights: Sequence[Extent], have: dict[int, Block]) -> Dialogue[bool]:
    """Read the blocks of flights that the capture does not have yet, of each flight up to the first erased block."""
    total = sum(one.end - one.start for one in flights)
    done, whole = 0, True
    for one in flights:
        for number in range(one.start, one.end):
            link.fraction = done / total
            block = have.get(number) or (yield from _block(link, number))
            whole = whole and not block.missing
            done += 1
            if block.content == ERASED_BLOCK and not block.missing:
                break
        done = sum(other.end - other.start for other in flights[: flights.index(one) + 1])
    link.fraction = 1.0
    return whole


def _block(link: Link, number: int) -> Dialogue[Block]:
    """Read a block, and read it again if lines are missing."""
    for attempt in range(1, TRIES + 1):
        link.send(b"e %x\n" % number)
        lines: list[str] = []
        while len(lines) < BLOCK // ROW and (line := (yield from link.text_line(ANSWER))) is not None:
            if line.strip():
                lines.append(line)
            if _row(line) and line.split()[0].lower() == "f8":
                break
        block = assembled(lines)
        if not block.missing:
            link.samples += BLOCK // ROW
            return block
        link.damaged += 1
        again = "; reading it again" if attempt < TRIES else "; they stay empty"
        yield Instruction(f"block {number:x}: {counted(block.missing, 'line')} arrived incomplete{again}")
        yield from link.drain(0.3)
    return block


def assembled(lines: Iterable[str]) -> Block:
    """The block assembled from lines; missing bytes are 0xff."""
    content = bytearray(ERASED_BLOCK)
    missing = set(range(0, BLOCK, ROW))
    for line in lines:
        row = _row(line)
        if row and row[0] in missing:
            missing.discard(row[0])
            content[row[0] : row[0] + ROW] = bytes(row[1:])
    return Block(bytes(content), len(missing))


def _row(line: str) -> list[int] | None:
    """The nine numbers of a line, None if the line is not valid."""
    tokens = line.split()
    if len(tokens) != 1 + ROW or not all(re.fullmatch(r"[0-9a-fA-F]{1,2}", token) for token in tokens):
        return None
    return [int(token, 16) for token in tokens]


def blocks(captured: Captured) -> dict[int, Block]:
    """The best copy of each requested block."""
    best: dict[int, Block] = {}
    for answer in captured.answers():
        asked = re.fullmatch(rb"e ([0-9a-f]+)\n", answer.command)
        if asked:
            number, block = int(asked[1], 16), assembled(answer.content.decode("latin-1").splitlines())
            if number not in best or block.missing < best[number].missing:
                best[number] = block
    return best


def logs(captured: Captured) -> list[Log]:
    """Each flight in the format of the vendor's program: what the unit reports about itself, then its memory in hex."""
    answers = {answer.command: answer.content.decode("latin-1").splitlines() for answer in captured.answers()}
    reported = [line for command in (b"c s\n", b"f\n", b"v\n") for line in answers.get(command, [])]
    memory = blocks(captured)
    found = []
    for one in extents(answers.get(b"l\n", [])):
        have = [number for number in range(one.start, one.end) if number in memory]
        content = b"".join(
            memory[number].content if number in memory else ERASED_BLOCK
            for number in range(one.start, max(have, default=0) + 1)
        )
        if have and content.strip(b"\xff"):
            name = f"{captured.file.name} flight {one.number}"
            found.append(Log(name, _eeprom(settings(reported) | {"flight": one.number}, content)))
    return found


def settings(lines: Iterable[str]) -> dict[str, str | int]:
    """What a unit reports about itself, under the names that the vendor's program uses in its files."""
    found: dict[str, str | int] = {}
    for line in lines:
        if match := _CALIBRATION.match(line):
            found |= {"accel_cal_plus": int(match[1]), "accel_cal_minus": int(match[2])}
        elif match := _SETTING.match(line):
            name = re.sub(r"[^a-z0-9]+", "_", (match[1] or match[2]).lower()).strip("_")
            value = match[3].strip().strip('"')
            found[_RENAMED_KEYS.get(name, name)] = int(value) if re.fullmatch(r"-?\d{1,10}", value) else value
    return found


def _eeprom(reported: Mapping[str, str | int], content: bytes) -> bytes:
    rows = [content[place : place + LINE].hex(" ") for place in range(0, len(content), LINE)]
    return "\n".join([json.dumps(reported, indent=1), *rows, ""]).encode()


_CALIBRATION = re.compile(r"\s*Accel cal \+1g:\s*(-?\d{1,9})\s+-1g:\s*(-?\d{1,9})")
_SETTING = re.compile(r"\s*(?:([A-Za-z][A-Za-z0-9 _-]{0,40}):\s*|([A-Za-z][A-Za-z0-9_-]{0,40})\s+)([!-~][ -~]{0,80})$")
_RENAMED_KEYS = {"serial_number": "serial", "current_flight": "last_flight"}


PROTOCOL = Protocol(
    "Altus Metrum flight computers (TeleMetrum, TeleMega, EasyMini, ...)",
    PortSettings(9600),
    dialogue,
    logs,
    usb=frozenset((ALTUS_METRUM, product) for product in range(0x0A, 0x2D) if product not in (0x0C, 0x2B)),
)
