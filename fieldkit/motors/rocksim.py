"""RockSim files (`.rse`): XML, an `engine` with `eng-data` samples for each motor, masses in grams.

They are read as a stream, which gives every error a line number. A document type declaration is rejected before its
content is read, because only there can entities be defined that expand without limit or refer to other files.

Source: the format as ThrustCurve.org offers it for download, https://www.thrustcurve.org.
"""

import re
from xml.parsers.expat import ExpatError, ParserCreate

from fieldkit.errors import DamagedLog
from fieldkit.motors.draft import FileLine, MotorDraft, add_draft, decoded, delays, finished
from fieldkit.motors.motor import Motor

_KINDS = {"single-use": "SU", "reloadable": "reload", "hybrid": "hybrid"}


def read(data: bytes, source: str) -> tuple[list[Motor], list[DamagedLog]]:
    """The motors in a RockSim file, and the errors of damaged ones, each naming its line. Raises DamagedLog for
    any other file."""
    reader = _Reader(source)
    try:
        reader.parser.Parse(_text(data), True)
    except ExpatError as error:
        raise DamagedLog(f"found broken XML ({error})", row=error.lineno, source=source) from error
    except (LookupError, ValueError) as error:
        raise DamagedLog(f"found an encoding that cannot be read ({error})", row=1, source=source) from error
    if not (reader.drafts or reader.errors):
        raise DamagedLog("found no <engine>, expected an <engine-database> with one or more", row=1, source=source)
    return finished(reader.drafts, reader.errors)


def _text(data: bytes) -> bytes | str:
    """A file without padding at its end, decoded unless it states an encoding other than UTF-8."""
    declared = re.match(rb"\s*<\?xml[^>]{0,200}?encoding\s*=\s*[\"']([\w.-]{1,40})", data)
    if declared and declared[1].lower() != b"utf-8":
        return data.rstrip(b"\0\x1a")
    return decoded(data)


class _Reader:
    """Collects drafts while the XML parser runs."""

    def __init__(self, source: str) -> None:
        self.source = source
        self.drafts: list[MotorDraft] = []
        self.errors: list[DamagedLog] = []
        self.skips = False
        self.parser = ParserCreate()
        self.parser.StartElementHandler = self._start
        self.parser.StartDoctypeDeclHandler = self._doctype

    @property
    def _place(self) -> FileLine:
        return FileLine(self.source, self.parser.CurrentLineNumber)

    def _doctype(self, *_: object) -> None:
        raise self._place.damaged("found a document type declaration, expected plain XML without <!DOCTYPE>")

    def _start(self, element: str, attributes: dict[str, str]) -> None:
        fields = _Fields(self._place, element, attributes)
        if element == "eng-data" and not (self.drafts or self.errors):
            raise self._place.damaged("found <eng-data>, expected an <engine> around it")
        self.skips = self.skips and element != "engine"
        try:
            if element == "engine":
                add_draft(self.drafts, _engine(fields))
            elif element == "eng-data" and not self.skips:
                place = self._place
                self.drafts[-1].add(place, place.number(fields["t"], "t", "s"), place.number(fields["f"], "f", "N"))
        except DamagedLog as error:
            self.errors.append(error)
            self.skips = True  # up to the next motor
            if element == "eng-data":
                self.drafts[-1].failed = True


class _Fields:
    """The attributes of an element; a missing one means a damaged file."""

    def __init__(self, place: FileLine, element: str, attributes: dict[str, str]) -> None:
        self.place = place
        self.element = element
        self.attributes = attributes

    def __getitem__(self, name: str) -> str:
        try:
            return self.attributes[name]
        except KeyError:
            raise self.place.damaged(f"found <{self.element}> without {name}=", name) from None

    def above(self, name: str, unit: str, least: float = 0.0) -> float:
        return self.place.above(self[name], name, unit, least)


def _engine(fields: _Fields) -> MotorDraft:
    return MotorDraft(
        place=fields.place,
        maker=fields.attributes.get("mfg", ""),
        designation=fields["code"].strip(),
        kind=_KINDS.get(fields.attributes.get("Type", "").lower(), ""),
        diameter=fields.above("dia", "mm", 1.0) / 1e3,
        length=fields.above("len", "mm", 1.0) / 1e3,
        delays=delays(fields.attributes.get("delays", ""), fields.place),
        propellant_mass=fields.above("propWt", "g") / 1e3,
        loaded_mass=fields.above("initWt", "g") / 1e3,
    )
