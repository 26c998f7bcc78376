"""MicroPeak .mpd: the altimeter's optical output after a flight, `MP`, hex and CRC; also MicroKite and MicroPeak 2.

It contains the ground pressure, the lowest pressure after its filter, and the low 16 bits of each sample, the first one
step after the ground pressure was measured. Heights are above that pressure level, by the standard atmosphere. So is
the stated apogee, which the device blinks; the samples may end before it. The clock of the first model may be off by
10%. Characters between the digits are ignored; a wrong checksum is an error.
Source: micropeak/MicroData.java of AltOS, doc/micropeak.txt.
"""

import re
import struct
from codecs import BOM_UTF16_BE, BOM_UTF16_LE
from collections.abc import Iterator
from dataclasses import dataclass
from itertools import compress, islice, pairwise
from operator import not_

import numpy as np

from fieldkit.errors import BadValue, DamagedLog
from fieldkit.flight import BY_NAME, Series
from fieldkit.flight.limits import check
from fieldkit.importing import MOST_FLIGHTS, Note, Parsed, Parser, Reading
from fieldkit.importing.tables.checksums import crc_x25
from fieldkit.importing.tables.text import narrow
from fieldkit.physics.standard_atmosphere import pressure_height
from fieldkit.quantities import counted
from fieldkit.shapes import Array, Float

SEPARATOR_BYTES = b" \t\r\n\v\f\0"
START = re.compile(rb"MP(?=(?:[\s\0]*[0-9a-fA-F]){20})")
DIGITS = re.compile(rb"[0-9a-fA-F]{20,}")
LINE, AT_REST = 16, 20.0
"""Size of a line of a transmission [bytes], and the largest change of pressure in a line on the ground [Pa]."""
MAX_LOG_SIZE = 4 << 20
"""Largest file size: more than the digits and separators of a day of flight. [bytes]"""
MIN_GROUND_PRESSURE, MAX_GROUND_PRESSURE = 10_000, 120_000
"""Range of the pressure on the ground. [Pa]"""


@dataclass(frozen=True, slots=True)
class DeviceModel:
    """A device with this protocol, and its sample interval. [s]"""

    name: str
    step: float


MODELS = (DeviceModel("MicroPeak", 0.192), DeviceModel("MicroKite", 19.2), DeviceModel("MicroPeak 2", 0.1))
"""The devices by model number."""


def recognises(head: bytes) -> bool:
    return any(_is_header(bytes.fromhex(digits[:20].decode())) for _, digits in _transmissions(_plain(head)))


def read(log: bytes) -> list[Parsed]:
    log, found = _plain(log), list[Parsed]()
    for start, digits in islice(_transmissions(log), MOST_FLIGHTS + 1):
        found += _flight(digits, log.count(b"\n", 0, start) + 1, _before_gap(log[start + 2 : start + MAX_LOG_SIZE]))
    if not any(isinstance(item, Reading | Note) for item in found):
        raise found[0] if found else DamagedLog("found no flight, expected MP and hex digits", row=1)  # type: ignore[misc]
    return found


def _plain(log: bytes) -> bytes:
    """A log with one byte per character, even if a terminal saved it as UTF-16 with a byte order mark."""
    return narrow(log) if log.startswith((BOM_UTF16_LE, BOM_UTF16_BE)) else log


def _transmissions(log: bytes) -> Iterator[tuple[int, bytes]]:
    """The positions of `MP` followed by enough hex digits for a header, and the digits without other characters."""
    for match in START.finditer(log):
        text = log[match.end() : match.end() + MAX_LOG_SIZE].translate(None, SEPARATOR_BYTES)
        digits = DIGITS.match(text)
        if digits:
            yield match.start(), digits[0]


def _before_gap(text: bytes) -> int:
    """The number of digits before the end of the first line of a transmission that is shorter than the others, except
    the last one: from there on the bytes are not where they seem to be."""
    lengths = np.array([len(line.translate(None, SEPARATOR_BYTES)) for line in re.split(rb"[\r\n]+", text)])
    lengths = lengths[lengths > 0]
    short = np.flatnonzero(lengths[:-1] < 2 * LINE)
    if not short.size or (lengths[: short[0]] != 2 * LINE).any() or lengths[short[0] + 1] != 2 * LINE:
        return MAX_LOG_SIZE
    return int(lengths[: short[0] + 1].sum())


