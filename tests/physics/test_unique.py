"""Identical draws are simulated once, with the same results as separate simulations."""

from dataclasses import fields

import numpy as np
import pytest

from fieldkit.physics import unique
from fieldkit.physics.flight import fly
from fieldkit.physics.state import FlightResult, Setup
from fieldkit.physics.unique import fly_unique, kinds
from tests.physics.simulated import LONG, NOISY, rocket

pytestmark = pytest.mark.fast


@pytest.fixture
def doubled() -> Setup:
    """Twenty draws, each present four times, on two axes."""
    rng = np.random.default_rng(1)
    mass, wind = (np.tile(rng.uniform(low, high, 5), (4, 1)) for low, high in ((0.3, 0.5), (0.0, 6.0)))
    return rocket([NOISY, LONG], dry_mass=mass, wind=wind, motor=np.arange(5) % 2, delay=np.full(5, np.nan))


def _same(one: FlightResult, other: FlightResult) -> None:
    for entry in fields(FlightResult):
        np.testing.assert_array_equal(getattr(one, entry.name), getattr(other, entry.name), strict=True)


def test_equal_draws_have_the_same_results_as_separate_simulations(doubled: Setup) -> None:
    _same(fly_unique(doubled), fly(doubled))


def test_only_one_of_each_kind_is_simulated(doubled: Setup, monkeypatch: pytest.MonkeyPatch) -> None:
    flown: list[int] = []

    def counted(setup: Setup) -> FlightResult:
        flown.append(setup.draws)
        return fly(setup)

    monkeypatch.setattr(unique, "fly", counted)
    fly_unique(doubled)
    assert flown == [5]


def test_a_single_draw_is_simulated() -> None:
    _same(fly_unique(rocket(NOISY)), fly(rocket(NOISY)))


@pytest.mark.parametrize("name", ["dry_mass", "wind", "opening_time", "altimeter_gain"])
def test_draws_that_differ_in_anything_are_simulated_separately(doubled: Setup, name: str) -> None:
    shape = doubled.draw_shape
    last_differs = np.broadcast_to(getattr(doubled, name), shape).copy()
    last_differs[-1, -1] = np.nextafter(last_differs[-1, -1], np.inf)
    first, kind = kinds(doubled.with_changes(**{name: last_differs}).flat(shape))
    assert len(first) == 6
    assert np.count_nonzero(kind == kind[-1]) == 1


def test_draws_whose_checksums_agree_by_chance_are_kept_separate(
    doubled: Setup, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(unique, "MIXERS", np.zeros_like(unique.MIXERS))
    first, kind = kinds(doubled.flat(doubled.draw_shape))
    assert list(first) == list(kind) == list(range(20))
