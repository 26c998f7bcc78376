"""Common parts of the exports of flight simulators: columns with units, read as a simulation.

Every column states its unit; one without a unit or with an unknown name is dropped. Names are those of the programs in
English, and for a translated program the words in `fieldkit/data/sample_columns.toml`. A wrong word
loses a column but cannot change a number, because the unit must fit the quantity.
"""

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from fieldkit.errors import DamagedLog
from fieldkit.importing.reading import Parsed, Reading
from fieldkit.importing.tables.columns import Channel, LogTable, read_columns
from fieldkit.importing.tables.headings import KNOWN_WORDS, QUANTITIES, Heading, heading, stated_unit, unit_named
from fieldkit.importing.tables.text import shown
from fieldkit.messages import amount, message
from fieldkit.units import UNITS

NAMES: Mapping[str, str] = {
    "time": "time",
    "altitude": "altitude",
    "altitude above sea level": "altitude_msl",
    "vertical velocity": "speed",
    "y velocity": "speed",
    "vel v": "speed",
    "velocity": "speed",
    "vertical acceleration": "acceleration",
    "y acceleration": "acceleration",
    "accel v": "acceleration",
    "thrust": "thrust",
    "drag force": "drag",
    "drag": "drag",
    "mass": "mass",
    "weight": "mass",
    "air pressure": "pressure",
    "air temperature": "temperature",
    "latitude": "latitude",
    "longitude": "longitude",
}
"""Columns by the words of their name, without the unit."""


_WORDS = KNOWN_WORDS["simulations"]
TIME_WORDS = _WORDS["time"]
"""Whole names of the time, without accents."""


def base_words(head: Heading) -> tuple[str, ...]:
    """The words of a column's name without those of its unit."""
    for length in (5, 4, 3, 2, 1):
        ending = "".join(head.words[-length:])
        if not head.unit and len(head.words) > length and any(unit_named(q, ending) for q in UNITS if q != "number"):
            return head.words[:-length]
    return head.words


def channel_of(head: Heading) -> str:
    """The channel of a simulation's column, or ""."""
    words = base_words(head)
    name = " ".join(words)
    if name in NAMES:
        return NAMES[name]
    if len(words) == 1 and words[0] in TIME_WORDS:
        return "time"
    if len(words) == 1 and words[0] in _WORDS["height"]:
        return "altitude"
    if any(stem in name for stem in _WORDS["vertical"]):
        if any(stem in name for stem in _WORDS["acceleration"]):
            return "acceleration"
        return "speed" * any(stem in name for stem in _WORDS["speed"])
    return ""


def read_simulation(
    log: bytes,
    headers: Sequence[str],
    device: str,
    *,
    after: int,
    separator: str | None = ",",
    comment: str = "",
    seconds: bool = False,
) -> tuple[LogTable, list[Parsed]]:
    """The rows of an export and what was found in them: a simulation for each start of the clock.

    `seconds` means that the program's clock has no unit in its header and is in seconds. Raises DamagedLog for an
    export without time or height, or whose height and speed contradict each other.
    """
    channels = _channels(headers, seconds)
    if missing := {"time", "altitude"} - {channel.name for channel in channels}:
        columns = ", ".join(map(shown, headers[:20]))
        raise DamagedLog(f"found no column of {min(missing)} with its unit among {columns}", row=after or None)
    table = read_columns(log, channels, after=after, separator=separator, comment=comment)
    for name in table.values.keys() - {"time"}:
        column = table.values[name]
        column[~(np.abs(column) < 1e12)] = np.nan
    parts, found = table.flights()
    readings = [
        Reading(row=int(part.rows[0]), describes="simulation", series=_vertical(part).series(), device=device)
        for part in parts
    ]
    return table, [*readings, *found]


def _channels(headers: Sequence[str], seconds: bool) -> list[Channel]:
    """The columns with a known name and a unit; only the first of each name."""
    channels: dict[str, Channel] = {}
    for place, spelled in enumerate(headers):
        head = heading(spelled)
        name = channel_of(head)
        if not name or name in channels:
            continue
        unit = unit_named(QUANTITIES[name], stated_unit(head, name))
        if name == "time" and seconds and not head.unit and len(head.words) == 1:
            unit = UNITS["time"]["s"]
        if unit is not None:
            channels[name] = Channel(name, place, unit, needed=name in ("time", "altitude"), header=head.spelled)
    return list(channels.values())


def _vertical(table: LogTable) -> LogTable:
    """The table, without its speed if that is not vertical.

    Raises DamagedLog if the climb does not match the speed: then a unit differs from the header.
    """
    if "speed" not in table.values:
        return table
    time, height, speed = (table.values[name] for name in ("time", "altitude", "speed"))
    whole = np.isfinite(height) & np.isfinite(speed)
    t, h, v = time[whole], height[whole], speed[whole]
    top = int(np.argmax(h)) if len(h) else 0
    rise = float(h[top] - h[0]) if len(h) else 0.0
    if top < 8 or rise < 3.0:
        return table
    climbed = np.trapezoid(v[: top + 1], t[: top + 1])
    if not 0.7 < climbed / rise < 2.0:
        by_height, by_speed = amount(rise, "m"), amount(float(climbed), "m")
        found = f"found a climb of {by_height} by height and of {by_speed} by speed, expected units that agree"
        raise DamagedLog(message(found))
    fall = float(h[top] - h[-1])
    if fall > 0.2 * rise and np.trapezoid(v[top:], t[top:]) > -0.5 * fall:
        return replace(table, values={name: column for name, column in table.values.items() if name != "speed"})
    return table
