"""The digits of a number as flyers type them: `1,250`, `1 250`, `281,3`, `1/2`, `1½`, and numbers in two units such as
`12'6"` and `1lb 3oz`. `fieldkit.units` interprets the units.
"""

import re
from dataclasses import dataclass

from fieldkit.errors import BadValue

MAX_TYPED_LENGTH = 200
"""Size limit of a typed number, including its unit and spaces. [character]"""
_PLAIN_MARKS = str.maketrans(
    dict.fromkeys("−–", "-")
    | dict.fromkeys("º˚", "°")
    | dict.fromkeys("′’ʹ", "'")
    | dict.fromkeys("″”“", '"')
    | dict.fromkeys("\N{NO-BREAK SPACE}\N{THIN SPACE}\N{NARROW NO-BREAK SPACE}", " ")
)
_FRACTIONS = str.maketrans({"½": " 1/2", "¼": " 1/4", "¾": " 3/4", "⅛": " 1/8", "⅜": " 3/8", "⅝": " 5/8", "⅞": " 7/8"})
_DIGITS = r"(?:\d{1,3}(?: \d{3})+(?![\d.,]* *\d)[\d.,]*|\d[\d.,]*|[.,]\d+)(?:[eE][+-]?\d+)?"
_AMOUNT = rf"(?:(?:\d+[ -]+)?\d+/\d+|{_DIGITS})"
_NUMBER = rf"([+-]?)\s*({_AMOUNT})\s*([^\d\s].*)?$"
_TWO_NUMBERS = rf"(?i)([+-]?)\s*(\d+)\s*([a-z']+\.?)[\s,]*(?:and )?\s*({_AMOUNT})\s*([a-z'\"]+\.?)?$"
_GROUPED_THOUSANDS = r"[1-9]\d{0,2}([.,])\d{3}(?:\1\d{3})*"
"""Patterns, compiled when a number is typed: at import they would take 1.5 ms of every start."""


@dataclass(frozen=True, slots=True)
class TypedAmount:
    """A typed number: whether it is negative, its digits, and its unit, empty if none was typed.

    A number in two units has `more` digits in `more_unit`, which is empty if it was not typed: `12' 6`.
    """

    negative: bool
    digits: str
    unit: str
    more: str = ""
    more_unit: str = ""

    def signed(self, value: float) -> float:
        """The value, in any unit, with the sign that was typed."""
        return -value if self.negative else value


def plain_marks(text: str) -> str:
    """A text with plain hyphens, spaces, quotation marks, degree signs and fractions."""
    return text.translate(_FRACTIONS).translate(_PLAIN_MARKS).strip()


def typed_amount(text: str) -> TypedAmount | None:
    """The number in a text with its unit, None if the text is not one."""
    found = re.match(_NUMBER, plain_marks(text)) if len(text) <= MAX_TYPED_LENGTH else None
    return TypedAmount(found[1] == "-", found[2], (found[3] or "").strip()) if found else None


def typed_in_two(text: str) -> TypedAmount | None:
    """The number in two units in a text, None if the text is not one."""
    found = re.match(_TWO_NUMBERS, plain_marks(text)) if len(text) <= MAX_TYPED_LENGTH else None
    return TypedAmount(found[1] == "-", *found.groups(default="")[1:]) if found else None


def value_of(digits: str, *, customary: bool) -> float:
    """The value of digits such as `12.5`, `1,250`, `1 250` or `1 1/2`.

    A comma before three digits separates thousands in a `customary` unit, and a comma or point that is repeated or
    followed by the other does in any unit. Raises BadValue for a comma with two meanings, a denominator of zero, and
    digits that are not a number.
    """
    if "/" in digits:
        *whole, above, below = re.findall(r"\d+", digits)
        if not int(below):
            raise BadValue(f"found {digits[:40]!r}, expected a number")
        return sum(map(float, whole)) + float(above) / float(below)
    digits = digits.replace(" ", "")
    grouped = re.match(_GROUPED_THOUSANDS, digits)
    if grouped:
        mark, rest = grouped[1], digits[grouped.end() :]
        several = rest.startswith((",", ".")) or grouped[0].count(mark) > 1
        if several or (mark == "," and customary):
            digits = grouped[0].replace(mark, "") + rest
        elif mark == "," and not rest:
            one, other = digits.replace(",", ""), digits.replace(",", ".")
            raise BadValue(f"found {digits[:40]!r}, which may be {one} or {other}, expected an unambiguous number")
    try:
        return float(digits.replace(",", "."))
    except ValueError:
        raise BadValue(f"found {digits[:40]!r}, expected a number") from None
