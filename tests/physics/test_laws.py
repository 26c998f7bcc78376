"""The laws of flight: closed forms, orders of convergence, monotonicity, independence."""

from collections.abc import Callable, Iterator
from dataclasses import fields
from itertools import pairwise
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from fieldkit.errors import UnknownMotor
from fieldkit.motors import catalogue
from fieldkit.motors.motor import impulse
from fieldkit.physics import coast as coasting
from fieldkit.physics import flight as flying
from fieldkit.physics import paper
from fieldkit.physics.atmosphere import (
    GRAVITY,
    HYDROSTATIC_EXPONENT,
    LAPSE,
    STANDARD_PRESSURE,
    STANDARD_TEMPERATURE,
    Air,
    altimeter_gain,
    pad_air,
    station_pressure,
)
from fieldkit.physics.burn import AscentState, burn
from fieldkit.physics.flight import apogees, fly
from fieldkit.physics.state import FlightResult, Setup, State
from fieldkit.physics.thrust_steps import Curve
from tests.effort import examples
from tests.physics.simulated import CONSTANT, DENSITY, EVEN_AIR, LONG, NOISY, STANDARD_AIR, Push, rocket

NAN = np.asarray(np.nan)
SLACK = 0.03
"""Tolerance of monotonicity for finite steps. [m]"""
CASES = examples(25)
masses = st.floats(0.2, 1.0)
areas = st.floats(1e-4, 8e-3)
curves = st.sampled_from([CONSTANT, NOISY, LONG])


def nothing(state: State, strength: Any) -> Any:
    """A force of zero; it makes the coast integrate in steps."""
    return np.zeros_like(state.drag)


# Closed forms


@pytest.mark.parametrize("changes", [{}, {"forces": ((nothing, np.asarray(1.0)),)}, {"rail_angle": 1e-9}])
def test_a_coast_without_drag_gains_half_v_squared_over_g(changes: dict[str, Any]) -> None:
    setup = rocket(NOISY, drag_area=0.0, **changes)
    track = burn(setup.flat((1,)))
    flown = fly(setup)
    gain = flown.apogee - track.position[0]
    np.testing.assert_allclose(gain, track.velocity[0] ** 2 / (2 * GRAVITY), rtol=1e-9)
    np.testing.assert_allclose(flown.coast_to_apogee + flown.burn_time, track.flying + track.velocity[0] / GRAVITY)


def test_burnout_and_coast_agree_with_fehskens_and_malewicki() -> None:
    mass, thrust, time = 0.4, 30.0, 1.5
    area = np.linspace(2e-4, 6e-3, 9)
    flown = fly(rocket(CONSTANT, steps=48, air=EVEN_AIR, dry_mass=mass, drag_area=area))
    k = 0.5 * DENSITY * area
    balance = np.sqrt((thrust - mass * GRAVITY) / k)
    speed = balance * np.tanh(k * balance * time / mass)
    height = mass / k * np.log(np.cosh(k * balance * time / mass))
    terminal = np.sqrt(mass * GRAVITY / k)
    np.testing.assert_allclose(flown.top_speed, speed, rtol=1e-6)
    np.testing.assert_allclose(flown.burn_time, time, rtol=1e-12)
    np.testing.assert_allclose(flown.apogee, height + mass / (2 * k) * np.log1p((speed / terminal) ** 2), rtol=1e-6)
    np.testing.assert_allclose(flown.coast_to_apogee, terminal / GRAVITY * np.arctan(speed / terminal), rtol=1e-6)


def test_burnout_without_drag_agrees_with_tsiolkovsky() -> None:
    motor = Push((0.0, 1.5), (30.0, 30.0), propellant_mass=0.1)
    exhaust, full, empty = 45.0 / 0.1, 0.5, 0.4
    flown = fly(rocket(motor, drag_area=0.0))
    np.testing.assert_allclose(flown.top_speed, exhaust * np.log(full / empty) - GRAVITY * 1.5, rtol=1e-7)


# Orders of convergence


