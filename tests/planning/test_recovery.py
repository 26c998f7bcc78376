"""Recovery as flown: the descent is fitted to flights, and used for durations and landings."""

import json
import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from fieldkit.cli.main import main
from fieldkit.errors import BadValue
from fieldkit.flight import Flight
from fieldkit.flight.plan import check_plan
from fieldkit.flight.site import Site
from fieldkit.forecast.prediction import Prediction
from fieldkit.ledger import Ledger
from fieldkit.motors import PLUGGED_DELAY, Found, catalogue
from fieldkit.paths import REFERENCE_FLIGHTS
from fieldkit.physics.descent import Devices, FreeFall, descend, filling
from fieldkit.physics.flight import fly
from fieldkit.physics.history import field_setup
from fieldkit.physics.wind import WindProfile
from fieldkit.planning.check import SafetyCheck
from fieldkit.planning.descent import descents, durations
from fieldkit.planning.descent_rate import Fall, fall_of, usual
from fieldkit.planning.flown_descent import landing_mass, shown_speeds
from fieldkit.planning.forecasts import Plan, RocketData, forecasts
from fieldkit.planning.landing import (
    MAX_RECOMMENDED_ANGLE,
    TRIED_DRAWS,
    RailChoice,
    landing,
    rail_choices,
    wind_that_holds,
)
from fieldkit.planning.landing_speed import _too_fast
from fieldkit.planning.limits import limits
from fieldkit.planning.planned_flight import PlannedFlight, planned_flight
from fieldkit.planning.safety import safety_lines
from fieldkit.presentation.landing_text import landing_in_words, rail_in_words
from fieldkit.quantities import ShownUnits
from fieldkit.services.plans import completed_plan
from fieldkit.settings import Settings

CHECK_SHAPES = False
FOUND = catalogue().resolve("F39T-6")
NEW = RocketData((), ())
DUAL_LOG = Path(__file__).parents[2] / "sample_logs" / "altos_csv__a_barometer_alone.csv"
"""A flight on a drogue at 15 m/s and a main at 6 m/s."""
PLAN = Flight(rocket="Comet", motor="F39T-6", dry_mass=0.4, diameter=0.066, wind=4.0)


@pytest.fixture(scope="module")
def prediction() -> Prediction:
    return forecasts(NEW, [(PLAN, FOUND)], draws=300)[0]


def flown(speed: float, delay: float, main: float | None = None, drogue: float = 20.0) -> Flight:
    """A flight whose charge fires after its delay, with the record of a flyer with a stopwatch and an altimeter."""
    extra = {} if main is None else {"main_altitude_m": f"{main}"}
    flight = Flight(rocket="Comet", dry_mass=0.4, diameter=0.066, delay=delay, motor="F39T", extra=extra)
    up = fly(field_setup([flight], [FOUND], np.array([0.6 * np.pi / 4 * 0.066**2])))
    wait = np.zeros(1) if main else up.apogee_to_eject
    first = drogue if main else speed
    fills = filling(np.array([landing_mass(flight, FOUND)]), np.array([1.225]))
    devices = Devices(np.array([first]), np.array([speed]), main or 0.0, 0.5, fills)
    terminal = np.sqrt(2 * landing_mass(flight, FOUND) * 9.80665 / (1.225 * 0.6 * np.pi / 4 * 0.066**2))
    air = field_setup([flight], [FOUND], np.array([0.002])).air
    down = descend(FreeFall(up.apogee, wait, np.array([terminal])), devices, air, WindProfile())
    return flight.with_changes(apogee=float(up.apogee[0]), duration=float(up.rise_time[0] + down.time[0]))


def speed_of(fall: Fall) -> float:
    return float(np.exp(fall.log_mean) * np.sqrt(landing_mass(flown(5.0, 6.0), FOUND) / 1.225))


@pytest.mark.parametrize("delay", [6.0, 9.0, 12.0])
def test_a_known_delay_is_used_when_the_descent_is_fitted(delay: float) -> None:
    """If a charge fires late, the time before it is not time under the parachute."""
    fall = fall_of([(flown(6.0, delay), FOUND)])
    assert speed_of(fall) == pytest.approx(6.0, rel=0.02)


def test_the_timers_of_a_contest_are_a_duration() -> None:
    """They take precedence over an altimeter, which detects a landing late; a timer that is not a number is ignored."""
    flight = flown(6.0, 6.0)
    timed = {"timer_1_s": f"{flight.duration or 0.0:.2f}", "timer_2_s": f"{flight.duration or 0.0:.2f}"}
    for duration in (None, 90.0):
        fall = fall_of([(flight.with_changes(duration=duration, extra=timed), FOUND)])
        assert fall.flights == 1
        assert speed_of(fall) == pytest.approx(6.0, rel=0.02)
    typo = fall_of([(flight.with_changes(extra={"timer_1_s": "late"}), FOUND)])
    assert speed_of(typo) == pytest.approx(6.0, rel=0.02)


