"""Rules for every effect in the folder."""

import ast
from dataclasses import fields
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from fieldkit.flight import COLUMNS, Flight
from fieldkit.flight.launch_conditions import launch_conditions
from fieldkit.motors import catalogue
from fieldkit.physics.burn import burn
from fieldkit.physics.effect import Effect, effects
from fieldkit.physics.flight import fly
from fieldkit.physics.history import field_setup
from fieldkit.physics.rail import rail_exit_speed
from fieldkit.physics.setups import turn_lengths
from fieldkit.physics.state import FlightResult
from fieldkit.plugins import plugin_folder

pytestmark = pytest.mark.fast
CHECK_SHAPES = False

EFFECTS = effects()
FILES = sorted((plugin_folder("models") / "effects").glob("[!_]*.py"))
every_effect = pytest.mark.parametrize("name", EFFECTS)
MAY_IMPORT = ("fieldkit.physics", "fieldkit.flight", "fieldkit.errors", "fieldkit.messages", "fieldkit.shapes", "numpy")
PLAIN = ("collections", "dataclasses", "math", "typing", "functools")
"""Modules of Python's own library that effects may import."""

FLIGHTS = (
    Flight("1", dry_mass=0.322, diameter=0.066, delay=4.0, wind=4.0, motor="F24-4W", site="mead"),
    Flight("2", dry_mass=0.322, diameter=0.066, delay=6.0, wind=6.0, motor="F39-6T", site="mead", rail_length=1.5),
    Flight("3", dry_mass=0.25, diameter=0.05, delay=2.0, wind=3.0, motor="H219T", temperature=300.0, site="high"),
)
"""A slow, a medium and a fast flight, each with ejection before apogee if the delay is a little short."""
FASTER = {"mach_drag": 0.15, "flutter": 0.15}
"""Dry mass if an effect asks for speed. [kg]"""

LOWER = (
    *("base_drag", "early_ejection", "early_ejection_seconds", "flutter", "heavier_recovery", "launch_angle"),
    *("mach_drag", "mass_offset", "rail_friction", "tip_off", "wear", "wind"),
)
HIGHER = ("motor_thrust",)
"""Required sign of the change of apogee by a positive strength; for mass only above the optimum mass."""


def flown(name: str, strength: Any, flights: tuple[Flight, ...] = FLIGHTS) -> dict[str, Any]:
    """All figures of flights with one effect at a strength, including its effect on readings."""
    effect = EFFECTS[name]
    found = [catalogue().resolve(flight.motor) for flight in flights]
    area = 0.5 * np.pi / 4 * np.array([flight.diameter or 0.0 for flight in flights]) ** 2
    setup = effect.bend_setup(field_setup(flights, found, area), np.asarray(strength, float))
    result = fly(setup)
    figures = {field.name: getattr(result, field.name) for field in fields(FlightResult)}
    return figures | dict(effect.bend_reading(result.readouts(), np.asarray(strength, float)))


def some(effect: Effect) -> float:
    """An ordinary strength of the effect."""
    prior = effect.prior
    fitted = min(max(prior.mean + prior.sd, 0.2 * prior.sd), prior.high)
    return float(effect.strength(np.asarray(fitted)))


@pytest.mark.sampled
@every_effect
def test_an_effect_vanishes_at_zero_strength_with_a_rail_tilted_either_way(name: str) -> None:
    leaning = tuple(
        flight.with_changes(rail_angle=angle) for flight, angle in zip(FLIGHTS, (-0.1, 0.1, 0), strict=True)
    )
    without = flown("altimeter_scale", 0.0, leaning)
    for figure, value in flown(name, 0.0, leaning).items():
        np.testing.assert_allclose(value, without[figure], rtol=2e-4, atol=0.03, err_msg=figure)


@every_effect
def test_an_effect_vanishes_at_zero_strength(name: str) -> None:
    without = flown("altimeter_scale", 0.0)
    for figure, value in flown(name, 0.0).items():
        if EFFECTS[name].acceleration is None:
            np.testing.assert_allclose(value, without[figure], rtol=1e-9, atol=1e-9, err_msg=figure)
        else:
            np.testing.assert_allclose(value, without[figure], rtol=2e-4, atol=0.03, err_msg=figure)


