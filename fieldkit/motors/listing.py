"""An entry for searches among the motors: its names without its curve."""

import re
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

from fieldkit.motors.motor import Motor
from fieldkit.motors.names import parse

_NAME = re.compile(r"(1/[248])?[A-O][\d.]*")
_BY_CASE = re.compile(r"([A-Z]{2})-\d+-\d+")
"""AMW's older designations: propellant, diameter and case."""


@dataclass(frozen=True, slots=True)
class Listing:
    """An entry for searches; `motor()` is the motor itself with its curve.

    `words` are its case and its propellant; `diameter` is in m and `delays` in s; `former` is its previous designation;
    `own` marks a motor from the user's files; `propellant` is empty if unknown.
    """

    maker: str
    name: str
    designation: str
    diameter: float
    delays: tuple[float, ...]
    available: bool
    words: str
    motor: Callable[[], Motor]
    own: bool = False
    former: str = ""
    propellant: str = ""

    @property
    def label(self) -> str:
        """Maker and designation: `AeroTech F24W`."""
        return f"{self.maker} {self.designation}"

    @property
    def letters(self) -> str:
        """The letters of its designation: for AMW's `GG-54-2550` the first two, for Estes' 13 mm motors the T."""
        if case := _BY_CASE.fullmatch(self.designation):
            return case[1]
        letters = parse(self.designation).letters
        return "T" if not letters and self.maker == "Estes" and self.diameter == 0.013 else letters

    def mentions(self, word: str) -> bool:
        """Whether a word in capitals is part of its data; F or F2 match only the start of its name."""
        if _NAME.fullmatch(word):
            return self.name.startswith(word)
        return word in f"{self.label} {self.diameter * 1e3:g}mm {self.words}".upper()


Listings = Mapping[str, Sequence[Listing]]
"""Listings by common name: `F24`."""
