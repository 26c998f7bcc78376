"""Common parts of the raw records of Altus Metrum devices: clock, checksum, sensors, states.

Sources: the format notes of AltOS (altoslib, libaltos); MS5607-02BA03 data sheet, "Pressure and temperature
calculation" and "Second order temperature compensation"; MP3H6115A data sheet, transfer function.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from fieldkit.shapes import Array, Bool, Flags, Float, Int, Integers
from fieldkit.units import STANDARD_GRAVITY, ZERO_CELSIUS

TICK = 0.01
"""One tick of every AltOS clock. [s]"""
SEED = 0x5A
"""Initial value of the checksums of records and of radio lines."""
STEP_BACK = 100
"""A clock that decreases by at most this many ticks went backward; a larger decrease is a wraparound. [1]"""
MAX_RADIO_GAP = 2.0
"""If a state is entered during a longer radio gap, its time is unknown. [s]"""
NO_VALUE = 2_147_483_647
"""What AltOS writes for a missing number."""
LEAST_BOOST, AFTER_FLIGHT = 1.0, (-2.5, 0.5)
"""Acceleration net of gravity of a log that begins in the boost, and at its end, where the axis points anywhere. [g]"""
STATES: Mapping[str, tuple[int, ...]] = {
    "liftoff": (3,),
    "burnout": (4, 5),
    "drogue": (6,),
    "main": (7,),
    "landing": (8,),
}
"""The states that mark an event: 3 boost, 4 fast, 5 coast, 6 drogue, 7 main, 8 landed."""


def seconds(ticks: Int[Integers, "record"]) -> Float[Array, "record"]:
    """Times of records from their 16-bit ticks, which wrap every 655.36 s; the first keeps its own tick. [s]

    A tick may be slightly less than the one before it, as happens with AltOS clocks; then the time is as well.
    """
    ahead = np.diff(ticks, prepend=ticks[:1]) % 65536
    ahead[ahead >= 65536 - STEP_BACK] -= 65536
    times: Array = (ticks[:1] + np.cumsum(ahead)) * TICK
    return times


def sound(records: Int[Any, "record byte"]) -> Bool[Flags, "record"]:
    """Which records have a valid checksum: their bytes and the seed add up to 0 modulo 256."""
    return np.asarray((records.sum(axis=1) + SEED) % 256 == 0)


@dataclass(frozen=True, slots=True)
class Coefficients:
    """C1 to C6 of an MS5607, with the names of the data sheet."""

    sens: int
    off: int
    tcs: int
    tco: int
    tref: int
    tempsens: int


def ms5607(
    pressure: Int[Integers, "record"], temperature: Int[Integers, "record"], c: Coefficients
) -> tuple[Float[Array, "record"], Float[Array, "record"]]:
    """Pressure [Pa] and temperature [K] from the counts of an MS5607, compensated as in its data sheet."""
    d1, d2 = pressure.astype(np.int64), temperature.astype(np.int64)
    dt = d2 - (c.tref << 8)
    hundredths = 2000 + ((dt * c.tempsens) >> 23)
    off = (c.off << 17) + ((c.tco * dt) >> 6)
    sens = (c.sens << 16) + ((c.tcs * dt) >> 7)
    below, far_below = np.minimum(hundredths - 2000, 0), np.minimum(hundredths + 1500, 0)
    off = off - ((61 * below**2) >> 4) - 15 * far_below**2
    sens = sens - 2 * below**2 - 8 * far_below**2
    hundredths = hundredths - np.where(below < 0, dt**2 >> 31, 0)
    pascal = (((d1 * sens) >> 21) - off) >> 15
    return pascal.astype(float), hundredths / 100 + ZERO_CELSIUS


def mp3h6115(counts: Int[Integers, "record"]) -> Float[Array, "record"]:
    """Pressure from the counts of the MP3H6115A of TeleMetrum 1 and TeleMini 1. [Pa]

    The sensor's output is (0.009 p/kPa - 0.095) times its supply, for which the converter gives 16 * 2047 counts. Every
    pressure in exports of TeleMetrum 1 corresponds to an integer count.
    """
    return (counts / (16 * 2047) + 0.095) / 0.009 * 1000


def net_acceleration(
    counts: Int[Integers, "record"], ground: int | None, plus: int | None, minus: int | None
) -> Float[Array, "record"] | None:
    """Acceleration along the axis, net of gravity, from the counts of an accelerometer. [m/s^2]

    `plus` and `minus` are its counts with the nose up and down, `ground` those on the pad. None if one of them is
    unknown, or if the first samples match neither the pad nor a boost that ends in a descent or on the ground: then
    these are not the right counts.
    """
    if ground is None or plus is None or minus is None or plus == minus or not len(counts):
        return None
    gravities: Array = (counts - ground) / ((plus - minus) / 2)
    first, last = float(np.median(gravities[:10])), float(np.median(gravities[-10:]))
    in_boost = first > LEAST_BOOST and AFTER_FLIGHT[0] < last < AFTER_FLIGHT[1]
    return gravities * STANDARD_GRAVITY if abs(first) < 0.5 or in_boost else None


def entered(
    states: Float[Array, "row"] | Int[Any, "row"],
    time: Float[Array, "row"],
    which: Mapping[str, Sequence[int]] = STATES,
    blind: float = np.inf,
    *,
    in_packets: bool = False,
) -> dict[str, float]:
    """When the first of the states of each event was entered; a state may recur, or never occur. [s]

    A state that radio packets carry was entered since the packet before: halfway on average. If nothing was received
    for longer than `blind` before it, the time is unknown and the event is omitted.
    """
    firsts = {name: np.flatnonzero(np.isin(states, numbers)) for name, numbers in which.items()}
    known = {name: int(found[0]) for name, found in firsts.items() if len(found)}
    since = {name: float(time[row] - time[row - 1]) if row else 0.0 for name, row in known.items()}
    late = {name: gap / 2 if in_packets else 0.0 for name, gap in since.items()}
    return {name: float(time[row]) - late[name] for name, row in known.items() if since[name] <= blind}
