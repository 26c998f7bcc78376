"""MicroPeak, MicroKite and MicroPeak 2: an LED transmits the flight once, at power-up, to a phototransistor.

The host sends nothing. The stream is junk, `MP`, hex digits with arbitrary white space, and four digits of CRC-16/X-25;
the header states the number of samples. A MicroPeak 2 adds a line with its chip's identity.

Sources: MicroData.java and ao_log_micro.c (Altus Metrum).
"""

import time
from dataclasses import dataclass, field

from fieldkit.capture.captured import Captured, Log
from fieldkit.capture.events import Instruction
from fieldkit.capture.line import PortSettings
from fieldkit.capture.link import Dialogue, Link
from fieldkit.capture.port import ALTUS_METRUM
from fieldkit.capture.protocol import CaptureOptions, Protocol
from fieldkit.importing.tables.checksums import crc_x25

WAIT = 180.0
"""How long the user may take to switch the unit on, more than once if needed. [s]"""
PAUSE = 5.0
"""A stream that pauses this long in the middle will not resume. [s]"""
TAIL = 1.5
"""How long the identity line of a MicroPeak 2 may take to follow. [s]"""
MODELS = {0: "MicroPeak", 1: "MicroKite", 2: "MicroPeak 2"}
"""Names by model number."""

_HEX = frozenset(b"0123456789abcdefABCDEF")
_WHITESPACE = frozenset(b" \t\r\n")


@dataclass(frozen=True, slots=True)
class Record:
    """A record in a stream, starting at its `MP`; `sound` if its checksum is valid."""

    start: int
    end: int
    payload: bytes
    sound: bool

    @property
    def model(self) -> int:
        """The model number in the record."""
        return self.payload[9] >> 4

    @property
    def count(self) -> int:
        """The number of samples in the record. [1]"""
        return (len(self.payload) - (12 if self.model == 2 else 10)) // 2


@dataclass(slots=True)
class Stream:
    """Finds records in a stream that arrives in chunks of any size.

    `place` is the number of bytes already taken, `start` the offset of the current record, -1 outside of one, and
    `digits` are those of the current record.
    """

    place: int = 0
    start: int = -1
    digits: bytearray = field(default_factory=bytearray)
    _needed: int = 20
    _last: int = 0

    def feed(self, chunk: bytes) -> list[Record | None]:
        """The records that end in a chunk, None for a record broken by noise."""
        found: list[Record | None] = []
        at = 0
        while at < len(chunk):
            if self.start < 0:
                at = self._take_start(chunk, at)
                continue
            byte = chunk[at]
            if byte in _HEX:
                self.digits.append(byte)
                if len(self.digits) == self._needed and self._complete():
                    found.append(self._record(self.place + at + 1))
            elif byte not in _WHITESPACE:
                self.start = -1
                found.append(None)
                continue  # it may start another record
            at += 1
        self.place += len(chunk)
        self._last = chunk[-1] if chunk else self._last
        return found

    def _take_start(self, chunk: bytes, at: int) -> int:
        """The position at which to continue: after the next `MP`, with a record started, or at the end."""
        while (letter := chunk.find(b"P", at)) >= 0:
            at = letter + 1
            if (chunk[letter - 1] if letter else self._last) == ord("M"):
                self.start, self._needed = self.place + letter - 1, 20
                self.digits.clear()
                return at
        return len(chunk)

    def _complete(self) -> bool:
        """Whether all digits have arrived, according to the header."""
        needed = (_size(bytes.fromhex(self.digits[:24].decode())) + 2) * 2
        self._needed = max(needed, self._needed)
        return len(self.digits) >= needed

    def _record(self, end: int) -> Record:
        content = bytes.fromhex(self.digits.decode())
        sound = crc_x25(content[:-2]) == int.from_bytes(content[-2:], "big")
        record = Record(self.start, end, content[:-2], sound)
        self.start = -1
        return record


def _size(header: bytes) -> int:
    """Payload size according to the part of its header received so far; erased memory has no samples. [bytes]"""
    word = int.from_bytes(header[8:10], "little")
    if word == 0xFFFF:
        return 10
    if word >> 12 != 2:
        return 10 + 2 * (word & 0xFFF)
    return 12 + 2 * ((word & 0xFFF) | int.from_bytes(header[10:12], "little") << 12)


def recognizes_stream(heard: bytes) -> bool:
    """Whether `MP` and a complete header are present."""
    stream = Stream()
    return any(record is not None for record in stream.feed(heard)) or (stream.start >= 0 and len(stream.digits) >= 24)


def dialogue(link: Link, wishes: CaptureOptions, captured: Captured) -> Dialogue[bool]:
    """Record what the unit's LED transmits; returns whether the record is sound. Raises PortTrouble on silence."""
    stream = Stream()
    useful = time.monotonic()
    base = link.samples
    wait = WAIT if wishes.wait is None else wishes.wait
    yield from link.first_word(wait, "switch the unit on with its LED over the adapter")
    while time.monotonic() - useful < wait:
        chunk = yield from link.hear()
        before = len(stream.digits) if stream.start >= 0 else 0
        for record in stream.feed(chunk):
            if record is not None and record.sound:
                link.about["model"] = MODELS.get(record.model, "MicroPeak")
                link.samples, link.fraction = base + record.count, 1.0
                if not record.count:
                    yield Instruction("the unit holds no flight")
                yield from link.drain(TAIL)
                return True
            link.damaged += 1
            yield Instruction("the record is damaged; switch the unit off and on to receive it again")
        if stream.start >= 0 and len(stream.digits) > before:
            useful = time.monotonic()
            link.samples = base + max(0, len(stream.digits) - 20) // 4
            link.fraction = min(1.0, len(stream.digits) / stream._needed) if len(stream.digits) >= 24 else None
        elif stream.start >= 0 and time.monotonic() - useful > PAUSE:
            stream = Stream()
            link.damaged += 1
            yield Instruction("the record stopped in the middle; switch the unit off and on to receive it again")
    return False


def logs(captured: Captured) -> list[Log]:
    """Each flight once: records with a valid checksum, then complete ones without if none of those has the same header;
    without any record, the bytes from the last `MP` on."""
    raw = captured.raw
    stream = Stream()
    records = [record for record in stream.feed(raw) if record is not None]
    sound = {record.payload: record for record in records if record.sound}
    headers = {payload[:8] for payload in sound}
    kept = list(sound.values()) + [one for one in records if not one.sound and one.payload[:8] not in headers]
    slices = [raw[one.start : _end(raw, one)] for one in kept]
    if not slices and (last := raw.rfind(b"MP")) >= 0:
        slices = [raw[last:]]
    names = [f" record {number}" if len(slices) > 1 else "" for number in range(1, len(slices) + 1)]
    return [Log(captured.file.name + name, content) for name, content in zip(names, slices, strict=True)]


def _end(raw: bytes, record: Record) -> int:
    """The end of a record, including the identity line of a MicroPeak 2."""
    if record.model != 2:
        return record.end
    more = raw[record.end : record.end + 64]
    line = more.lstrip(b"\r\n").split(b"\n", 1)[0]
    return record.end + len(more) - len(more.lstrip(b"\r\n")) + len(line) if line.count(b"-") == 2 else record.end


PROTOCOL = Protocol(
    "Altus Metrum MicroPeak, MicroKite, MicroPeak 2",
    PortSettings(9600),
    dialogue,
    logs,
    recognizes_stream,
    invites="hold the unit's LED over the adapter and switch the unit on",
    usb=frozenset({(ALTUS_METRUM, 0x2B)}),
)
