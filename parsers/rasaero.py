"""RASAero II's CSV export of a simulation: `Time (sec),Stage,Stage Time (sec),Mach Number,...,Altitude (ft),...`.

Rows are a hundredth of a second apart. Units stand in brackets; `lb` is a force for thrust and drag.
"""

import re

from fieldkit.errors import DamagedLog
from fieldkit.logs.simulations import read_simulation
from fieldkit.logs.text import decode, first_row
from fieldkit.parsing import HEAD, Found, Parser

_HEADER = re.compile(r"\s*Time \(sec\)\s*([,;\t])\s*Stage\s*\1\s*Stage Time \(sec\)\s*\1", re.IGNORECASE)


def recognises(head: bytes) -> bool:
    return bool(_HEADER.match(decode(head)))


def read(log: bytes) -> list[Found]:
    text = decode(log[:HEAD])
    found = _HEADER.match(text)
    if not found:
        raise DamagedLog("found no header of RASAero II, expected Time (sec),Stage,Stage Time (sec),...", row=1)
    row, names = first_row(text, found[1])
    return read_simulation(log, names, "RASAero II", after=row, separator=found[1])[1]


PARSER = Parser("RASAero II simulation (CSV)", recognises, read)
