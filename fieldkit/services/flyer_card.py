"""The flyer's card as texts to edit, and their values."""

import re

from fieldkit import units
from fieldkit.errors import BadValue
from fieldkit.planning.rules import governing, known_rules, read_authorities
from fieldkit.quantities import ShownUnits
from fieldkit.settings import BIRTH, CERTIFICATIONS, MOST_IN_BOX, BoxedMotors, Settings

LONGEST_RAIL = 30.0
"""A rod or rail from here on is a typing error. [m]"""
_BOXED = re.compile(
    r"(?:(?P<count>\d{1,4})\s*[x×]\s*)?(?P<motor>\S(?:.*?\S)?)(?:\s+lot\s+(?P<lot>\S+))?", re.IGNORECASE
)


def card_texts(settings: Settings, system: str, box: tuple[BoxedMotors, ...]) -> dict[str, str]:
    """The card as text to edit, in the units of a system, with what is left in its `box`."""
    card, shown = settings.flyer, ShownUnits(system)
    level = "" if card.certification is None else "none" if card.certification == 0 else str(card.certification)
    boxed = ", ".join(f"{one.count} x {one.motor}{f' lot {one.lot}' if one.lot else ''}" for one in box if one.count)
    rails = ", ".join(f"{one / shown.length_factor:.4g} {shown.length_unit}" for one in card.rails)
    return {"certification": level, "born": card.born or "", "rules": settings.rules, "rails": rails, "box": boxed}


def read_card(name: str, text: str, unit: str = "m") -> object:
    """The value of an entry of the card from its text; a length without a unit is in `unit`. Raises BadValue."""
    match name:
        case "certification":
            levels = {"": None, "none": 0, **{str(level): level for level in CERTIFICATIONS}}
            if text.strip().casefold().removeprefix("l") not in levels:
                raise BadValue(f"found {text[:40]!r}, expected one of none, 1, 2, 3")
            return levels[text.strip().casefold().removeprefix("l")]
        case "born":
            if text.strip() and not re.fullmatch(BIRTH, text.strip()):
                raise BadValue(f"found {text[:40]!r}, expected a year or a date such as 2009-05-31")
            return text.strip() or None
        case "rules":
            if text.strip():
                from datetime import date

                governing(known_rules(), read_authorities(text), False, date.today())
            return text.strip()
        case "rails":
            return tuple(sorted(_rail(one.strip(), unit) for one in text.split(",") if one.strip()))
        case _:
            return tuple(_boxed(one.strip()) for one in text.split(",") if one.strip())


def _rail(text: str, unit: str) -> float:
    length = units.parse(text, "length", unit)
    if not 0 < length < LONGEST_RAIL:
        raise BadValue(f"found {text[:40]!r}, expected a length above zero, such as 3ft or 1.8m")
    return length


def _boxed(text: str) -> BoxedMotors:
    found = _BOXED.fullmatch(text)
    count = int(found["count"] or 1) if found else 0
    if found is None or not 0 < count <= MOST_IN_BOX:
        raise BadValue(f"found {text[:40]!r}, expected motors such as 3 x C6-5, 2 x D12-5 lot 0412")
    return BoxedMotors(found["motor"], count, found["lot"] or "")