@pytest.mark.parametrize("name", [name for name, effect in EFFECTS.items() if effect.acceleration])
def test_a_force_at_zero_strength_is_zero(name: str) -> None:
    force = EFFECTS[name].acceleration
    assert force is not None

    def none(state: Any, strength: Any) -> Any:
        return np.zeros_like(state.drag)

    found = [catalogue().resolve(flight.motor) for flight in FLIGHTS]
    setup = field_setup(FLIGHTS, found, np.full(3, 0.002))
    bent, plain = (fly(setup.with_changes(forces=((f, np.asarray(0.0)),))) for f in (force, none))
    for field in fields(FlightResult):
        here, there = getattr(bent, field.name), getattr(plain, field.name)
        np.testing.assert_allclose(here, there, rtol=1e-9, atol=1e-9, err_msg=field.name)


@every_effect
def test_an_effect_does_something_at_an_ordinary_strength(name: str) -> None:
    light = tuple(flight.with_changes(dry_mass=FASTER.get(name, flight.dry_mass)) for flight in FLIGHTS)
    before, after = flown(name, 0.0, light), flown(name, some(EFFECTS[name]), light)
    change = max(float(np.abs(after[key] / before[key] - 1).max()) for key in ("apogee", "burn_time"))
    shown = max(float(np.abs(after[key] - before[key]).max()) for key in ("apogee_to_eject", "apogee"))
    assert change > 0.005 or shown > 0.3


@pytest.mark.sampled
@every_effect
def test_draws_do_not_influence_each_other(name: str) -> None:
    strengths = some(EFFECTS[name]) * np.array([[0.0], [0.3], [1.0]])
    together = flown(name, np.broadcast_to(strengths, (3, 3)))
    for draw in range(3):
        alone = flown(name, strengths[draw])
        for figure, value in alone.items():
            figures = np.broadcast_to(together[figure], (3, 3))
            np.testing.assert_allclose(figures[draw], value, rtol=1e-9, atol=1e-9, err_msg=figure)


@pytest.mark.sampled
@every_effect
def test_flights_do_not_influence_each_other(name: str) -> None:
    together = flown(name, some(EFFECTS[name]))
    for number, flight in enumerate(FLIGHTS):
        alone = flown(name, some(EFFECTS[name]), (flight,))
        for figure, value in alone.items():
            np.testing.assert_allclose(together[figure][..., number], value[..., 0], rtol=1e-9, atol=1e-9)


@pytest.mark.parametrize(("name", "sign"), [(name, -1) for name in LOWER] + [(name, 1) for name in HIGHER])
def test_a_positive_strength_changes_the_apogee_in_the_documented_direction(name: str, sign: int) -> None:
    strengths = some(EFFECTS[name]) * np.linspace(0, 1, 6)[:, None]
    light = tuple(flight.with_changes(dry_mass=FASTER.get(name, flight.dry_mass)) for flight in FLIGHTS)
    heights = flown(name, np.broadcast_to(strengths, (6, 3)), light)["apogee"]
    assert np.all(sign * np.diff(heights, axis=0) > -0.05)
    assert np.any(sign * (heights[-1] - heights[0]) > 1)


def test_denser_air_lowers_the_apogee_and_a_longer_burn_keeps_the_impulse() -> None:
    assert np.all(flown("air_density", 0.1)["apogee"] < flown("air_density", 0.0)["apogee"])
    short, long = flown("thrust_curve", 0.0), flown("thrust_curve", 0.2)
    np.testing.assert_allclose(long["burn_time"], 1.2 * short["burn_time"], rtol=0.05)
    assert np.all(long["peak_accel"] < short["peak_accel"])


@pytest.mark.parametrize("name", ["site_elevation", "blank_elevation"])
@pytest.mark.parametrize("temperature", [None, 290.0])
def test_a_site_without_an_elevation_has_the_elevation_of_the_effect(name: str, temperature: float | None) -> None:
    unknown = tuple(flight.with_changes(site_elevation=None, temperature=temperature) for flight in FLIGHTS)
    known = tuple(flight.with_changes(site_elevation=1500.0) for flight in unknown)
    bent, declared = flown(name, 1500.0, unknown), flown(name, 0.0, known)
    for figure in ("apogee", "top_speed", "coast_to_apogee"):
        np.testing.assert_allclose(bent[figure], declared[figure], rtol=2e-4, err_msg=figure)


