"""Eggtimer (Classic, TRS, Quantum): the text that it prints, a summary and a table `T,Alt,...` for each flight.

Neither the summary nor the table states its units. The Classic (`T,Alt,VRaw,VFilt`) prints feet. For the others the
fall determines the unit: near the top of an undisturbed flight the acceleration is 9.8 m/s^2 or 32 ft/s^2. If that is
inconclusive, the log is rejected; adding a unit to the header (`Alt_ft`, `Alt_m`) fixes that. `T` is in ms or in s,
according to its steps of a tenth or a twentieth of a second. A column of events contains the altitude at its event,
otherwise zero.
"""

import codecs
import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import islice

import numpy as np

from fieldkit.errors import DamagedLog
from fieldkit.flight import Series
from fieldkit.importing import MOST_FLIGHTS, Note, Parsed, Parser, Reading
from fieldkit.importing.tables.columns import Channel, LogTable, read_columns
from fieldkit.importing.tables.damage import below
from fieldkit.importing.tables.header import Header, find_header, header_in
from fieldkit.importing.tables.pad_state import marks
from fieldkit.importing.tables.text import lines, narrow
from fieldkit.importing.tables.unit_inference import InferredUnit, settle_felt, settle_time_heights
from fieldkit.safe_text import printable
from fieldkit.shapes import Array, Float
from fieldkit.units import UNITS, Unit

EVENTS = {"lda": "liftoff", "apogee": "apogee", "n-o": "nose-over", "drogue": "drogue", "main": "main"}
"""Columns of events, with the names of the events."""
ALTITUDES = {"alt": "", "alt_ft": "ft", "alt (ft)": "ft", "alt(ft)": "ft", "alt_m": "m", "alt (m)": "m", "alt(m)": "m"}
"""Names of the column of altitudes, with the unit in each; "" if it has none."""
CLASSIC_COLUMNS = {"t", "alt", "vraw", "vfilt"}
"""Columns of the Classic."""
SPEEDS = ("fveloc", "veloc", "vfilt")
"""Columns with a speed, of which the first is used."""
EARLY_WINDOW, LATE_WINDOW = (-3.0, -1.0), (-2.0, -0.4)
"""Time windows before the top in which the fall is measured. [s]"""
FALLS = ((8.2, 17.0), (8.6, 13.0), (8.0, 12.5))
"""Ranges of the deceleration early and late, with some drag, and extrapolated to zero speed: gravity. [m/s^2]"""
MAX_TOP_OFFSET = 0.4
"""Largest time from the fitted to the measured top: early parachute deployment truncates a flight. [s]"""
SLOW_STEP = 2.0
"""A clock step above this is in ms, because no Eggtimer has a step this long in s. [1]"""
MOST_LABELS = 60
"""Largest number of labels above a table. [1]"""
_LABEL = re.compile(r"\s*([A-Za-z@][A-Za-z @.\-]{2,30}?)\s*[:=,;\t]\s*(\S[^\r\n]{0,60}?)\s*$")


def _fits(names: Sequence[str]) -> bool:
    if len(names) < 3 or "t" not in names or _height(names) is None:
        return False
    return set(names) >= CLASSIC_COLUMNS or ("veloc" in names and bool({"lda", "n-o", "apogee"} & set(names)))


def _height(names: Sequence[str]) -> int | None:
    """Index of the altitude in a header, or None."""
    return next((place for place, name in enumerate(names) if name in ALTITUDES), None)


def recognises(head: bytes) -> bool:
    return find_header(head, _fits) is not None


@dataclass(frozen=True, slots=True)
class _TextTable:
    """One table of a text: its header, the labels above it, and its beginning and end. [bytes]"""

    head: Header
    summary: Mapping[str, str]
    start: int
    stop: int


