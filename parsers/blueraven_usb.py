"""Blue Raven over USB: the output of `download l` and `download h`, one frame per line with its own checksum.

`@ LOG_LOW 212 2024 5 11 14:09:44.602 ... Bo: ... Vel: ... CRC: FEE8`, 50 per second, and `@ LOG_HIR`, 500 per second. A
line may be overwritten by the next (`...0@ LOG_LOW   @ LOG_LOW  212 ...`): the last `@ LOG_` in it is tried. Frames
without a valid checksum are skipped and counted. Numbers are scaled integers; acceleration is read from a label that
names it, if some scale makes it one g at the start. Time starts at the first frame.
"""

import math
import re
from array import array
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from datetime import datetime, timedelta
from itertools import islice

import numpy as np

from fieldkit.errors import DamagedLog
from fieldkit.flight import Series
from fieldkit.importing import Note, Parsed, Parser, Reading
from fieldkit.importing.tables.checksums import BUYPASS
from fieldkit.importing.tables.pad_state import scale_at_rest, upright
from fieldkit.importing.tables.text import line_end, lines, narrow
from fieldkit.quantities import counted
from fieldkit.shapes import Array, Float
from fieldkit.units import DEGREE, FOOT, STANDARD_GRAVITY, UNITS

KINDS = (b"@ LOG_LOW", b"@ LOG_HIR")
LINE = 4096
"""Longest line that is examined; frames have about 200 characters. [bytes]"""
CHECKSUM_BATCH = 2048
"""Number of lines whose checksums are computed together. [1]"""
MAX_NUMBERS = 1_500_000
"""More numbers than the flights of a Blue Raven have at either rate. [1]"""
MAX_FRAME_GAP = 60.0
"""Frames further apart than this belong to two flights. [s]"""
EPOCH = datetime(2000, 1, 1)
"""Zero of the clock in `SampleFrame.numbers`."""
LOW_RATE_FIELDS = (("bo", 0), ("bo", 1), ("v", 0), ("vel", 0), ("ang", 0))
"""The numbers used from a low-rate frame: label and index."""
SCALES = (STANDARD_GRAVITY / 100, STANDARD_GRAVITY / 1000, STANDARD_GRAVITY / 10_000)
"""Possible scales of acceleration. [m/s^2 per count]"""
PAD = 0.5
"""Time after the first frame during which the rocket is assumed to be on the pad. [s]"""
_HEAD = re.compile(
    rb"@ LOG_(LOW|HIR)\s+\d+"
    rb"\s+(\d{4})[\s\-/,]+(\d{1,2})[\s\-/,]+(\d{1,2})[\s,]+(\d{1,2}):(\d{1,2}):(\d{1,2})\.(\d{1,6})"
)
_CHECKED_LINE = re.compile(rb"(@ LOG_.*) CRC:\s*([0-9A-Fa-f]{4})\s*$")
_FIELD = re.compile(rb"\b([A-Za-z]\w*):((?:[\s,]*[-+]?\d+(?![\w:.]))+)")


def crcs(frames: Sequence[bytes]) -> list[int]:
    """CRC-16/BUYPASS of each frame: polynomial 0x8005, from zero, not reflected; 0xFEE8 for `123456789`.

    Leading zeros do not change it, so frames are padded and processed together.
    """
    longest = max(map(len, frames), default=0)
    columns = (
        np.frombuffer(b"".join(frame.rjust(longest, b"\0") for frame in frames), np.uint8)
        .reshape(len(frames), longest)
        .T
    )
    values = np.zeros(len(frames), np.uint16)
    for column in columns:
        values = (values << 8) ^ _TABLE[(values >> 8) ^ column]
    return [int(value) for value in values]


_TABLE = np.array(BUYPASS, np.uint16)


@dataclass(frozen=True, slots=True)
class SampleFrame:
    """One sample: its kind, the logger's clock, and the numbers under each label."""

    kind: str
    clock: datetime
    fields: Mapping[str, tuple[int, ...]]

    def numbers(self) -> list[float]:
        """The clock [s from `EPOCH`] and the numbers used from the sample, nan for missing ones."""
        wanted: tuple[tuple[str, int], ...] = LOW_RATE_FIELDS
        if self.kind == "HIR":
            label = next((name for name, values in self.fields.items() if "acc" in name and len(values) >= 3), "")
            wanted = tuple((label, place) for place in range(3))
        cells = (self.fields.get(label, ())[place : place + 1] for label, place in wanted)
        return [(self.clock - EPOCH) / timedelta(seconds=1), *(float(cell[0]) if cell else math.nan for cell in cells)]


def recognises(head: bytes) -> bool:
    return any(kind in narrow(head) for kind in KINDS)


