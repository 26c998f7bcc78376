"""MicroPeak CSV: what its program makes of a .mpd file, with pressures, heights and speeds in several units.

The pressures are the device's, the heights and speeds the program's; its accelerations, which it takes from the heights
too, are left to whoever wants them. Source: the header as listed with the format.
"""

from fieldkit.errors import DamagedLog
from fieldkit.logs.columns import Channel, read_columns
from fieldkit.logs.text import first_lines
from fieldkit.parsing import Found, Parser, Reading

COLUMNS = {"time": "time", "press(pa)": "pressure", "height(m)": "altitude", "speed(m/s)": "speed"}


def recognises(head: bytes) -> bool:
    return _header(head) is not None


def read(log: bytes) -> list[Found]:
    header = _header(log)
    if header is None:
        raise DamagedLog("found no header, expected Time, Press(Pa), Height(m)", row=1)
    row, names = header
    channels = [
        Channel(channel, names.index(name), needed=channel == "time", header=name)
        for name, channel in COLUMNS.items()
        if name in names
    ]
    parts, found = read_columns(log, channels, after=row, widths={len(names)}).flights()
    return [*(Reading(series=part.series(), device="MicroPeak") for part in parts), *found]


def _header(log: bytes) -> tuple[int, list[str]] | None:
    """The row and the names of the header, None if it is another's."""
    for row, line in enumerate(first_lines(log), start=1):
        names = [name.strip().lower() for name in line.split(",")]
        if names[:3] == ["time", "press(pa)", "height(m)"]:
            return row, names
        if line.strip():
            return None
    return None


PARSER = Parser("MicroPeak CSV", recognises, read)
