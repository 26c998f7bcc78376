"""Blue Raven, the summary from its app: one `key,value unit` per line with the logger's own results for a flight.

Some units are incomplete (`Main chute descent rate,-23.5 feet`), descent rates are negative, and the key of the serial
number is spelled `Searial`. The maximum by inertial navigation is stored separately from the altitude.
"""

import re
from collections.abc import Iterator, Mapping
from datetime import datetime, timedelta

from fieldkit.errors import BadValue, DamagedLog
from fieldkit.importing import HEAD, Parsed, Parser, Reading
from fieldkit.importing.tables.text import decode, lines_of, shown
from fieldkit.safe_text import printable
from fieldkit.units import parse

STATED_READOUTS: Mapping[str, tuple[str, str, str]] = {
    "max altitude": ("apogee", "length", "ft"),
    "max velocity": ("top_speed", "speed", "ft/s"),
    "time to first burnout": ("burn_time", "time", "s"),
    "max motor burn acceleration": ("peak_accel", "acceleration", "g"),
    "main chute descent rate": ("descent_speed", "speed", "ft/s"),
    "pad altitude asl": ("site_elevation", "length", "ft"),
}
"""Lines that state a field of `Flight`: the field, its quantity, and the unit if none is given."""
EVENTS = {
    "time to first burnout": "burnout",
    "time to apo channel fire": "drogue",
    "time to main channel fire": "main",
    "time to third channel fire": "third channel",
    "time to fourth channel fire": "fourth channel",
}
"""Lines that state the time of an event: its name."""
_MONTHS = ("jan", "feb", "mar", "apr", "may", "jun", "jul", "aug", "sep", "oct", "nov", "dec")
_FIRST_LINE = re.compile(r'^"?Max Altitude"?[,;\t]', re.M | re.I)
_LATER_LINE = re.compile(r'^"?(?:Launch (?:date|time)|Time to Apo channel fire)"?[,;\t]', re.M | re.I)
_MARK = re.compile(r"[,;\t]")
_PADDING = " \t\r\n\f\v,;"
"""Characters at the end of a line, from cells that a spreadsheet added."""
_DATE = re.compile(r"(\d{1,2})-([A-Za-z]{3})-(\d{2}|\d{4})$")


def recognises(head: bytes) -> bool:
    text = "\n".join(lines_of(decode(head)))
    first = _FIRST_LINE.search(text)
    return first is not None and _LATER_LINE.search(text, first.end()) is not None


def read(log: bytes) -> list[Parsed]:
    stated: dict[str, object] = {}
    events: dict[str, float] = {}
    fields: dict[str, str] = {}
    found: list[Parsed] = []
    for row, spelled, key, value in _lines(log):
        if key in fields:
            continue
        fields[key] = value
        try:
            if key in STATED_READOUTS:
                name, quantity, unit = STATED_READOUTS[key]
                number = _number(value, quantity, unit)
                stated[name] = abs(number) if name == "descent_speed" else number
            if key in EVENTS:
                events[EVENTS[key]] = _number(value, "time", "s")
        except BadValue as error:
            found.append(DamagedLog(str(error), row=row, column=printable(spelled)))
    if "apogee" not in stated and not events:
        raise DamagedLog("found no figure of a flight, expected one such as Max Altitude,1234.5 feet")
    return [_reading(stated, events, fields), *found]


def _lines(log: bytes) -> Iterator[tuple[int, str, str, str]]:
    """The row of each line, its key as spelled and in plain words, and its value."""
    for row, line in enumerate(lines_of(decode(log[:HEAD])), start=1):
        key, *values = _MARK.split(line.replace('"', "").lstrip(), maxsplit=1)
        if key.strip() and values:
            yield row, key.strip(), " ".join(key.lower().split()), values[0].lstrip().rstrip(_PADDING)


def _reading(stated: dict[str, object], events: dict[str, float], fields: Mapping[str, str]) -> Reading:
    """The flight, with the times of day from its lines."""
    lift_off, landing = _moment(fields, "launch time"), _moment(fields, "landing time")
    if lift_off:
        stated["date_time"] = lift_off
    if lift_off and landing:
        events["landing"] = (landing - lift_off) % timedelta(days=1) / timedelta(seconds=1)
    serial = fields.get("searial number") or fields.get("serial number") or ""
    return Reading(
        stated,
        {printable(k): printable(v) for k, v in fields.items() if k not in STATED_READOUTS},
        events=events,
        device="Blue Raven",
        firmware=fields.get("firmware", ""),
        serial=serial.split()[0] if serial else "",
        part="summary",
    )


def _number(value: str, quantity: str, unit: str) -> float:
    """The SI value of a text; the unit of a speed may lack the time (`feet`). Raises BadValue."""
    text = re.sub(r"/\s*s(ec)?$", "", value) if quantity == "speed" else value
    length = re.search(r"(feet|ft|m)$", text) if quantity == "speed" else None
    if length:
        text = text[: length.start()] + ("m/s" if length[1] == "m" else "ft/s")
    try:
        return parse(re.sub(r"\bGs$", "g", text), quantity, unit)
    except BadValue:
        raise BadValue(f"found {shown(value)}, expected a number in {unit}") from None


def _moment(lines: Mapping[str, str], key: str) -> datetime | None:
    """A time of day on the day of launch, or None if either is unreadable."""
    date = _DATE.match(lines.get("launch date", ""))
    if not date or date[2].lower() not in _MONTHS:
        return None
    year = int(date[3]) + (2000 if len(date[3]) == 2 else 0)
    try:
        day = datetime(year, _MONTHS.index(date[2].lower()) + 1, int(date[1]))
        return datetime.fromisoformat(f"{day:%Y-%m-%d}T{lines.get(key, '')}")
    except ValueError:
        return None


PARSER = Parser(
    "Blue Raven summary",
    recognises,
    read,
    signs=("Max Altitude", "Launch date|Launch time|Time to Apo channel fire", "Firmware", "Max Velocity"),
)