def ends(at: Callable[[int], np.ndarray[Any, Any]], counts: tuple[int, ...], finest: int) -> list[float]:
    """Ratio of errors for each doubling of the number of steps."""
    truth = at(finest)
    errors = [float(np.abs(at(count) - truth).max()) for count in counts]
    return [a / b for a, b in pairwise(errors)]


@pytest.mark.parametrize("changes", [{}, {"rail_angle": 0.1, "rail_length": 1e6}])
def test_halving_the_steps_of_a_burn_divides_the_error_by_sixteen(changes: dict[str, Any]) -> None:
    motor = Push((0.0, 2.0), (40.0, 20.0), 0.05)

    def end(steps: int) -> np.ndarray[Any, Any]:
        track = burn(rocket(motor, steps, drag_area=4e-3, **changes).flat((1,)))
        return np.concatenate([track.position, track.velocity])

    for ratio in ends(end, (8, 16, 32), 512):
        assert ratio == pytest.approx(16, rel=0.25)


@pytest.mark.parametrize(
    ("changes", "order", "counts", "finest"),
    [
        ({}, 2, (4, 8, 16), 2048),
        ({"forces": ((nothing, np.asarray(1.0)),)}, 4, (16, 32, 64), 2048),
        ({"rail_angle": 0.2}, 4, (16, 32, 64), 2048),
    ],
    ids=["layers", "steps", "planar steps"],
)
def test_doubling_the_layers_of_a_coast_divides_the_error_according_to_its_order(
    monkeypatch: pytest.MonkeyPatch, changes: dict[str, Any], order: int, counts: tuple[int, ...], finest: int
) -> None:
    def end(count: int) -> np.ndarray[Any, Any]:
        monkeypatch.setattr(coasting, "_count", lambda wanted: np.full_like(wanted, count))
        return np.asarray(fly(rocket(NOISY, drag_area=3e-3, **changes)).apogee)

    for ratio in ends(end, counts, finest):
        assert ratio == pytest.approx(2**order, rel=0.25)


# Monotonicity


def never_rises(heights: Any) -> None:
    assert np.all(np.diff(heights) <= SLACK)


@CASES
@given(motor=curves, mass=masses, wind=st.sampled_from([0.0, 4.0]))
def test_more_drag_is_never_higher(motor: Push, mass: float, wind: float) -> None:
    never_rises(apogees(rocket(motor, dry_mass=mass, drag_area=np.linspace(0, 8e-3, 60), wind=wind)))


@CASES
@given(motor=curves, mass=masses, area=areas)
def test_more_thrust_is_never_lower(motor: Push, mass: float, area: float) -> None:
    never_rises(apogees(rocket(motor, dry_mass=mass, drag_area=area, thrust_factor=np.linspace(1.3, 0.2, 60))))


@CASES
@given(motor=curves, mass=masses, area=areas)
def test_denser_air_is_never_higher(motor: Push, mass: float, area: float) -> None:
    air = Air(np.linspace(0.6, 1.5, 60), np.asarray(288.15))
    never_rises(apogees(rocket(motor, dry_mass=mass, drag_area=area, air=air)))


@CASES
@given(motor=curves, area=areas)
def test_there_is_one_optimum_mass_and_beyond_it_more_is_never_higher(motor: Push, area: float) -> None:
    heights = apogees(rocket(motor, dry_mass=np.geomspace(0.01, 3.0, 40), drag_area=area))
    best = int(np.argmax(heights))
    never_rises(heights[best:])
    never_rises(heights[best::-1])


@pytest.mark.parametrize("motor", [CONSTANT, NOISY, LONG])
def test_more_wind_is_never_higher(motor: Push) -> None:
    flown = fly(rocket(motor, wind=np.linspace(0, 9, 40)))
    never_rises(flown.apogee)
    assert flown.apogee[-1] < flown.apogee[0] - 5
    assert np.all(flown.drift[1:] < 0)
    assert flown.drift[-1] < -5, "a rocket turns into the wind"


