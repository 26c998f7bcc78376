"""Parse the flash of an Altus Metrum device into records from the lines of hex bytes that a download writes.

A record is a letter, a checksum, a 16-bit clock and data; the log format determines its length and layout. Erased bytes
are ff; a record with a wrong checksum is skipped.
Source: altoslib and libaltos of AltOS. Formats 1, 7, 16 and 22 were checked with real files, but the axial
accelerometer of a TeleMega and an EasyMega only with `struct ao_log_mega` (ao_log.h).
"""

import re
from collections import Counter
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from fieldkit.errors import DamagedLog
from fieldkit.importing.reading import Note, Parsed
from fieldkit.importing.tables.altos import sound
from fieldkit.importing.tables.damage import Damaged, damage
from fieldkit.importing.tables.text import blocks, first_lines, is_cut, shown
from fieldkit.quantities import counted
from fieldkit.shapes import Int, Integers

Octets = np.ndarray[Any, np.dtype[np.uint8]]
LARGEST_FLASH = 16 << 20
"""Twice the flash of the largest of these devices. [bytes]"""
_RECORDS_TO_MEASURE, _WORDS_OF_FORMAT_1 = 200, 2
"""Number of records of the old form whose length determines the layout, and how many numbers follow the clock in log
format 1. [1]"""
OLD_RECORD = re.compile(r"([A-Z]) +([0-9a-fA-F]{1,4})((?: +[0-9a-fA-F]{1,4})+)\s*$")
"""A record of the old form; the oldest pads its numbers with spaces."""


@dataclass(frozen=True, slots=True)
class RecordLayout:
    """One log format: the number of bytes in a record, and the positions of sensor data after its clock.

    The raw pressure and temperature come first, with `counts` bytes each; 0 for an analog pressure of 2 bytes after the
    acceleration. `acceleration` and `ground` (in the record of the flight) are 2 bytes, None if the format has none;
    `pad` there is the pressure on the pad, 4 bytes [Pa]. `positions` means that there are records of a satellite
    receiver.
    """

    device: str
    size: int
    counts: int = 4
    acceleration: int | None = None
    ground: int | None = None
    positions: bool = False
    pad: int | None = 4

    @property
    def payload(self) -> int:
        """Number of bytes after the clock. [bytes]"""
        return self.size - 4


MEGA = {5: "TeleMega", 10: "TeleMega 2", 15: "TeleMega 3", 19: "TeleMega 4", 21: "TeleMega 5", 22: "TeleMega 6"}
EASY_MEGA = {16: "EasyMega 2", 24: "EasyMega 3"}
MINI = {6: "EasyMini 1", 14: "EasyMini 2", 8: "TeleMini 2", 12: "TeleMini 3"}
"""Devices by log format, in groups with the same layout."""
LAYOUTS: Mapping[int, RecordLayout] = {
    1: RecordLayout("TeleMetrum 1", 8, counts=0, acceleration=0, ground=0, pad=None),
    7: RecordLayout("TeleMetrum 2", 16, acceleration=8, ground=2, positions=True),
    **{number: RecordLayout(device, 32, acceleration=26, ground=2) for number, device in (MEGA | EASY_MEGA).items()},
    **{number: RecordLayout(device, 16, counts=3) for number, device in MINI.items()},
}
"""The supported log formats with a pressure."""


@dataclass(frozen=True, slots=True)
class Flash:
    """Records without damaged ones, the text above them, and notes about the rest."""

    settings: str
    records: Int[Octets, "record byte"]
    found: tuple[Parsed, ...]


