"""AltiMulti, AltiDuo, TTGO Bear, AltiGPS and related altimeters by bdureau: their output over a serial line.

The output is `$start;`, one sentence per line, and `$end;`. `$data,flight,ms,m,degC,Pa,...,checksum;` are samples,
always metric. The checksum is the sum of the characters after `$` up to and including the comma before it, modulo 256.
A sentence with a wrong checksum is skipped and reported. Telemetry may be interleaved. The values after the pressure
depend on the board, which `$alticonfig` names; without it only the battery of a short sentence is certain. Eight-bit
boards print 16-bit numbers, so time and pressure wrap.
"""

import math
import re
from array import array
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace

import numpy as np

from fieldkit.errors import DamagedLog
from fieldkit.flight import Series
from fieldkit.importing import MOST_FLIGHTS, Note, Parsed, Parser, Reading
from fieldkit.importing.tables.cell import MAX_CELL_VALUE
from fieldkit.importing.tables.damage import Damaged
from fieldkit.importing.tables.text import narrow, shown
from fieldkit.quantities import counted
from fieldkit.shapes import Array, Float
from fieldkit.units import ZERO_CELSIUS

WRAP = 65_536.0
"""Period of numbers printed in 16 bits. [1]"""
GROUND = (60_000.0, 110_000.0)
"""Range of pressures at launch sites. [Pa]"""
MAX_SAMPLES = 100_000
"""More samples than any of these altimeters can store. [1]"""
WIDTH = 12
"""Largest number of values read from a sample. [1]"""
_SENTENCE = re.compile(rb"\$([A-Za-z]{1,20}(?:,[^$;\r\n]{0,400})?);")
_KNOWN_SENTENCE = re.compile(rb"\$(?:data|telemetry|alticonfig),[^;\r\n]{1,400};|\$start;\s{0,4}\$")


def checksum(body: bytes) -> int:
    """The checksum of a sentence: `data,0,50,12,21,100873,` gives 48."""
    return sum(body) % 256


def recognises(head: bytes) -> bool:
    return _KNOWN_SENTENCE.search(narrow(head)) is not None


def _sentences(log: bytes) -> Iterator[tuple[int, list[bytes] | DamagedLog]]:
    """The sentences with their row: fields if the checksum is valid, otherwise the error."""
    row, place = 1, 0
    for match in _SENTENCE.finditer(log):
        row, place = row + log.count(b"\n", place, match.start()), match.start()
        body, comma, check = match[1].rpartition(b",")
        if not comma:
            continue
        if check.strip().isdigit() and checksum(body + comma) == int(check):
            yield row, body.split(b",")
        else:
            found = shown(check.decode("ascii", "replace"))
            yield row, DamagedLog(f"found the checksum {found}, expected {checksum(body + comma)}", row=row)


def read(log: bytes) -> list[Parsed]:
    log, damaged = narrow(log), Damaged()
    flights: dict[int, array[float]] = {}
    live = array("d")
    board, firmware, samples = "", "", 0
    for row, sentence in _sentences(log):
        try:
            if isinstance(sentence, DamagedLog):
                raise sentence
            name, *cells = sentence
            if name == b"alticonfig" and len(cells) > 9:
                board, *version = (cell.decode("ascii", "replace").strip() for cell in cells[7:10])
                firmware = ".".join(version)
            elif name == b"telemetry":
                live.extend(_numbers(cells, 8, 8, row))
            elif name == b"data":
                numbers = _numbers(cells, 5, WIDTH, row)
                flights.setdefault(int(numbers[0]), array("d")).extend(numbers)
                samples += 1
        except DamagedLog as error:
            damaged.add(error)
        if samples > MAX_SAMPLES or len(live) > MAX_SAMPLES * 8 or len(flights) > MOST_FLIGHTS:
            more = f"{MOST_FLIGHTS} flights" if len(flights) > MOST_FLIGHTS else f"{MAX_SAMPLES} samples"
            raise DamagedLog(f"found more than {more}, more than any altimeter holds", row=row)
    found = damaged.reported("sentences")
    if log.rfind(b"$") > log.rfind(b";"):
        found.append(Note("ends within a sentence, left out", row=log.count(b"\n") + 1))
    device = f"bdureau {board}".strip()
    readings = [_flight(number, samples, board, found) for number, samples in flights.items()]
    if not readings and len(live) > 8:
        readings = [_live(np.array(live).reshape(-1, 8))]
    if not readings:
        raise damaged.first[0] if damaged.first else DamagedLog("found no sample of a flight, expected $data,...;")
    return [*(replace(reading, device=device, firmware=firmware) for reading in readings), *found]