def test_a_tilted_rail_is_never_higher_and_drifts_in_the_direction_of_its_tilt() -> None:
    flown = fly(rocket(NOISY, rail_angle=np.radians(np.linspace(0, 40, 40))))
    never_rises(flown.apogee)
    assert np.all(np.diff(flown.drift) > 0)


def test_friction_on_the_rail_lowers_the_speed_off_it() -> None:
    flown = fly(rocket(NOISY, rail_friction=np.linspace(0, 30, 20), rail_length=1.5))
    assert np.all(np.diff(flown.rail_speed) < 0)
    never_rises(flown.apogee)


def test_friction_on_the_rail_holds_a_rocket_and_never_pushes_it_back() -> None:
    held = fly(rocket(CONSTANT, rail_friction=30 / 0.4 - GRAVITY + np.array([-1.0, 1.0])))
    np.testing.assert_array_equal(held.lift_off, [1, 0])
    late = Push((0.0, 0.5, 0.500001, 1.5), (0.0, 15.0, 40.0, 40.0))
    soon = Push((0.0, 1e-6, 1.0), (0.0, 40.0, 40.0))
    flown = [fly(rocket(push, rail_friction=40.0)) for push in (late, soon)]
    np.testing.assert_allclose(flown[0].apogee, flown[1].apogee, rtol=0.01)
    stops = Push((0.0, 0.05, 0.050001, 2.0), (40.0, 40.0, 12.0, 12.0))  # then thrust exceeds the weight, not friction
    stuck = fly(rocket(stops, rail_friction=40.0))
    assert 0 < stuck.apogee < 0.1
    assert stuck.top_speed < 0.05 * (40 / 0.4 - GRAVITY - 40) + 1e-6


def test_a_longer_rail_increases_the_exit_speed_and_changes_nothing_else() -> None:
    flown = fly(rocket(NOISY, rail_length=np.linspace(0.5, 3, 20)))
    assert np.all(np.diff(flown.rail_speed) > 0)
    assert np.ptp(flown.apogee) == 0


# Energy


def points(setup: Setup, track: AscentState) -> Iterator[Any]:
    closed = len(track.position) == 1 and not setup.forces
    return coasting._layers(setup, track, timed=True) if closed else coasting._steps(setup, track)


@pytest.mark.parametrize("changes", [{}, {"forces": ((nothing, np.asarray(1.0)),)}, {"rail_angle": 0.3}])
def test_energy_is_constant_without_drag_and_never_increases_with_it(changes: dict[str, Any]) -> None:
    for area, conserved in ((0.0, True), (3e-3, False)):
        setup = rocket(NOISY, drag_area=area, **changes).flat((1,))
        track = burn(setup)
        energy = [0.5 * (p.upward**2 + p.sideways**2) + GRAVITY * p.height for p in points(setup, track)]
        change = np.diff(np.ravel(energy))
        if conserved:
            assert np.abs(change).max() < 1e-8 * energy[0]
        else:
            assert np.all(change < 0)


# Independence of draws


def mixed(rows: int = 24) -> Setup:
    """Draws that differ in everything; some fly vertically, some at an angle, some not at all, some eject early."""
    rng = np.random.default_rng(4)
    upright = rng.random(rows) < 0.5
    level = upright | (rng.random(rows) < 0.5)
    tiny = Push((0.0, 0.2), (2.0, 1.0), 0.01)
    return rocket(
        [NOISY, CONSTANT, LONG, tiny],
        motor=rng.integers(0, 4, rows),
        dry_mass=rng.uniform(0.1, 0.8, rows),
        drag_area=rng.uniform(0, 2e-2, rows),
        thrust_factor=rng.uniform(0.5, 1.2, rows),
        burn_stretch=rng.uniform(0.5, 1.5, rows),
        wind=np.where(upright, 0.0, rng.uniform(0, 8, rows)),
        rail_angle=np.where(upright, 0.0, rng.uniform(0, 0.2, rows)),
        rail_across=np.where(level, 0.0, rng.uniform(-0.2, 0.2, rows)),
        rail_friction=np.where(rng.random(rows) < 0.7, 0.0, rng.uniform(0, 20, rows)),
        rail_length=rng.uniform(0.5, 3, rows),
        turn_length=rng.uniform(2, 8, rows),
        power_off_drag=rng.uniform(1, 1.2, rows),
        opening_time=rng.uniform(0.1, 1, rows),
        descent_speed=rng.uniform(2, 9, rows),
        delay=np.where(rng.random(rows) < 0.3, np.nan, rng.uniform(0, 9, rows)),
        air=Air(rng.uniform(0.8, 1.3, rows), rng.uniform(270, 310, rows)),
    )


