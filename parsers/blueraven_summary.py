"""Blue Raven, the summary of its app: one `key,value unit` a line, what the logger itself made of a flight.

Units miss here and there (`Main chute descent rate,-23.5 feet`), rates of descent are negative, and the key of
the serial number is spelt `Searial`. The maximum by inertial navigation is kept apart from the altitude.
"""

import re
from collections.abc import Mapping
from datetime import datetime, timedelta

from fieldkit.errors import BadValue, DamagedLog
from fieldkit.logs.text import decode, lines_of, shown
from fieldkit.parsing import HEAD, Found, Parser, Reading
from fieldkit.safe_text import printable
from fieldkit.units import parse

STATED: Mapping[str, tuple[str, str, str]] = {
    "max altitude": ("apogee", "length", "ft"),
    "max velocity": ("top_speed", "speed", "ft/s"),
    "time to first burnout": ("burn_time", "time", "s"),
    "max motor burn acceleration": ("peak_accel", "acceleration", "g"),
    "main chute descent rate": ("descent_speed", "speed", "ft/s"),
    "pad altitude asl": ("site_elevation", "length", "ft"),
}
"""Lines that state a field of `Flight`: which, of what quantity, in which unit if none is given."""
EVENTS = {
    "time to first burnout": "burnout",
    "time to apo channel fire": "drogue",
    "time to main channel fire": "main",
    "time to third channel fire": "third channel",
    "time to fourth channel fire": "fourth channel",
}
_MONTHS = ("jan", "feb", "mar", "apr", "may", "jun", "jul", "aug", "sep", "oct", "nov", "dec")
_OURS = re.compile(
    r'^"?Max Altitude"?[,;\t].*?^"?(?:Launch (?:date|time)|Time to Apo channel fire)"?[,;\t]', re.M | re.S | re.I
)
_LINE = re.compile(r"\s*([^,;\t]+?)\s*[,;\t]\s*(.*?)[\s,;]*")
_DATE = re.compile(r"(\d{1,2})-([A-Za-z]{3})-(\d{2}|\d{4})$")


def recognises(head: bytes) -> bool:
    return _OURS.search("\n".join(lines_of(decode(head)))) is not None


def read(log: bytes) -> list[Found]:
    stated: dict[str, object] = {}
    events: dict[str, float] = {}
    extra: dict[str, str] = {}
    found: list[Found] = []
    for row, line in enumerate(lines_of(decode(log[:HEAD])), start=1):
        match = _LINE.fullmatch(line.replace('"', ""))
        spelled, value = match.groups() if match else ("", "")
        key = " ".join(spelled.lower().split())
        if not key or key in extra:
            continue
        extra[key] = value
        try:
            if key in STATED:
                name, quantity, unit = STATED[key]
                number = _number(value, quantity, unit)
                stated[name] = abs(number) if name == "descent_speed" else number
            if key in EVENTS:
                events[EVENTS[key]] = _number(value, "time", "s")
        except BadValue as error:
            found.append(DamagedLog(str(error), row=row, column=printable(spelled)))
    if "apogee" not in stated and not events:
        raise DamagedLog("found no figure of a flight, expected such as Max Altitude,1234.5 feet")
    lift_off, landing = _moment(extra, "launch time"), _moment(extra, "landing time")
    if lift_off:
        stated["date_time"] = lift_off
    if lift_off and landing:
        events["landing"] = (landing - lift_off) % timedelta(days=1) / timedelta(seconds=1)
    serial = extra.get("searial number") or extra.get("serial number") or ""
    return [
        Reading(
            stated,
            {printable(k): printable(v) for k, v in extra.items() if k not in STATED},
            events=events,
            device="Blue Raven",
            firmware=extra.get("firmware", ""),
            serial=serial.split()[0] if serial else "",
            part="summary",
        ),
        *found,
    ]


def _number(value: str, quantity: str, unit: str) -> float:
    """The SI value of a text; of a speed the unit may say how far and leave out in what time. Raises BadValue."""
    text = re.sub(r"/\s*s(ec)?$", "", value) if quantity == "speed" else value
    length = re.search(r"(feet|ft|m)$", text) if quantity == "speed" else None
    if length:
        text = text[: length.start()] + ("m/s" if length[1] == "m" else "ft/s")
    try:
        return parse(re.sub(r"\bGs$", "g", text), quantity, unit)
    except BadValue:
        raise BadValue(f"found {shown(value)}, expected a number in {unit}") from None


def _moment(lines: Mapping[str, str], key: str) -> datetime | None:
    """A time of day on the day of launch, or None where either is not to be read."""
    date = _DATE.match(lines.get("launch date", ""))
    if not date or date[2].lower() not in _MONTHS:
        return None
    year = int(date[3]) + (2000 if len(date[3]) == 2 else 0)
    try:
        day = datetime(year, _MONTHS.index(date[2].lower()) + 1, int(date[1]))
        return datetime.fromisoformat(f"{day:%Y-%m-%d}T{lines.get(key, '')}")
    except ValueError:
        return None


PARSER = Parser("Blue Raven summary", recognises, read)
