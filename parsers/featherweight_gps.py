"""Featherweight GPS: tracker recordings, ground station recordings, and copies with fewer columns.

`ALT` is in feet above sea level. Rows can be out of order or duplicated. The stated Unix time has been observed seven
hours off the UTC of the same row, so only its differences are used, from the first sample on. A ground station receives
several trackers, each of which becomes a separate reading.
"""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from itertools import pairwise

import numpy as np

from fieldkit.errors import DamagedLog
from fieldkit.flight import Series
from fieldkit.importing import HEAD, Note, Parsed, Parser, Reading
from fieldkit.importing.tables.clocks import in_order
from fieldkit.importing.tables.columns import LogTable, read_columns
from fieldkit.importing.tables.header import Header, find_header, header_or_damage
from fieldkit.importing.tables.text import decode, lines, lines_of, narrow
from fieldkit.quantities import counted
from fieldkit.safe_text import printable
from fieldkit.units import FOOT, Unit

CHANNELS: Mapping[str, tuple[str, Unit]] = {
    "unixtime": ("time", Unit(1.0)),
    "time": ("time", Unit(1.0)),
    "alt": ("gps_altitude_msl", Unit(FOOT)),
    "lat": ("latitude", Unit(1.0)),
    "lon": ("longitude", Unit(1.0)),
    "vertv": ("gps_speed", Unit(FOOT)),
    "fix": ("fix", Unit(1.0)),
}
RECEIVER_COLUMNS = ("alt", "lat", "lon", "vertv", "fix")
"""What a receiver records about its own position; height comes first."""
GROUND = {"tracker", "date", "time"}
DAY = 86_400.0
"""Length of a day. [s]"""
_MILLISECONDS = 1e11
"""Above this a Unix time is in milliseconds. [s]"""


def _fits(names: Sequence[str]) -> bool:
    if not {"alt", "lat", "lon"} <= set(names):
        return False
    return "unixtime" in names or set(names) >= GROUND or ("time" in names and not {"horzv", "vertv"}.isdisjoint(names))


def recognises(head: bytes) -> bool:
    return find_header(head, _fits) is not None


def read(log: bytes) -> list[Parsed]:
    head = header_or_damage(log, _fits, "UTCTIME,UNIXTIME,ALT,LAT,LON or TRACKER,DATE,TIME with ALT,LAT,LON")
    ground = set(head.names) >= GROUND
    text = b"\n".join(_seconds(narrow(log), head)) if ground else log
    tables = [
        read_columns(
            text,
            one.channels(CHANNELS),
            after=head.row,
            separator=head.separator,
            widths={len(head.names)},
            words={"tracker": head.names.index("tracker")} if ground else {},
        )
        for one in _receivers(head)
    ]
    table = max(tables, key=_rise) if len(tables) > 1 else tables[0]
    readings: list[Parsed] = []
    notes: list[Parsed] = []
    for name, part in _trackers(table):
        time = part.values["time"]
        if (time > _MILLISECONDS).any():
            time = time / 1000
        if ground:
            time = time + DAY * np.concatenate([[0], np.cumsum(np.diff(time) < -DAY / 2)])
        names = [name for name in part.values if name != "time"]
        ordered = in_order(time, *(part.values[channel] for channel in names))
        if not ordered[0].size:
            raise DamagedLog("found no time of day or Unix time, expected at least one")
        if (np.diff(time) < 0).any():
            notes.append(Note(f"has {counted(int((np.diff(time) < 0).sum()), 'row')} out of order, sorted"))
        extra = _utc(log, head, part, time)
        zero = 0.0 if head.place("unixtime") is None and not ground else ordered[0][0]
        series = _series(np.round(ordered[0] - zero, 3), dict(zip(names, ordered[1:], strict=True)))
        readings.append(Reading({}, extra, series=series, device="Featherweight GPS", serial=name))
    return [*readings, *notes, *table.found]


def _seconds(log: bytes, head: Header) -> Iterator[bytes]:
    """The lines of a ground station's log, with a time of day such as `14:09:44.6` converted to seconds."""
    mark, place = head.separator.encode(), head.names.index("time")
    for row, line in enumerate(lines(log), start=1):
        cells = line.rstrip(b"\r").replace(b'"', b"").split(mark)
        clock = cells[place].replace(b",", b".").split(b":") if len(cells) > place and row > head.row else []
        if len(clock) == 3:
            try:
                hours, minutes, seconds = map(float, clock)
            except ValueError:
                pass
            else:
                seconds += hours * 3600 + minutes * 60
                points = mark == b"," or any(b"." in cell for cell in cells[place + 1 :])
                cells[place] = (b"%.3f" % seconds).replace(b".", b"." if points else b",")
        yield mark.join(cells)


def _receivers(head: Header) -> list[Header]:
    """A header for each receiver of a log: a ground station may record its own position along with the tracker's, with
    the same column names. In each header the columns of the others have no name. `read` uses the one whose heights have
    the largest range."""
    starts = [place for place, name in enumerate(head.names) if name == "alt"]
    if len(starts) < 2:
        return [head]
    first = min(place for place, name in enumerate(head.names) if name in RECEIVER_COLUMNS)
    edges = [first, *starts[1:], len(head.names)]
    hidden = [
        tuple(
            "" if name in RECEIVER_COLUMNS and not begin <= place < end else name
            for place, name in enumerate(head.names)
        )
        for begin, end in pairwise(edges)
    ]
    return [replace(head, names=names) for names in hidden]


def _rise(table: LogTable) -> float:
    """Range of the heights of a table, without a few outliers. [m]"""
    height = table.values["gps_altitude_msl"]
    height = height[np.isfinite(height)]
    return float(np.subtract(*np.quantile(height, [0.98, 0.02]))) if height.size else -1.0


def _trackers(table: LogTable) -> list[tuple[str, LogTable]]:
    """The rows of each tracker, with its name; "" for a log of a single one."""
    if "tracker" not in table.words:
        return [("", table)]
    names, which = table.words["tracker"]
    return [(printable(name), table.pick(which == i)) for i, name in enumerate(names[:64]) if (which == i).any()]


def _series(time: np.ndarray, values: dict[str, np.ndarray]) -> Series:
    """The samples. Without a fix there is no position, and without a three-dimensional fix no height."""
    fix = values.pop("fix", None)
    for name, least in {"gps_altitude_msl": 3, "gps_speed": 3, "latitude": 2, "longitude": 2}.items():
        if name in values and fix is not None:
            values[name] = np.where(fix >= least, values[name], np.nan)
    return Series(time=time, **{name: column for name, column in values.items() if not np.isnan(column).all()})


def _utc(log: bytes, head: Header, table: LogTable, time: np.ndarray) -> dict[str, str]:
    """The stated UTC of the earliest row, if it is near the start of the log."""
    place = head.place("utctime")
    texts = lines_of(decode(log[:HEAD]))
    row = int(table.rows[int(np.argmin(time))])
    if place is None or row > len(texts):
        return {}
    cells = texts[row - 1].split(head.separator)
    return {"utc at the first sample": printable(cells[place].strip())} if place < len(cells) else {}


PARSER = Parser("Featherweight GPS", recognises, read, signs=("UNIXTIME|TRACKER|TIME", "ALT", "LAT", "LON", "VERTV"))