def frames_of(lines: Sequence[bytes]) -> list[SampleFrame | None]:
    """The frame in each line, the last one if several were printed over each other; None if none is valid."""
    starts = [line.rfind(b"@ LOG_") for line in lines]
    checked = [
        _CHECKED_LINE.match(line, start) if start >= 0 else None for line, start in zip(lines, starts, strict=True)
    ]
    good = crcs([match[1] if match else b"" for match in checked])
    return [
        _frame(match[1]) if match and int(match[2], 16) == value else None
        for match, value in zip(checked, good, strict=True)
    ]


def _frame(text: bytes) -> SampleFrame | None:
    head = _HEAD.match(text)
    if not head:
        return None
    year, month, day, hour, minute, second = map(int, head.groups()[1:7])
    try:
        moment = datetime(year, month, day, hour, minute, second, int(head[8].ljust(6, b"0")))
    except ValueError:
        return None
    fields = {
        field[1].decode().lower(): tuple(map(int, re.findall(rb"[-+]?\d{1,9}", field[2])))
        for field in _FIELD.finditer(text, head.end())
    }
    return SampleFrame(head[1].decode(), moment, fields)


def read(log: bytes) -> list[Parsed]:
    log, samples = narrow(log), {"LOW": array("d"), "HIR": array("d")}
    lost, first_lost, cut = 0, 0, False
    last = log.count(line_end(log)) + 1
    rows, row = lines(log, LINE), 0
    while block := list(islice(rows, CHECKSUM_BATCH)):
        for line, frame in zip(block, frames_of(block), strict=True):
            row += 1
            if frame:
                samples[frame.kind].extend(frame.numbers())
            elif b"@ LOG_" in line:
                cut = row == last
                first_lost, lost = first_lost or row, lost + (not cut)
        if max(map(len, samples.values())) > MAX_NUMBERS:
            raise DamagedLog(f"found more than {MAX_NUMBERS} numbers, more than a Blue Raven holds")
    low = np.array(samples["LOW"]).reshape(-1, 1 + len(LOW_RATE_FIELDS))
    high = np.array(samples["HIR"]).reshape(-1, 4)
    if not len(low) + len(high):
        raise DamagedLog("found no frame with a good checksum, expected lines of @ LOG_LOW or @ LOG_HIR")
    found: list[Parsed] = []
    if lost:
        found.append(
            Note(f"has a frame with a bad checksum, left out; {counted(lost, 'such line')} in all", first_lost)
        )
    if cut:
        found.append(Note("ends within a frame, left out", last))
    return [*_readings(low, high, found), *found]


def _readings(
    low: Float[Array, "frame number"], high: Float[Array, "frame axis"], notes: list[Parsed]
) -> Iterator[Reading]:
    """A reading for each flight: frames of both rates without a gap in the clock."""
    clock = np.unique(np.concatenate([low[:, 0], high[:, 0]]))
    starts = clock[np.concatenate([[True], np.diff(clock) > MAX_FRAME_GAP])]
    for zero, end in zip(starts, [*starts[1:], np.inf], strict=True):
        parts = [_ordered(part[(part[:, 0] >= zero) & (part[:, 0] < end)], zero) for part in (low, high)]
        makers: tuple[Callable[[Array, list[Parsed]], Series], ...] = (_low, _high)
        series = tuple(make(part, notes) for make, part in zip(makers, parts, strict=True) if len(part))
        first = f"{EPOCH + timedelta(seconds=float(zero)):%Y-%m-%d %H:%M:%S}"
        yield Reading({}, {"clock at the first sample": first}, series=series, device="Blue Raven")


def _ordered(part: Float[Array, "frame number"], zero: float) -> Float[Array, "frame number"]:
    ordered = part[np.argsort(part[:, 0], kind="stable")]
    ordered[:, 0] = np.round(ordered[:, 0] - zero, 3)
    return ordered


def _low(part: Float[Array, "frame number"], _: list[Parsed]) -> Series:
    time, fahrenheit, pressure, battery, up, tilt = part.T
    scale = UNITS["temperature"]["f"]
    return Series(
        time=time,
        temperature=_known(fahrenheit / 100 * scale.factor + scale.offset),
        pressure=_known(pressure / 50_000 * UNITS["pressure"]["atm"].factor),
        voltage=_known(battery / 1000),
        inertial_speed=_known(up * FOOT),
        tilt=_known(tilt / 10 * DEGREE),
    )


def _known(values: Float[Array, "frame"]) -> Float[Array, "frame"] | None:
    return None if np.isnan(values).all() else values


def _high(part: Float[Array, "frame axis"], notes: list[Parsed]) -> Series:
    time, axes = part[:, 0], part[:, 1:].T
    total: Float[Array, "frame"] = np.sqrt((axes**2).sum(axis=0))
    rest = time - time[0] < PAD
    scale = scale_at_rest(total[rest], SCALES)
    if scale is None:
        notes.append(Note("holds high-rate frames whose acceleration scale is unknown, left out"))
        return Series(time=time)
    return Series(time=time, felt=upright(axes * scale, rest), felt_total=total * scale)


PARSER = Parser("Blue Raven over USB", recognises, read, signs=("@ LOG_LOW|@ LOG_HIR", "CRC"))