def read(log: bytes) -> list[Parsed]:
    log = narrow(log)
    found: list[Parsed] = []
    parts = list(islice(_parts(log), MOST_FLIGHTS + 1))
    if not parts:
        raise DamagedLog("found no header, expected T,Alt,...")
    troubles: list[DamagedLog] = []
    for part in parts:
        try:
            found += _flights(log, part)
        except DamagedLog as error:
            troubles.append(error)
    if not found:
        raise troubles[0]
    return [*found, *troubles]


def _parts(log: bytes) -> Iterator[_TextTable]:
    """The tables of a text: each ends where the labels or the header of the next one begin."""
    part: _TextTable | None = None
    labels: dict[str, str] = {}
    place = 0
    for row, line in enumerate(lines(log), start=1):
        begin, place = place, place + len(line) + 1
        if line[:1].isdigit() or not line.strip():
            continue
        text = line[:400].replace(codecs.BOM_UTF8, b"").decode("cp1252", "replace")
        if head := header_in(text, row, _fits):
            if part:
                yield replace(part, stop=min(part.stop, begin))
            part, labels = _TextTable(head, labels, place, len(log)), {}
        elif (label := _LABEL.match(text)) and len(labels) < MOST_LABELS:
            labels[printable(label[1])] = printable(label[2].rstrip(",;\t "))
            part = replace(part, stop=min(part.stop, begin)) if part else None
    if part:
        yield replace(part, summary=part.summary or labels)


def _flights(log: bytes, part: _TextTable) -> list[Parsed]:
    """The flight of one table, or several if its clock restarts."""
    head, last = part.head, part.stop == len(log)
    body, above = (log, 0) if last else (log[part.start : part.stop], head.row)
    flags = [Channel(event, head.names.index(name)) for name, event in EVENTS.items() if name in head.names]
    speed = head.place(*SPEEDS)
    channels = [
        Channel("time", head.names.index("t"), needed=True, header="T"),
        Channel("altitude", _height(head.names) or 0, needed=True, header="Alt"),
        *flags,
    ]
    channels += [] if speed is None else [Channel("speed", speed)]
    channels += [Channel("felt", head.names.index("accel"))] if "accel" in head.names else []
    widths = {len(head.names), len(head.names) + 1}
    after = head.row - above
    table = read_columns(body, channels, after=after, separator=head.separator, widths=widths)
    table.values["time"][:] = _seconds(table.values["time"])
    parts, remarks = table.flights()
    found: list[Parsed] = []
    for one in parts:
        unit = _unit(one, head)
        note = f"has no units; altitude is taken in {unit.unit}, {unit.why}"
        reading = _reading(one, part, unit.unit)
        found += [reading] if _spelled_unit(head) else [reading, Note(note, row=head.row)]
    return [*found, *(below(remark, above) for remark in remarks)]


def _spelled_unit(head: Header) -> str:
    """The unit in the name of the altitude column; "" if there is none."""
    return next(ALTITUDES[name] for name in head.names if name in ALTITUDES)


def _unit(table: LogTable, head: Header) -> InferredUnit:
    """The unit of the heights of a table. Raises DamagedLog if it cannot be determined."""
    if set(head.names) >= CLASSIC_COLUMNS:
        return InferredUnit("ft", "as the Classic prints it")
    if spelled := _spelled_unit(head):
        return InferredUnit(spelled, "as its column says")
    if near_top := unit_of_fall(table.values["time"], table.values["altitude"]):
        return InferredUnit(near_top, "as the deceleration just before apogee shows")
    samples = {name: table.values[name] for name in ("time", "altitude")}
    if settled := settle_time_heights(samples, {"time": "s"}).get("altitude"):
        return settled
    found = "found altitudes whose unit cannot be determined, expected a header such as Alt_ft or Alt_m"
    raise DamagedLog(found, row=head.row, column="Alt")


def _seconds(time: Float[Array, "row"]) -> Float[Array, "row"]:
    """A clock in seconds or milliseconds, converted to seconds. [s]"""
    steps = np.diff(time[:40])
    return time * (1e-3 if len(steps) and np.median(steps) > SLOW_STEP else 1.0)


