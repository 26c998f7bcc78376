"""OpenRocket's CSV export of a simulation.

The header is a comment, `# Time (s),Altitude (m),...`, unless somebody removed the mark. Between the rows there are
lines such as `# Event APOGEE occurred at t=5.2 seconds`. The user chooses the separator, the comment mark, the columns,
their units and the language of their names; a zero-width character in the brackets means "no unit".

Format: openrocket/openrocket, core/.../file/CSVExport.java.
"""

import re
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace

from fieldkit.errors import DamagedLog
from fieldkit.importing import HEAD, Parsed, Parser, Reading
from fieldkit.importing.tables.headings import folded, heading, unit_named
from fieldkit.importing.tables.simulations import TIME_WORDS, channel_of, read_simulation
from fieldkit.importing.tables.text import decode, lines_of

EVENTS = {
    "LIFTOFF": "liftoff",
    "BURNOUT": "burnout",
    "APOGEE": "apogee",
    "EJECTION_CHARGE": "ejection",
    "GROUND_HIT": "landing",
}
"""Events with a fieldkit name; others keep their own in lower case, and repeated ones are numbered."""
DEPLOYMENT, LONGEST_OPENING = "recovery_device_deployment", 1.0
"""The event of a recovery device as it is read, and its longest delay after the charge that deploys it. [s]"""
ZERO = 0.05
"""Time and height of the first row of a simulation are smaller. [any unit]"""
MOST_EVENTS = 200
"""Largest number of events. [1]"""
_EVENT = re.compile(r"Event ([A-Z][A-Z_]{1,40}) occurred at t=([+-]?[\d.]+(?:[eE][+-]?\d+)?) seconds")
_POINTS = re.compile(r"\d{1,9} data points written for \d{1,9} variables")
_STATE = re.compile(
    r"(?P<name>.*) \((?P<state>Up to date|Out of date|Data loaded from a file|Imported data|Not simulated yet)\)\s*$"
)
_HEADER = re.compile(r'"?(?P<mark>[^\w\s(",]{0,4})\s*(?P<first>[^\W\d_]{2,20}) \((?P<unit>[^()]{1,8})\)"?(?P<after>.?)')
_SIMULATED_CHANNELS = ("thrust", "mass", "drag", "drag coefficient", "mach number", "reynolds number", "cp location")


@dataclass(frozen=True, slots=True)
class ExportHeader:
    """The names of the columns, their row, and the marks of this export; `mark` is "" if there is none.

    `quoted` if a spreadsheet put every cell in quotation marks, including the comments.
    """

    names: tuple[str, ...]
    row: int
    separator: str | None
    mark: str
    quoted: bool


def recognises(head: bytes) -> bool:
    text = decode(head)
    header = _header(text)
    if header is None:
        return False
    if (header.mark and _starts_at_zero(text, header)) or _EVENT.search(text) or _POINTS.search(text):
        return True
    return any(" ".join(heading(name).words) in _SIMULATED_CHANNELS for name in header.names)


def _starts_at_zero(text: str, header: ExportHeader) -> bool:
    """Whether time and height begin at zero: a simulation begins at ignition, a logger waits on the pad."""
    below = (line for line in lines_of(text)[header.row :] if line.strip() and not line.startswith(header.mark))
    first = next(below, "").replace('"', "")
    cells = first.split(header.separator) if header.separator else first.split()
    names = [channel_of(heading(name)) for name in header.names]
    try:
        start = [float(cells[names.index(name)].replace(",", ".")) for name in ("time", "altitude")]
    except (ValueError, IndexError):
        return False
    return all(abs(value) < ZERO for value in start)


