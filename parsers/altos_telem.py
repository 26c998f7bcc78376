"""AltOS .telem: telemetry received by a ground station, `TELEM` and a line of hex for each 32-byte packet.

Only packets with a valid line checksum and a valid radio checksum are used. Rockets on one channel are distinguished by
their serial numbers, and each becomes a reading; if nothing was received there is a gap. Lines of other kinds, and the
packets of 94 and 95 bytes of versions before 1.0, are counted and skipped.
Source: altoslib/AltosLink.java and the AltOS telemetry document (positions of fields within a packet).
"""

from collections import Counter
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from fieldkit.errors import DamagedLog
from fieldkit.flight import Series
from fieldkit.importing import Note, Parsed, Parser, Reading
from fieldkit.importing.tables.altos import MAX_RADIO_GAP, SEED, STATES, entered, mp3h6115, seconds
from fieldkit.importing.tables.altos_flash import Octets
from fieldkit.importing.tables.damage import Damaged, damage
from fieldkit.importing.tables.text import blocks, shown
from fieldkit.quantities import counted
from fieldkit.shapes import Array, Float, Int, Integers
from fieldkit.units import ZERO_CELSIUS

MAX_LOG_SIZE = 32 << 20
"""Largest file size: half a day of packets. [bytes]"""
PACKET, FRAME = 32, 36
"""Size of a packet, and of its line with the length before it and signal strength, status and checksum after it.
[bytes]"""
OLD_FRAMES = (94, 95)
"""Sizes of the packets of versions before 1.0. [bytes]"""
CHECKSUM_BIT = 0x80
"""Status bit that is set if the radio's own checksum was valid."""
SUBSTANCE = ("pressure", "altitude", "gps_altitude_msl")
"""Channels of which one is required, because a clock without any is useless."""


@dataclass(frozen=True, slots=True)
class PacketField:
    """A number in a packet: its position, its format, and its conversion to SI, by a scale and an offset or a
    function."""

    place: int
    kind: str
    scale: float = 1.0
    offset: float = 0.0
    convert: Callable[[Integers], Array] | None = None


FLIGHT_STATE = {"state": PacketField(5, "u1")}


def _kalman(place: int) -> Mapping[str, PacketField]:
    """Acceleration, speed and height, as every device transmits them. [m/s^2, m/s, m]"""
    return {
        "acceleration": PacketField(place, "<i2", 1 / 16),
        "speed": PacketField(place + 2, "<i2", 1 / 16),
        "altitude": PacketField(place + 4, "<i2"),
    }


def _air(pressure: int, temperature: int) -> Mapping[str, PacketField]:
    """Pressure and temperature, as devices with a digital sensor transmit them. [Pa, K]"""
    return {
        "pressure": PacketField(pressure, "<i4"),
        "temperature": PacketField(temperature, "<i2", 0.01, ZERO_CELSIUS),
    }


ANALOGUE = {**FLIGHT_STATE, "pressure": PacketField(8, "<i2", convert=mp3h6115), **_kalman(18)}
MINI = {**FLIGHT_STATE, **_air(12, 16), **_kalman(18)}
SATELLITES = {
    "fixed": PacketField(5, "u1"),
    "gps_altitude_msl": PacketField(6, "<i2"),
    "height_low": PacketField(6, "<u2"),
    "height_high": PacketField(31, "i1"),
    "mode": PacketField(25, "u1"),
    "latitude": PacketField(8, "<i4", 1e-7),
    "longitude": PacketField(12, "<i4", 1e-7),
}
PACKETS: Mapping[int, tuple[str, Mapping[str, PacketField]]] = {
    1: ("TeleMetrum 1", ANALOGUE),
    2: ("TeleMini 1", ANALOGUE),
    3: ("TeleNano", ANALOGUE),
    5: ("", SATELLITES),
    8: ("TeleMega", _air(8, 12)),
    9: ("TeleMega", {**FLIGHT_STATE, **_kalman(26)}),
    10: ("TeleMetrum 2", {**FLIGHT_STATE, **_air(8, 12), **_kalman(14)}),
    16: ("TeleMini 2", MINI),
    17: ("TeleMini 3", MINI),
    18: ("TeleMega", _air(8, 12)),
    19: ("TeleMega", _air(8, 12)),
    20: ("TeleMega", _air(8, 12)),
}
"""The supported packets by type: the device, and the fields."""
POSITION = 5
"""The type of a packet with a position."""
FIX_BIT, HIGH_BYTE_BIT = 0x10, 0x01
"""Bits of a position that mark a valid fix, and a height with a third byte."""


def recognises(head: bytes) -> bool:
    return any(line.startswith("TELEM ") for _, lines in blocks(head) for line in lines)


def read(log: bytes) -> list[Parsed]:
    if len(log) > MAX_LOG_SIZE:
        raise DamagedLog(f"found {len(log)} bytes, expected at most {MAX_LOG_SIZE}")
    packets, found = _packets(log)
    if not len(packets):
        raise found[0] if found and isinstance(found[0], DamagedLog) else DamagedLog("found no packet to read", row=1)
    serials = _numbers(packets, 0, "<u2")
    readings = [_reading(int(serial), packets[serials == serial]) for serial in dict.fromkeys(serials.tolist())]
    unread = Counter(packets[:, 4].tolist()) - Counter({kind: len(packets) for kind in (*PACKETS, 4, 6, 7, 11)})
    if unread:
        found.append(Note(f"packets of types {', '.join(map(str, sorted(unread)))} are not read"))
    with_samples = [reading for reading in readings if reading.series]
    if not with_samples:
        raise DamagedLog("found no packet with a height, a pressure or a position", row=1)
    return [*with_samples, *found]


