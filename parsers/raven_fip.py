"""Featherweight Raven, exported by its interface program: `Time@<channel>,<channel>,bILBA` for every channel.

Each channel has its own clock and length. A channel that has ended leaves two empty cells instead of three, so rows
have different widths. The digits of `bILBA` are flags: I, lift-off, burnout (the integrated speed begins to fall),
apogee (it has reached zero), as confirmed by real flights. Channels with brackets in their names were computed
later by the program. Hand-edited copies (`Time-...`, `Time (s)`, two channels) are also read, and so are those
that a spreadsheet saved with semicolons.
"""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace

import numpy as np

from fieldkit.errors import DamagedLog
from fieldkit.flight import Series
from fieldkit.importing import Parsed, Parser, Reading
from fieldkit.importing.tables.cell import is_grouped
from fieldkit.importing.tables.clocks import MAX_CLOCK, in_order
from fieldkit.importing.tables.columns import Channel, LogTable, read_columns
from fieldkit.importing.tables.header import find_header, header_or_damage
from fieldkit.importing.tables.layout import split
from fieldkit.importing.tables.text import lines, narrow
from fieldkit.shapes import Array, Float
from fieldkit.units import FOOT, STANDARD_GRAVITY, UNITS, Unit

FLAGS = "bilba"
CHANNELS: Mapping[str, tuple[str, Unit]] = {
    "axial accel (gs)": ("felt", Unit(STANDARD_GRAVITY)),
    "baro (atm)": ("pressure", UNITS["pressure"]["atm"]),
    "[altitude (baro-ft-agl)]": ("altitude", Unit(FOOT)),
    "altitude (ft-agl)": ("altitude", Unit(FOOT)),
    "[altitude (baro-ft-asl)]": ("altitude_msl", Unit(FOOT)),
    "[altitude (accel-ft)]": ("inertial_altitude", Unit(FOOT)),
    "velocity (accel-ft/sec)": ("inertial_speed", Unit(FOOT)),
    "[velocity (accel-ft/sec)]": ("inertial_speed", Unit(FOOT)),
    "temperature (f)": ("temperature", UNITS["temperature"]["f"]),
    "volts battery (v)": ("voltage", Unit(1.0)),
}
"""Channels by header; the logger's own come before computed ones."""
MAX_LOG_SIZE = 1 << 25
"""Larger than the exported memory of a Raven. [bytes]"""
EVENTS = {"liftoff": 2, "burnout": 3, "apogee": 4}
"""Index of each flag in a cell such as `b1100`."""


def _starts(names: Sequence[str]) -> list[int]:
    """Indices of the clocks of a header's channels, each followed by its values and flags; other columns may be
    added."""
    flags = [place for place, name in enumerate(names) if name == FLAGS and place >= 2]
    return [place - 2 for place in flags if names[place - 2].startswith("time")]


def _fits(names: Sequence[str]) -> bool:
    return bool(_starts(names))


def recognises(head: bytes) -> bool:
    return find_header(head, _fits) is not None


def read(log: bytes) -> list[Parsed]:
    if len(log) > MAX_LOG_SIZE:
        raise DamagedLog(f"found {len(log) >> 20} MB, expected at most {MAX_LOG_SIZE >> 20} MB of a Raven")
    log = narrow(log)
    head = header_or_damage(log, _fits, "Time@<channel>,<channel>,bILBA for every channel")
    starts, places = _starts(head.names), dict[str, int]()
    named = [name.replace("_", " ") for name in head.names]
    recorded = {named[start + 1]: start for start in reversed(starts)}
    for name, (channel, _) in CHANNELS.items():
        if name in recorded:
            places.setdefault(channel, recorded[name])
    if not places:
        raise DamagedLog("found no known channel, expected one such as Baro (Atm)", row=head.row)
    clocks = dict.fromkeys(places.values())
    wanted = [Channel(f"time {start}", start, header=head.names[start], becomes="time") for start in clocks]
    wanted += [
        Channel(name, start + 1, CHANNELS[named[start + 1]][1], header=head.names[start + 1])
        for name, start in places.items()
    ]
    flags = {str(start): start + 2 for start in clocks}
    whole = b"\n".join(_whole_rows(log, starts, len(head.names), head.separator.encode()))
    table = read_columns(whole, wanted, after=head.row, separator=head.separator, widths={len(head.names)}, words=flags)
    return [Reading(series=_clocks(table, places), events=_events(table), device="Raven"), *table.found]


def _whole_rows(log: bytes, starts: Sequence[int], width: int, mark: bytes) -> Iterator[bytes]:
    """The lines of a log with three cells for every channel, including those that have ended.

    A spreadsheet pads each line to the longest, so missing cells are detected by the flags, not by the length.
    """
    for line in lines(log):
        line = _unquoted(line.rstrip(b"\r"), mark)
        cells = line.split(mark)
        if len(cells) > starts[-1] + 2 and not any(cells[start + 2].strip(b" b01") for start in starts):
            yield line
            continue
        row, place, is_cut = list[bytes](), 0, True
        while len(row) < width:
            size = 3 if len(row) in starts else 1
            ended = size == 3 and place < len(cells) and not cells[place].strip()
            row += [b""] * 3 if ended else cells[place : place + size] or [b""]
            place += 2 if ended else size
            if len(row) == starts[-1] + 3:
                is_cut = place > len(cells)
        fits = not is_cut and not any(map(bytes.strip, cells[place:]))
        yield mark.join(row) if fits else line


def _unquoted(line: bytes, mark: bytes) -> bytes:
    """A line without quotation marks, and without the commas that a spreadsheet put between thousands in them."""
    if b'"' not in line or mark != b",":
        return line.replace(b'"', b"")
    cells = split(line.decode("utf-8", "replace"), mark.decode())
    return mark.join((cell.replace(",", "") if is_grouped(cell.strip()) else cell).encode() for cell in cells)


def _clocks(table: LogTable, places: Mapping[str, int]) -> tuple[Series, ...]:
    """The samples; channels that were sampled at the same times are grouped together."""
    found: list[Series] = []
    for name, place in places.items():
        time, values = in_order(table.values[f"time {place}"], table.values[name])
        if not len(time):
            continue
        same = next((i for i, series in enumerate(found) if np.array_equal(series.time, time)), None)
        if same is None:
            found.append(_series(Series(time=time), name, values))
        else:
            found[same] = _series(found[same], name, values)
    if not found:
        raise DamagedLog("found a header and no samples, expected at least one")
    return tuple(found)


def _series(series: Series, name: str, values: Float[Array, "time"]) -> Series:
    return series if np.isnan(values).all() else replace(series, **{name: values})


def _events(table: LogTable) -> dict[str, float]:
    """When each flag is first set on any channel, because some channels end before others. [s]"""
    events: dict[str, float] = {}
    for place, (known, which) in table.words.items():
        time = table.values[f"time {place}"]
        for event, digit in EVENTS.items():
            places = [i for i, word in enumerate(known) if len(word) == 5 and word[digit] == "1"]
            times = time[np.isin(which, places) & (np.abs(time) < MAX_CLOCK)]
            if len(times):
                events[event] = min(float(times.min()), events.get(event, np.inf))
    return events


PARSER = Parser(
    "Raven (FIP export)",
    recognises,
    read,
    signs=("bILBA", "Axial Accel (Gs)", "Baro (Atm)|[Altitude (Baro-Ft-AGL)]|Altitude (Ft-AGL)"),
)
