"""MicroPeak CSV: its program's export of a .mpd file, with pressures, heights and speeds in several units.

Pressures are from the device, heights and speeds from the program; its accelerations, which it also derives from the
heights, are not read.
Source: the header as listed with the format.
"""

from collections.abc import Sequence

from fieldkit.importing import Parsed, Parser, Reading
from fieldkit.importing.tables.columns import Channel, read_columns
from fieldkit.importing.tables.header import find_header, header_or_damage

COLUMNS = {"time": "time", "press(pa)": "pressure", "height(m)": "altitude", "speed(m/s)": "speed"}


def _fits(names: Sequence[str]) -> bool:
    return {"time", "press(pa)", "height(m)"} <= set(names)


def recognises(head: bytes) -> bool:
    return find_header(head, _fits) is not None


def read(log: bytes) -> list[Parsed]:
    head = header_or_damage(log, _fits, "Time, Press(Pa), Height(m)")
    channels = [
        Channel(channel, head.names.index(name), needed=channel == "time", header=name)
        for name, channel in COLUMNS.items()
        if name in head.names
    ]
    widths = {len(head.names)}
    parts, found = read_columns(log, channels, after=head.row, separator=head.separator, widths=widths).flights()
    return [*(Reading(series=part.series(), device="MicroPeak") for part in parts), *found]


PARSER = Parser("MicroPeak CSV", recognises, read, signs=("Time", "Press(Pa)", "Height(m)", "Speed(m/s)"))
