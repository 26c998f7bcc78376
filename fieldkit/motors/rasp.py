"""RASP files (`.eng`): text, a header and a `seconds newtons` line per sample for each motor.

    ; AeroTech F24
    F24W 24 70 4-7 0.019 0.0629 AeroTech
    0.014 36.1
    2.13 0

Source: the format as ThrustCurve.org describes it, https://www.thrustcurve.org/info/raspformat.html.
"""

import re

from fieldkit.errors import DamagedLog
from fieldkit.motors.draft import FileLine, MotorDraft, add_draft, decoded, delays, finished
from fieldkit.motors.motor import Motor

_COMMENT = re.compile(r";|(?:^|\s)(?:#|//)")
_LEAST_HEADER = 6
"""Fewest words of a header. [1]"""
_HEADER = "a header: name diameter_mm length_mm delays propellant_kg loaded_kg maker"


def read(data: bytes, source: str) -> tuple[list[Motor], list[DamagedLog]]:
    """The motors in a RASP file, and the errors of damaged ones, each naming its line. Raises DamagedLog without any.

    Comments start with `;` anywhere in a line, with `#` or `//` at its start or after a space; a motor ends at the next
    header.
    """
    drafts: list[MotorDraft] = []
    errors: list[DamagedLog] = []
    row, skips = 0, False
    for row, line in enumerate(decoded(data).splitlines(), start=1):
        words = _COMMENT.split(line, maxsplit=1)[0].split()
        skips = skips and len(words) < _LEAST_HEADER
        try:
            if words and not skips:
                _line(words, FileLine(source, row), drafts)
        except DamagedLog as error:
            if not drafts and len(words) < _LEAST_HEADER:
                raise
            errors.append(error)
            skips = True  # up to the next header
            if len(words) < _LEAST_HEADER:
                drafts[-1].failed = True
    if not (drafts or errors):
        raise FileLine(source, max(row, 1)).damaged(f"found no motor, expected {_HEADER}")
    return finished(drafts, errors)


def _line(words: list[str], place: FileLine, drafts: list[MotorDraft]) -> None:
    """Read a header or a sample. Raises DamagedLog."""
    if len(words) == 2 and drafts:
        time, thrust = place.number(words[0], "time", "s"), place.number(words[1], "thrust", "N")
        drafts[-1].add(place, time, thrust)
    elif len(words) >= _LEAST_HEADER:
        add_draft(drafts, _header(words, place))
    else:
        expected = f"`seconds newtons` or {_HEADER}" if drafts else _HEADER
        raise place.damaged(f"found {' '.join(words)!r}, expected {expected}")


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
