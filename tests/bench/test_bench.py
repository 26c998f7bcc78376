"""Laws of the bench: its simulators follow the physics, and its altimeter follows the definitions of the readouts."""

import csv
import importlib.util
import json
import os
import subprocess
import sys
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from bench import barrowman, fast_truth
from bench.air import pressure_altitude, station_pressure
from bench.altimeter import RESOLUTION, Altimeter, barometric_height, exact_readouts, readouts
from bench.effects import EFFECTS
from bench.fleet import Flown
from bench.make import case, make
from bench.motors import motors
from bench.result import Errors, Result, effects, false_names
from bench.scenarios import SCENARIOS
from bench.score import _planned, score
from bench.tables import summary, table
from bench.vertical import climb
from bench.world import Air, Airframe, Drag, Launch, Track


def rocket(margin: float = 2.0, name: str = "F39T", mass: float = 0.4) -> Launch:
    """A calm launch of a 54 mm rocket on a vertical rail."""
    motor = motors()[name]
    frame = Airframe(0.0546, 0.9, 0.2, 3, 0.09, 0.05, 0.06, 0.04, 0.0)
    cg = barrowman.cg_for_margin(frame, mass, motor.total_mass, motor.length, margin)
    return Launch(replace(frame, dry_cg=cg), mass, motor, Drag(0.5), Air(), rail_length=1.2, delay=9.0)


LAUNCHES = {
    "calm": rocket(),
    "calm F24": rocket(name="F24W"),
    "calm, high": replace(rocket(), air=Air(elevation=1500, temperature=278.4)),
    "margin 1": replace(rocket(1.0), air=Air(wind=7)),
    "margin 2": replace(rocket(2.0), air=Air(wind=7)),
    "margin 3.5": replace(rocket(3.5), air=Air(wind=7)),
    "long rail": replace(rocket(), air=Air(wind=7), rail_length=3.0),
    "short rail": replace(rocket(), air=Air(wind=7), rail_length=0.9),
    "tilted": replace(rocket(3.0), air=Air(wind=6), tilt=0.05),
    "short delay": replace(rocket(), delay=4.0),
}


def flown(*launches: Launch) -> list[dict[str, float]]:
    return [exact_readouts(track, launch.air) for launch, track in zip(launches, fast_truth.fly(launches), strict=True)]


@pytest.fixture(scope="module")
def shown() -> dict[str, dict[str, float]]:
    """The exact readouts of `LAUNCHES`, simulated in one batch."""
    return dict(zip(LAUNCHES, flown(*LAUNCHES.values()), strict=True))


Shown = dict[str, dict[str, float]]


@pytest.mark.sampled
@pytest.mark.parametrize("name", ["calm", "calm F24", "calm, high"])
def test_in_calm_air_on_a_vertical_rail_the_rigid_rocket_flies_like_a_point_mass(shown: Shown, name: str) -> None:
    straight = climb(LAUNCHES[name])
    assert shown[name]["apogee_m"] == pytest.approx(straight.apogee, rel=0.003)
    assert shown[name]["top_speed_mps"] == pytest.approx(straight.top_speed, rel=0.003)


def test_more_static_margin_means_more_weathercocking(shown: Shown) -> None:
    heights = [shown[name]["apogee_m"] for name in ("calm", "margin 1", "margin 2", "margin 3.5")]
    assert heights == sorted(heights, reverse=True)
    assert heights[1] > heights[3] + 2


def test_a_slower_rail_exit_means_more_weathercocking(shown: Shown) -> None:
    assert shown["long rail"]["apogee_m"] > shown["short rail"]["apogee_m"] + 2


