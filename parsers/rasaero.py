"""RASAero II's CSV export of a simulation: `Time (sec),Stage,Stage Time (sec),Mach Number,...,Altitude (ft),...`.

Rows are a hundredth of a second apart. Units are in brackets; `lb` is a force for thrust and drag.
"""

from collections.abc import Sequence

from fieldkit.importing import Parsed, Parser
from fieldkit.importing.tables.header import find_header, header_or_damage
from fieldkit.importing.tables.simulations import read_simulation

COLUMNS = frozenset(
    {"mach number", "angle of attack (deg)", "cd", "cl", "thrust (lb)", "drag (lb)", "lift (lb)", "cg (in)", "cp (in)"}
    | {"stability margin (cal)", "weight (lb)", "accel-v (ft/sec^2)", "accel-h (ft/sec^2)", "vel-v (ft/sec)"}
    | {"vel-h (ft/sec)", "pitch attitude (deg)", "flight path angle (deg)", "stage", "stage time (sec)"}
)
"""Names that only this program writes, in a table whose other columns somebody may have deleted."""


def _fits(names: Sequence[str]) -> bool:
    return len(names) > 1 and names[0] == "time (sec)" and bool(COLUMNS & set(names))


def recognises(head: bytes) -> bool:
    return find_header(head, _fits) is not None


def read(log: bytes) -> list[Parsed]:
    head = header_or_damage(log, _fits, "Time (sec),Stage,Stage Time (sec),...")
    return read_simulation(log, head.names, "RASAero II", after=head.row, separator=head.separator)[1]


PARSER = Parser(
    "RASAero II simulation (CSV)",
    recognises,
    read,
    signs=("Time (sec)", "Stage", "Stage Time (sec)", "Mach Number"),
    simulates=True,
)
