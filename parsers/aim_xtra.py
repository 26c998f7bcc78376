"""Entacore AIM XTRA, the CSV export: groups of columns, each starting with its own `time` column.

Units are seconds from launch (from about -100), Pa, m, g and V. A group ends where its samples end, so the lower rows
are empty on the right. Flags have their own clock as well.
"""

from collections.abc import Mapping, Sequence
from itertools import pairwise

import numpy as np

from fieldkit.errors import DamagedLog
from fieldkit.flight import Series
from fieldkit.importing import Note, Parsed, Parser, Reading
from fieldkit.importing.tables.clocks import in_order
from fieldkit.importing.tables.columns import Channel, LogTable, read_columns
from fieldkit.importing.tables.header import find_header, header_or_damage
from fieldkit.importing.tables.pad_state import marks
from fieldkit.shapes import Array, Float
from fieldkit.units import STANDARD_GRAVITY, Unit

CHANNELS: Mapping[str, tuple[str, Unit]] = {
    "pressure": ("pressure", Unit(1.0)),
    "pressure msl": ("altitude_msl", Unit(1.0)),
    "pressure agl": ("altitude", Unit(1.0)),
    "acceleration": ("felt", Unit(STANDARD_GRAVITY)),
    "comp. bat. voltage": ("voltage", Unit(1.0)),
}
FLAGS = {
    "launch detect": "liftoff",
    "apogee detect": "apogee",
    "a on.": "output A",
    "b on": "output B",
    "c on": "output C",
    "d on": "output D",
}


def _fits(names: Sequence[str]) -> bool:
    return names.count("time") > 2 and "pressure agl" in names


def recognises(head: bytes) -> bool:
    return find_header(head, _fits) is not None


def read(log: bytes) -> list[Parsed]:
    head = header_or_damage(log, _fits, "groups of columns that begin with time, Pressure AGL among them")
    groups = _groups(head.names)
    wanted = []
    for clock, places in groups:
        wanted.append(Channel(str(clock), clock, header="time", becomes="time"))
        wanted += [_channel(head.names[place], place) for place in places]
    widths = range(head.names.index("time") + 2, len(head.names) + 1)  # empty cells may be missing on the right
    table = read_columns(log, wanted, after=head.row, separator=head.separator, widths=widths)
    series: list[Series] = []
    events: dict[str, float] = {}
    notes: list[Parsed] = []
    for clock, places in groups:
        time, *columns = in_order(table.values[str(clock)], *(table.values[str(place)] for place in places))
        named = {head.names[place]: column for place, column in zip(places, columns, strict=True)}
        if (np.diff(_known(table, clock)) < 0).any():
            notes.append(Note(f"has rows of {', '.join(named)} out of order, sorted"))
        events |= marks(time, {event: named[name] for name, event in FLAGS.items() if name in named})
        known = {CHANNELS[name][0]: column for name, column in named.items() if name in CHANNELS}
        channels = {name: column for name, column in known.items() if not np.isnan(column).all()}
        series += [Series(time=time, **channels)] if channels else []
    if not series:
        raise DamagedLog("found a header and no samples, expected at least one")
    return [Reading(series=tuple(series), events=events, device="AIM XTRA"), *notes, *table.found]


def _groups(names: Sequence[str]) -> list[tuple[int, list[int]]]:
    """The clock of each group of columns, and the known columns of the group, if there are any."""
    starts = [place for place, name in enumerate(names) if name == "time"]
    groups = [
        (clock, [place for place in range(clock + 1, end) if names[place] in {*CHANNELS, *FLAGS}])
        for clock, end in pairwise([*starts, len(names)])
    ]
    return [(clock, places) for clock, places in groups if places]


def _channel(name: str, place: int) -> Channel:
    """A column, whose name here is its index, because names repeat."""
    becomes, unit = CHANNELS.get(name, ("", Unit(1.0)))
    return Channel(str(place), place, unit, header=name, becomes=becomes)


def _known(table: LogTable, clock: int) -> Float[Array, "row"]:
    time = table.values[str(clock)]
    return time[np.isfinite(time)]


PARSER = Parser(
    "AIM XTRA",
    recognises,
    read,
    signs=("time", "Pressure AGL", "Pressure MSL", "acceleration", "launch detect", "apogee detect"),
)
