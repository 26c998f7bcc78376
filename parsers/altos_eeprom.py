"""AltOS .eeprom: the flash of an Altus Metrum device as downloaded, in the new form and the old.

New form: an object of settings, then lines of hex bytes with records whose length depends on `log_format`. Old form:
settings as text, possibly among the commands of a terminal, then one record per line, `A 1f2e 00 12 ...`; the samples
of a TeleMini 1, which has no accelerometer, are records of the letter P. A record is a letter, a checksum, a 16-bit
clock and data. Erased bytes are ff; a record with a wrong checksum is skipped. The record of the flight holds the
pressure on the pad, from which the device itself counts its heights: a log may begin in the boost.
Source: altoslib and libaltos of AltOS (`ao_log.h`); formats 1, 7, 16 and 22 were checked with real files.
"""

import codecs
import re
from dataclasses import fields, replace
from itertools import pairwise

import numpy as np

from fieldkit.errors import DamagedLog
from fieldkit.flight import Series
from fieldkit.importing import Parsed, Parser, Reading
from fieldkit.importing.tables.altos import (
    NO_VALUE,
    STATES,
    Coefficients,
    entered,
    mp3h6115,
    ms5607,
    net_acceleration,
    seconds,
)
from fieldkit.importing.tables.altos_flash import (
    LAYOUTS,
    OLD_RECORD,
    Octets,
    RecordLayout,
    hex_bytes,
    layout_in,
    new_form,
    number_at,
    old_form,
)
from fieldkit.importing.tables.damage import Damaged, damage
from fieldkit.importing.tables.text import blocks, first_lines, shown
from fieldkit.physics.standard_atmosphere import pressure_height
from fieldkit.shapes import Array, Float, Int, Integers

MAX_LOG_SIZE = 32 << 20
"""Largest file size; the flash of these devices fits in it. [bytes]"""
LARGEST_SETTINGS = 1 << 18
"""Size of the beginning of a file that is searched for the first record. [bytes]"""
HEX = re.compile(r"\s*(?:[0-9a-fA-F]{2}\s*){4,}$")
OLD_MARK = re.compile(r"^(?:~|> ?E 0|Config version:)", re.MULTILINE)
"""What the settings of the old form contain: commands of a terminal, or the first setting."""
SAMPLE, FLIGHT, STATE, POSITION = (ord(letter) for letter in "AFSP")
"""Letters of records."""
PRESSURE = POSITION
"""The letter of a sample without an acceleration, in formats without positions."""
TELEMINI_1 = 2
"""The log format of a TeleMini 1."""
OLD_TELEMINI_1 = RecordLayout("TeleMini 1", 8, counts=0, pad=None)
PAD_PRESSURES, MAX_START = (30_000.0, 120_000.0), 1000.0
"""Pressures on the ground anywhere [Pa], and the largest height at which a log that misses its lift-off begins [m]."""
OTHER_DEVICES = {9: "TeleGPS", 18: "MicroPeak 2", 20: "EasyMotor", 23: "EasyTimer 2"}
"""Devices by log formats that are not supported."""


def recognises(head: bytes) -> bool:
    text = _plain(head).decode("latin-1")
    if text.lstrip().startswith("{"):
        return '"log_format"' in text
    return bool(OLD_MARK.search(text)) and any(OLD_RECORD.match(line) for line in text.splitlines())


def read(log: bytes) -> list[Parsed]:
    if len(log) > MAX_LOG_SIZE:
        raise DamagedLog(f"found {len(log)} bytes, expected at most {MAX_LOG_SIZE}, the largest flash there is")
    log = _plain(log)
    settings, row = _settings(log)
    number = _setting(settings, "log.format")
    old = not settings.lstrip().startswith("{") and OLD_RECORD.match(_line(log, row)) is not None
    if number == TELEMINI_1 and not old:
        return _telemini_1(settings, log, row)
    layout = OLD_TELEMINI_1 if number == TELEMINI_1 else LAYOUTS.get(number or 0)
    if not number and old:
        layout = layout_in(settings, log, row)
    if layout is None:
        known = f"{number}, {OTHER_DEVICES[number]}," if number in OTHER_DEVICES else str(number) if number else "none"
        raise DamagedLog(f"found log format {known}, expected one with pressures: {', '.join(map(str, LAYOUTS))}")
    flash = old_form(log, row, settings, layout) if old else new_form(log, row, settings, layout)
    readings = [_reading(records, flash.settings, layout) for records in _flights(flash.records)]
    found: list[Parsed] = [reading for reading in readings if reading is not None]
    if not found:
        raise DamagedLog("found no samples, expected records of the letter A or P", row=row)
    return [*found, *flash.found]


