"""Lots of motors, as flyers record them: in the name of the motor, `F24-4W lot 0412`, or in a column of their table."""

from collections.abc import Sequence

from fieldkit.flight import Flight
from fieldkit.flight.further import names_a_lot, text_under
from fieldkit.motors.catalogue import split_lot

OF_A_LOT = " lot "
"""What separates a motor type from its lot in the name of a group."""


def recorded_lot(flight: Flight) -> str:
    """The lot of a flight's motor as recorded, empty if it is not."""
    return split_lot(flight.motor)[1] or text_under(flight, names_a_lot)


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