def _is_header(data: bytes) -> bool:
    """Whether bytes are the start of a flight or of erased memory."""
    ground, _, count = struct.unpack("<IIH", data)
    return (MIN_GROUND_PRESSURE < ground < MAX_GROUND_PRESSURE and count >> 12 < len(MODELS)) or data == b"\xff" * 10


def _flight(digits: bytes, row: int, sound: int) -> list[Parsed]:
    """The flight in one transmission, or its error. Without a checksum only its `sound` first digits are used."""
    data = bytes.fromhex(digits[: len(digits) // 2 * 2].decode())
    if data[:10] == b"\xff" * len(data[:10]):
        return [Note("holds no flight, its memory is erased", row)]
    if len(data) < 12:
        return [DamagedLog(f"found {counted(len(data), 'byte')}, expected at least 12", row=row)]
    ground, least, count = struct.unpack("<IIH", data[:10])
    number, count, begin = count >> 12, count & 0xFFF, 10
    if number >= len(MODELS):
        return [DamagedLog(f"found model {number}, expected 0 to {len(MODELS) - 1}", row=row)]
    if number == 2:
        count, begin = count | struct.unpack("<H", data[10:12])[0] << 12, 12
    end = begin + 2 * count
    once, repeated = _without_repeats(data)
    if repeated and (len(once) < end + 2 or not _is_whole(data, end)):
        data = once
    if len(data) >= end + 2 and not _is_whole(data, end):
        expected, got = crc_x25(data[:end]), int.from_bytes(data[end : end + 2], "big")
        return [DamagedLog(f"found checksum {got:04x}, expected {expected:04x}; capture it again", row=row)]
    if len(data) < end + 2:
        data = data[: sound // 2]
    samples = np.frombuffer(data[begin : min(end, begin + (len(data) - begin) // 2 * 2)], "<u2").astype(float)
    if not (MIN_GROUND_PRESSURE < ground < MAX_GROUND_PRESSURE and 0 < least <= ground + 1000):
        return [
            DamagedLog(
                f"found {ground} Pa on the ground and {least} Pa above it, expected plausible pressures", row=row
            )
        ]
    if not len(samples):
        return [DamagedLog("found no samples, expected at least one", row=row)]
    found: list[Parsed] = [_reading(MODELS[number], ground, least, samples)]
    if len(data) < end + 2:
        found.append(Note(f"is cut off: {len(samples)} of {counted(count, 'sample')}, without a checksum", row))
    if data is once and repeated:
        found.append(Note(f"has {counted(repeated, 'line')} twice, read once", row))
    return found


def _is_whole(data: bytes, end: int) -> bool:
    """Whether the checksum after the samples is theirs."""
    return crc_x25(data[:end]) == int.from_bytes(data[end : end + 2], "big")


def _without_repeats(data: bytes) -> tuple[bytes, int]:
    """The bytes without the lines that equal the one before, as a terminal may save them, and how many these are; two
    lines on the ground may be equal."""
    lines = [data[begin : begin + LINE] for begin in range(0, len(data), LINE)]
    again = [line == before and _moves(line) for before, line in pairwise(lines)]
    return b"".join([*lines[:1], *compress(lines[1:], map(not_, again))]), sum(again)


def _moves(line: bytes) -> bool:
    """Whether the pressures of a line differ by more than they do on the ground."""
    samples = np.frombuffer(line[: len(line) // 2 * 2], "<u2").astype(float)
    return samples.size > 0 and bool(np.ptp(_whole(int(samples[0]), samples)) > AT_REST)


def _reading(model: DeviceModel, ground: int, least: int, samples: Float[Array, "sample"]) -> Reading:
    pressure = _whole(ground, samples)
    pad, apogee = pressure_height(np.array([ground, least], float))
    try:
        stated = {"apogee": check(BY_NAME["apogee"], float(apogee - pad))}
    except BadValue:
        stated = {}
    time = np.arange(1, 1 + len(pressure), dtype=float) * model.step
    return Reading(
        stated=stated,
        extra={"ground_pressure_pa": str(ground), "least_pressure_pa": str(least)},
        series=Series(time, pressure=pressure, altitude=pressure_height(pressure) - pad),
        device=model.name,
    )


def _whole(ground: int, samples: Float[Array, "sample"]) -> Float[Array, "time"]:
    """Pressures from the ground pressure and the low 16 bits of the samples, each closest to its predecessor. [Pa]"""
    steps = np.diff(samples, prepend=ground % 65536)
    return ground + np.cumsum((steps + 32768) % 65536 - 32768)


PARSER = Parser("MicroPeak .mpd", recognises, read, signs=("MP",))
