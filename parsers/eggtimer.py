"""Eggtimer (Classic, TRS, Quantum): the text that it prints, a summary and a table `T,Alt,...` for each flight.

Neither text names its units. The Classic (`T,Alt,VRaw,VFilt`) prints feet. For the others the fall settles it:
near the top of an undisturbed flight the height changes by 9.8 m/s^2 or by 32 ft/s^2. Where that is not to be
seen the log is refused, and a unit in the header (`Alt_ft`, `Alt_m`) mends it. `T` is in ms or in s, as its
steps of a tenth or a twentieth of a second show. A column of events holds the altitude at its event, else zero.
"""

import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from fieldkit.columns import Channel, Table, read_columns
from fieldkit.errors import DamagedLog
from fieldkit.flight import Series
from fieldkit.logtext import decode
from fieldkit.parsing import Found, Note, Parser, Reading
from fieldkit.safe_text import printable
from fieldkit.shapes import Array, Float
from fieldkit.tables import Heading, heading_of, lines, marks
from fieldkit.units import UNITS, Unit

EVENTS = {"lda": "liftoff", "apogee": "apogee", "n-o": "nose-over", "drogue": "drogue", "main": "main"}
ALTITUDES = {"alt": "", "alt_ft": "ft", "alt (ft)": "ft", "alt(ft)": "ft", "alt_m": "m", "alt (m)": "m", "alt(m)": "m"}
CLASSIC = ("t", "alt", "vraw", "vfilt")
SPEEDS = ("fveloc", "veloc", "vfilt")
EARLY, LATE = (-3.0, -1.0), (-2.0, -0.4)
"""Where before the top the fall is looked at. [s]"""
FALLS = ((8.2, 17.0), (8.6, 13.0), (8.0, 12.5))
"""What it may be early and late, with some drag, and as what follows of them at no speed: gravity. [m/s^2]"""
OFF = 0.4
"""How far from the top the curve may have its own: a parachute that opens early cuts a flight short. [s]"""
SLOW_STEP = 2.0
"""A step of the clock above this is in ms: no Eggtimer takes so long in s. [1]"""
MOST_LABELS = 60
_LABEL = re.compile(r"\s*([A-Za-z@][A-Za-z @.\-]{2,30}?)\s*[:=,;\t]\s*(\S[^\r\n]{0,60}?)\s*$")


def _fits(names: Sequence[str]) -> bool:
    if len(names) < 3 or names[0] != "t" or names[1] not in ALTITUDES:
        return False
    return tuple(names[:4]) == CLASSIC or ("veloc" in names and bool({"lda", "n-o", "apogee"} & set(names)))


def recognises(head: bytes) -> bool:
    return any(_fits(found.names) for line in decode(head).splitlines() if (found := heading_of(line, 0, _fits)))


@dataclass(frozen=True, slots=True)
class _Part:
    """One flight of a text: its header, the row of its first line, and its lines, those of the summary apart."""

    head: Heading
    summary: Mapping[str, str]
    body: bytes


def read(log: bytes) -> list[Found]:
    if b"\0" in log[:200]:
        log = decode(log).encode()
    found: list[Found] = []
    parts = list(_parts(log))
    if not parts:
        raise DamagedLog("found no header, expected T,Alt,...")
    troubles: list[DamagedLog] = []
    for part in parts:
        try:
            found += _flight(part)
        except DamagedLog as error:
            troubles.append(error)
    if not found:
        raise troubles[0]
    return [*found, *troubles]


def _parts(log: bytes) -> Iterator[_Part]:
    """The flights of a text: each header begins one, and the labels between two tables belong to the lower."""
    head: Heading | None = None
    labels: dict[str, str] = {}
    summary: Mapping[str, str] = {}
    body = bytearray()
    for row, line in enumerate(lines(log), start=1):
        text = line[:400].decode("cp1252", "replace")
        if found := heading_of(text, row, _fits):
            if head:
                yield _Part(head, summary, bytes(body))
            head, summary, labels, body = found, labels, {}, bytearray()
        elif (label := _LABEL.match(text)) and len(labels) < MOST_LABELS:
            labels[printable(label[1])] = printable(label[2])
        elif head and text.strip():
            body += b"\n" * (row - head.row - 1 - body.count(b"\n")) + line.rstrip(b"\r") + b"\n"
    if head:
        yield _Part(head, summary or labels, bytes(body) if log.endswith(b"\n") else bytes(body[:-1]))


