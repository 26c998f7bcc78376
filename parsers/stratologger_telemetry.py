"""StratoLogger live telemetry: a table of seconds and feet that a capture makes of the lines the unit sends.

The unit sends one altitude in feet a line and no clock; the seconds are those of arrival. Where it sends on the
pad already, its first line is the pad's elevation above sea level and the others are above the pad; where it sends
from launch on, all are. The first kind shows by a step down to about nothing after the first line.

Source: docs/telem.md (UND-ARC/StratoLogger).
"""

import re
from datetime import datetime

import numpy as np

from fieldkit.errors import DamagedLog
from fieldkit.flight import Series
from fieldkit.logs.text import decode, shown
from fieldkit.parsing import Found, Note, Parser, Reading
from fieldkit.units import FOOT

TITLE = "StratoLogger live telemetry, captured by fieldkit"
ON_PAD = 30
"""Heights of a rocket that is still on its pad, by its own barometer. [ft]"""
ROW = re.compile(r"(\d{1,7}\.\d{3}),(-?\d{1,6})?")


def recognises(head: bytes) -> bool:
    return head.startswith(TITLE.encode())


def read(log: bytes) -> list[Found]:
    lines = decode(log).splitlines()
    if "seconds,feet" not in lines:
        raise DamagedLog("found no row seconds,feet, expected it before the samples", row=1)
    header = lines.index("seconds,feet")
    notes: list[Found] = []
    samples: list[tuple[float, int]] = []
    lost: list[int] = []
    for row, line in enumerate(lines[header + 1 :], start=header + 2):
        match = ROW.fullmatch(line)
        if not match:
            notes.append(DamagedLog(f"found {shown(line)}, expected seconds,feet", row=row))
        elif match[2] is None:
            lost.append(row)
        else:
            samples.append((float(match[1]), int(match[2])))
    if lost:
        notes.append(Note(f"is the first of {len(lost)} lines that were no number and are left out", lost[0]))
    stated: dict[str, object] = {}
    began = next((line.removeprefix("began,") for line in lines[:header] if line.startswith("began,")), "")
    try:
        stated["date_time"] = datetime.fromisoformat(began).replace(tzinfo=None) if began else None
    except ValueError:
        notes.append(DamagedLog(f"found {shown(began)}, expected a date and time", row=2))
    if len(samples) > 1 and abs(samples[0][1]) > ON_PAD >= abs(samples[1][1]):
        stated["site_elevation"] = samples.pop(0)[1] * FOOT
    if not samples:
        raise DamagedLog("found no sample, expected rows of seconds,feet", row=header + 1)
    time, feet = np.array(samples, dtype=np.float64).T
    order = np.argsort(time, kind="stable")
    series = Series(time=time[order] - time.min(), altitude=feet[order] * FOOT)
    return [Reading(stated, series=series, device="PerfectFlite StratoLogger"), *notes]


PARSER = Parser("PerfectFlite StratoLogger live telemetry", recognises, read)