def test_a_recorded_ejection_height_substitutes_for_an_unknown_delay() -> None:
    known = flown(6.0, 10.0)
    up = fly(field_setup([known], [FOUND], np.array([0.6 * np.pi / 4 * 0.066**2])))
    read = replace(known, delay=None, eject_altitude=float(up.eject_altitude[0]))
    plain = Found(FOUND.motor, None)
    assert speed_of(fall_of([(read, plain)])) == pytest.approx(6.0, rel=0.03)
    assert speed_of(fall_of([(replace(read, eject_altitude=None), plain)])) > 6.5  # fall and parachute together


def test_two_devices_are_distinguished_by_the_main_speed_and_the_duration() -> None:
    flight = flown(5.0, 6.0, main=80.0, drogue=18.0).with_changes(descent_speed=5.0)
    plan = PLAN.with_changes(extra={"main_altitude_m": "80"})
    fall = fall_of([(flight, FOUND)], plan)
    assert fall.drogue is not None
    assert speed_of(fall.drogue) == pytest.approx(18.0, rel=0.03)
    assert speed_of(fall) == pytest.approx(5.0, rel=1e-6)


def test_a_streamer_falls_faster_and_flights_on_a_parachute_do_not_constrain_it() -> None:
    plan = PLAN.with_changes(extra={"recovery": "streamer"})
    fall = fall_of([(flown(5.0, 6.0), FOUND)], plan)
    assert (fall.flights, fall.log_mean) == (0, pytest.approx(usual("streamer").log_mean))
    assert np.exp(fall.log_mean - usual().log_mean) == pytest.approx(2.0)
    with pytest.raises(BadValue, match="parachute, streamer"):
        check_plan(Flight(extra={"recovery": "hope"}))
    with pytest.raises(BadValue, match="height at which the main opens"):
        check_plan(Flight(extra={"drogue_speed_mps": "20"}))


@pytest.mark.parametrize("mass", [0.1, 1.5, 12.0])
def test_an_unknown_parachute_is_assumed_to_suit_the_mass(mass: float) -> None:
    """OpenRocket's stored simulations of 0.07 to 12.7 kg all land at 4.4 to 7.2 m/s: a flyer buys one that does."""
    plan = PLAN.with_changes(dry_mass=mass)
    fall = fall_of([], plan, FOUND)
    rng = np.random.default_rng(2)
    speeds = fall.speeds(rng, (4000, 1), landing_mass(plan, FOUND), 1.225)
    assert float(np.median(speeds)) == pytest.approx(5.0, rel=0.02)


def test_a_typed_speed_or_diameter_of_the_parachute_is_used_until_flights_show_another() -> None:
    def lands(plan: Flight, *history: Flight) -> float:
        fall = fall_of([(flight, FOUND) for flight in history], plan, FOUND)
        rng = np.random.default_rng(3)
        return float(np.median(fall.speeds(rng, (4000, 1), landing_mass(plan, FOUND), 1.225)))

    typed, other = (PLAN.with_changes(extra={"main_speed_fps": text}) for text in ("26", "13"))
    assert lands(typed) == pytest.approx(26 * 0.3048, rel=0.02)
    assert lands(typed, flown(5.0, 6.0)) == pytest.approx(26 * 0.3048, rel=0.02)  # on another parachute
    same = flown(6.0, 6.0).with_changes(extra=typed.extra)
    assert lands(typed, same) == pytest.approx(6.0, rel=0.04)
    assert lands(other, same) == pytest.approx(13 * 0.3048, rel=0.02)
    wide = PLAN.with_changes(extra={"parachute_diameter_in": "18"})
    weight, area = landing_mass(PLAN, FOUND) * 9.80665, np.pi / 4 * (18 * 0.0254) ** 2
    assert lands(wide) == pytest.approx(np.sqrt(2 * weight / (1.225 * 0.75 * area)), rel=0.02)
    with pytest.raises(BadValue, match="main speed: found -2 m/s"):
        check_plan(PLAN.with_changes(extra={"main_speed_mps": "-2"}))


def test_one_timed_flight_narrows_the_descent_of_a_rocket_without_any() -> None:
    narrowed = [usual().relative_sd(more) for more in (0, 1, 4)]
    assert narrowed == pytest.approx([np.hypot(0.3, 0.1), np.hypot(0.1, 0.1), np.hypot(0.1, 0.05)])


