"""Thrust curves beside their certified records: impulse, burn time, average and peak thrust."""

import json

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from fieldkit.motors import catalogue
from fieldkit.motors.motor import impulse
from fieldkit.motors.record import (
    AGREEMENT,
    MISSED_PEAK,
    CertifiedRecord,
    agreement,
    checked,
    record_of,
    reshaped,
    used_curve,
    with_peak,
)
from fieldkit.planning.safety import thrust_to_weight
from tests.commands import Run

TIME, THRUST = np.array([0.0, 0.1, 1.0, 1.1, 2.0]), np.array([0.0, 60.0, 40.0, 2.0, 0.0])
TOTAL, ABOVE = impulse(TIME, THRUST), 1.095


def test_every_curve_of_the_catalog_is_within_five_percent_of_its_record() -> None:
    found = checked(catalogue().motors)
    assert len(found) == len(catalogue())
    assert max(abs(one.deviation) for _, one in found) <= AGREEMENT == 0.05
    assert {used_curve(motor) for motor, _ in found} == {"recorded", "reshaped", "another", "estimated"}


CONTRADICTORY = {"I747-HP": 0.64, "I195J": 1.07, "I223GT": 1.03}
"""Motors whose certified peak no curve of theirs has: the peak over the certified impulse over the burn time."""


def test_every_peak_of_the_catalog_is_within_five_percent_of_its_record_unless_the_record_contradicts_itself() -> None:
    """A thrust that rises and falls has a peak above its average. The other documents of the three are in the open
    corrections."""
    found = {motor.designation: (motor, one) for motor, one in checked(catalogue().motors) if one.largest > AGREEMENT}
    assert found.keys() == CONTRADICTORY.keys()
    for name, (motor, one) in found.items():
        assert one.record.peak
        assert one.record.peak * one.record.burn / one.record.impulse == pytest.approx(CONTRADICTORY[name], abs=0.005)
        assert ("cannot be true" in one.why) is (CONTRADICTORY[name] < 1), name
        assert any(not each.applied for each in motor.corrections), name


@pytest.mark.parametrize(
    ("name", "total", "burn", "average"),
    [
        ("I284W", 607.3, 1.94, 313.0),
        ("AeroTech I195J", 426.1, 2.10, 202.9),
        ("I211W", 441.6, 1.72, 256.7),
        ("AeroTech H123W", 223.6, 1.76, 127.0),
        ("H238T", 165.5, 0.71, 233.1),
        ("H242T", 231.7, 1.06, 218.6),
        ("I357T", 342.0, 1.00, 342.0),
        ("F25W", 77.92, 3.05, 25.55),
        ("F44W", 41.5, 1.00, 41.5),
        ("H128W", 172.9, 1.27, 136.1),
        ("Estes A8", 2.32, 0.73, 3.18),
        ("Cesaroni 396I140-14A", 395.6, 2.886, 137.1),
        ("M2000R", 9218.0, 4.585, 2010.5),
        ("KBA I280F", 382.0, 1.45, 263.4),
    ],
)
def test_a_motor_has_the_figures_of_its_record_together(name: str, total: float, burn: float, average: float) -> None:
    """Source: the records of ThrustCurve.org; the burn time of the 396I140 is its impulse over its average thrust."""
    motor = catalogue().resolve(name).motor
    assert (motor.total_impulse, motor.rated_burn) == pytest.approx((total, burn), rel=1e-4)
    assert motor.rated_thrust == pytest.approx(average, rel=0.001)
    assert motor.total_impulse / motor.rated_burn == pytest.approx(motor.rated_thrust, rel=0.01)
    record = record_of(motor)
    assert record
    assert agreement(motor.time, motor.thrust, record).burn == pytest.approx(burn, rel=AGREEMENT)


def test_a_heavy_rocket_on_an_i284_has_less_than_three_times_its_weight_in_thrust() -> None:
    """10.96 kg on the pad with 313 N, the certified impulse over the certified burn time: 2.9."""
    motor = catalogue().resolve("I284W").motor
    assert thrust_to_weight(motor, 10.96 - motor.loaded_mass)[1] == pytest.approx(2.91, abs=0.02)