def _plain(log: bytes) -> bytes:
    """A log without NUL padding, the NULs that UTF-16 puts between letters, and the byte order mark."""
    return log.translate(None, b"\0").lstrip(codecs.BOM_UTF8 + codecs.BOM_UTF16)


def _settings(log: bytes) -> tuple[str, int]:
    """The text above the first record, and the row of that record: the first of two in a row, because a setting may
    look like one."""
    lines = [line for _, block in blocks(log[:LARGEST_SETTINGS]) for line in block]
    records = [row for row, line in enumerate(lines, start=1) if HEX.match(line) or OLD_RECORD.match(line)]
    if not records:
        raise DamagedLog("found no records, expected lines of hex bytes below the settings", row=len(lines) or 1)
    row = next((one for one, other in pairwise(records) if other == one + 1), records[0])
    return "\n".join(lines[: row - 1]), row


def _line(log: bytes, row: int) -> str:
    return first_lines(log, after=row - 1, most=1)[0].strip()


def _setting(settings: str, name: str) -> int | None:
    """A number among the settings, regardless of how its name is joined; None if it is missing or "none"."""
    found = re.search(rf"(?i)\b(?:ms5607.)?{name}\b\"?\s*[:=]?\s*\"?(-?\d{{1,10}})\b", settings.replace("_", "-"))
    return None if found is None or int(found[1]) == NO_VALUE else int(found[1])


def _flights(records: Int[Octets, "record byte"]) -> list[Int[Octets, "record byte"]]:
    """The records of each flight, which begin with a record of the letter F."""
    starts = np.flatnonzero(records[:, 0] == FLIGHT)
    return [part for part in np.split(records, starts[starts > 0]) if len(part)]


def _reading(records: Int[Octets, "record byte"], settings: str, layout: RecordLayout) -> Reading | None:
    """The flight in records; None if they contain no samples."""
    time = seconds(number_at(records, -2, 2))
    samples = records[:, 0] == SAMPLE
    if not samples.any() and not layout.positions:
        samples, layout = records[:, 0] == PRESSURE, replace(layout, acceleration=None)
    if not samples.any():
        return None
    states = records[:, 0] == STATE
    events = entered(number_at(records[states], 0, 2), time[states], STATES)
    events = {name: when for name, when in events.items() if when > time[samples][0]}  # else it was entered before
    start = events.get("liftoff", float(time[samples][0]))
    head = records[records[:, 0] == FLIGHT][:1]
    series = [_samples(records[samples], _increasing(time[samples] - start), head, settings, layout)]
    if layout.positions and (fixes := records[:, 0] == POSITION).any():
        size = 4 if _setting(settings, "altitude.32") == 1 else 2
        series.append(_positions(records[fixes], _increasing(time[fixes] - start), size))
    flight = str(number_at(head, 2 if layout.size == 8 else 0, 2)[0]) if len(head) else _text(settings, "flight")
    return Reading(
        extra={"flight": flight} if flight else {},
        series=tuple(series),
        events={name: when - start for name, when in events.items()},
        device=_word(settings, "product") or layout.device,
        firmware=_word(settings, "software.version|firmware.version|version"),
        serial=_text(settings, "serial") or _text(settings, "serial.number"),
    )


def _increasing(time: Float[Array, "record"]) -> Float[Array, "record"]:
    """Times in which a tick just before its predecessor is replaced by the predecessor. [s]"""
    return np.maximum.accumulate(time)


def _text(settings: str, name: str) -> str:
    number = _setting(settings, name)
    return "" if number is None else str(number)


def _word(settings: str, names: str) -> str:
    found = re.search(
        rf"(?i)(?:^|[{{,])[\s\"]*(?:{names})\"?\s*[:=]?\s*\"?([\w][\w.\- ]{{0,40}})", settings, re.MULTILINE
    )
    return found[1].strip() if found else ""


def _samples(
    samples: Int[Octets, "record byte"],
    time: Float[Array, "record"],
    head: Int[Octets, "flight byte"],
    settings: str,
    layout: RecordLayout,
) -> Series:
    acceleration = None
    if layout.acceleration is not None and layout.ground is not None and len(head):
        signed = layout.size != 8
        counts = number_at(samples, layout.acceleration, 2, signed=signed)
        ground = int(number_at(head, layout.ground, 2, signed=signed)[0])
        acceleration = net_acceleration(counts, ground, *_gravities(settings))
    if not layout.counts:
        return Series(time, pressure=_real(mp3h6115(number_at(samples, 2, 2))), acceleration=acceleration)
    raw, raw_temperature = (number_at(samples, place, layout.counts) for place in (0, layout.counts))
    counts_as, temperature = ms5607(raw, raw_temperature, _coefficients(settings))
    pressure = _real(counts_as)
    altitude = _above_pad(pressure, number_at(head, layout.pad, 4)) if layout.pad is not None else None
    return Series(time, altitude, pressure=pressure, temperature=temperature, acceleration=acceleration)


