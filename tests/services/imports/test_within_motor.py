"""Readouts of a log that are impossible on its motor are named and not stored."""

import pytest

from fieldkit.flight import Flight
from fieldkit.services.imports.within_motor import within_motor

CHECK_SHAPES = False
SEEN = Flight(
    flight_id="1",
    motor="C6-5",
    dry_mass=0.1,
    apogee=150.0,
    top_speed=60.0,
    burn_time=1.7,
    peak_accel=100.0,
    sd={"top_speed": 2.0, "burn_time": 0.1, "peak_accel": 10.0},
    source=dict.fromkeys(("apogee", "top_speed", "burn_time", "peak_accel"), "baro"),
)


def test_readouts_possible_on_a_motor_are_stored() -> None:
    assert within_motor(SEEN) == (SEEN, [])


@pytest.mark.parametrize(
    ("name", "value"), [("top_speed", 799.0), ("peak_accel", 3364.0), ("burn_time", 0.17)], ids=["799", "343 g", "0.17"]
)
def test_readouts_impossible_on_a_motor_are_named_and_not_stored(name: str, value: float) -> None:
    flight, notes = within_motor(SEEN.with_changes(**{name: value}, sd=SEEN.sd, source=SEEN.source))
    assert flight.number(name) is None
    assert name not in flight.sd
    assert name not in flight.source
    assert flight.apogee == 150.0
    (note,) = notes
    assert note.startswith("not measured")
    assert "C6" in note


def test_uncertain_or_typed_readouts_are_kept() -> None:
    vague = SEEN.with_changes(top_speed=799.0, sd={"top_speed": 380.0}, source=SEEN.source)
    typed = SEEN.with_changes(top_speed=799.0, source={"top_speed": "typed"})
    assert within_motor(vague)[0].top_speed == within_motor(typed)[0].top_speed == 799.0


def test_without_a_mass_or_a_motor_nothing_is_checked() -> None:
    for changes in ({"dry_mass": None}, {"motor": ""}):
        flight = SEEN.with_changes(top_speed=799.0, sd=SEEN.sd, source=SEEN.source, **changes)
        assert within_motor(flight) == (flight, [])