def test_forecast_durations_agree_with_the_flight_they_were_fitted_to() -> None:
    flights = tuple((flown(6.0, 6.0).with_changes(flight_id=str(n)), FOUND) for n in range(5))
    rocket = RocketData(flights, ())
    plan = PLAN.with_changes(wind=None, delay=6.0)
    (one,) = forecasts(rocket, [(plan, FOUND)], draws=300)
    fall = fall_of(rocket.history, plan)
    speeds = fall.speeds(np.random.default_rng(1), (300, 1), landing_mass(plan, FOUND), 1.225)
    middle = float(np.median(durations([one], fall, speeds)))
    assert middle == pytest.approx(flights[0][0].duration or 0.0, rel=0.03)


def test_a_drogue_keeps_a_landing_near(prediction: Prediction) -> None:
    high = replace(prediction, true_apogee=prediction.true_apogee * 10)
    dual = replace(high, plan=PLAN.with_changes(extra={"main_altitude_m": "150", "drogue_speed_mps": "20"}))
    alone, with_drogue = (float(np.median(landing(one, fall_of([], one.plan)).away)) for one in (high, dual))
    assert with_drogue < 0.45 * alone


def test_without_a_wind_the_landing_is_unknown_but_the_drift_per_wind_speed_is_shown(
    prediction: Prediction,
) -> None:
    """The drift is the descent time times the mean wind on the way, less what the rocket flies into the wind."""
    calm = replace(prediction, plan=PLAN.with_changes(wind=None))
    fall = fall_of([], calm.plan, FOUND)
    found = landing(calm, fall)
    shown = found.json()
    assert (shown["away_m"], shown["downwind_m"], shown["ellipse"]) == (None, None, None)
    height, time = np.median(calm.true_apogee), np.median(found.duration - calm.rise_time)
    profile = WindProfile(1.0).components(np.linspace(0.0, height, 200))[0].mean()
    assert np.median(found.drift) == pytest.approx(time * profile, rel=0.08)
    assert np.median(found.drift) < time * profile
    words = " ".join(landing_in_words(PlannedFlight(calm, fall, found, (), ()), Site(size=300.0)))
    assert "unknown without the wind" in words
    assert " 0 m from the pad" not in words
    assert rail_choices(Plan(NEW, calm.plan, FOUND), 0.1) == []
    line = next(one for one in safety_lines(calm, Site(size=400.0), fall, limits()) if one.name == "field size")
    assert line.verdict == "unknown"
    assert "wind not given; drifts" in line.text


@pytest.mark.parametrize(
    ("size", "changes"),
    [
        (300.0, {}),
        (300.0, {"rail_angle": 0.17}),  # climbs into the wind, and so may fly in a stronger one
        (240.0, {"rail_angle": 0.1, "extra": {"main_altitude_m": "30", "drogue_speed_mps": "30"}}),
        (600.0, {"extra": {"wind_aloft_mps": "4"}}),
    ],
)
def test_up_to_the_maximum_wind_landings_stay_on_the_field(size: float, changes: dict[str, object]) -> None:
    plan = PLAN.with_changes(wind=None, **changes)
    wind = wind_that_holds(Plan(NEW, plan, FOUND), size)
    (prediction,) = forecasts(NEW, [(plan.with_changes(wind=wind), FOUND)], draws=1000)
    stay = np.mean(landing(prediction, fall_of([], plan, FOUND)).away <= size / 2)
    by_chance = np.sqrt(0.95 * 0.05 * (1 / TRIED_DRAWS + 1 / 1000))  # of the two sets of draws
    assert stay == pytest.approx(0.95, abs=3 * by_chance)


def test_in_no_wind_a_tilted_rail_misses_a_small_field_and_in_any_wind_a_fast_descent_hits_a_large_one() -> None:
    calm = PLAN.with_changes(wind=None)
    leaning = planned_flight(Plan(NEW, calm.with_changes(rail_angle=0.17), FOUND), Site(size=60.0), limits())
    fast = calm.with_changes(dry_mass=0.9, extra={"main_altitude_m": "30", "drogue_speed_mps": "40"})
    wide = planned_flight(Plan(NEW, fast, FOUND), Site(size=1000.0), limits())

    site = Site(size=60.0)

    def words(one: PlannedFlight) -> str:
        return " ".join(landing_in_words(one, site))

    assert "even in calm air" in words(leaning)
    assert "in any wind up to 10" in words(wide)
    assert planned_flight(Plan(NEW, PLAN, FOUND), site, limits()).holds is None


