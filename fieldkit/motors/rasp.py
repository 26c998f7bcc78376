"""RASP files (`.eng`): text, a header and a `seconds newtons` line per sample for each motor.

    ; AeroTech F24
    F24W 24 70 4-7 0.019 0.0629 AeroTech
    0.014 36.1
    2.13 0

Source: the format as ThrustCurve.org describes it, https://www.thrustcurve.org/info/raspformat.html.
"""

import re

from fieldkit.motors.draft import FileLine, MotorDraft, add_draft, decoded, delays
from fieldkit.motors.motor import Motor

_COMMENT = re.compile(r";|(?:^|\s)(?:#|//)")
_HEADER = "a header: name diameter_mm length_mm delays propellant_kg loaded_kg maker"


def read(data: bytes, source: str) -> list[Motor]:
    """The motors in a RASP file. Raises DamagedLog that names the line.

    Comments start with `;` anywhere in a line, with `#` or `//` at its start or after a space; a motor ends at the next
    header.
    """
    drafts: list[MotorDraft] = []
    row = 0
    for row, line in enumerate(decoded(data).splitlines(), start=1):
        place = FileLine(source, row)
        words = _COMMENT.split(line, maxsplit=1)[0].split()
        if len(words) == 2 and drafts:
            time, thrust = place.number(words[0], "time", "s"), place.number(words[1], "thrust", "N")
            drafts[-1].add(place, time, thrust)
        elif len(words) >= 6:
            add_draft(drafts, _header(words, place))
        elif words:
            expected = f"`seconds newtons` or {_HEADER}" if drafts else _HEADER
            raise place.damaged(f"found {' '.join(words)!r}, expected {expected}")
    if not drafts:
        raise FileLine(source, max(row, 1)).damaged(f"found no motor, expected {_HEADER}")
    return [draft.motor() for draft in drafts]


def _header(words: list[str], place: FileLine) -> MotorDraft:
    name, diameter, length, delay, propellant, loaded, *maker = words
    return MotorDraft(
        place=place,
        maker=" ".join(maker),
        designation=name,
        kind="",
        diameter=place.above(diameter, "diameter", "mm", 1.0) / 1e3,
        length=place.above(length, "length", "mm", 1.0) / 1e3,
        delays=delays(delay, place),
        propellant_mass=place.above(propellant, "propellant", "kg", 0.0),
        loaded_mass=place.above(loaded, "loaded mass", "kg", 0.0),
    )
