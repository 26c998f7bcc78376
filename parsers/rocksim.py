"""RockSim's CSV export of a simulation.

One line of names, each followed by a space and its unit: `Time,Thrust N,Altitude Feet,Velocity Feet / Sec`. Cells have
leading spaces, and some names have one before the comma. Only time has no unit; it is in seconds, which is checked by
comparing the integrated speed with the height.
"""

import re

from fieldkit.errors import DamagedLog
from fieldkit.importing import HEAD, Parsed, Parser
from fieldkit.importing.tables.header import SEPARATORS
from fieldkit.importing.tables.headings import heading, stated_unit, unit_named
from fieldkit.importing.tables.layout import split
from fieldkit.importing.tables.simulations import base_words, channel_of, read_simulation
from fieldkit.importing.tables.text import decode, lines_of

_OF_A_SIMULATION = {"thrust": "force", "mass": "mass", "drag": "force"}
_SPACED_UNIT = re.compile(r" (?:Feet|Meters|Miles|Kilometers) / (?:Sec|Hour)", re.IGNORECASE)
"""A unit as only this program spells it."""
MOST_ABOVE = 5
"""Number of nonblank lines in which the names must be, after a title or two. [1]"""


def recognises(head: bytes) -> bool:
    return _header(head) is not None


def read(log: bytes) -> list[Parsed]:
    found = _header(log[:HEAD])
    if found is None:
        raise DamagedLog("found no header of RockSim, expected one such as Time,Thrust N,Altitude Feet", row=1)
    row, names, separator = found
    return read_simulation(log, names, "RockSim", after=row, separator=separator, seconds=True)[1]


def _header(head: bytes) -> tuple[int, list[str], str] | None:
    """The row of names, the names and the separator, or None if it is not from RockSim."""
    text = decode(head)
    first = [(row, line) for row, line in enumerate(lines_of(text), start=1) if line.strip()][:MOST_ABOVE]
    rows = ((row, split(line, separator), separator) for row, line in first for separator in SEPARATORS)
    return next((one for one in rows if _is_rocksims(one[1])), None)


def _is_rocksims(names: list[str]) -> bool:
    """Whether time comes first without a unit, height has its unit after a space, and a column exists only in
    simulations."""
    if not names or names[0].strip().lower() != "time" or any(mark in name for name in names for mark in "()[]_"):
        return False
    heads = [heading(name) for name in names]
    found = set()
    for head in heads:
        name = channel_of(head)
        if name == "altitude" and stated_unit(head, name) and len(base_words(head)) < len(head.words):
            found.add("height")
        quantity = _OF_A_SIMULATION.get(name)
        if (quantity and unit_named(quantity, stated_unit(head, name))) or _SPACED_UNIT.search(head.spelled):
            found.add("program")
    return found == {"height", "program"}


PARSER = Parser(
    "RockSim simulation (CSV)",
    recognises,
    read,
    signs=(
        "Time",
        "Altitude Feet|Altitude Meters|Altitude",
        "Velocity Feet / Sec|Velocity|y-Velocity",
        "Thrust N|Thrust|Mass Grams|Mass",
    ),
    simulates=True,
)