def test_the_time_step_is_small_enough_and_a_flight_does_not_depend_on_its_batch(
    shown: Shown, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(fast_truth, "FINE", 0.003)
    monkeypatch.setattr(fast_truth, "COARSE", 0.013)
    (alone,) = flown(LAUNCHES["tilted"])
    assert alone["apogee_m"] == pytest.approx(shown["tilted"]["apogee_m"], rel=2e-4)


def test_an_early_charge_costs_height_and_coast_time_but_no_speed(shown: Shown) -> None:
    late, early = shown["calm"], shown["short delay"]
    assert early["apogee_m"] < late["apogee_m"] - 10
    assert early["coast_to_apogee_s"] < late["coast_to_apogee_s"]
    assert early["top_speed_mps"] == pytest.approx(late["top_speed_mps"])
    assert early["apogee_to_eject_s"] < 0 < late["apogee_to_eject_s"]


def test_drag_rises_only_near_mach_one() -> None:
    factors = fast_truth.mach_factor(np.array([0.3, 0.7, 1.05, 2.0]), 0.8)
    assert factors == pytest.approx([1.0, 1.0, 1.8, 1 + 0.8 * 0.6])


def straight_track() -> Track:
    """1 s up to 100 m/s, 10 s coasting up, 10 s down to an ejection, then 5 m/s."""
    time = np.array([0, 0.5, 1, 6, 11, 21, 26, 31], dtype=float)
    height = np.array([0, 12.5, 50, 425, 550, 50, 25, 0], dtype=float)
    speed = np.array([0, 50, 100, 50, 0, 20, np.nan, np.nan])
    push = np.array([9.80665, 107.8732, 107.8732, 0, 0, 0, np.nan, np.nan])
    return Track(time, height, speed, push, liftoff=0.0, burnout=1.0, ejection=21.0)


def test_the_altimeters_readouts_follow_their_definitions() -> None:
    shown = exact_readouts(straight_track(), Air())
    assert list(shown) == [name for name in RESOLUTION if name in shown]
    assert shown["burn_time_s"] == 1.0
    assert shown["top_speed_mps"] == 100
    assert shown["avg_accel_g"] == pytest.approx(100 / 9.80665)
    assert shown["peak_accel_g"] == pytest.approx(10.0, abs=0.001)
    assert shown["descent_speed_mps"] == pytest.approx(5.0)
    assert shown["eject_altitude_m"] == pytest.approx(50.0)
    assert shown["coast_to_apogee_s"] + shown["apogee_to_eject_s"] == pytest.approx(20)
    assert shown["duration_s"] == 31


def test_the_altimeter_is_right_on_a_standard_day_and_low_on_a_hot_one() -> None:
    height = np.array([100.0, 1000.0])
    assert barometric_height(height, Air()) == pytest.approx(height, abs=1e-6)
    high = Air(elevation=1500, temperature=288.15 - 0.0065 * 1500)
    assert barometric_height(height, high) == pytest.approx(height, abs=1e-6)
    hot = barometric_height(height, Air(temperature=288.15 * 1.05))
    assert hot == pytest.approx(height / 1.05, rel=1e-3)


def test_station_pressure_and_pressure_altitude_are_inverse_functions() -> None:
    assert float(pressure_altitude(station_pressure(101325.0, 1234.0))) == pytest.approx(1234.0)


def test_the_gain_of_a_barometer_does_not_change_speed_and_times() -> None:
    true, scaled = exact_readouts(straight_track(), Air()), exact_readouts(straight_track(), Air(), 1.05)
    assert scaled["apogee_m"] == pytest.approx(1.05 * true["apogee_m"])
    for name in ("top_speed_mps", "burn_time_s", "peak_accel_g", "coast_to_apogee_s", "duration_s"):
        assert scaled[name] == pytest.approx(true[name])


def test_readings_are_multiples_of_the_last_digit_and_scatter_about_the_truth() -> None:
    rng = np.random.default_rng(1)
    exact = exact_readouts(straight_track(), Air())
    many = [readouts(straight_track(), Air(), Altimeter(), rng) for _ in range(300)]
    for name, digit in RESOLUTION.items():
        values = np.array([reading[name] for reading in many if name in reading])
        assert values / digit == pytest.approx(np.round(values / digit))
        if name != "avg_accel_g":
            assert values.mean() == pytest.approx(exact[name], rel=0.02)
    assert 0.002 < np.std([reading["apogee_m"] for reading in many]) / exact["apogee_m"] < 0.006


def test_every_scenario_has_known_effects_and_does_not_declare_them() -> None:
    for scenario in SCENARIOS.values():
        assert {part.effect for part in scenario.parts} <= set(EFFECTS)
        assert scenario.label in ("none", "unexplained") or all(scenario.label.split("+"))


def _bent(flown_: Flown) -> tuple[float, ...]:
    launch = flown_.launch
    return launch.dry_mass, float(launch.motor.thrust.sum()), launch.delay, flown_.gain


def test_an_effect_does_not_change_random_draws() -> None:
    for name in ("mass_offset", "motor_thrust", "altimeter_scale", "early_ejection"):
        found = case(SCENARIOS[name], 3, 2)
        pairs = list(zip(found.honest.flights, found.bent.flights, strict=True))
        assert all(a.scatter == b.scatter for a, b in pairs)
        assert all(a.declared["dry_mass_g"] == b.declared["dry_mass_g"] for a, b in pairs)
        assert any(_bent(a) != _bent(b) for a, b in pairs)


def test_a_wrong_elevation_affects_one_site_only() -> None:
    found = case(SCENARIOS["air_density"], 3, 1)
    site = found.parameters["air_density.site"]
    for flown_ in found.bent.flights:
        declared = flown_.declared.get("site_elevation_m", -1)
        assert (declared == round(flown_.launch.air.elevation)) == (flown_.site != site)


@pytest.fixture(scope="module")
def sets(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with one set."""
    folder = tmp_path_factory.mktemp("sets")
    make(folder, ["mass_offset"], 1, 7, "fast")
    return folder


@pytest.mark.thorough
def test_a_set_has_a_history_later_flights_and_a_label(sets: Path) -> None:
    (label,) = json.loads((sets / "labels.json").read_text())
    assert label["label"] == "mass_offset"
    for name, count in (("set_001", "n_flights"), ("set_001_future", "n_future")):
        with (sets / f"{name}.csv").open() as file:
            rows = list(csv.DictReader(file))
        assert len(rows) == label[count]
        assert all(row["motor"] and row["date_time"] for row in rows)
    assert label["ideal_mae_m"] < label["blind_mae_m"]


SEASON = """
from bench.make import case
from bench.scenarios import SCENARIOS
for flown in case(SCENARIOS["wear"], {seed}, 1).bent.flights:
    print(flown.when, flown.declared, flown.scatter)
"""


@pytest.mark.thorough
def test_the_same_seed_draws_the_same_season_in_any_process() -> None:
    def season(seed: int, hashing: str) -> str:
        environment = {**os.environ, "PYTHONHASHSEED": hashing, "PYTHONPATH": os.pathsep.join(sys.path)}
        command = [sys.executable, "-c", SEASON.format(seed=seed)]
        return subprocess.run(command, env=environment, capture_output=True, text=True, check=True).stdout

    first = season(7, "1")
    assert len(first.splitlines()) >= 24
    assert first == season(7, "2")


def test_planned_flights_contain_no_readouts(sets: Path, tmp_path: Path) -> None:
    with _planned(sets / "set_001_future.csv", tmp_path / "planned.csv").open() as file:
        header = next(csv.reader(file))
    assert "motor" in header
    assert not any(name.startswith(("apogee", "top_speed", "eject", "duration")) for name in header)


PRODUCT = """
import csv, json, os, sys
command = sys.argv[3]
if command == "import":
    print(json.dumps({"imported": 20, "duplicates": 0, "rejected": [], "flights": []}))
elif command == "loop":
    verdict = {"effect": "motor_thrust", "confidence": 0.9, "why": "x", "also": ["mass_offset"]}
    if "--effect" in sys.argv:
        assert sys.argv[sys.argv.index("--effect") + 1] == "mass_offset"
        open(sys.argv[2] + ".forced", "w").close()
    print(json.dumps({"verdict": verdict, "candidates": [{"effect": "motor_thrust"}, {"effect": "mass_offset"}]}))
else:
    rows = list(csv.DictReader(open(sys.argv[5])))
    forced = os.path.exists(sys.argv[2] + ".forced")
    high = 1e6 if sys.argv[7] == "after" else 300.0
    apogee = {"mean": 300.0, "p05": 0.0, "p50": 250.0 if forced else 300.0, "p95": high}
    print(json.dumps({"predictions": [{"flight_id": row["flight_id"], "apogee_m": apogee} for row in rows]}))
"""


def test_scoring_calls_the_product_as_specified(sets: Path, tmp_path: Path) -> None:
    product = tmp_path / "product.py"
    product.write_text(PRODUCT)
    (label,) = json.loads((sets / "labels.json").read_text())
    result = score(sets, label, [sys.executable, str(product)], timeout=20)
    assert not result.error
    assert result.right
    assert not result.named
    assert result.before is not None
    assert result.given is not None
    assert result.given.mae != result.before.mae
    assert result.gain == pytest.approx(1 - result.given.mae / result.before.mae)
    assert result.after is not None
    assert result.before.mae == result.after.mae > 0
    assert result.after.covered == result.after.flights == label["n_future"]
    assert "mass_offset | 1 | 0% | 100%" in table([result])
    broken = score(sets, label, [sys.executable, "-c", "raise SystemExit('no ledger here')"], timeout=20)
    assert "no ledger here" in broken.error
    assert "sets with an error: 1" in summary([result, broken])


def test_a_verdict_is_right_in_any_order_and_if_listed_as_indistinguishable() -> None:
    base = Result("s", "x", "wind+wear", 0.5, 1.0)
    assert effects("wear+wind") == effects(base.label)
    assert replace(base, verdict="wear+wind").named
    assert replace(base, verdict="wind", also=("wear+wind",)).right
    assert not replace(base, verdict="wind").right


def test_an_effect_of_a_pair_matters_if_the_fit_without_it_is_much_worse() -> None:
    before, given = (Errors(mae, 0.0, 9, 10, 5.0 * mae) for mae in (20.0, 10.0))
    pair = Result("s", "x", "altimeter_scale+wear", 0.5, 5.0, "wear", before=before, after=given, given=given)
    one = replace(pair, without={"altimeter_scale": 10.5, "wear": 19.0})
    both = replace(pair, without={"altimeter_scale": 14.0, "wear": 19.0})
    alone = replace(pair, label="wind", also=("base_drag+wind",))
    assert (one.needed, both.needed, alone.needed) == ({"wear"}, {"altimeter_scale", "wear"}, {"wind"})
    assert (one.found, both.found, alone.found) == ({"wear"}, {"wear"}, {"wind"})
    assert "the error without this one: 3 of 4" in summary([one, both, alone])


@pytest.mark.thorough
def test_scenarios_that_rocketpy_cannot_simulate_are_left_out_and_named(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr("bench.make._flier", lambda truth: fast_truth.fly)
    labels = make(tmp_path, ["rail_friction", "null", "unknown_hour", "null_realistic"], 1, 7, "rocketpy")
    assert [(label["scenario"], label["truth"]) for label in labels] == [("null", "rocketpy")]
    assert "left out, for RocketPy is not asked for it: rail_friction, unknown_hour, null_realistic" in (
        capsys.readouterr().err
    )


@pytest.mark.skipif(importlib.util.find_spec("rocketpy") is None, reason="rocketpy, of the extra `bench`, is missing")
@pytest.mark.filterwarnings("default")
def test_rocketpy_and_the_fast_simulator_agree_within_one_percent() -> None:
    from bench import truth

    launch = replace(rocket(), air=Air(wind=5, elevation=200), tilt=0.03)
    (fast,) = flown(launch)
    slow = exact_readouts(truth.fly(launch), launch.air)
    for name in ("apogee_m", "top_speed_mps", "coast_to_apogee_s", "peak_accel_g"):
        assert fast[name] == pytest.approx(slow[name], rel=0.01)


def _answer(effect: str, **sizes: float) -> dict[str, Any]:
    parameters = {name.replace("_", " "): {"mean": size} for name, size in sizes.items()}
    return {"verdict": {"effect": effect}, "candidates": [{"effect": effect, "parameters": parameters}]}


def test_a_name_is_false_if_nothing_of_half_its_stated_size_is_there() -> None:
    label = {"label": "none", "deviations": {"motor_thrust": {"G40W": -0.08, "G64W": 0.02}}}
    for size, false in ((-0.12, ()), (-0.3, ("motor_thrust",)), (0.1, ("motor_thrust",))):
        assert false_names(_answer("motor_thrust", **{"motor_thrust of AeroTech G40W": size}), label) == false
    assert false_names(_answer("wear", wear=0.02), label) == ("wear",)
    assert false_names(_answer("wear", wear=0.02), {"label": "wear"}) == ()
    assert false_names(_answer("none"), label) == ()


@pytest.mark.thorough
def test_seasons_in_a_world_scatter_by_what_their_flyer_scatters(tmp_path: Path) -> None:
    labels = make(tmp_path, ["null"], 4, 3, "fast", world="start")
    relative = [label["ideal_mae_m"] / label["apogee_mean_m"] for label in labels]
    assert 0.01 < min(relative) < max(relative) < 0.2
    assert all(set(label["deviations"]) >= {"motor_thrust", "mass_offset"} for label in labels)