def _packets(log: bytes) -> tuple[Int[Octets, "packet byte"], list[Parsed]]:
    """Complete packets, and notes about the others."""
    good, damaged, left_out = bytearray(), Damaged(), Counter[str]()
    for first, lines in blocks(log):
        for row, line in enumerate(lines, start=first):
            if line.startswith("TELEM "):
                frame = _bytes(line[6:])
                if frame is None or not _is_frame(frame):
                    damaged.add(DamagedLog(_complaint(line, frame), row=row))
                elif len(frame) != FRAME:
                    form = (
                        "of a version before 1.0"
                        if len(frame) - 4 in OLD_FRAMES
                        else f"of {counted(len(frame) - 4, 'byte')}"
                    )
                    left_out[f"packets {form} are not read"] += 1
                elif not frame[-2] & CHECKSUM_BIT:
                    left_out["packets with a bad radio checksum"] += 1
                else:
                    good += frame[1 : 1 + PACKET]
            elif line.strip():
                left_out["lines are not packets"] += 1
    notes = [Note(f"{count} {what}, left out") for what, count in left_out.items()]
    packets = np.frombuffer(bytes(good), np.uint8).reshape(-1, PACKET)
    return packets, [*damage(damaged, "packets", log), *notes]


def _bytes(text: str) -> bytes | None:
    try:
        return bytes.fromhex(text)
    except ValueError:
        return None


def _is_frame(frame: bytes) -> bool:
    return len(frame) > 4 and frame[0] == len(frame) - 2 and frame[-1] == (SEED + sum(frame[1:-1])) % 256


def _complaint(line: str, frame: bytes | None) -> str:
    if frame is None:
        return f"found {shown(line)}, expected TELEM and hex"
    if len(frame) < 5 or frame[0] != len(frame) - 2:
        return f"found a packet of {counted(len(frame), 'byte')}, expected {frame[0] + 2 if frame else FRAME}"
    return f"found checksum {frame[-1]:02x}, expected {(SEED + sum(frame[1:-1])) % 256:02x}"


def _reading(serial: int, packets: Int[Octets, "packet byte"]) -> Reading:
    """Everything received from one rocket: a clock for each type of packet, the one with its states first."""
    time = seconds(_numbers(packets, 2, "<u2"))
    kinds = packets[:, 4]
    states = np.isin(kinds, [kind for kind, (_, places) in PACKETS.items() if "state" in places]) & (
        packets[:, 5] <= 10
    )
    events = entered(packets[states, 5], time[states], blind=MAX_RADIO_GAP, in_packets=True)
    events = {name: when for name, when in events.items() if when > time[states][0]}
    boost = np.flatnonzero(packets[states, 5] == STATES["liftoff"][0])
    start = float(time[states][boost[0]]) if "liftoff" in events else float(time[0])
    order = sorted({*kinds.tolist()} & {*PACKETS}, key=lambda kind: (kind == POSITION, kind))
    series = [
        _series(kind, packets[kinds == kind], np.maximum.accumulate(time[kinds == kind] - start)) for kind in order
    ]
    device = next((PACKETS[kind][0] for kind in order if PACKETS[kind][0]), "")
    return Reading(
        series=tuple(one for one in series if one is not None),
        events={name: when - start for name, when in events.items()},
        device=device,
        serial=str(serial),
    )


def _series(kind: int, packets: Int[Octets, "packet byte"], time: Float[Array, "packet"]) -> Series | None:
    """The samples in packets of one type; None if they contain nothing plausible for a flight."""
    values: dict[str, Any] = {name: _values(packets, field) for name, field in PACKETS[kind][1].items()}
    values.pop("state", None)
    if "pressure" in values:
        pressure = values["pressure"]
        values["pressure"] = np.where((pressure > 0) & (pressure < 130_000), pressure, np.nan)
    if kind == POSITION:
        values = _position(values)
    if not any(np.isfinite(values[name]).any() for name in SUBSTANCE if name in values):
        return None
    return Series(time, **values)


def _position(values: dict[str, Any]) -> dict[str, Any]:
    """Positions with nan if there was no fix, and heights from all of their bytes. [deg, m]"""
    fixed = values.pop("fixed").astype(int) & FIX_BIT == FIX_BIT
    high = values.pop("mode").astype(int) & HIGH_BYTE_BIT == HIGH_BYTE_BIT
    whole = values.pop("height_low") + values.pop("height_high") * 65536.0
    values["gps_altitude_msl"] = np.where(high, whole, values["gps_altitude_msl"])
    return {name: np.where(fixed, each, np.nan) for name, each in values.items()}


def _values(packets: Int[Octets, "packet byte"], field: PacketField) -> Float[Array, "packet"]:
    counts = _numbers(packets, field.place, field.kind)
    return counts.astype(float) * field.scale + field.offset if field.convert is None else field.convert(counts)


def _numbers(packets: Int[Octets, "packet byte"], place: int, kind: str) -> Int[Integers, "packet"]:
    """The integer at a position of every packet."""
    raw = packets[:, place : place + np.dtype(kind).itemsize]
    return np.frombuffer(raw.tobytes(), kind).astype(np.int64)


PARSER = Parser("AltOS .telem", recognises, read, signs=("TELEM",))
