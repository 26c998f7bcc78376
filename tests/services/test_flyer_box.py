"""The range box: which motors with which delays are in it, and what flights take out."""

from collections.abc import Iterator
from datetime import datetime, timedelta
from pathlib import Path

import pytest

from fieldkit.flight import Flight
from fieldkit.ledger import Ledger
from fieldkit.motors import catalogue
from fieldkit.services.range_box import box_left, motors_in_box, recounted, taken_in_words
from fieldkit.settings import BoxedMotors

pytestmark = pytest.mark.fast


def test_a_boxed_motor_has_only_the_delays_that_are_in_the_box() -> None:
    box = (BoxedMotors("C6-5", 3), BoxedMotors("C6-3", 1), BoxedMotors("H128W-14A", 1), BoxedMotors("D12", 2))
    found = motors_in_box(box, catalogue())
    assert {motor.designation: (motor.delays, count) for motor, count in found.items()} == {
        "C6": ((3.0, 5.0), 4),
        "H128W": ((14.0,), 1),
        "D12": (catalogue().resolve("D12").motor.delays, 2),
    }
    assert motors_in_box(box, catalogue()).keys() == found.keys(), "the same objects each time"


def test_a_motor_that_is_not_in_the_catalog_is_left_out_of_the_box() -> None:
    assert motors_in_box((BoxedMotors("Z99-3", 1),), catalogue()) == {}


COUNTED = datetime(2026, 5, 1, 9, 0)


@pytest.fixture
def ledger(tmp_path: Path) -> Iterator[Ledger]:
    with Ledger.open(tmp_path / "ledger.db") as ledger:
        yield ledger


def boxed(motor: str, count: int, lot: str = "", counted: datetime | None = COUNTED) -> BoxedMotors:
    return BoxedMotors(motor, count, lot, "" if counted is None else counted.isoformat(timespec="minutes"))


def flown(id: str, motor: str, hours: float = 1.0, **more: object) -> Flight:
    return Flight(
        rocket="Box", flight_id=id, motor=motor, apogee=100.0, date_time=COUNTED + timedelta(hours=hours), **more
    )


def left(ledger: Ledger, *box: BoxedMotors) -> list[int]:
    return [one.count for one in box_left(box, ledger, catalogue())]


@pytest.mark.parametrize(
    ("flight", "counts"),
    [
        (flown("1", "C6-5"), [2, 1, 1]),
        (flown("1", "Estes C6-5"), [2, 1, 1]),
        (flown("1", "C6", delay=3.0), [3, 0, 1]),
        (flown("1", "3 x C6-5"), [0, 1, 1]),
        (flown("1", "4 x C6-5"), [0, 1, 1]),
        (flown("1", "C6-7"), [3, 1, 1]),
        (flown("1", "H128W-10A"), [3, 1, 0]),
        (flown("1", "D12-5"), [3, 1, 1]),
        (flown("1", "C6-5", hours=-0.5), [3, 1, 1]),
        (flown("1", "C6-5", hours=-9.0), [3, 1, 1]),
        (flown("1", "C6-5", hours=-24 * 365), [3, 1, 1]),
        (flown("1", "C6-5").with_changes(date_time=None), [3, 1, 1]),
        (flown("1", "no such motor"), [3, 1, 1]),
    ],
    ids=lambda one: "" if isinstance(one, list) else f"{one.motor} {one.date_time}",
)
def test_a_flight_after_the_count_takes_its_motors_out(ledger: Ledger, flight: Flight, counts: list[int]) -> None:
    """A drilled delay is cut from the longer one in the box; flights from before the count take nothing out."""
    ledger.add([flight])
    assert left(ledger, boxed("C6-5", 3), boxed("C6-3", 1), boxed("H128W-14A", 1)) == counts


def test_undoing_removing_and_correcting_a_flight_put_its_motor_back(ledger: Ledger) -> None:
    box = (boxed("C6-5", 3),)
    ledger.add([flown("1", "C6-5"), flown("2", "C6-5")])
    assert left(ledger, *box) == [1]
    ledger.edit("2", motor="B6-4")
    assert left(ledger, *box) == [2]
    ledger.remove("1")
    assert left(ledger, *box) == [3]
    for expected in (2, 1, 3):
        ledger.undo()
        assert left(ledger, *box) == [expected]
    ledger.redo()
    assert left(ledger, *box) == [1]


def test_a_motor_is_taken_from_its_lot(ledger: Ledger) -> None:
    box = (boxed("C6-5", 1), boxed("C6-5", 2, "0412"), boxed("C6-5", 2, "0500"))
    ledger.add([flown("1", "C6-5", extra={"motor_lot": "0500"}), flown("2", "C6-5 lot 0412", 2), flown("3", "C6-5", 3)])
    assert left(ledger, *box) == [0, 1, 1]
    ledger.add([flown("4", "C6-5 lot 0600", 4)])
    assert left(ledger, *box) == [0, 1, 1], "none of this lot was in the box"


def test_a_box_counted_by_an_earlier_version_is_not_counted_down(ledger: Ledger) -> None:
    ledger.add([flown("1", "C6-5")])
    assert left(ledger, boxed("C6-5", 3, counted=None), BoxedMotors("C6-5", 1, counted="yesterday")) == [3, 1]


def test_what_a_flight_took_out_is_printed(ledger: Ledger) -> None:
    box = (boxed("C6-5", 3), boxed("B6-4", 1))
    cluster = flown("1", "2 x C6-5 + B6-4")
    ledger.add([cluster, flown("2", "A8-3")])
    assert taken_in_words(box, cluster, ledger, catalogue()) == (
        "Taken from your range box: 2 x C6-5, 1 left; 1 x B6-4, 0 left."
    )
    assert not taken_in_words(box, flown("2", "A8-3"), ledger, catalogue())


def test_an_edited_box_counts_only_what_was_changed(ledger: Ledger) -> None:
    saved = (boxed("C6-5", 3), boxed("B6-4", 2))
    ledger.add([flown("1", "C6-5")])
    shown = box_left(saved, ledger, catalogue())
    edited = recounted([BoxedMotors("C6-5", 2), BoxedMotors("B6-4", 5)], shown, saved)
    assert edited[0] == saved[0]
    assert (edited[1].count, edited[1].counted > saved[1].counted) == (5, True)
    assert left(ledger, *edited) == [2, 5]