def test_an_altimeter_that_opens_a_drogue_at_apogee_needs_no_delay(prediction: Prediction) -> None:
    def line(**changes: object) -> SafetyCheck:
        one = replace(prediction, plan=prediction.plan.with_changes(**changes))
        lines = safety_lines(one, Site(), fall_of([], one.plan, FOUND), limits())
        return next(check for check in lines if check.name == "ejection speed")

    dual = line(extra={"main_altitude_m": "150"}, delay=PLUGGED_DELAY)
    assert dual.verdict == "ok"
    assert "altimeter opens the drogue at apogee" in dual.text
    assert line(delay=PLUGGED_DELAY).verdict == "caution"
    assert "plugged" in line(delay=PLUGGED_DELAY).text
    assert line(delay=0.0).verdict == "unsafe"  # a booster has no charge


@pytest.mark.parametrize(
    ("main", "drogue", "verdicts"),
    [
        ("150", "20", ("ok", "ok")),
        ("61", "15.3", ("ok", "ok")),  # just above 200 ft and 50 ft/s
        ("60", "15.2", ("caution", "caution")),
        ("457", "45.7", ("ok", "ok")),  # just below 1,500 ft and 150 ft/s
        ("458", "45.8", ("caution", "caution")),
        ("150", "", ("unknown", "ok")),
    ],
)
def test_drogue_and_main_are_checked(prediction: Prediction, main: str, drogue: str, verdicts: tuple[str, str]) -> None:
    """Source: student launch teams, the IREC design guide, and Eggtimer's least altitude for deployment."""
    extra = {"main_altitude_m": main} | ({"drogue_speed_mps": drogue} if drogue else {})
    one = replace(prediction, plan=prediction.plan.with_changes(extra=extra))
    lines = {line.name: line for line in safety_lines(one, Site(), fall_of([], one.plan, FOUND), limits())}
    assert (lines["drogue speed"].verdict, lines["main altitude"].verdict) == verdicts
    assert "drogue speed" not in {line.name for line in safety_lines(prediction, Site(), usual(), limits())}


def test_figures_are_only_in_the_units_of_the_flyer(prediction: Prediction) -> None:
    lines = safety_lines(prediction, Site(size=300.0, people=20.0, ceiling=500.0), usual(), limits())
    metric, american = (
        [one.words(system).partition(". The rule")[0].partition(" [")[0] for one in lines[:-1]]
        for system in ("SI", "US")
    )
    assert not [line for line in metric if re.search(r"\d (ft|mph|°F|oz)\b", line)]
    assert not [line for line in american if re.search(r"\d (m|m/s|°C|g)\b", line)]
    down = landing(prediction, usual())
    rail = RailChoice("into", 0.1, (1.0, 2.0, 3.0), prediction)
    words = [*landing_in_words(PlannedFlight(prediction, usual(), down, (), (rail,)), Site(size=300.0), "US")]
    assert not [line for line in words if re.search(r"\d (m|m/s)\b", line)]


def test_the_ellipse_contains_nine_landings_in_ten(prediction: Prediction) -> None:
    found = landing(prediction, usual())
    inside = found.ellipse().inside(found.along, found.across).mean()
    assert inside == pytest.approx(0.9, abs=0.05)
    assert np.median(found.along) > 0
    assert abs(np.median(found.across)) < 0.2 * np.median(found.along)
    outline = found.ellipse().outline()
    assert (
        found.ellipse().inside(outline[:, 0] * 0.999 + 0.001 * found.along.mean(), outline[:, 1] * 0.999).mean() > 0.9
    )


def test_a_rail_into_the_wind_brings_the_landing_closer() -> None:
    choices = rail_choices(Plan(NEW, PLAN, FOUND), np.radians(20))
    upright = next(choice for choice in choices if choice.angle == 0)
    assert choices[0].direction == "into"
    assert choices[0].angle > 0
    assert choices[0].away[1] < upright.away[1]
    assert all(choice.angle <= np.radians(5) + 1e-9 for choice in rail_choices(Plan(NEW, PLAN, FOUND), np.radians(5)))


def test_a_charge_that_fires_too_late_means_a_ballistic_landing(prediction: Prediction) -> None:
    late = replace(prediction, plan=PLAN.with_changes(delay=20.0), eject=np.full_like(prediction.eject, np.nan))
    assert descents(late, usual(), np.full(300, 5.0)).ballistic.all()
    unknown = replace(late, plan=PLAN.with_changes(delay=None), found=Found(FOUND.motor, None))
    assert not descents(unknown, usual(), np.full(300, 5.0)).ballistic.any()


