"""ARTS2 of Loki Research: text, 50 samples per second, in two exports.

The interpreted export has `# MET Acc Vel iAlt pAlt`: seconds, g, ft/s, ft from acceleration, ft from pressure. Its
names may be separated by spaces and its numbers by commas. The raw export, `MET,Acc(HI),Acc/Baro(LO),Baro(HI),State`,
contains converter counts whose scale is not publicly documented, so it is rejected. Whether `Acc` includes gravity is
determined from the rest on the pad.
"""

import re
from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from fieldkit.errors import DamagedLog
from fieldkit.flight import Series
from fieldkit.importing import HEAD, Note, Parsed, Parser, Reading
from fieldkit.importing.tables.columns import Channel, LogTable, read_columns
from fieldkit.importing.tables.header import SEPARATORS, find_header
from fieldkit.importing.tables.text import decode, lines_of
from fieldkit.units import FOOT, STANDARD_GRAVITY, Unit

NAMES = ("met", "acc", "vel", "ialt", "palt")
RAW_COLUMNS = ("met", "acc(hi)")
_INTERPRETED_HEADER = re.compile(r"^\s*(?:#[\s,;]*)?MET([\s,;]+)Acc\1Vel\1iAlt\1pAlt\s*$", re.IGNORECASE)
RESTING_SAMPLES = 25
"""Number of samples at the start, half a second, that are assumed to be on the pad. [1]"""


def _interpreted(head: bytes) -> tuple[int, str | None] | None:
    """The row of the interpreted header and the separator of the cells below it (None: whitespace), or None."""
    lines = lines_of(decode(head[:HEAD]))
    for row, line in enumerate(lines, start=1):
        if match := _INTERPRETED_HEADER.match(line):
            below = next((one for one in lines[row:] if one.strip() and not one.startswith("#")), "")
            separators = [mark for mark in SEPARATORS if below.count(mark) == len(NAMES) - 1]
            return row, separators[0] if separators else None if below else match[1].strip() or None
    return None


def _raw(names: Sequence[str]) -> bool:
    return tuple(name.lstrip("# ") for name in names[:2]) == RAW_COLUMNS


def recognises(head: bytes) -> bool:
    return _interpreted(head) is not None or find_header(head, _raw) is not None


def read(log: bytes) -> list[Parsed]:
    head = _interpreted(log)
    if head is None:
        if raw := find_header(log, _raw):
            hint = "found raw counts of an ARTS2, expected the interpreted export (MET Acc Vel iAlt pAlt)"
            raise DamagedLog(hint, row=raw.row)
        raise DamagedLog("found no header, expected # MET Acc Vel iAlt pAlt")
    units = (Unit(1.0), Unit(STANDARD_GRAVITY), Unit(FOOT), Unit(FOOT), Unit(FOOT))
    fields = ("time", "acc", "inertial_speed", "inertial_altitude", "altitude")
    channels = [
        Channel(field, place, unit, field == "time", NAMES[place])
        for place, (field, unit) in enumerate(zip(fields, units, strict=True))
    ]
    parts, found = read_columns(
        log, channels, after=head[0], separator=head[1], widths={len(NAMES)}, comment="#"
    ).flights()
    return [*(Reading(series=_series(part, found), device="ARTS2") for part in parts), *found]


def _series(table: LogTable, notes: list[Parsed]) -> Series:
    series = table.series()
    level = float(np.median(table.values["acc"][:RESTING_SAMPLES])) / STANDARD_GRAVITY
    if abs(level - 1) < 0.2:
        return replace(series, felt=table.values["acc"])
    if abs(level) < 0.2:
        return replace(series, acceleration=table.values["acc"])
    notes.append(Note(f"begins at {level:.3g} g, neither at rest nor weightless: acceleration is left out"))
    return series


PARSER = Parser("ARTS2", recognises, read, signs=("MET", "Acc|Acc(hi)", "Vel|Acc(lo)", "iAlt|Baro", "pAlt|Baro"))