def _numbers(cells: Sequence[bytes], least: int, width: int, row: int) -> list[float]:
    """The numbers of a sentence, padded with nan or cut to `width`. Raises DamagedLog."""
    try:
        numbers = [float(cell) for cell in cells[:width]]
    except ValueError:
        numbers = []
    if len(numbers) < least or not all(abs(number) <= MAX_CELL_VALUE for number in numbers):
        found = shown(b",".join(cells).decode("ascii", "replace"))
        raise DamagedLog(f"found {found}, expected at least {least} numbers", row=row)
    return numbers + [math.nan] * (width - len(numbers))


def _unwrapped(clock: Float[Array, "row"]) -> Float[Array, "row"]:
    """A clock in ms printed in 16 bits, with its wraparounds removed. [ms]"""
    return clock + WRAP * np.concatenate([[0], np.cumsum(np.diff(clock) < -WRAP / 2)])


def _pressure(printed: Float[Array, "row"], altitude: Float[Array, "row"]) -> Float[Array, "row"] | None:
    """Pressures that may have been printed in 16 bits, resolved with the altitude; nan if they do not match it. [Pa]

    None if the first is not a pressure of `GROUND`.
    """
    ground = [p for p in printed[0] + WRAP * np.arange(3) if GROUND[0] <= p <= GROUND[1]]
    if len(ground) != 1:
        return None
    expected = ground[0] * np.clip(1 - (altitude - altitude[0]) / 44_330, 0.01, 2) ** 5.256
    pressure: Float[Array, "row"] = printed + WRAP * np.round((expected - printed) / WRAP)
    return np.where(np.abs(pressure / expected - 1) < 0.1, pressure, np.nan)


def _flight(number: int, samples: "array[float]", board: str, notes: list[Parsed]) -> Reading:
    table = np.array(samples).reshape(-1, WIDTH)
    clock = _unwrapped(table[:, 1])
    order = np.argsort(clock, kind="stable")
    if (np.diff(clock) < 0).any():
        notes.append(Note(f"flight {number} has samples out of order, sorted"))
    table, clock = table[order], clock[order]
    pressure = _pressure(table[:, 4], table[:, 2])
    if pressure is None:
        notes.append(Note(f"flight {number} has pressures that are implausible in Pa, left out"))
    extra, unnamed = _of_board(table, board)
    if unnamed:
        notes.append(
            Note(
                f"flight {number} has {counted(unnamed, 'more number')} per sample; "
                "only the board's name says what is in them"
            )
        )
    series = Series(
        time=clock / 1000,
        altitude=table[:, 2],
        temperature=table[:, 3] + ZERO_CELSIUS,
        pressure=pressure,
        **extra,
    )
    return Reading({}, {"flight_number": str(number)}, series=series)


def _of_board(table: Float[Array, "row column"], board: str) -> tuple[Mapping[str, Array], int]:
    """The values that a board adds after the pressure, by channel, and how many numbers remain unnamed."""
    more = int((~np.isnan(table)).any(axis=0).sum()) - 5
    name = board.lower()
    if more == 1:
        return {"voltage": table[:, 5] / 100}, 0
    if "gps" in name and more >= 7:
        found = {"latitude": table[:, 6] / 1e5, "longitude": table[:, 7] / 1e5, "gps_altitude_msl": table[:, 8]}
        seen = table[:, 9] > 0
        return {"voltage": table[:, 5] / 100} | {k: np.where(seen, v, np.nan) for k, v in found.items()}, 0
    if "esp32" in name and more >= 4:
        total = np.sqrt((table[:, 6:9] ** 2).sum(axis=1)) / 1000
        return {"voltage": table[:, 5] / 100, "felt_total": total}, 0
    return {}, max(more, 0)


def _live(table: Float[Array, "row column"]) -> Reading:
    """A flight as reported by live telemetry, with the apogee that the altimeter stated."""
    clock = _unwrapped(table[:, 7])
    order = np.argsort(clock, kind="stable")
    table, time = table[order], clock[order] / 1000
    events = {
        name: float(time[np.argmax(table[:, place] == 1)])
        for name, place in {"liftoff": 1, "apogee": 2, "main": 4, "landing": 6}.items()
        if (table[:, place] == 1).any()
    }
    stated: dict[str, object] = {"apogee": float(table[-1, 3])} if "apogee" in events and table[-1, 3] > 0 else {}
    return Reading(stated, series=Series(time=time, altitude=table[:, 0]), events=events)


PARSER = Parser("bdureau AltiMulti and similar", recognises, read, signs=("$start", "$data|$telemetry|$alticonfig"))