def test_a_plan_descends_like_the_last_flight_of_its_configuration(tmp_path: Path) -> None:
    with Ledger.open(str(tmp_path / "ledger.db")) as ledger:
        flight = PLAN.with_changes(flight_id="1", apogee=200.0, extra={"main_altitude_m": "80", "unrelated": "x"})
        ledger.add([flight])
        plan = completed_plan(ledger, catalogue(), Flight(rocket="Comet", motor="F39T-6"), Settings())
        assert plan.extra == {"main_altitude_m": "80"}


@pytest.mark.thorough
def test_a_log_on_a_drogue_and_a_main_is_forecast_with_both_speeds(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """It once landed at the mean speed of both, on one parachute, and unsafely."""
    ledger = ["--ledger", str(tmp_path / "ledger.db")]
    setup = [part for one in ("rocket=Big", "motor=F39T-6", "dry_mass=500g") for part in ("--set", one)]
    assert main([*ledger, "import", str(DUAL_LOG), *setup]) == 0
    capsys.readouterr()
    assert main([*ledger, "landing", "--rocket", "Big", "--motor", "F39T-6", "--wind", "2m/s", "--json"]) == 0
    document = json.loads(capsys.readouterr().out)
    (landing_check,) = [line for line in document["safety"] if line["check"] == "landing speed"]
    assert landing_check["verdict"] == "ok"
    assert document["landing"]["landing_speed_mps"]["p50"] == pytest.approx(6.0, rel=0.1)
    assert main([*ledger, "landing", "--rocket", "Big", "--motor", "F39T-6", "--wind", "2m/s"]) == 0
    (device,) = [line for line in capsys.readouterr().out.splitlines() if line.startswith("  landing ")]
    assert re.search(r"drogue at apogee, 1[45]\.\d m/s, main at 6\d m", device)


def test_without_a_landing_the_measured_drogue_is_used_and_an_entered_one_is_not_a_measurement() -> None:
    plan = flown(5.0, 6.0).with_changes(duration=None, apogee=400.0)
    known = {"main_altitude_m": "100", "drogue_speed_mps": "15"}
    found = catalogue().resolve("F39T-6")
    typed = shown_speeds(plan.with_changes(extra=known), found)
    measured = shown_speeds(plan.with_changes(extra={**known, "drogue_speed_sd_mps": "0.4"}), found)
    assert typed[1] is None
    assert measured[1] == pytest.approx(15.0)


@pytest.mark.parametrize(
    ("flown", "planned", "completed"),
    [
        ({"main_speed_mps": "5"}, {"parachute_diameter_mm": "900"}, {"parachute_diameter_mm": "900"}),
        ({"parachute_diameter_in": "18"}, {"main_speed_mps": "4"}, {"main_speed_mps": "4"}),
        ({"main_speed_mps": "5", "opening_time_s": "1"}, {"recovery": "streamer"}, {"recovery": "streamer"}),
        ({"recovery_notes": "in a tree", "recovery": "streamer"}, {}, {"recovery": "streamer"}),
        ({"main_speed_mps": "5", "stability_cal": "2"}, {}, {"main_speed_mps": "5", "stability_cal": "2"}),
    ],
)
def test_a_plan_with_another_parachute_does_not_use_the_speed_of_the_previous_one(
    tmp_path: Path, flown: dict[str, str], planned: dict[str, str], completed: dict[str, str]
) -> None:
    with Ledger.open(str(tmp_path / "ledger.db")) as ledger:
        ledger.add([PLAN.with_changes(flight_id="1", apogee=200.0, extra=flown)])
        plan = Flight(rocket="Comet", motor="F39T-6", extra=planned)
        assert completed_plan(ledger, catalogue(), plan, Settings()).extra == completed


@pytest.mark.parametrize(
    ("given", "basis", "noted"),
    [
        (["--main-speed", "5m/s"], "speed under the parachute as entered; one flight", False),
        (["--parachute-diameter", "450mm"], "diameter of the parachute as entered; one flight", False),
        (
            ["--main-speed", "5m/s", "--parachute-diameter", "450mm"],
            "speed under the parachute as entered and not its diameter; one flight",
            True,
        ),
    ],
)
def test_of_an_entered_speed_and_diameter_the_one_used_is_named(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], given: list[str], basis: str, noted: bool
) -> None:
    plan = ["landing", "--rocket", "Fresh", "--motor", "F39T-6", "--dry-mass", "400g", "--diameter", "66mm"]
    assert main(["--ledger", f"{tmp_path}/ledger.db", *plan, *given]) == 0
    shown = capsys.readouterr()
    assert basis in " ".join(shown.out.split())
    assert ("--main-speed is used" in shown.err) == noted