def new_form(log: bytes, row: int, settings: str, layout: RecordLayout) -> Flash:
    """The records in lines of hex bytes; what a damaged line lacks counts as erased, and the last may be shorter.

    Raises DamagedLog for too much data.
    """
    damaged = Damaged()
    flash, missing = bytearray(), 0
    widths = Counter(len(hex_bytes(line) or b"") for line in first_lines(log, after=row - 1, most=100) if line.strip())
    width = widths.most_common(1)[0][0]
    last = 0 if is_cut(log) else log.rstrip().count(b"\n") + 1
    for first, lines in blocks(log, row - 1):
        for number, line in enumerate(lines, start=first):
            if not line.strip():
                continue
            data = hex_bytes(line)
            if data is None or len(data) > width or (len(data) < width and number != last):
                damaged.add(DamagedLog(f"found {shown(line)}, expected {width} bytes in hex", row=number))
                data = (data or b"")[:width]
            missing = width - len(data)
            flash += data.ljust(width, b"\xff")
        if len(flash) > LARGEST_FLASH:
            raise DamagedLog(f"found more than {LARGEST_FLASH >> 20} MB of memory, more than any device has", row=first)
    if is_cut(log) and missing:
        del flash[-missing:]
    found = damage(damaged, "lines", log)
    size = layout.size
    whole = np.frombuffer(bytes(flash[: len(flash) // size * size]), np.uint8).reshape(-1, size)
    written = whole[(whole != 0xFF).any(axis=1)]
    good = sound(written)
    if not good.all():
        first_bad = int(np.flatnonzero(~good)[0]) + 1
        records = "record has" if (~good).sum() == 1 else "records have"
        found.append(Note(f"{(~good).sum()} {records} a wrong checksum, left out; the first is record {first_bad}"))
    return Flash(settings, written[good], tuple(found))


def layout_in(settings: str, log: bytes, row: int) -> RecordLayout | None:
    """The layout of records in the old form whose log format is not stated: by the length of most of the first records,
    and where two devices share it by the name of the product. None if neither shows it."""
    lines = (OLD_RECORD.match(line.strip()) for line in first_lines(log, after=row - 1, most=_RECORDS_TO_MEASURE))
    sizes = Counter(len(match[3].split()) for match in lines if match)
    words = sizes.most_common(1)[0][0] if sizes else 0
    if words == _WORDS_OF_FORMAT_1:
        return LAYOUTS[1]
    fitting = [layout for layout in LAYOUTS.values() if layout.payload == words and layout.counts]
    product = re.sub(r"[^a-z]", "", settings.lower())
    named = [one for one in fitting if re.sub(r"[^a-z]", "", one.device.lower()) in product]
    return next(iter(named or (fitting if len({one.counts for one in fitting}) == 1 else [])), None)


def hex_bytes(line: str) -> bytes | None:
    """The bytes of a line of hex, None if it is not hex."""
    try:
        return bytes.fromhex(line)
    except ValueError:
        return None


def old_form(log: bytes, row: int, settings: str, layout: RecordLayout) -> Flash:
    """The records in lines of a letter, a clock and bytes, or of two numbers in format 1."""
    damaged = Damaged()
    records = bytearray()
    for first, lines in blocks(log, row - 1):
        for number, line in enumerate(lines, start=first):
            record = _old_record(line, layout)
            if record is not None:
                records += record
            elif re.match(r"[A-Z] [0-9a-fA-F]", line):
                expected = "two numbers" if layout.size == 8 else counted(layout.payload, "byte")
                damaged.add(DamagedLog(f"found {shown(line)}, expected {expected} in hex", row=number))
    whole = np.frombuffer(bytes(records), np.uint8).reshape(-1, layout.size)
    return Flash(settings, whole, tuple(damage(damaged, "records", log)))


def _old_record(line: str, layout: RecordLayout) -> bytes | None:
    match = OLD_RECORD.match(line)
    if not match:
        return None
    clock, words = int(match[2], 16).to_bytes(2, "little"), match[3].split()
    size = 2 if layout.size == 8 else 1
    if len(words) * size != layout.payload or any(len(word) > 2 * size for word in words):
        return None
    payload = b"".join(int(word, 16).to_bytes(size, "little") for word in words)
    return bytes([ord(match[1]), 0]) + clock + payload


def number_at(records: Int[Octets, "record byte"], place: int, size: int, *, signed: bool = False) -> Integers:
    """The integer of `size` bytes, lowest first, in each record; `place` is counted from the end of the clock."""
    values: Integers = records[:, 4 + place : 4 + place + size].astype(np.int64) @ (1 << 8 * np.arange(size))
    return values - ((values >> (8 * size - 1)) << 8 * size) if signed else values
