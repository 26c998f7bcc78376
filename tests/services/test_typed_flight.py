"""Cd, alpha and the next apogee while a flight is entered: missing inputs, updates, finite figures only."""

import math
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest

from fieldkit.flight import Flight
from fieldkit.ledger import Ledger
from fieldkit.motors import catalogue
from fieldkit.services.quick_look import predict_quickly
from fieldkit.services.typed_flight import TypedEstimate, TypedFlight
from tests.seasons import season

CHECK_SHAPES = False
TYPED = Flight(rocket="Test", config="A", motor="F24", dry_mass=0.322, diameter=0.066, delay=10.0, rail_length=1.2)


@pytest.fixture
def ledger(tmp_path: Path) -> Iterator[Ledger]:
    """Six flights of one rocket."""
    flown = [flight for flight, _ in season(np.random.default_rng(3), ("apogee", "top_speed"), 6)]
    with Ledger.open(str(tmp_path / "ledger.db")) as book:
        book.add(flown)
        yield book


def figures(found: TypedEstimate) -> list[float]:
    assert found.cd is not None
    assert found.alpha is not None
    assert found.next_apogee is not None
    return [*found.cd, *found.alpha, *found.next_apogee]


@pytest.mark.parametrize(
    ("lacks", "expected"),
    [
        ({"dry_mass": None}, ("mass",)),
        ({"diameter": None, "dry_mass": None}, ("mass", "diameter")),
        ({"motor": ""}, ("motor",)),
        ({"motor": "Z999"}, ("a motor in the catalog",)),
        ({"rocket": "Other"}, ("a readout",)),
        ({"rocket": "Other", "dry_mass": None}, ("mass", "a readout")),
    ],
)
def test_nothing_is_estimated_if_an_input_is_missing(
    ledger: Ledger, lacks: dict[str, object], expected: object
) -> None:
    found = TypedFlight(ledger, catalogue()).estimate(TYPED.with_changes(**lacks))
    assert found == TypedEstimate(needs=expected)


def test_each_readout_changes_the_estimate_until_it_is_removed(ledger: Ledger) -> None:
    beside = TypedFlight(ledger, catalogue())
    before = beside.estimate(TYPED)
    usual = figures(before)[7]
    high, low = (beside.estimate(TYPED.with_changes(apogee=ratio * usual)) for ratio in (1.1, 0.9))
    fast = beside.estimate(TYPED.with_changes(apogee=1.1 * usual, top_speed=80.0))
    assert figures(high)[1] < figures(low)[1]
    assert figures(high)[7] > figures(low)[7]
    assert figures(fast) != figures(high)
    assert figures(beside.estimate(TYPED)) == figures(before)


def test_a_first_flight_is_estimated_from_its_own_readouts(ledger: Ledger) -> None:
    found = TypedFlight(ledger, catalogue()).estimate(TYPED.with_changes(rocket="Other", apogee=250.0))
    assert found.flights == 1
    low, middle, high = figures(found)[6:]
    assert low < middle < high


def test_a_cached_preparation_gives_the_same_result_as_a_new_one(ledger: Ledger) -> None:
    beside = TypedFlight(ledger, catalogue())
    for apogee in (250.0, 260.0):
        beside.estimate(TYPED.with_changes(apogee=apogee))
    last = TYPED.with_changes(apogee=240.0, dry_mass=0.33)
    assert figures(beside.estimate(last)) == figures(TypedFlight(ledger, catalogue()).estimate(last))


def test_the_next_apogee_is_that_of_the_quick_forecast_once_it_is_saved(ledger: Ledger) -> None:
    typed = TYPED.with_changes(apogee=250.0, flight_id="7")
    now = TypedFlight(ledger, catalogue()).estimate(typed)
    ledger.add([typed])
    (after,) = predict_quickly(ledger, catalogue(), [typed.with_changes(apogee=None, flight_id="next")])
    assert figures(now)[7] == pytest.approx(after.answer.apogee_at(0.5), rel=0.005)


@pytest.mark.sampled
@pytest.mark.parametrize("apogee", [0.0, -5.0, 1.0, 9e4, 1e9, math.nan, math.inf])
@pytest.mark.parametrize("speed", [None, 0.0, 1e6])
def test_every_figure_is_finite(ledger: Ledger, apogee: float, speed: float | None) -> None:
    found = TypedFlight(ledger, catalogue()).estimate(TYPED.with_changes(apogee=apogee, top_speed=speed))
    if found.cd is None:
        assert found.implausible_because
    else:
        assert all(map(math.isfinite, figures(found)))