def _reading(table: LogTable, part: _TextTable, unit: str) -> Reading:
    time, length, velocity = table.values["time"], UNITS["length"][unit], table.get("speed")
    series = Series(
        time=time,
        altitude=table.values["altitude"] * length.factor,
        speed=None if velocity is None else velocity * length.factor,
        felt=_felt(table.get("felt")),
    )
    events = marks(time, {event: np.abs(table.values[event]) for event in EVENTS.values() if event in table.values})
    stated = _stated(part.summary, length)
    return Reading(stated, part.summary, series=series, events=events, device="Eggtimer")


def _felt(printed: Float[Array, "row"] | None) -> Float[Array, "row"] | None:
    """The acceleration that an Eggtimer Proton prints, if it is one g at rest in some unit; otherwise None. [m/s^2]"""
    one = None if printed is None else settle_felt(printed)
    return None if printed is None or one is None else printed * UNITS["acceleration"][one.unit].factor


def unit_of_fall(time: Float[Array, "row"], altitude: Float[Array, "row"]) -> str:
    """`m` or `ft`, from the change of printed heights in the last seconds before the top; empty if neither is
    certain."""
    middle = np.median([altitude[:-4], altitude[1:-3], altitude[2:-2], altitude[3:-1], altitude[4:]], axis=0)
    clock = time[2:-2]
    if len(middle) < 40:
        return ""
    top = int(np.argmax(middle))
    if top > len(middle) - 5 or middle[top] - middle[-1] < 0.02 * (middle[top] - middle[0]):
        return ""
    fall, speed, peak = _fall(clock - clock[top], middle, *LATE_WINDOW)
    before, faster, _ = _fall(clock - clock[top], middle, *EARLY_WINDOW)
    if not (abs(peak) < MAX_TOP_OFFSET and faster > speed):
        return ""
    still = fall - (before - fall) / (faster**2 - speed**2) * speed**2
    for unit in ("m", "ft"):
        factor = UNITS["length"][unit].factor
        seen = zip((before, fall, still), FALLS, strict=True)
        if all(low <= change * factor <= high for change, (low, high) in seen):
            return unit
    return ""


def _fall(
    clock: Float[Array, "row"], height: Float[Array, "row"], start: float, stop: float
) -> tuple[float, float, float]:
    """Deceleration between two times [height/s^2], speed in the middle [height/s], and time of zero speed [s]; nan for
    an uneven or too short climb."""
    inside = (clock >= start) & (clock <= stop)
    nothing = (float("nan"),) * 3
    if len(np.unique(clock[inside])) < 12:
        return nothing
    middle = float(clock[inside].mean())
    curve = np.polynomial.polynomial.polyfit(clock[inside] - middle, height[inside], 2)
    residual = height[inside] - np.polynomial.polynomial.polyval(clock[inside] - middle, curve)
    fall, speed = -2 * float(curve[2]), float(curve[1])
    if np.sqrt((residual**2).mean()) > 0.01 * np.ptp(height[inside]) + 1 or fall <= 0:
        return nothing
    return fall, speed, middle + speed / fall


def _stated(summary: Mapping[str, str], length: Unit) -> dict[str, object]:
    """The apogee that a summary states, in the unit of its table. [m]"""
    for label, value in summary.items():
        if label.strip().lower() == "apogee" and (
            match := re.match(r"(\d{1,6}(?:\.\d+)?)\s*(ft|feet|m)?\W*$", value.lower())
        ):
            unit = UNITS["length"][match[2]] if match[2] else length
            return {"apogee": float(match[1]) * unit.factor}
    return {}


PARSER = Parser("Eggtimer", recognises, read, signs=("T", "Alt|Alt_ft|Alt_m", "VRaw|Veloc", "VFilt|LDA|Apogee|N-O"))
