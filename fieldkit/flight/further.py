"""Further columns of a flight table, which only some flights have: those with a meaning, typed, and the flyer's own."""

import re
from collections.abc import Callable, Sequence
from functools import lru_cache

from fieldkit import units
from fieldkit.errors import BadValue
from fieldkit.flight.columns import BY_NAME
from fieldkit.flight.flight import Flight
from fieldkit.flight.limits import check
from fieldkit.flight.table import MOTOR_TEMPERATURE
from fieldkit.messages import marked, message

LOT_WORDS = ({"lot"}, {"batch"})
"""What the header of a column of lots says, besides `FURTHER_WORDS`."""
FURTHER_WORDS = {"motor", "number", "no", "id"}
DEVICE_HEADERS = ("altimeter", "device", "logger", "altimeter_serial", "serial")
"""Headers of a column with the altimeter, in lower case."""
TIMERS = ("timer_1_s", "timer_2_s")
"""Columns with what each of two watches showed."""
JUDGED_COLUMNS = (*TIMERS, "eggs", "disqualified")
"""Columns in which a contest flight is judged."""
STATE_COLUMN, STATES = "drag_step", {"yes": True, "open": True, "no": False, "shut": False}
"""Column in which a flyer records whether the drag of a flight switched, and its values."""


def texts_under(flight: Flight, is_named: Callable[[str], bool]) -> list[str]:
    """The texts in the further columns whose headers are so named, without empty ones."""
    return [text.strip() for header, text in flight.extra.items() if is_named(header) and text.strip()]


def text_under(flight: Flight, is_named: Callable[[str], bool]) -> str:
    """The first text in the further columns whose header is so named, empty if there is none."""
    return next(iter(texts_under(flight, is_named)), "")


@lru_cache(maxsize=256)
def names_a_lot(header: str) -> bool:
    """Whether a column of a flyer's table has the lots of the motors, by its header: `motor_lot`, `Batch no.`."""
    return set(re.findall(r"[a-z]+", header.casefold())) - FURTHER_WORDS in LOT_WORDS


def names_a_device(header: str) -> bool:
    """Whether a column of a flyer's table has the altimeter, by its header."""
    return header.casefold().strip() in DEVICE_HEADERS


def drag_switches(flight: Flight) -> bool | None:
    """Whether the drag of a flight switches, as the flyer recorded it; None if not."""
    return STATES.get(flight.text(STATE_COLUMN).strip().lower())


def motor_temperature(plan: Flight) -> float | None:
    """The motor temperature declared with the plan, or None. [K] Raises BadValue for a non-number or an implausible
    value.
    """
    text = plan.text(MOTOR_TEMPERATURE)
    try:
        value = units.parse(text, "temperature", "c") if text else None
        return None if value is None else check(BY_NAME["temperature"], value, units.typed_unit(text, "c"))
    except BadValue as error:
        raise BadValue(message(f"motor temperature: {marked(error)}")) from error


def headers(flights: Sequence[Flight]) -> list[str]:
    """The headers of the further columns that flights have, in the order in which they first appear."""
    return list(dict.fromkeys(name for flight in flights for name in flight.extra))