def _flight(part: _Part) -> list[Found]:
    head = part.head
    flags = [Channel(event, head.names.index(name)) for name, event in EVENTS.items() if name in head.names]
    speed = head.place(*SPEEDS)
    channels = [Channel("time", 0, needed=True, header="T"), Channel("altitude", 1, needed=True, header="Alt"), *flags]
    if speed is not None:
        channels.append(Channel("speed", speed))
    table = read_columns(
        part.body,
        channels,
        after=0,
        separator=head.separator,
        decimal="," if head.separator != "," and b"," in part.body[:2000] else ".",
        widths={len(head.names), len(head.names) + 1},
    ).forward()
    table = _lower(table, head.row)
    time = table.values["time"]
    steps = np.diff(time)
    time = time * (1e-3 if len(steps) and np.median(steps[:40]) > SLOW_STEP else 1.0)
    unit = (
        "ft"
        if tuple(head.names[:4]) == CLASSIC
        else ALTITUDES[head.names[1]] or unit_of_fall(time, table.values["altitude"])
    )
    if not unit:
        found = (
            "found altitudes without a unit that the fall does not settle, expected a header such as Alt_ft or Alt_m"
        )
        raise DamagedLog(found, row=head.row, column="Alt")
    length = UNITS["length"][unit]
    altitude, velocity = table.values["altitude"] * length.factor, table.get("speed")
    series = Series(time=time, altitude=altitude, speed=None if velocity is None else velocity * length.factor)
    events = marks(time, {flag.name: np.abs(table.values[flag.name]) for flag in flags})
    reading = Reading(_stated(part.summary, length), part.summary, series=series, events=events, device="Eggtimer")
    said = "" if ALTITUDES[head.names[1]] else f"bears no units; altitude is taken in {unit}, {_why(head)}"
    return [reading, *([Note(said, row=head.row)] if said else []), *table.found]


def _why(head: Heading) -> str:
    return "as the Classic prints it" if tuple(head.names[:4]) == CLASSIC else "as its fall near the top shows"


def _lower(table: Table, rows: int) -> Table:
    """A table whose rows are counted from the start of the file."""
    for item in table.found:
        if isinstance(item, DamagedLog) and item.row is not None:
            item.row += rows
    moved = tuple(
        replace(item, row=item.row + rows) if isinstance(item, Note) and item.row else item for item in table.found
    )
    return replace(table, rows=table.rows + rows, found=moved)


def unit_of_fall(time: Float[Array, "row"], altitude: Float[Array, "row"]) -> str:
    """`m` or `ft`, by how the height changes in the last seconds before its top; empty where neither is sure."""
    middle = np.median([altitude[:-4], altitude[1:-3], altitude[2:-2], altitude[3:-1], altitude[4:]], axis=0)
    clock = time[2:-2]
    if len(middle) < 40:
        return ""
    top = int(np.argmax(middle))
    if top > len(middle) - 5 or middle[top] - middle[-1] < 0.02 * (middle[top] - middle[0]):
        return ""
    fall, speed, peak = _fall(clock - clock[top], middle, *LATE)
    before, faster, _ = _fall(clock - clock[top], middle, *EARLY)
    if not (abs(peak) < OFF and faster > speed):
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
    """By what the speed changes between two times, the speed amid them, and when it would be zero; nan if not evenly.

    [1/s^2], [1/s], [s]
    """
    inside = (clock >= start) & (clock <= stop)
    nothing = (float("nan"),) * 3
    if inside.sum() < 12:
        return nothing
    middle = float(clock[inside].mean())
    curve = np.polynomial.polynomial.polyfit(clock[inside] - middle, height[inside], 2)
    rough = height[inside] - np.polynomial.polynomial.polyval(clock[inside] - middle, curve)
    fall, speed = -2 * float(curve[2]), float(curve[1])
    if np.sqrt((rough**2).mean()) > 0.01 * np.ptp(height[inside]) + 1 or fall <= 0:
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


PARSER = Parser("Eggtimer", recognises, read)
