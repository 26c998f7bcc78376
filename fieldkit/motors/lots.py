"""Lots of motors, as flyers record them: in the name of the motor, `F24-4W lot 0412`, or in a column of their table."""

import re
from collections.abc import Sequence
from functools import lru_cache

from fieldkit.flight import Flight
from fieldkit.motors.catalogue import split_lot

LOT_WORDS = ({"lot"}, {"batch"})
"""What the header of a column of lots says, besides `FURTHER_WORDS`."""
FURTHER_WORDS = {"motor", "number", "no", "id"}

OF_A_LOT = " lot "
"""What separates a motor type from its lot in the name of a group."""


@lru_cache(maxsize=256)
def names_a_lot(header: str) -> bool:
    """Whether a column of a flyer's table has the lots of the motors, by its header: `motor_lot`, `Batch no.`."""
    return set(re.findall(r"[a-z]+", header.casefold())) - FURTHER_WORDS in LOT_WORDS


def recorded_lot(flight: Flight) -> str:
    """The lot of a flight's motor as recorded, empty if it is not."""
    columns = (text.strip() for header, text in flight.extra.items() if names_a_lot(header))
    return split_lot(flight.motor)[1] or next(filter(None, columns), "")


def lots(motors: Sequence[str], recorded: Sequence[str]) -> list[str]:
    """The lot of each flight's motor, `Estes D12 lot 2`, by motor types and lots in the order flown; empty if unknown.

    A flight without a lot has that of the flight before on the same motor type: a flyer records the lot of a new pack.
    """
    if not any(recorded):
        return [""] * len(recorded)
    last: dict[str, str] = {}
    result = []
    for motor, lot in zip(motors, recorded, strict=True):
        if lot:
            last[motor] = f"{motor}{OF_A_LOT}{lot}"
        result.append(last.get(motor, ""))
    return result