def alone(setup: Setup, row: int, flat: tuple[int, ...]) -> FlightResult:
    return fly(setup.flat(flat).part(np.array([row])))


@pytest.mark.sampled
@pytest.mark.parametrize("chunk", [5, 8192])
@pytest.mark.parametrize("forces", [(), ((nothing, np.asarray(1.0)),)], ids=["plain", "forces"])
def test_a_batch_equals_its_members_simulated_alone(monkeypatch: pytest.MonkeyPatch, chunk: int, forces: Any) -> None:
    setup = mixed().with_changes(forces=forces)
    monkeypatch.setattr(flying, "CHUNK", chunk)
    together = fly(setup)
    assert 0 < together.lift_off.sum() < 24
    np.testing.assert_array_equal(together.apogee, apogees(setup))
    for row in range(24):
        single = alone(setup, row, (24,))
        for field in fields(FlightResult):
            here, there = getattr(together, field.name)[row], getattr(single, field.name)[0]
            np.testing.assert_allclose(here, there, rtol=1e-9, atol=1e-9, err_msg=f"{field.name} of row {row}")


def test_axes_of_a_batch_are_preserved() -> None:
    area, mass = np.array([[1e-3], [2e-3]]), np.array([0.3, 0.4, 0.5])
    grid = apogees(rocket(NOISY, drag_area=area, dry_mass=mass))
    assert grid.shape == (2, 3)
    np.testing.assert_allclose(grid[1, 2], apogees(rocket(NOISY, drag_area=2e-3, dry_mass=0.5)), rtol=1e-12)


def test_an_upright_planar_flight_is_the_vertical_one() -> None:
    upright: dict[str, Any] = {"drag_area": np.linspace(0, 6e-3, 12), "delay": 3.0}
    vertical = fly(rocket(LONG, 400, forces=((nothing, np.asarray(1.0)),), **upright))
    planar = fly(rocket(LONG, 400, rail_angle=1e-12, **upright))
    closed = fly(rocket(LONG, **upright))
    for field in fields(FlightResult):
        here, there = getattr(planar, field.name), getattr(vertical, field.name)
        np.testing.assert_allclose(here, there, rtol=1e-6, atol=1e-6, err_msg=field.name)
    np.testing.assert_allclose(planar.apogee, closed.apogee, atol=0.1)


def test_mirroring_changes_only_the_side() -> None:
    wind, angle = np.array([0.0, 3.0, 6.0]), np.radians([5.0, -3.0, 0.0])
    here, there = fly(rocket(NOISY, wind=wind, rail_angle=angle)), fly(rocket(NOISY, wind=-wind, rail_angle=-angle))
    np.testing.assert_allclose(here.apogee, there.apogee, rtol=1e-12)
    np.testing.assert_allclose(here.drift, -there.drift, rtol=1e-12)
    assert np.all(np.abs(here.drift) > 1)


@pytest.mark.parametrize("rail_angle", [0.0, 0.1])
def test_large_steps_agree_with_small_steps(rail_angle: float, monkeypatch: pytest.MonkeyPatch) -> None:
    changes: dict[str, Any] = {"wind": 20 * rail_angle, "rail_angle": rail_angle, "drag_area": np.linspace(0, 6e-3, 9)}
    usual = fly(rocket([LONG], **changes))
    monkeypatch.setattr(coasting, "_count", lambda wanted: np.full_like(wanted, 400))
    fine = fly(rocket([LONG], 300, **changes))
    np.testing.assert_allclose(usual.apogee, fine.apogee, atol=0.1)
    np.testing.assert_allclose(usual.drift, fine.drift, atol=0.3)
    np.testing.assert_allclose(usual.top_speed, fine.top_speed, atol=0.02)
    np.testing.assert_allclose(usual.rail_speed, fine.rail_speed, rtol=0.005)