@pytest.mark.thorough
def test_the_command_prints_the_landing_and_writes_it_as_kml(
    tmp_path: object, capsys: pytest.CaptureFixture[str]
) -> None:
    ledger = ["--ledger", f"{tmp_path}/ledger.db"]
    assert main([*ledger, "import", str(REFERENCE_FLIGHTS)]) == 0
    capsys.readouterr()
    plan = ["landing", "--motor", "F24-4W", "--wind", "4m/s", "--wind-aloft", "9m/s", "--field-size", "400m"]
    kml = ["--kml", f"{tmp_path}/landing.kml", "--pad", "47.5,8.7", "--wind-from", "270"]
    assert main([*ledger, *plan, *kml, "--json"]) == 0
    document = json.loads(capsys.readouterr().out)
    assert document["landing"]["away_m"]["p50"] > 0
    assert document["on_field"] is not None
    assert document["rail"][0]["away_m"]["p50"] <= document["rail"][-1]["away_m"]["p50"]
    assert main([*ledger, *plan]) == 0
    out = " ".join(capsys.readouterr().out.split())
    assert "9.0 m/s at 300 m" in out
    assert "recommended rail" in out


def test_the_range_card_is_one_page(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    card, body = tmp_path / "card.png", ["--rocket", "Fresh", "--dry-mass", "400g", "--diameter", "66mm"]
    command = ["--ledger", str(tmp_path / "ledger.db"), "landing", "--motor", "F39T-6", "--wind", "3m/s", *body]
    assert main([*command, "--card", str(card)]) == 0
    assert card.read_bytes().startswith(b"\x89PNG")
    assert main([*command, "--card", str(tmp_path / "card.txt")]) == 1
    assert ".png" in capsys.readouterr().err


def test_the_range_card_has_the_conditions_of_its_forecast(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    card, body = tmp_path / "card.svg", ["--rocket", "Fresh", "--dry-mass", "400g", "--diameter", "66mm"]
    slanted = ["--rail-length", "1.5m", "--rail-angle", "5", "--rail-direction", "away", "--site", "Moor"]
    plan = ["landing", "--motor", "3 x F39T-6", "--wind", "3m/s", *slanted, *body]
    assert main(["--ledger", str(tmp_path / "ledger.db"), *plan, "--card", str(card)]) == 0
    words = " ".join(capsys.readouterr().out.split())
    card_text = card.read_text(encoding="utf-8")
    for prediction in ("rail 1.5 m", "away from the wind", "kg/m³ at the pad"):
        assert prediction in words
    for prediction in ("rail 1.5 m", "at 5° away", "kg/m³ at the pad"):
        assert prediction in card_text
    assert ", Moor" in card_text
    assert "as if every motor" in card_text


def test_many_failed_checks_use_the_width_of_the_range_card(tmp_path: Path) -> None:
    """They were printed in letters of half the size, wrapped at the width of the usual ones."""
    card, body = tmp_path / "card.svg", ["--rocket", "Bad", "--dry-mass", "6kg", "--diameter", "150mm"]
    day = ["--wind", "10m/s", "--rail-angle", "25", "--rail-length", "1m", "--field-size", "90m", "--people", "9m"]
    day += ["--bystanders", "30m", "--waiver", "90m", "--motor-temperature", "45c", "--rules", "NAR,Tripoli,FAA,CAR"]
    day += ["--main-altitude", "30m", "--drogue-speed", "6m/s", "--main-speed", "12m/s", "--stability-cal", "0.5"]
    plan = ["landing", "--motor", "2 x I316-17", *day, *body]
    assert main(["--ledger", str(tmp_path / "ledger.db"), *plan, "--card", str(card)]) == 0
    rows = re.findall(r"<!--(.*?)-->", card.read_text(encoding="utf-8"), flags=re.DOTALL)
    checks = [text.strip() for text in rows[rows.index(" Safety lines ") :]]
    assert len(checks) > 45
    assert 120 < max(map(len, checks)) < 170


def test_the_energy_of_a_landing_is_in_the_units_of_the_flyer() -> None:
    """12 m/s with 6 kg are 432 J, or 319 foot-pounds of force."""
    line = _too_fast("fast", 6 * 12.0**2 / 2, limits())
    assert "432 J if it lands in one piece, at most 102 J" in line.words("SI")
    assert "319 ft lbf if it lands in one piece, at most 75 ft lbf" in line.words("US")


def test_two_devices_are_opened_by_an_altimeter_and_an_early_charge_is_a_caution(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """A charge before apogee opens the rocket in fast flight, whatever its altimeter does; one after it is a backup."""
    body = ["--rocket", "Fresh", "--dry-mass", "1.4kg", "--diameter", "66mm", "--main-altitude", "150m"]
    verdicts = {}
    for delay in ("", "-6", "-14"):
        plan = ["landing", "--motor", f"AeroTech G80T{delay}", "--rail-length", "2m", *body, "--json"]
        assert main(["--ledger", str(tmp_path / "ledger.db"), *plan]) == 0
        checks = json.loads(capsys.readouterr().out)["safety"]
        (verdicts[delay],) = (one for one in checks if one["check"] == "ejection speed")
    assert [one["verdict"] for one in verdicts.values()] == ["ok", "caution", "ok"]
    assert "fires before apogee" in verdicts["-6"]["text"]


def test_a_map_states_its_assumed_wind(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    body = ["--rocket", "Fresh", "--dry-mass", "400g", "--diameter", "66mm", "--motor", "F39T-6", "--wind", "3m/s"]
    kml = ["--kml", str(tmp_path / "a.kml"), "--pad", "47.5,8.7", "--force"]
    plan = ["--ledger", str(tmp_path / "ledger.db"), "landing", *body, *kml]
    assert main(plan) == 0
    assert "assumes a wind from 270° (west)" in capsys.readouterr().err
    assert main([*plan, "--wind-from", "90"]) == 0
    assert "assumes" not in capsys.readouterr().err
    assert "<description>wind from 90 degrees, 3.0 m/s" in (tmp_path / "a.kml").read_text()


@pytest.mark.parametrize(
    ("margin", "verdict"),
    [("0.99", "caution"), ("1.0", "ok"), ("1.01", "ok"), ("3.0", "ok"), ("3.01", "caution")],
)
def test_a_known_static_margin_is_checked(margin: str, verdict: str, prediction: Prediction) -> None:
    plan = prediction.plan.with_changes(extra={"stability_cal": margin})
    lines = safety_lines(replace(prediction, plan=plan), Site(), usual(), limits())
    (found,) = [line for line in lines if line.name == "stability"]
    assert found.verdict == verdict
    assert found.text.startswith(f"{float(margin):.1f}" if margin != "0.99" else margin)


def test_the_stability_of_a_rocket_that_has_not_flown_is_asked_for(prediction: Prediction) -> None:
    new, flown = (
        next(line for line in safety_lines(one, Site(), usual(), limits()) if line.name == "stability")
        for one in (replace(prediction, rests_on=0), replace(prediction, rests_on=5, heaviest_motor=1.0))
    )
    assert (new.verdict, new.mark) == ("unknown", "O")
    assert "check it before flight" in new.text
    assert "I will check the stability before flight" in new.rule
    assert flown.verdict == "ok"
    assert "flown 5 times" in flown.text


def test_no_rail_is_recommended_for_a_rocket_that_lands_without_a_parachute(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    body = ["--rocket", "Fresh", "--dry-mass", "400g", "--diameter", "66mm", "--wind", "3m/s"]
    assert main(["--ledger", str(tmp_path / "ledger.db"), "landing", "--motor", "F39T-60", *body]) == 0
    assert "recommended rail: none: the rocket hits the ground" in capsys.readouterr().out


@pytest.mark.parametrize(
    ("changes", "why"),
    [
        ({"wind": 15.0}, "unsafe at every angle: rail exit speed, ground wind"),
        ({"wind": 4.0, "rail_length": 0.05}, "unsafe at every angle: rail exit speed"),
        ({"wind": 3.0, "dry_mass": 2.0}, "unsafe at every angle: thrust to weight"),
        ({"wind": 3.0, "delay": 0.0}, "at every angle ejection speed would be unsafe"),
        ({"wind": 3.0, "delay": 3.0}, "at every angle ejection speed would be unsafe"),
    ],
)
def test_no_rail_angle_is_recommended_for_a_flight_that_none_makes_safe(changes: dict[str, float], why: str) -> None:
    plan = PLAN.with_changes(delay=6.0, extra={"main_speed_mps": "5"}).with_changes(**changes)
    one = planned_flight(Plan(NEW, plan, FOUND), Site(), limits())
    assert one.rail == ()
    assert one.no_rail.startswith(why) or "ground before" in one.no_rail
    words = landing_in_words(one, Site())
    assert f"recommended rail: none: {one.no_rail}" in "\n".join(words)


def test_a_safe_rail_angle_is_recommended_for_an_unsafe_one() -> None:
    plan = PLAN.with_changes(wind=2.0, delay=6.0, rail_angle=0.78)
    one = planned_flight(Plan(NEW, plan, FOUND), Site(), limits())
    assert {line.name for line in one.lines if line.verdict == "unsafe"} & {"launch angle", "ejection speed"}
    assert one.no_rail == ""
    assert one.rail[0].angle <= MAX_RECOMMENDED_ANGLE
    assert rail_in_words(RailChoice("into", 0.0, (1.0, 57.0, 90.0), one.prediction), ShownUnits("SI")) == (
        "vertical, lands 57 m away"
    )


def test_the_landing_speed_is_that_under_the_parachute_of_the_flights_that_open_it() -> None:
    """With a delay that lets a third hit the ground first, the speed of those is no landing speed."""
    plan = PLAN.with_changes(delay=11.0, extra={"main_speed_mps": "5"})
    one = planned_flight(Plan(NEW, plan, FOUND), Site(), limits())
    assert 0.1 < one.down.down.ballistic.mean() < 0.5
    assert one.down.landing_speed[1] == pytest.approx(5.0, rel=0.15)
    assert one.down.json()["landing_speed_mps"]["p50"] == one.down.landing_speed[1]
    words = " ".join(landing_in_words(one, Site()))
    assert f"landing   at {one.down.landing_speed[1]:.1f} m/s" in words


@pytest.mark.parametrize(
    ("typed", "verdict", "expected"),
    [
        ({}, "unknown", "assumed"),
        ({"main_speed_mps": "1.5"}, "caution", "0.5 times as wide lands at 3.0 m/s"),
        ({"main_speed_mps": "5"}, "ok", "usual 3.0 m/s to 7.0 m/s"),
        ({"main_speed_mps": "8.5"}, "ok", "at most 9.1 m/s"),
        ({"main_speed_mps": "10.5"}, "caution", "1.5 times as wide lands at 7.0 m/s"),
        ({"main_speed_mps": "35"}, "unsafe", "J if it lands in one piece"),
        ({"recovery": "streamer", "main_speed_mps": "10.5"}, "caution", "at most 9.1 m/s"),
        ({"drogue_speed_mps": "20", "main_altitude_m": "4", "main_speed_mps": "5"}, "caution", "opens too low"),
    ],
)
def test_a_parachute_that_is_too_small_or_too_large_gives_a_safety_line(
    typed: dict[str, str], verdict: str, expected: str
) -> None:
    plan = PLAN.with_changes(extra=typed)
    line = next(
        one for one in planned_flight(Plan(NEW, plan, FOUND), Site(), limits()).lines if one.name == "landing speed"
    )
    assert line.verdict == verdict, line.text
    assert expected in line.text
    wrong_size = verdict in ("caution", "unsafe") and not {"recovery", "main_altitude_m"} & set(typed)
    assert ("as wide" in line.text) == wrong_size


def test_a_main_above_the_apogee_opens_there_and_the_landing_reports_it(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    body = ["--rocket", "Fresh", "--dry-mass", "400g", "--diameter", "66mm", "--motor", "F39T-6", "--wind", "3m/s"]
    words = "chance of an apogee below that: the main opens at apogee"
    for height, above in (("900m", True), ("60m", False)):
        dual = ["--drogue-speed", "20m/s", "--main-altitude", height]
        assert main(["--ledger", str(tmp_path / "ledger.db"), "landing", *body, *dual]) == 0
        assert (words in capsys.readouterr().out) == above


def test_a_rocket_that_lands_before_anything_opens_has_no_landing_speed() -> None:
    late = PLAN.with_changes(delay=40.0, extra={"main_speed_mps": "5"})
    lines = planned_flight(Plan(NEW, late, FOUND), Site(), limits()).lines
    line = next(one for one in lines if one.name == "landing speed")
    assert line.verdict == "unsafe"
    assert "before anything opens" in line.text


def test_a_landing_in_calm_air_is_uncertain() -> None:
    """Calm means less than 0.3 m/s: this much drift is possible in every direction."""
    down = planned_flight(Plan(NEW, PLAN.with_changes(wind=0.0), FOUND), Site(), limits()).down
    reach = np.quantile(down.away, 0.95)
    assert 0.2 * np.median(down.drift) < reach < 0.3 * np.quantile(down.drift, 0.99)
    ellipse = down.ellipse()
    assert ellipse.short > 0.7 * ellipse.long
    assert np.hypot(ellipse.along, ellipse.across) < 0.2 * ellipse.short
