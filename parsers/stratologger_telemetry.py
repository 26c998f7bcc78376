"""StratoLogger live telemetry: a table of seconds and feet that a capture makes of the lines the unit sends.

The unit sends one altitude in feet a line and no clock; the seconds are those of arrival. Where it sends on the
pad already, its first line is the pad's elevation above sea level and the others are above the pad; where it sends
from launch on, all are. The first kind shows by a step down to about nothing after the first line.

Source: docs/telem.md (UND-ARC/StratoLogger).
"""

from datetime import datetime

import numpy as np

from fieldkit.errors import DamagedLog
from fieldkit.flight import Series
from fieldkit.logs.columns import Channel, read_columns
from fieldkit.logs.text import decode, shown
from fieldkit.parsing import HEAD, Found, Note, Parser, Reading
from fieldkit.units import FOOT, UNITS

TITLE = "StratoLogger live telemetry, captured by fieldkit"
ON_PAD = 30 * FOOT
"""Heights of a rocket that is still on its pad, by its own barometer. [m]"""
MOST_HEADER = 100
"""The row of columns is looked for among so many lines. [1]"""
CHANNELS = (
    Channel("time", 0, needed=True, header="seconds"),
    Channel("altitude", 1, UNITS["length"]["ft"], header="feet"),
)


def recognises(head: bytes) -> bool:
    return head.startswith(TITLE.encode())


def read(log: bytes) -> list[Found]:
    head = decode(log[:HEAD]).splitlines()[:MOST_HEADER]
    if "seconds,feet" not in head:
        raise DamagedLog("found no row seconds,feet, expected it before the samples", row=1)
    header = head.index("seconds,feet")
    table = read_columns(log, CHANNELS, after=header + 1, widths={2})
    notes = list(table.found)
    heard = ~np.isnan(table.values["altitude"])
    if not heard.all():
        lost = table.rows[~heard]
        notes.append(Note(f"is the first of {len(lost)} lines that were no number and are left out", int(lost[0])))
    stated: dict[str, object] = {}
    began = next((line.removeprefix("began,") for line in head[:header] if line.startswith("began,")), "")
    try:
        stated["date_time"] = datetime.fromisoformat(began).replace(tzinfo=None) if began else None
    except ValueError:
        notes.append(DamagedLog(f"found {shown(began)}, expected a date and time", row=2))
    time, height = table.values["time"][heard], table.values["altitude"][heard]
    if len(height) > 1 and abs(height[0]) > ON_PAD >= abs(height[1]):
        stated["site_elevation"] = float(height[0])
        time, height = time[1:], height[1:]
    if not len(height):
        raise DamagedLog("found no sample, expected rows of seconds,feet", row=header + 1)
    order = np.argsort(time, kind="stable")
    series = Series(time=time[order] - time.min(), altitude=height[order])
    return [Reading(stated, series=series, device="PerfectFlite StratoLogger"), *notes]


PARSER = Parser("PerfectFlite StratoLogger live telemetry", recognises, read)