# The pad, the charge and the readouts


def test_a_motor_that_cannot_lift_its_rocket_gives_zeros() -> None:
    flown = fly(rocket(NOISY, dry_mass=np.array([0.4, 40.0]), delay=4.0, drag_area=np.array([0.0, 2e-3])))
    np.testing.assert_array_equal(flown.lift_off, [1, 0])
    assert flown.apogee[0] > 10
    for field in fields(FlightResult):
        assert getattr(flown, field.name)[1] == 0, field.name


def test_thrust_below_weight_is_waited_out_on_the_pad() -> None:
    late = Push((0.0, 1.0, 1.1, 2.0), (0.0, 3.0, 40.0, 40.0))
    soon = Push((0.0, 0.1, 1.0), (3.0, 40.0, 40.0))
    np.testing.assert_allclose(fly(rocket(late)).apogee, fly(rocket(soon)).apogee, atol=0.02)
    np.testing.assert_allclose(fly(rocket(late)).burn_time, fly(rocket(soon)).burn_time, atol=1e-3)


def test_a_rocket_that_turns_down_under_power_has_its_apogee_there() -> None:
    sagging = Push((0.0, 0.5, 0.500001, 8.0), (30.0, 30.0, 0.5, 0.5))
    flown = fly(rocket(sagging, drag_area=0.0))
    speed, slows = (30 / 0.4 - GRAVITY) * 0.5, GRAVITY - 0.5 / 0.4
    assert flown.apogee == pytest.approx(speed * 0.25 + speed**2 / (2 * slows), rel=1e-5)
    assert flown.coast_to_apogee == pytest.approx(speed / slows, rel=1e-5)


def test_a_charge_before_apogee_lowers_it_and_the_later_the_less() -> None:
    plain = fly(rocket(NOISY, dry_mass=0.3))
    burnout, top = NOISY.burnout, plain.burn_time + plain.coast_to_apogee
    flown = fly(rocket(NOISY, dry_mass=0.3, delay=np.linspace(0, 1.2 * float(top) - burnout, 200)))
    assert np.all(np.diff(flown.apogee) > -1e-3)
    early = flown.apogee_to_eject < -0.5
    assert early.sum() > 20
    assert np.all(flown.apogee[early] < plain.apogee)
    np.testing.assert_allclose(flown.apogee[flown.apogee_to_eject > 0.01], plain.apogee, rtol=1e-12)
    np.testing.assert_allclose(flown.rise_time + flown.cut_short, plain.rise_time, rtol=1e-12)
    assert np.all(flown.cut_short[early] > 0)


@pytest.mark.parametrize("changes", [{}, {"rail_angle": 1e-9}], ids=["layers", "steps"])
def test_a_charge_at_apogee_does_not_change_it(changes: dict[str, Any]) -> None:
    at_apogee = 9.0 - fly(rocket(NOISY, delay=9.0, **changes)).apogee_to_eject
    around = at_apogee + np.array([-1.0, -0.55, -0.51, -0.49, -0.01, -1e-6, 1e-6, 0.1])
    flown = fly(rocket(NOISY, delay=around, **changes))
    assert np.abs(np.diff(flown.apogee[2:])).max() < 0.01
    assert np.all(flown.eject_altitude <= flown.apogee + 1e-6)
    np.testing.assert_allclose(flown.apogee_to_eject[-3:], [-1e-6, 1e-6, 0.1], atol=1e-7)


