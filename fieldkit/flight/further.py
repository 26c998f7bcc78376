"""Further columns of a flight table whose texts are names or the flyer's own."""

import re
from collections.abc import Callable, Sequence
from functools import lru_cache

from fieldkit.flight.flight import Flight

LOT_WORDS = ({"lot"}, {"batch"})
"""What the header of a column of lots says, besides `FURTHER_WORDS`."""
FURTHER_WORDS = {"motor", "number", "no", "id"}
DEVICE_HEADERS = ("altimeter", "device", "logger", "altimeter_serial", "serial")
"""Headers of a column with the altimeter, in lower case."""
TIMERS = ("timer_1_s", "timer_2_s")
"""Columns with what each of two watches showed."""
JUDGED_COLUMNS = (*TIMERS, "eggs", "disqualified")
"""Columns in which a contest flight is judged."""


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


def headers(flights: Sequence[Flight]) -> list[str]:
    """The headers of the further columns that flights have, in the order in which they first appear."""
    return list(dict.fromkeys(name for flight in flights for name in flight.extra))
