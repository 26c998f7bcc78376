"""Readouts that were meant in one unit and read in another."""

from math import log

import pytest

from fieldkit.flight import BY_NAME, Flight
from fieldkit.flight.plausibility import far_from_usual
from fieldkit.flight.unit_slips import CONFUSED, UnitSlip, unit_slip
from fieldkit.units import UNITS, parse

pytestmark = pytest.mark.fast

PAIRS = [
    (name, *pair)
    for name in ("apogee", "top_speed", "peak_accel")
    for one in CONFUSED[BY_NAME[name].quantity]
    for pair in (one, one[::-1])
]


@pytest.mark.parametrize(("name", "meant", "read"), PAIRS)
def test_a_number_read_in_the_wrong_unit_is_given_back_as_typed(name: str, meant: str, read: str) -> None:
    column, number = BY_NAME[name], 80.0
    factor = UNITS[column.quantity]
    value = number * factor[read].factor
    found = unit_slip(column, value, log(factor[read].factor / factor[meant].factor), 0.02)
    assert found == UnitSlip(pytest.approx(number), meant, read)
    assert parse(found.typed, column.quantity, column.unit) == pytest.approx(number * factor[meant].factor)


def test_a_usual_readout_a_doubtful_ratio_and_an_uncertain_one_have_no_slip() -> None:
    column = BY_NAME["top_speed"]
    assert unit_slip(column, 60.0, 0.05, 0.05) is None
    assert unit_slip(column, 60.0, log(3.4), 0.05) is None  # ft/s as m/s, or m/s as km/h
    assert unit_slip(column, 60.0, log(3.281), 0.3) is None
    assert unit_slip(column, 60.0, float("nan"), 0.05) is None
    assert unit_slip(BY_NAME["burn_time"], 2.0, log(3.281), 0.02) is None


def test_a_readout_far_from_the_usual_one_is_questioned_with_the_unit_that_explains_it() -> None:
    flight = Flight("1", "Lark", "", "F24-4W", apogee=918.0, top_speed=165.0)
    apogee, speed = (phrase for phrase, _ in far_from_usual(flight, {"apogee": 280.0, "top_speed": 74.0}))
    assert (
        apogee == "apogee 918 m is 3.3 times the usual 280 m of this rocket and motor; perhaps 918 ft taken for 918 m"
    )
    assert speed.endswith("; perhaps 165 mph taken for 165 m/s")
    (fivefold,) = (phrase for phrase, _ in far_from_usual(flight, {"apogee": 183.6}))
    assert "perhaps" not in fivefold