def read(log: bytes) -> list[Parsed]:
    head = decode(log[:HEAD])
    header = _header(head)
    if header is None:
        raise DamagedLog("found no header, expected one such as # Time (s),Altitude (m)", row=1)
    mark = '"' * header.quoted + (header.mark or _mark(head))
    table, found = read_simulation(
        log, header.names, "OpenRocket", after=header.row, separator=header.separator, comment=mark
    )
    events = _events(line for _, line in table.remarks)
    extra = _description(lines_of(head)[: header.row - 1], mark)
    return [replace(item, events=events, extra=extra) if isinstance(item, Reading) else item for item in found]


def _header(text: str) -> ExportHeader | None:
    """The line of names, in which time has its unit and every cell ends in brackets."""
    for row, line in enumerate(lines_of(text)[:500], start=1):
        match = _HEADER.match(line)
        if match and folded(match["first"]) in TIME_WORDS and unit_named("time", match["unit"]):
            after = match["after"]
            if after and after in match["mark"]:
                continue  # an empty cell before the names, not a comment
            separator = None if after in (" ", "") else after
            names = _split(line[match.start("first") :].replace('"', ""), separator)
            bracketed = all(name.endswith(")") for name in names)
            heights = any(channel_of(heading(name)) == "altitude" for name in names)
            if bracketed and (heights or match["mark"]) and len(names) > 1:
                return ExportHeader(tuple(names), row, separator, match["mark"], line.startswith('"'))
    return None


def _split(line: str, separator: str | None) -> list[str]:
    """The names of a header; spaces separate cells only after a bracket."""
    if separator is not None:
        return [name.strip() for name in line.strip().rstrip(separator).split(separator)]
    return re.split(r"(?<=\))\s+(?=[^\s(])", line.strip())


def _mark(text: str) -> str:
    """The comment mark of the events, if the header has lost its own."""
    match = re.search(r'^"?([^\w\s"]{1,4})\s*Event [A-Z_]+ occurred', text, re.MULTILINE)
    return match[1] if match else "#"


def _events(lines: Iterable[str]) -> dict[str, float]:
    """Times by event; the second burnout is `burnout 2`. [s]"""
    events: dict[str, float] = {}
    for line in lines:
        match = _EVENT.search(line)
        if not match or len(events) >= MOST_EVENTS:
            continue
        try:
            time = float(match[2])
        except ValueError:
            continue
        name = EVENTS.get(match[1], match[1].lower())
        number = 1 + sum(known.split()[0] == name for known in events)
        if abs(time) < 1e6:
            events[name if number == 1 else f"{name} {number}"] = time
    return _deployed(events)


def _deployed(events: dict[str, float]) -> dict[str, float]:
    """The events, with the first deployment of a recovery device as ejection if none follows the motor's charge: the
    program states a charge at the burnout of a plugged motor too."""
    charge = events.get("ejection")
    deployments = [when for name, when in events.items() if name.startswith(DEPLOYMENT)]
    if charge is None or not deployments or any(0 <= when - charge < LONGEST_OPENING for when in deployments):
        return events
    return {**events, "ejection": min(deployments), "ejection charge": charge}


def _description(lines: Sequence[str], mark: str) -> dict[str, str]:
    """The description of the simulation in the comments above the header."""
    texts = [line.removeprefix(mark).rstrip(' ",;\t').strip() for line in lines]
    extra: dict[str, str] = {}
    for line in texts:
        if match := _STATE.match(line):
            extra = {"simulation": match["name"][:200], "state": match["state"]}
            break
    if "Simulation warnings:" in texts:
        rest = texts[texts.index("Simulation warnings:") + 1 :]
        warnings = rest[: rest.index("")] if "" in rest else rest
        if warnings:
            extra["warnings"] = "; ".join(warnings)[:1000]
    return extra


PARSER = Parser(
    "OpenRocket simulation (CSV)",
    recognises,
    read,
    signs=(
        "data points written for",
        "Time (s)",
        "Altitude (m)|Altitude (ft)|Höhe (m)",
        "Event LIFTOFF occurred|Simulation warnings",
    ),
    simulates=True,
)
