"""AltimeterCloud Nano and Mercury (Rocketry Limited): a block of labels and values, an empty row, then the table.

The table begins with `time(ms)`; its column names include their units. Older logs begin with the table. Labels and
values are side by side and are stored unchanged; an apogee among them counts as stated if it has a unit. The axis that
points up is determined from the rest before launch.
"""

import re
from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from fieldkit.errors import BadValue
from fieldkit.flight import Series
from fieldkit.importing import HEAD, Parsed, Parser, Reading
from fieldkit.importing.tables.columns import Channel, LogTable, read_columns
from fieldkit.importing.tables.header import Header, find_header, header_or_damage
from fieldkit.importing.tables.pad_state import upright
from fieldkit.importing.tables.text import decode, lines_of
from fieldkit.safe_text import printable
from fieldkit.shapes import Array, Float
from fieldkit.units import STANDARD_GRAVITY, UNITS, Unit, parse

CHANNELS: Mapping[str, tuple[str, Unit]] = {
    "time(ms)": ("time", Unit(1e-3)),
    "altitude(m)": ("altitude", Unit(1.0)),
    "velocity_pressure(m/s)": ("speed", Unit(1.0)),
    "pressure(pa)": ("pressure", Unit(1.0)),
    "pressure(hpa)": ("pressure", UNITS["pressure"]["hpa"]),
    "acceleration_x(mg)": ("acceleration_x", Unit(STANDARD_GRAVITY / 1000)),
    "acceleration_y(mg)": ("acceleration_y", Unit(STANDARD_GRAVITY / 1000)),
    "acceleration_z(mg)": ("acceleration_z", Unit(STANDARD_GRAVITY / 1000)),
}
AXES = ("acceleration_x", "acceleration_y", "acceleration_z")
LABELS = 40
"""Largest number of label rows before the table. [1]"""


def _fits(names: Sequence[str]) -> bool:
    """Whether names are those of its table, and none is an acceleration that it would leave unread."""
    unread = (name for name in names if name.startswith("accel") and name not in CHANNELS)
    return {"time(ms)", "altitude(m)"} <= set(names) and not any(unread)


def recognises(head: bytes) -> bool:
    return find_header(head, _fits) is not None


def read(log: bytes) -> list[Parsed]:
    head = header_or_damage(log, _fits, "time(ms),altitude(m),...")
    channels: list[Channel] = head.channels(CHANNELS)
    parts, found = read_columns(
        log, channels, after=head.row, separator=head.separator, widths={len(head.names)}
    ).flights()
    labels = _labels(log, head)
    serial = next((value for label, value in labels.items() if "serial" in label.lower()), "")
    firmware = next((value for label, value in labels.items() if "firmware" in label.lower()), "")
    readings = [
        Reading(series=_series(part), device="AltimeterCloud", firmware=firmware, serial=serial) for part in parts
    ]
    if len(readings) == 1:
        readings = [replace(readings[0], stated=_stated(labels), extra=labels)]
    return [*readings, *found]


def _series(table: LogTable) -> Series:
    series = table.series()
    axes = [table.values[name] for name in AXES if name in table.values]
    if len(axes) == 3:
        together: Float[Array, "axis row"] = np.array(axes)
        felt = upright(together, table.values["time"] < 0)
        series = replace(series, felt=felt, felt_total=np.sqrt((together**2).sum(axis=0)))
    return series


def _labels(log: bytes, head: Header) -> dict[str, str]:
    """The labels before the table and their values, which are next to each other."""
    labels: dict[str, str] = {}
    for line in lines_of(decode(log[:HEAD]))[: min(head.row - 1, LABELS)]:
        cells = [printable(cell.strip().strip('"')) for cell in line.split(head.separator)]
        labels |= {label: value for label, value in zip(cells[::2], cells[1::2], strict=False) if label and value}
    return labels


def _stated(labels: Mapping[str, str]) -> dict[str, object]:
    """The apogee that the altimeter states, if its label or value includes the unit. [m]"""
    for label, value in labels.items():
        match = re.fullmatch(r"(?:max(?:imum)? )?apogee(?: altitude)?\s*[(\[]?(m|ft|feet)?[)\]]?", label.lower())
        if match and (match[1] or value[-1:].isalpha()):
            try:
                return {"apogee": parse(value, "length", match[1] or "m")}
            except BadValue:
                continue
    return {}


PARSER = Parser(
    "AltimeterCloud (Nano, Mercury)",
    recognises,
    read,
    signs=("time(ms)", "altitude(m)", "velocity_pressure(m/s)|pressure(pa)|pressure(hpa)", "acceleration_x(mG)"),
)