def _above_pad(pressure: Float[Array, "record"], pad: Integers) -> Float[Array, "record"] | None:
    """Heights above the pad, whose pressure the record of the flight states; None without a plausible one. [m]"""
    if not len(pad) or not PAD_PRESSURES[0] < pad[0] < PAD_PRESSURES[1]:
        return None
    heights = np.asarray(pressure_height(pressure) - pressure_height(pad[:1].astype(float)))
    return heights if abs(float(np.nanmedian(heights[:10]))) < MAX_START else None


def _real(pressure: Float[Array, "record"]) -> Float[Array, "record"]:
    """Pressures with nan for invalid ones. Raises DamagedLog if all are invalid. [Pa]"""
    real = (pressure > 0) & (pressure < 130_000)
    if not real.any():
        raise DamagedLog("found no plausible pressure, expected other settings or another log format")
    return np.where(real, pressure, np.nan)


def _gravities(settings: str) -> tuple[int | None, int | None]:
    """Counts of the accelerometer with the nose up and down."""
    both = re.search(r"(?i)accel[ _-]cal\D{0,10}?(?:\+1g)?:?\s*(-?\d{1,6})\s*(?:-1g)?:?\s+(-?\d{1,6})", settings)
    if both:
        return int(both[1]), int(both[2])
    return _setting(settings, "accel-cal-plus"), _setting(settings, "accel-cal-minus")


def _coefficients(settings: str) -> Coefficients:
    """The sensor's own calibration. Raises DamagedLog if part of it is missing."""
    found = {}
    for place, name in enumerate((f.name for f in fields(Coefficients)), start=1):
        value = _setting(settings, f"(?:{name}|c{place})")
        if value is None or not 0 < value < 65536:
            raise DamagedLog(f"found no ms5607 {name} among the settings, expected it from 1 to 65535")
        found[name] = value
    return Coefficients(**found)


def _positions(fixes: Int[Octets, "record byte"], time: Float[Array, "record"], size: int) -> Series:
    """Positions [deg, m], whose altitudes have `size` bytes: older firmware fills only the lower half of four."""
    degrees = [number_at(fixes, place, 4, signed=True) * 1e-7 for place in (0, 4)]
    return Series(
        time,
        latitude=np.where(abs(degrees[0]) <= 90, degrees[0], np.nan),
        longitude=np.where(abs(degrees[1]) <= 180, degrees[1], np.nan),
        gps_altitude_msl=number_at(fixes, 8, size, signed=True).astype(float),
    )


def _telemini_1(settings: str, log: bytes, row: int) -> list[Parsed]:
    """The flight of a TeleMini 1: 2-byte words, the flight number first, then pressures and states (high bit set).

    Pressures are 0.1 s apart up to the drogue state, then 1 s.
    """
    data, damaged = bytearray(), Damaged()
    for first, lines in blocks(log, row - 1):
        for number, line in enumerate(lines, start=first):
            words = hex_bytes(line)
            if words is None:
                damaged.add(DamagedLog(f"found {shown(line)}, expected bytes in hex", row=number))
            data += words or b""
    flight, *rest = np.frombuffer(bytes(data[: len(data) // 2 * 2]), "<u2").tolist() or [0]
    times, counts, state_times, states, time = [], [], [], [], 0.0
    for word in rest:
        if word == 0xFFFF:
            break
        if word >= 0x8000:
            state_times.append(time)
            states.append(word & 0x7FFF)
        else:
            times.append(time)
            counts.append(word)
            time += 1.0 if states and states[-1] >= STATES["drogue"][0] else 0.1
    if not counts:
        raise DamagedLog("found no samples, expected words of 2 bytes", row=row)
    events = entered(np.array(states, np.int64), np.array(state_times), STATES)
    start = events.get("liftoff", 0.0)
    pressure = _real(mp3h6115(np.array(counts)))
    reading = Reading(
        extra={"flight": str(flight)},
        series=Series(np.array(times) - start, pressure=pressure),
        events={name: when - start for name, when in events.items()},
        device=_word(settings, "product") or "TeleMini 1",
        serial=_text(settings, "serial"),
    )
    return [reading, *damage(damaged, "lines", log)]


PARSER = Parser(
    "AltOS .eeprom",
    recognises,
    read,
    signs=(
        "log_format|log-format|Config version",
        "serial|serial-number",
        "flight",
        "ground_pres|product|Config version",
    ),
)
