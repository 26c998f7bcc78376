"""RocketPy's CSV export of a simulation: `# Time (s),Z (m),Vz (m/s),...`, with the columns that the user chose.

The header is a comment. `Z` is the height above sea level, `Altitude AGL` that above the pad; names without brackets
are Euler parameters and angles, which are not read.
Format: RocketPy-Team/RocketPy, rocketpy/simulation/flight.py, `export_data`.
"""

from collections.abc import Sequence
from dataclasses import replace

from fieldkit.flight import Series
from fieldkit.importing import Parsed, Parser, Reading
from fieldkit.importing.tables.header import find_header, header_or_damage
from fieldkit.importing.tables.simulations import read_simulation

ABOVE_SEA, ABOVE_PAD = "z (m)", "altitude agl (m)"
NAMES = {ABOVE_SEA: "Altitude (m)", ABOVE_PAD: "Altitude (m)", "vz (m/s)": "Vertical velocity (m/s)"}
NAMES |= dict.fromkeys(("az (m/s²)", "az (m/s^2)", "az (m/s2)"), "Vertical acceleration (m/s²)")
"""Columns under the names that other simulators give them."""
SOLUTION = frozenset({"x (m)", "y (m)", "vx (m/s)", "vy (m/s)", "vz (m/s)", "e0", "e1", "e2", "e3", "speed (m/s)"})
"""Columns beside the height of which one is enough to recognize an export."""


def _fits(names: Sequence[str]) -> bool:
    heights = {ABOVE_SEA, ABOVE_PAD} & {*names}
    return names[0].lstrip("# ") == "time (s)" and bool(heights) and bool(SOLUTION & {*names})


def recognises(head: bytes) -> bool:
    return find_header(head, _fits) is not None


def read(log: bytes) -> list[Parsed]:
    head = header_or_damage(log, _fits, "Time (s),Z (m),Vz (m/s),...")
    height = ABOVE_PAD if ABOVE_PAD in head.names else ABOVE_SEA
    kept = [name.lstrip("# ") if name == height or name not in (ABOVE_SEA, ABOVE_PAD) else "" for name in head.names]
    names = [NAMES.get(name, name) for name in kept]
    found = read_simulation(log, names, "RocketPy", after=head.row, separator=head.separator)[1]
    if height == ABOVE_PAD:
        return found
    return [_above_pad(item) if isinstance(item, Reading) else item for item in found]


def _above_pad(reading: Reading) -> Reading:
    """A simulation whose heights begin at zero."""
    return replace(reading, series=tuple(_from_zero(series) for series in reading.clocks))


def _from_zero(series: Series) -> Series:
    return series if series.altitude is None else replace(series, altitude=series.altitude - series.altitude[0])


PARSER = Parser(
    "RocketPy simulation (CSV)",
    recognises,
    read,
    signs=("Time (s)", "Z (m)|Altitude AGL (m)", "Vz (m/s)|X (m)", "E0|Az (m/s²)|Vx (m/s)"),
    simulates=True,
)
