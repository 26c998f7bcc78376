"""Whether forecasts are the same for two rockets read from the ledger, which `==` cannot say of their arrays."""

import numpy as np
import pytest

from fieldkit.model.shared_prior import SharedPrior
from fieldkit.model.term_names import TermName
from fieldkit.planning.forecasts import RocketData

pytestmark = pytest.mark.fast


def rocket(mean: float | None, flights: int = 0) -> RocketData:
    shared = None if mean is None else SharedPrior((TermName("a"), TermName("b")), np.array([mean, 0.0]), np.eye(2))
    return RocketData((), ((1.0, ()),) * flights, shared=shared)


@pytest.mark.parametrize("mean", [None, 0.3])
def test_rockets_of_the_same_data_are_the_same(mean: float | None) -> None:
    assert rocket(mean).same_as(rocket(mean))
    assert not rocket(mean).same_as(rocket(mean, flights=1))


@pytest.mark.parametrize(("one", "other"), [(None, 0.3), (0.3, None), (0.3, 0.4)])
def test_other_flights_of_other_rockets_make_a_difference(one: float | None, other: float | None) -> None:
    assert not rocket(one).same_as(rocket(other))