@given(st.floats(1.4, 6))
def test_a_curve_with_the_peak_of_its_record_keeps_its_impulse_and_its_thrust_on_the_rail(times: float) -> None:
    """The recorded curve has a peak of 2.2 times its average over the burn."""
    peak = times * TOTAL / ABOVE
    peaked = with_peak(TIME, THRUST, CertifiedRecord(TOTAL, ABOVE, peak=peak))
    assert peaked
    time, thrust = peaked
    assert (thrust.max(), impulse(time, thrust)) == pytest.approx((peak, TOTAL), rel=1e-6)
    assert (thrust >= 0).all()
    assert (np.diff(time) > 0).all()
    if peak > THRUST.max():  # a triangle of 5 ms on each side: all other thrust is less by its fraction of the impulse
        same, share = np.abs(time - 0.1) >= MISSED_PEAK, (peak - THRUST.max()) * MISSED_PEAK / TOTAL
        np.testing.assert_allclose(thrust[same], np.interp(time[same], TIME, THRUST) * (1 - share), rtol=share / 5)


@pytest.mark.parametrize("times", [0.9, 1.0, 1.05])
def test_no_curve_is_bent_to_a_peak_near_its_average(times: float) -> None:
    assert with_peak(TIME, THRUST, CertifiedRecord(TOTAL, ABOVE, peak=times * TOTAL / ABOVE)) is None


def test_no_curve_gets_a_peak_that_its_record_does_not_state() -> None:
    assert with_peak(TIME, THRUST, CertifiedRecord(TOTAL, ABOVE)) is None


@given(st.floats(0.2, 5), st.floats(0.2, 5), st.booleans())
def test_a_reshaped_curve_has_the_impulse_and_burn_time_of_its_record(total: float, burn: float, whole: bool) -> None:
    record = CertifiedRecord(total, burn)
    time, thrust = reshaped(TIME, THRUST, record, whole=whole)
    found = agreement(time, thrust, record)
    assert (found.impulse, found.burn) == pytest.approx((total, burn), rel=1e-6)
    assert abs(found.deviation) < 1e-6
    np.testing.assert_allclose(thrust / thrust.max(), THRUST / THRUST.max())


def test_the_peak_decides_whether_a_record_states_the_burn_time_of_the_whole_curve() -> None:
    same = agreement(TIME, THRUST, CertifiedRecord(TOTAL, 2.0, TOTAL / 2, 60.0))
    assert (same.burn, same.deviation) == pytest.approx((2.0, 0.0))
    other = agreement(TIME, THRUST, CertifiedRecord(TOTAL, 2.0, TOTAL / 2, 60 * ABOVE / 2))
    assert other.burn == pytest.approx(ABOVE, rel=0.02)
    assert other.deviation == pytest.approx(2.0 / ABOVE - 1, rel=0.05)


def test_the_average_thrust_counts_as_well_as_the_burn_time() -> None:
    """A record that contradicts itself is found, even with a curve that has its impulse and burn time."""
    found = agreement(TIME, THRUST, CertifiedRecord(TOTAL, ABOVE, 2 * TOTAL / ABOVE, 60.0))
    assert found.deviation == pytest.approx(-0.5, abs=0.01)


def test_the_check_prints_every_curve_beside_its_record(run: Run) -> None:
    motors = json.loads(run("motors", "--check", "--json").out)["motors"]
    assert len(motors) == len(catalogue())
    by_name = {one["motor"]: one for one in motors}
    found = by_name["AeroTech I284W"]
    assert found["certified"] == {"impulse_ns": 607.3, "burn_s": 1.94, "average_n": None, "peak_n": 570.6}
    assert (found["used"], found["burn_s"]) == ("reshaped", pytest.approx(1.94, rel=0.01))
    assert abs(found["peak_deviation"]) < 0.05
    assert "1.07 times its impulse over its burn time" in by_name["AeroTech I195J"]["why"]
    assert by_name["AeroTech F24W"]["used"] == "recorded"
    printed = run("motors", "--check", "I284W")
    assert "1.94/1.94" in printed.out
    assert "off by more than 5% in impulse, burn time or average thrust: 0; in peak thrust: 0" in printed.err
    assert "does not have the certified peak" in run("motors", "--check", "I195J").err


def test_a_reshaped_curve_is_marked_where_its_motor_is_named(run: Run) -> None:
    assert "reshaped to the certified burn time of 1.94 s" in catalogue().find("I284W").notes[0]
    assert "reshaped to the certified burn time of 1.94 s" in run("motors", "I284W").err
