"""Thrust curves: laws for knots and moments, and how the catalog is made."""

import importlib.util
import json
from pathlib import Path
from types import ModuleType
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from fieldkit.errors import BadValue
from fieldkit.motors import rasp
from fieldkit.motors.motor import Motor, impulse, impulse_class, knots

pytestmark = pytest.mark.fast

_numbers = st.floats(0, 100, allow_subnormal=False)
_curves = st.lists(st.tuples(_numbers, _numbers), min_size=2, max_size=20)


@given(_curves)
def test_knots_increase_and_begin_and_end_at_zero(samples: list[tuple[float, float]]) -> None:
    time = sorted(round(t, 3) for t, _ in samples)
    thrust = [f for _, f in samples]
    if time[-1] == 0 or not any(f > 1e-3 for f in thrust):
        return
    t, f = knots(time, thrust)
    assert t[0] == f[0] == f[-1] == 0
    assert (np.diff(t) > 0).all()
    slack = 200 * 1e-4 * len(time) + 100 * (t[-1] - time[-1]) + 50 * time[0]  # a curve begins at (0, 0)
    assert abs(impulse(t, f) - impulse(np.array(time), np.array(thrust))) <= slack


def test_valid_knots_are_unchanged() -> None:
    time, thrust = knots([0, 0.1, 2, 2.5], [0, 30, 20, 0])
    np.testing.assert_array_equal(time, [0, 0.1, 2, 2.5])
    np.testing.assert_array_equal(thrust, [0, 30, 20, 0])


@pytest.mark.parametrize(
    ("time", "thrust"),
    [
        ([0, 2, 1], [0, 5, 0]),
        ([0, 1], [0, 0]),
        ([0, 1, 2], [0, -5, 0]),
        ([0], [1]),
        ([0, float("nan")], [1, 0]),
    ],
)
def test_an_impossible_curve_is_refused(time: list[float], thrust: list[float]) -> None:
    with pytest.raises(BadValue):
        knots(time, thrust)


def _motor(samples: str) -> Motor:
    (motor,), _ = rasp.read(f"X1 24 70 P 0.02 0.06 me\n{samples}".encode(), "x.eng")
    return motor


def test_constant_thrust_has_the_moments_of_a_uniform_distribution() -> None:
    motor = _motor("0 20\n2 20\n2 0\n")
    mean, variance = motor.moments
    assert mean == pytest.approx(1, abs=1e-4)
    assert variance == pytest.approx(2**2 / 12, abs=1e-3)
    assert motor.burn_time == pytest.approx(2, abs=1e-3)
    assert motor.average_thrust == pytest.approx(20, rel=1e-3)
    assert motor.peak_thrust == pytest.approx(20, rel=1e-3)


def test_a_triangular_curve_burns_while_thrust_is_above_five_percent_of_its_peak() -> None:
    motor = _motor("1 40\n2 0\n")
    assert motor.total_impulse == pytest.approx(40)
    assert motor.burning == pytest.approx((0.05, 1.95))
    assert motor.moments == pytest.approx((1, 1 / 6))


@pytest.mark.parametrize(
    ("total", "letter"),
    [
        (0.3, "1/8A"),
        (0.6, "1/4A"),
        (1.25, "1/2A"),
        (2.5, "A"),
        (2.51, "B"),
        (47.3, "F"),
        (80, "F"),
        (81, "G"),
        (5e3, "L"),
    ],
)
def test_the_class_follows_from_the_total_impulse(total: float, letter: str) -> None:
    assert impulse_class(total) == letter


def _tool() -> ModuleType:
    path = Path(__file__).parents[2] / "tools" / "motors.py"
    spec = importlib.util.spec_from_file_location("make_catalogue", path)
    assert spec
    assert spec.loader
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def _source(number: int, **changes: Any) -> dict[str, Any]:
    return {
        "motorId": f"{number:024x}",
        "manufacturerAbbrev": "Me",
        "commonName": f"E{number}",
        "designation": f"E{number}W",
        "impulseClass": "E",
        "type": "SU",
        "diameter": 20 + number,
        "length": 60 + number**2,
        "totImpulseNs": 40,
        "burnTimeS": 1.9,
        "propWeightG": 20,
        "totalWeightG": 50 + number,
        "propInfo": "White",
        "delays": "4,7,P",
        "availability": "regular",
        "updatedOn": "2020-01-01",
        "samples": [[0, 0], [1, 40], [2, 0]],
    } | changes


def test_the_same_source_gives_the_same_catalog_and_omissions_are_reported() -> None:
    tool = _tool()
    source = [
        *(_source(number) for number in range(1, 6)),
        *(_source(number, type="reload") for number in range(11, 16)),
        _source(20, samples=None),
        _source(21, samples=[[0, 0], [1, 60], [2, 0]]),
        _source(22, propWeightG=None),
        _source(23, totalWeightG=None),
        _source(24, type="hybrid", propWeightG=None),
        _source(25, type="hybrid", propWeightG=5),
        _source(26, propWeightG=90),
    ]
    document = tool.build(source, "digest")
    again = tool.build(list(reversed(source)), "digest")
    assert tool.packed(document) == tool.packed(again)
    rows = [dict(zip(document["columns"], row, strict=True)) for row in document["motors"]]
    by_name = {row["name"]: row for row in rows}
    assert document["left_out"] == {
        "impulse of the samples off the certified one by more than 25%": ["Me E21W"],
        "masses not on record": ["Me E24W"],
        "nitrous not in the propellant mass": ["Me E25W"],
        "no samples": ["Me E20W"],
    }
    assert (by_name["E22"]["propellant_g"], by_name["E22"]["estimated"]) == (20, ["propellant mass"])
    assert (by_name["E26"]["propellant_g"], by_name["E26"]["casing_g"]) == (20, 56)
    assert by_name["E23"]["estimated"] == ["casing mass"]
    assert 20 < by_name["E23"]["casing_g"] < 70
    assert by_name["E1"]["delays"] == [4, 7, "P"]
    assert json.dumps(document)
