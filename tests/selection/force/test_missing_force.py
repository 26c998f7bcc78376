"""A force in simulated logs is found with its strength, and none is found if there is none."""

from functools import cache

import numpy as np
import pytest

from fieldkit.analysis import Forces
from fieldkit.motors import catalogue
from fieldkit.physics.atmosphere import pad_air
from fieldkit.selection.force.climb import ClimbTrack, RocketInputs, beside_model, track_of
from fieldkit.selection.force.one_flight import Law, law, missing_force
from fieldkit.selection.force.terms import library
from fieldkit.shapes import Array, Float

CHECK_SHAPES = False
RATE = 100
"""Samples a second."""
NOISE = 0.5
"""Noise of the accelerometer. [m/s^2]"""
AIR = pad_air(*(np.asarray(np.nan) for _ in range(4)))
SLOW = RocketInputs(catalogue().find("AeroTech F24W").motor, 0.322, 0.6 * np.pi / 4 * 0.066**2, AIR)
FAST = RocketInputs(catalogue().find("AeroTech G80T").motor, 0.25, 0.45 * np.pi / 4 * 0.038**2, AIR)


@cache
def climb(rocket: RocketInputs, term: str, strength: float) -> ClimbTrack:
    """A climb with one additional term of the library, without noise: the fixed point of force and motion."""
    time = np.arange(0, 25, 1 / RATE)
    burning, zero = time < rocket.motor.thrust_end, np.zeros(len(time))
    track = ClimbTrack(time, zero, zero, zero, np.full(len(time), NOISE), burning)
    for _ in range(40):
        model = beside_model(track, rocket)
        push = model.thrust - model.drag
        if term:
            column = next(one.column for one in library() if one.name == term)
            moved = ClimbTrack(time, track.height, track.speed, push, track.push_sd, burning)
            push = push + strength * column(beside_model(moved, rocket))
        net = np.where(time < 0.15, np.maximum(push - 9.80665, 0.0), push - 9.80665)
        speed = np.maximum(integral(net), -5.0)
        track = ClimbTrack(time, np.maximum(integral(speed), 0.0), speed, push, track.push_sd, burning)
    return track.part(np.arange(len(time)) < np.argmax((speed <= 0) & (time > 1)))


def integral(rate: Float[Array, "time"]) -> Float[Array, "time"]:
    return np.concatenate([[0.0], np.cumsum((rate[1:] + rate[:-1]) / (2 * RATE))])


def noisy(track: ClimbTrack, seed: int, *, smooth: int = 1) -> ClimbTrack:
    """The same as measured by an accelerometer, perhaps with smoothed noise."""
    rng = np.random.default_rng(seed)
    noise = np.convolve(rng.normal(0, NOISE, len(track.push) + smooth - 1), np.ones(smooth) / np.sqrt(smooth), "valid")
    speed = track.speed + rng.normal(0, 0.3, len(track.speed))
    return ClimbTrack(track.time_from_liftoff, track.height, speed, track.push + noise, track.push_sd, track.burning)


def forces(track: ClimbTrack, *, smoothed: bool = False) -> Forces:
    """A climb measured in a log, with an accelerometer or from heights."""
    none = np.full(len(track.speed), np.nan)
    return Forces(
        track.time_from_liftoff,
        track.height,
        track.speed,
        np.full(len(track.speed), 0.3),
        track.push,
        track.push_sd,
        track.burning,
        none,
        None if smoothed else track.window,
        "acceleration",
    )


def found(rocket: RocketInputs, term: str, strength: float, seed: int = 1, smooth: int = 1) -> Law:
    return law(missing_force(noisy(climb(rocket, term, strength), seed, smooth=smooth), rocket))


def test_the_simulated_climb_is_plausible() -> None:
    assert 200 < climb(SLOW, "", 0.0).height[-1] < 400
    assert climb(FAST, "", 0.0).speed.max() > 250


@pytest.mark.parametrize("smooth", [1, 15], ids=["white noise", "smoothed noise"])
def test_no_force_is_found_if_none_is_missing(smooth: int) -> None:
    alarms = [bool(found(SLOW, "", 0.0, seed, smooth).terms) for seed in range(16)]
    assert sum(alarms) <= 1


@pytest.mark.sampled
@pytest.mark.parametrize(
    ("rocket", "term", "strength"),
    [
        (SLOW, "drag", 0.3),
        (SLOW, "base drag", 0.4),
        (SLOW, "thrust", -0.1),
        (SLOW, "longer burn", 0.15),
        (SLOW, "rail", 12.0),
        (SLOW, "constant", 0.8),
        (SLOW, "linear in speed", 0.05),
        (FAST, "drag rise near the speed of sound", 0.8),
    ],
)
def test_an_added_force_is_found_with_its_strength(rocket: RocketInputs, term: str, strength: float) -> None:
    shown = found(rocket, term, strength)
    assert shown.terms[0].term.name == term
    assert len(shown.terms) == 1
    assert shown.terms[0].value == pytest.approx(strength, abs=max(5 * shown.terms[0].sd, 0.1 * abs(strength)))


@pytest.mark.usefixtures("shapes_checked")
def test_its_uncertainty_agrees_with_the_scatter_among_logs() -> None:
    shown = [found(SLOW, "base drag", 0.4, seed, smooth=5).terms[0] for seed in range(10)]
    values, sds = (np.array([getattr(one, name) for one in shown]) for name in ("value", "sd"))
    assert 0.4 < values.std() / sds.mean() < 2.5


def test_terms_of_the_plugin_folder_are_named_as_effects() -> None:
    assert found(SLOW, "base drag", 0.4).effects == ("base_drag",)
    assert found(SLOW, "thrust", -0.1).effects == ("motor_thrust",)
    assert found(SLOW, "linear in speed", 0.05).effects == ()


def test_a_late_lift_off_is_not_a_force() -> None:
    track = noisy(climb(SLOW, "", 0.0), 3)
    late = ClimbTrack(
        track.time_from_liftoff + 0.03, track.height, track.speed, track.push, track.push_sd, track.burning
    )
    assert law(missing_force(late, SLOW)).terms == ()


def test_smoothed_samples_have_less_weight() -> None:
    assert found(SLOW, "", 0.0, smooth=15).worth < 0.4 * found(SLOW, "", 0.0).worth


def test_measured_forces_are_used_unchanged() -> None:
    assert law(missing_force(track_of(forces(noisy(climb(SLOW, "base drag", 0.4), 1))), SLOW)).effects == ("base_drag",)


def test_a_guard_leaves_out_the_moment_of_burnout() -> None:
    track = climb(SLOW, "", 0.0)
    burnout = track.time_from_liftoff[track.burning].max()
    kept = missing_force(track, SLOW, guard=0.5).track.time_from_liftoff
    left_out = len(missing_force(track, SLOW).track.time_from_liftoff) - len(kept)
    assert left_out == pytest.approx(100, abs=2)
    assert kept.max() > burnout + 1