def test_a_day_without_a_temperature_has_the_temperature_of_the_effect() -> None:
    unknown = tuple(flight.with_changes(temperature=None, site_elevation=300.0) for flight in FLIGHTS)
    known = tuple(flight.with_changes(temperature=288.15 - 0.0065 * 300 + 14) for flight in unknown)
    bent, declared = flown("weather", 14.0, unknown), flown("weather", 0.0, known)
    for figure in ("apogee", "top_speed", "coast_to_apogee"):
        np.testing.assert_allclose(bent[figure], declared[figure], rtol=1e-6, err_msg=figure)


def test_an_altimeters_scale_changes_only_heights() -> None:
    true, shown = flown("altimeter_scale", 0.0), flown("altimeter_scale", 0.1)
    for figure, value in shown.items():
        factor = 1.1 if figure in ("apogee", "eject_altitude") else 1.0
        np.testing.assert_allclose(value, factor * true[figure], rtol=1e-12, err_msg=figure)


def test_an_altimeter_that_corrects_for_temperature_shows_true_heights() -> None:
    hot = tuple(flight.with_changes(temperature=308.0) for flight in FLIGHTS)
    plain, corrected = flown("altimeter_temperature", 0.0, hot), flown("altimeter_temperature", 1.0, hot)
    assert np.all(plain["apogee"] < 0.95 * corrected["apogee"])
    found = [catalogue().resolve(flight.motor) for flight in hot]
    area = 0.5 * np.pi / 4 * np.array([flight.diameter or 0.0 for flight in hot]) ** 2
    np.testing.assert_allclose(corrected["apogee"], fly(field_setup(hot, found, area)).apogee)


def test_a_delay_that_is_short_by_seconds_ejects_that_much_earlier() -> None:
    late = tuple(flight.with_changes(delay=delay) for flight, delay in zip(FLIGHTS, (9.0, 12.0, 15.0), strict=True))
    shift = flown("early_ejection_seconds", 0.7, late)["apogee_to_eject"]
    np.testing.assert_allclose(shift, flown("early_ejection_seconds", 0.0, late)["apogee_to_eject"] - 0.7, atol=1e-6)


def test_tip_off_falls_with_the_square_of_the_speed_off_the_rail() -> None:
    found = [catalogue().resolve(flight.motor) for flight in FLIGHTS]
    setup = field_setup(FLIGHTS, found, np.full(3, 0.002))
    speed = rail_exit_speed(setup)
    np.testing.assert_allclose(speed, fly(setup).rail_speed, rtol=0.03)
    angle = EFFECTS["tip_off"].bend_setup(setup, np.asarray(3.0)).rail_angle
    np.testing.assert_allclose(np.degrees(angle) * speed**2, 3.0 * 15.0**2, rtol=1e-9)


def test_base_drag_does_not_act_in_the_burn_and_a_coast_without_drag_is_as_in_vacuum() -> None:
    without, with_it = flown("base_drag", 0.0), flown("base_drag", 0.3)
    for figure in ("top_speed", "burn_time", "peak_accel", "rail_speed"):
        np.testing.assert_allclose(with_it[figure], without[figure], rtol=1e-9, err_msg=figure)
    found = [catalogue().resolve(flight.motor) for flight in FLIGHTS]
    setup = field_setup(FLIGHTS, found, np.full(3, 0.002))
    free = setup.with_changes(power_off_drag=np.asarray(0.0), delay=np.asarray(np.nan))
    track = burn(free.flat(free.draw_shape))
    gained = fly(free).apogee - track.position[0]
    np.testing.assert_allclose(gained, track.velocity[0] ** 2 / (2 * free.gravity), rtol=1e-4)


def test_a_heavy_rocket_turns_into_the_wind_later_and_a_stable_one_sooner() -> None:
    light, wide = FLIGHTS[0], FLIGHTS[0].with_changes(diameter=4 * 0.066)
    heavy, stable = light.with_changes(dry_mass=4 * 0.322), light.with_changes(extra={"stability_cal": "8"})
    flights = [light, heavy, wide, stable]
    lengths = turn_lengths(flights, [launch_conditions(one) for one in flights])
    np.testing.assert_allclose(lengths / lengths[0], [1.0, 2.0, 0.5, 0.5])
    assert 2.0 < lengths[0] < 5.0, "a quarter of the pitching wavelength of an ordinary model"
    unknown = light.with_changes(extra={"stability_cal": "about two"})
    assert turn_lengths([unknown], [launch_conditions(unknown)])[0] == lengths[0]
    low, high = (flown("wind", 1.0, (one.with_changes(wind=8.0),))["apogee"][0] for one in (stable, light))
    assert low < high


