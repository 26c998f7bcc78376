"""RockSim's CSV export of a simulation.

One line of names, each followed by its unit after a blank: `Time,Thrust N,Altitude Feet,Velocity Feet / Sec`. Cells
have leading blanks, and some names one before their comma. Time alone has no unit; it counts seconds, and the climb
that the speed makes of them must be the one that the height shows.
"""

from fieldkit.errors import DamagedLog
from fieldkit.importing import HEAD, Found, Parser
from fieldkit.importing.tables.header import SEPARATORS
from fieldkit.importing.tables.headings import heading, stated_unit, unit_named
from fieldkit.importing.tables.layout import split
from fieldkit.importing.tables.simulations import base_words, channel_of, read_simulation
from fieldkit.importing.tables.text import decode, lines_of

_OF_A_SIMULATION = {"thrust": "force", "mass": "mass", "drag": "force"}


MOST_ABOVE = 5
"""Among so many lines that are not blank are the names, behind a title or two. [1]"""


def recognises(head: bytes) -> bool:
    return _header(head) is not None


def read(log: bytes) -> list[Found]:
    found = _header(log[:HEAD])
    if found is None:
        raise DamagedLog("found no header of RockSim, expected one such as Time,Thrust N,Altitude Feet", row=1)
    row, names, separator = found
    return read_simulation(log, names, "RockSim", after=row, separator=separator, seconds=True)[1]


def _header(head: bytes) -> tuple[int, list[str], str] | None:
    """The row of names, the names and what parts them, or None if none is RockSim's."""
    text = decode(head)
    first = [(row, line) for row, line in enumerate(lines_of(text), start=1) if line.strip()][:MOST_ABOVE]
    rows = ((row, split(line, separator), separator) for row, line in first for separator in SEPARATORS)
    return next((one for one in rows if _is_rocksims(one[1])), None)


def _is_rocksims(names: list[str]) -> bool:
    """Whether time comes first and bare, height has its unit after a blank, and something only a program knows too."""
    if not names or names[0].strip().lower() != "time" or any(mark in name for name in names for mark in "()[]_"):
        return False
    heads = [heading(name) for name in names]
    found = set()
    for head in heads:
        name = channel_of(head)
        if name == "altitude" and stated_unit(head, name) and len(base_words(head)) < len(head.words):
            found.add("height")
        quantity = _OF_A_SIMULATION.get(name)
        if quantity and unit_named(quantity, stated_unit(head, name)):
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
