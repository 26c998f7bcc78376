"""RASAero II's CSV export of a simulation: `Time (sec),Stage,Stage Time (sec),Mach Number,...,Altitude (ft),...`.

Rows are a hundredth of a second apart. Units stand in brackets; `lb` is a force for thrust and drag.
"""

import re

from fieldkit.errors import DamagedLog
from fieldkit.logs.simulations import read_simulation
from fieldkit.logs.text import decode, first_row
from fieldkit.parsing import HEAD, Found, Parser

_HEADER = re.compile(r"\s*Time \(sec\)\s*,\s*Stage\s*,\s*Stage Time \(sec\)\s*,", re.IGNORECASE)


def recognises(head: bytes) -> bool:
    return bool(_HEADER.match(decode(head)))


def read(log: bytes) -> list[Found]:
    text = decode(log[:HEAD])
    if not _HEADER.match(text):
        raise DamagedLog("found no header of RASAero II, expected Time (sec),Stage,Stage Time (sec),...", row=1)
    row, names = first_row(text, ",")
    return read_simulation(log, names, "RASAero II", after=row)[1]


PARSER = Parser("RASAero II simulation (CSV)", recognises, read)