def test_an_effect_that_begins_at_a_flight_changes_the_same_quantity_as_its_constant_form() -> None:
    for late, kin in (("heavier_recovery", "mass_offset"), ("slow_lot", "thrust_curve")):
        np.testing.assert_allclose(flown(late, 0.1)["apogee"], flown(kin, 0.1)["apogee"])
        assert EFFECTS[late].form_of == kin
        assert not EFFECTS[late].from_first


def test_flutter_does_not_affect_slow_flights_and_costs_fast_ones_more() -> None:
    slow = tuple(flight.with_changes(dry_mass=0.9, motor="F24-4W") for flight in FLIGHTS[:1])
    assert flown("flutter", 0.0, slow)["top_speed"][0] < 100.0
    np.testing.assert_allclose(flown("flutter", 0.5, slow)["apogee"], flown("flutter", 0.0, slow)["apogee"], rtol=1e-3)
    light = tuple(flight.with_changes(dry_mass=0.2) for flight in FLIGHTS)
    loss = 1 - flown("flutter", 0.5, light)["apogee"] / flown("flutter", 0.0, light)["apogee"]
    order = np.argsort(flown("flutter", 0.0, light)["top_speed"])
    assert np.all(np.diff(loss[order]) > 0)


@every_effect
def test_an_effect_is_described_in_plain_words(name: str) -> None:
    effect = EFFECTS[name]
    for text in (effect.title, effect.explains, effect.unit, effect.source, effect.tell_apart):
        assert text
        assert text == text.strip()
        assert not text.endswith(".")
        assert "_" not in text, "a column's name is not plain words"
    assert len(effect.title.split()) <= 8
    assert len(effect.explains.split()) >= 6
    assert len(effect.tell_apart.split()) >= 4
    assert not any(jargon in effect.explains.lower() for jargon in ("prior", "posterior", "coefficient", "parameter"))


@every_effect
def test_a_prior_lies_inside_its_bounds(name: str) -> None:
    prior = EFFECTS[name].prior
    assert prior.low <= prior.mean <= prior.high
    assert prior.sd > 0
    assert prior.high - prior.low > prior.sd
    assert all(prior.low <= start <= prior.high for start in EFFECTS[name].starts)


@every_effect
def test_an_effect_changes_one_thing(name: str) -> None:
    effect = EFFECTS[name]
    assert sum(bend is not None for bend in (effect.setup, effect.acceleration, effect.reading)) == 1


@every_effect
def test_an_effect_requires_the_columns_without_which_it_cannot_act(name: str) -> None:
    effect = EFFECTS[name]
    if not effect.needs:
        return
    assert effect.needs in [column.name for column in COLUMNS]
    nothing = 0.0 if effect.declared else None  # a wind that was not recorded is not a calm
    bare = tuple(flight.with_changes(**{effect.needs: nothing}) for flight in FLIGHTS)
    with_it, without = flown(name, some(effect), bare), flown(name, 0.0, bare)
    np.testing.assert_allclose(with_it["apogee"], without["apogee"], rtol=1e-9)


@every_effect
def test_the_effect_of_a_squared_strength_is_even(name: str) -> None:
    """The square is fitted, so a strength and its negative must have the same effect."""
    effect = EFFECTS[name]
    if not effect.squared:
        assert effect.strength(np.asarray(-2.0)) == -2
        return
    assert effect.strength(np.asarray(9.0)) == 3
    here, there = flown(name, some(effect)), flown(name, -some(effect))
    np.testing.assert_allclose(here["apogee"], there["apogee"], rtol=1e-9)


@pytest.mark.parametrize("file", FILES, ids=lambda file: file.stem)
def test_an_effect_imports_only_allowed_modules(file: Path) -> None:
    for node in ast.walk(ast.parse(file.read_text("utf-8"))):
        names = [alias.name for alias in node.names] if isinstance(node, ast.Import) else []
        names += [node.module or "."] if isinstance(node, ast.ImportFrom) else []
        for name in names:
            ours = any(name == allowed or name.startswith(allowed + ".") for allowed in MAY_IMPORT)
            assert ours or name.split(".")[0] in PLAIN, f"{file.name} imports {name}"


def test_every_file_of_the_plugin_folder_is_an_effect() -> None:
    assert [file.stem for file in FILES] == list(EFFECTS)
    assert all(isinstance(effect, Effect) for effect in EFFECTS.values())
    assert len({effect.title for effect in EFFECTS.values()}) == len(EFFECTS)