def test_readouts_are_consistent_with_each_other() -> None:
    setup = mixed(200)
    flown = fly(setup)
    up = flown.lift_off == 1
    get = {field.name: getattr(flown, field.name)[up] for field in fields(FlightResult)}
    np.testing.assert_allclose(get["top_speed"], get["avg_accel"] * get["burn_time"], rtol=1e-12)
    assert np.all(get["peak_accel"] >= get["avg_accel"])
    assert np.all(get["burn_time"] > 0)
    assert np.all(get["rail_speed"] <= get["top_speed"] + 1e-9)
    assert np.all(get["apogee"] < get["top_speed"] * (get["burn_time"] + get["coast_to_apogee"]))
    assert np.all(get["duration"] > get["burn_time"] + get["coast_to_apogee"])
    known = np.isfinite(get["eject_altitude"])
    assert np.all(get["eject_altitude"][known] <= get["apogee"][known] + 1e-6)
    np.testing.assert_array_equal(known, np.isfinite(get["apogee_to_eject"]))


def test_an_altimeters_gain_scales_only_heights() -> None:
    plain, shown = (fly(rocket(NOISY, altimeter_gain=gain, delay=5.0)) for gain in (1.0, 0.93))
    readings, others = shown.readouts(), plain.readouts()
    for name, value in readings.items():
        factor = 0.93 if name in ("apogee", "eject_altitude") else 1.0
        np.testing.assert_allclose(value, factor * others[name], rtol=1e-12, err_msg=name)
    np.testing.assert_allclose(shown.apogee, plain.apogee)


def test_a_descent_under_a_parachute_takes_height_over_speed() -> None:
    flown = fly(rocket(NOISY, air=EVEN_AIR, descent_speed=4.0, delay=7.0, opening_time=0.0))
    charge = flown.burn_time + flown.coast_to_apogee + flown.apogee_to_eject
    slows = 4.0 / GRAVITY * np.log(2 / (1 + flown.eject_speed / 4.0))
    np.testing.assert_allclose(flown.duration, charge + flown.eject_altitude / 4.0 + slows, rtol=1e-9)


@pytest.mark.parametrize("area", [0.0, 1e-9])
def test_no_drag_is_the_limit_of_little_drag(area: float) -> None:
    flown = fly(rocket(NOISY, drag_area=area, delay=9.0))
    none = {field.name: float(getattr(flown, field.name)) for field in fields(FlightResult)}
    assert all(np.isfinite(value) for value in none.values()), none
    wait = none["apogee_to_eject"]
    assert none["eject_altitude"] == pytest.approx(none["apogee"] - 0.5 * GRAVITY * wait**2, rel=1e-4)
    never = fly(rocket(NOISY, drag_area=area, delay=60.0))
    fall = np.sqrt(2 * never.apogee / GRAVITY)
    np.testing.assert_allclose(never.duration, never.burn_time + never.coast_to_apogee + fall, rtol=1e-4)


# The air


@pytest.mark.parametrize(("height", "density"), [(0, 1.2250), (1000, 1.1117), (2000, 1.0066), (5000, 0.7364)])
def test_the_air_agrees_with_the_standard_atmosphere(height: float, density: float) -> None:
    """U.S. Standard Atmosphere 1976, table I."""
    assert STANDARD_AIR.density * STANDARD_AIR.density_ratio(np.asarray(float(height))) == pytest.approx(
        density, rel=6e-4
    )
    assert float(pad_air(np.asarray(float(height)), NAN, NAN, NAN).density) == pytest.approx(density, rel=6e-4)


def test_density_decreases_equally_from_the_pad_and_from_sea_level() -> None:
    high = pad_air(np.asarray(1500.0), NAN, NAN, NAN)
    sea = STANDARD_AIR.density * STANDARD_AIR.density_ratio(np.asarray(2300.0))
    np.testing.assert_allclose(high.density * high.density_ratio(np.asarray(800.0)), sea, rtol=1e-6)


