"""Single faulty flights as logs of recorders: the program reads them, and the fault remains in what it measures."""

import pytest

from bench.one_offs import COMPARED, LOGS, all_judged, as_flight, case, in_columns, in_si, table

CHECK_SHAPES = False


def test_readouts_in_columns_and_in_si_are_the_same() -> None:
    shown = dict(zip(COMPARED, (100.0, 50.0, 1.5, 8.0, 4.0, -0.5), strict=True))
    assert in_columns(in_si(shown)) == pytest.approx(shown)
    flight = as_flight(case("arc", 0, 0, 31).faulty, shown, 3)
    assert in_columns(flight.readouts()) == pytest.approx(shown)


@pytest.mark.thorough
def test_an_arc_in_logs_of_heights_is_among_the_causes() -> None:
    (found,) = all_judged([case("arc", 2, 0, 31)], LOGS)
    assert found["probability"] > 0.5
    assert "arc" in [name for name, _ in found["named"][:3]]
    assert "| arc | 40 | 1 | 100% |" in table([found])