def test_humid_and_hot_air_is_less_dense_and_high_pressure_air_is_denser() -> None:
    def density(kelvin: float, pascal: float, humidity: float) -> float:
        return float(pad_air(NAN, *(np.asarray(x, float) for x in (kelvin, pascal, humidity))).density)

    dry, humid = density(303.15, 101325, 0.0), density(303.15, 101325, 1.0)
    assert density(303.15, 101325, np.nan) == dry
    assert humid / dry == pytest.approx(1.1459 / 1.1644, abs=6e-4), "CIPM-2007 at 30 degrees"
    assert density(313.15, 101325, 0.0) < dry < density(303.15, 103000, 0.0)


def test_a_pressure_is_read_as_station_or_sea_level_pressure_whichever_is_nearer() -> None:
    elevation = np.asarray(1600.0)
    station = STANDARD_PRESSURE * (1 - LAPSE * 1600 / STANDARD_TEMPERATURE) ** HYDROSTATIC_EXPONENT
    np.testing.assert_allclose(station_pressure(np.asarray(102000.0), elevation), station * 102000 / STANDARD_PRESSURE)
    np.testing.assert_allclose(station_pressure(np.asarray(83100.0), elevation), 83100)
    np.testing.assert_allclose(station_pressure(np.asarray(99000.0), np.asarray(0.0)), 99000)


@CASES
@given(
    elevation=st.floats(-300, 3000),
    kelvin=st.floats(250, 315),
    sea=st.floats(97000, 104000),
    height=st.floats(10, 3000),
)
def test_altimeters_show_the_pressure_altitude_of_the_standard_atmosphere(
    elevation: float, kelvin: float, sea: float, height: float
) -> None:
    pad = float(station_pressure(np.asarray(sea), np.asarray(elevation)))
    aloft = pad * (1 - LAPSE * height / kelvin) ** HYDROSTATIC_EXPONENT

    def standard_height(pressure: float) -> float:
        return float(STANDARD_TEMPERATURE / LAPSE * (1 - (pressure / STANDARD_PRESSURE) ** (1 / HYDROSTATIC_EXPONENT)))

    gain = altimeter_gain(np.asarray(elevation), np.asarray(kelvin), np.asarray(sea))
    assert height * gain == pytest.approx(standard_height(aloft) - standard_height(pad), rel=1e-9)


# Motors


def test_motors_of_every_kind_become_thrust_curves() -> None:
    assert isinstance(catalogue().motors[0], Curve)
    assert isinstance(paper.MOTORS[0], Curve)
    assert isinstance(NOISY, Curve)
    assert not isinstance(object(), Curve)


@pytest.mark.parametrize("steps", [1, 12, 40])
def test_propellant_burns_off_with_the_impulse_and_ends_at_burnout(steps: int) -> None:
    table = rocket([NOISY, LONG], steps).burns
    assert np.all(table.spent[0, 0] == 0)
    assert np.all(table.spent[-1, -1] == 1)
    for column, motor in enumerate((NOISY, LONG)):
        length = np.diff(table.edge[:, column])
        start, middle, end = (table.thrust[:, stage, column] for stage in range(3))
        delivered = np.cumsum(length * (start + 4 * middle + end) / 6)
        np.testing.assert_allclose(delivered[-1], impulse(np.array(motor.time), np.array(motor.thrust)))
        np.testing.assert_allclose(table.spent[:, 2, column], delivered / delivered[-1], atol=1e-12)


@pytest.mark.parametrize(
    ("name", "index"),
    [
        ("E35-5W", 0),
        ("E35W-5", 0),
        ("F24-4W", 1),
        ("F24W-4", 1),
        ("AeroTech F24-4W", 1),
        ("f24", 1),
        ("F39", 2),
        ("F39T-6", 2),
        ("F39-6T", 2),
        (" Aerotech F39T ", 2),
    ],
)
def test_the_papers_motors_are_found_by_every_spelling(name: str, index: int) -> None:
    assert paper.motor_index(name) == index


@pytest.mark.parametrize("name", ["F240", "G39", "F25W-4", "Estes F24", "", "F24/F39"])
def test_the_papers_physics_has_no_other_motor(name: str) -> None:
    with pytest.raises(UnknownMotor, match="F24-4W"):
        paper.motor_index(name)
