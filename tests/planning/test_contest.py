"""Contest seasons: the rule is in a file, and points follow the rule."""

import csv
import json
import re
from dataclasses import replace
from datetime import date
from pathlib import Path

import numpy as np
import pytest

from fieldkit.cli.main import main
from fieldkit.errors import BadValue
from fieldkit.flight import Flight
from fieldkit.ledger import Ledger
from fieldkit.motors import Found, catalogue
from fieldkit.paths import REFERENCE_FLIGHTS
from fieldkit.physics.flight import fly
from fieldkit.physics.history import field_setup
from fieldkit.planning.air import air_of
from fieldkit.planning.ballast import Goal, ballast
from fieldkit.planning.contest import copy_season, declared_score, score, season, season_of, seasons
from fieldkit.planning.contest_day import Day, read_window
from fieldkit.planning.contest_flight import judged_duration, why_no_score
from fieldkit.planning.contest_limits import allowed, approved_motors, motor_line
from fieldkit.planning.descent_rate import DESCENT_PRIOR_FLIGHTS, FLIGHT_TO_FLIGHT_SD, Fall, fall_of
from fieldkit.planning.finals import finals_plan, finals_table, finals_targets, trials
from fieldkit.planning.flown_descent import landing_mass
from fieldkit.planning.forecasts import Plan, RocketData
from fieldkit.planning.outlook import outlook
from fieldkit.presentation.finals_text import finals_notes
from fieldkit.presentation.planning_text import ballast_in_words, outlook_in_words
from fieldkit.services.contest_day import day_of, keep_day
from fieldkit.units import FOOT
from tests.commands import Run

pytestmark = pytest.mark.fast

CHECK_SHAPES = False


def test_every_season_is_read_and_states_that_it_was_not_checked() -> None:
    assert seasons() == list(range(2019, 2028))
    assert not any(season(year).checked for year in seasons())
    with pytest.raises(BadValue, match="2027"):
        season(1999)


def test_feet_and_seconds_outside_cost_points() -> None:
    rule = season(2027)
    flights = [
        Flight(apogee=810 * FOOT, duration=38.0),
        Flight(apogee=795 * FOOT, duration=42.0),
        Flight(apogee=800 * FOOT),
        Flight(),
    ]
    assert [points for _, points in score(rule, flights)] == pytest.approx([10.0, 13.0, 0.0], abs=1e-9)


def test_the_target_and_window_of_the_day_are_used(tmp_path: Path) -> None:
    rule = season(2027).announced(785 * FOOT, (36.0, 39.0))
    assert float(rule.points(np.array(785 * FOOT), np.array(40.0))) == pytest.approx(4.0)
    (tmp_path / "2027.toml").write_text("season = 2027\n")
    with pytest.raises(BadValue, match=r"2027\.toml.*window_s"):
        season(2027, tmp_path)


def test_the_two_best_of_three_are_summed() -> None:
    assert season(2027).sums(np.array([[8.0, 20.0, 3.0], [1.0, 1.0, 1.0]])) == pytest.approx([11.0, 2.0])


def test_up_to_three_declared_flights_make_a_score() -> None:
    rule = season(2027)
    scored = [(Flight(flight_id=name), points) for name, points in (("4", 8.0), ("5", 20.0), ("6", 3.0), ("7", 1.0))]
    assert declared_score(rule, scored, ["4", "5", "6"]) == pytest.approx(11.0)
    for names, found in ((["4"], "found 1,"), (["4", "5", "6", "7"], "found 4,"), (["4", "9"], "'9'")):
        with pytest.raises(BadValue, match=found):
            declared_score(rule, scored, names)


def test_a_user_can_copy_and_change_a_season_and_add_new_years_as_files(tmp_path: Path) -> None:
    own = tmp_path / "seasons"
    file = copy_season(2027, own)
    file.write_text(file.read_text().replace("target_ft = 800", "target_ft = 785").replace("= false", "= true"))
    assert copy_season(2027, own).read_text() == file.read_text()  # an existing file is never overwritten
    mine = season(2027, own)
    assert (round(mine.target / FOOT), mine.caveat) == (785, "")
    (own / "2028.toml").write_text(file.read_text().replace("season = 2027", "season = 2028"))
    assert seasons(own)[-1] == season(2028, own).year == 2028
    with pytest.raises(BadValue, match="2028"):
        season(1999, own)


@pytest.mark.parametrize(
    ("day", "year"),
    [("2027-05-15", 2027), ("2026-11-23", 2027), ("2026-05-16", 2026), ("2025-06-04", 2026), ("2015-01-01", 2019)],
)
def test_a_day_belongs_to_the_season_whose_finals_are_next(day: str, year: int) -> None:
    assert season_of(date.fromisoformat(day)) == year


def test_after_the_last_season_with_a_file_that_one_is_used(tmp_path: Path) -> None:
    assert season_of(date(2040, 1, 1)) == seasons()[-1]
    (tmp_path / "2030.toml").write_text("")
    assert season_of(date(2030, 1, 1), tmp_path) == 2030


def test_without_a_given_season_flights_use_that_of_their_date_and_plans_todays(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    ledger = ["--ledger", str(tmp_path / "ledger.db")]
    flown = ["--apogee", "820ft", "--duration", "44s", "--date-time", "2024-04-06T10:00"]
    assert main([*ledger, "add", "--rocket", "Comet", "--motor", "F39T-6", "--dry-mass", "400g", *flown]) == 0
    capsys.readouterr()
    assert main([*ledger, "contest", "--json"]) == 0
    printed = capsys.readouterr()
    found = json.loads(printed.out)
    assert (found["season"], found["flights"][0]["points"]) == (2024, 0.0)
    assert "by the rule of season 2024, from the date of the last flight" in printed.err
    for command in ("contest", "finals"):
        assert main([*ledger, command, "--motor", "F39T-6", "--json"]) == 0
        printed = capsys.readouterr()
        assert json.loads(printed.out)["season"] == season_of(date.today())
        assert "from today's date" in printed.err


def test_a_scored_flight_without_a_name_of_its_own_is_listed_by_day_and_motor(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    table = tmp_path / "season.csv"
    table.write_text("rocket,motor,date_time,apogee_ft\nComet,F39T-6,2026-04-06,820\n")
    ledger = ["--ledger", str(tmp_path / "ledger.db")]
    assert main([*ledger, "import", str(table)]) == 0
    assert main([*ledger, "contest"]) == 0
    line = next(line for line in capsys.readouterr().out.splitlines() if " points " in line)
    assert re.fullmatch(r"  2026-04-06 F39T-6 +[\d.]+ points  820 ft, altitude only  \(2026-04-06-[0-9a-f]{10}\)", line)


def test_a_season_limits_mass_impulse_and_length() -> None:
    found = catalogue().resolve("G80T")
    lines = {line.name: line for line in allowed(season(2027), Flight(dry_mass=0.6), found, 0.7)}
    verdicts = [lines[f"contest {what}"].verdict for what in ("mass", "impulse", "length")]
    assert verdicts == ["unsafe", "unsafe", "ok"]
    assert "not checked" in lines["contest mass"].source
    assert [line.verdict for line in allowed(season(2020), Flight(dry_mass=0.6), found)][:2] == ["unsafe", "unsafe"]


def test_a_season_lists_visual_checks_and_the_certainty_of_each_limit() -> None:
    found = catalogue().resolve("F39T")
    lines = {line.name: line for line in allowed(season(2024), Flight(dry_mass=0.5), found, 0.7)}
    assert "55 to 61 g" in lines["contest eggs"].text
    assert "upper at most 57 mm" in lines["contest body"].text
    assert {lines[f"contest {what}"].verdict for what in ("eggs", "body")} == {"unknown"}
    marks = {name: lines[f"contest {name}"].source for name in ("mass", "length", "eggs")}
    assert "transcription" in marks["mass"]
    assert "unverified" in marks["length"].rpartition(";")[2]
    assert "official text" in marks["eggs"]
    assert (
        "rod of at least 1/4 in"
        in {line.name: line for line in allowed(season(2027), Flight(), found)}["contest launch"].text
    )


# Descent


def falls(count: int, rng: np.random.Generator, spread: float) -> tuple[list[tuple[Flight, Found]], float]:
    """Flights of a rocket whose descent speed scatters about its own factor, at many masses and two air densities; and
    the factor."""
    found, pace = catalogue().resolve("F24-4W"), float(np.exp(rng.normal(np.log(9.0), 0.3)))
    flights = []
    for row in range(count):
        flight = Flight(dry_mass=float(rng.uniform(0.3, 0.6)), temperature=TEMPERATURES[row % 2])
        speed = pace * np.sqrt(landing_mass(flight, found) / DENSITY[row % 2]) * np.exp(spread * rng.normal())
        flights.append((flight.with_changes(descent_speed=float(speed)), found))
    return flights, pace


TEMPERATURES = (275.0, 310.0)
DENSITY = [air_of(Flight(temperature=temperature)).density for temperature in TEMPERATURES]


def test_descent_speed_is_proportional_to_the_root_of_mass_over_area_and_density() -> None:
    def speed(mass: float, density: float, area: float) -> float:
        return float(np.median(Fall(2.0, 1e-9, 10**9).speeds(np.random.default_rng(0), (2000, 1), mass, density, area)))

    one = speed(0.4, 1.2, 1.0)
    assert speed(1.6, 1.2, 1.0) == pytest.approx(2 * one, rel=1e-6)
    assert speed(0.4, 0.3, 1.0) == pytest.approx(2 * one, rel=1e-6)
    assert speed(0.4, 1.2, 0.25) == pytest.approx(2 * one, rel=0.02)  # a change of area is itself uncertain


def test_the_descent_factor_is_found_from_flights_with_any_mass_and_air_density() -> None:
    flights, pace = falls(200, np.random.default_rng(0), 0.05)
    fall = fall_of(flights)
    assert fall.flights == 200
    assert np.exp(fall.log_mean) == pytest.approx(pace, rel=0.01)
    assert fall.spread == pytest.approx(0.05, rel=0.15)


@pytest.mark.parametrize("count", [1, 6])
def test_nine_in_ten_descent_speeds_are_in_their_interval(count: int) -> None:
    rng, inside, rockets = np.random.default_rng(count), 0, 300
    for _ in range(rockets):
        spread = FLIGHT_TO_FLIGHT_SD * np.sqrt(
            DESCENT_PRIOR_FLIGHTS / rng.chisquare(DESCENT_PRIOR_FLIGHTS)
        )  # some rockets fall more consistently than others
        flights, _ = falls(count + 1, rng, float(spread))
        (flight, found), fall = flights[-1], fall_of(flights[:-1])
        density = DENSITY[count % 2]
        low, high = np.quantile(fall.speeds(rng, (300, 1), landing_mass(flight, found), density), (0.05, 0.95))
        inside += low <= (flight.descent_speed or 0.0) <= high
    assert inside / rockets == pytest.approx(0.9, abs=0.05)  # three standard errors


def test_a_duration_constrains_the_descent_as_well_as_a_descent_speed() -> None:
    found, plan = catalogue().resolve("F24-4W"), Flight(dry_mass=0.4, diameter=0.066, descent_speed=6.0)
    flown = fly(field_setup([plan.with_changes(delay=6.0)], [found], np.array([0.6 * np.pi / 4 * 0.066**2])))
    names = ("apogee", "duration", "burn_time", "coast_to_apogee", "apogee_to_eject")
    shown = plan.with_changes(**{name: float(flown.readouts()[name][0]) for name in names}, descent_speed=None)
    stated, read = fall_of([(shown, found)]), fall_of([(plan, found)])
    assert stated.log_mean == pytest.approx(read.log_mean, abs=0.03)
    without = shown.with_changes(burn_time=None, coast_to_apogee=None)
    assert fall_of([(without, found)]).log_mean == pytest.approx(read.log_mean, abs=0.06)


def test_a_flight_with_a_tag_and_one_without_a_figure_do_not_constrain_the_descent() -> None:
    found = catalogue().resolve("F24-4W")
    flights = [Flight(dry_mass=0.4, descent_speed=20.0, tags=("damaged",)), Flight(dry_mass=0.4, apogee=200.0)]
    assert fall_of([(flight, found) for flight in flights]).flights == 0


def test_the_best_parachute_has_the_fewest_points_and_the_probability_is_that_of_sums() -> None:
    found = catalogue().resolve("F24-4W")
    plan = Flight(rocket="Comet", dry_mass=0.33, diameter=0.066, delay=6.0)
    history = tuple(
        (plan.with_changes(flight_id=str(n), motor="F24-6W", apogee=height, duration=height / 4.2 + 7.5), found)
        for n, height in enumerate((241.0, 246.0, 238.0, 249.0))
    )
    rule, rocket = season(2027), RocketData(history, ())
    as_flown = outlook(rule, Plan(rocket, plan, found), draws=200)
    assert as_flown.fall.flights == 4
    assert as_flown.area < 0.8  # it came down after 65 s, the window closes at 40 s
    smaller = outlook(rule, Plan(rocket, plan, found), as_flown.area, draws=200)
    assert smaller.points.mean() == pytest.approx(as_flown.points_there, rel=0.02)
    assert smaller.points.mean() < as_flown.points.mean() - 50
    sums = rule.sums(smaller.points)
    assert smaller.chance(rule, float(np.median(sums))) == pytest.approx(0.5, abs=0.01)
    assert as_flown.gain == pytest.approx(as_flown.points.mean() - as_flown.points_there, rel=1e-6)
    assert as_flown.clear
    advice = " ".join(outlook_in_words(as_flown, rule, 1.0))
    assert f"would lower the points per flight by {as_flown.gain:.0f} ± {as_flown.gain_error:.0f} and land at" in advice
    assert "no change" not in advice
    assert not smaller.clear
    assert "would lower" not in " ".join(outlook_in_words(smaller, rule, as_flown.area))


def test_a_parachute_that_was_never_timed_is_not_to_be_changed_for_a_gain_within_the_noise() -> None:
    """Without flights the best area is at the limit of those tried, because the descent is unknown by 30%."""
    found = catalogue().resolve("F67W-6")
    plan = Flight(rocket="Team", dry_mass=0.56, diameter=0.066, delay=6.0)
    ahead = outlook(season(2027), Plan(RocketData((), ()), plan, found))
    assert ahead.gain > 1
    assert ahead.at_edge
    assert not ahead.clear
    faster = ahead.fall.usual_speed(0.56, 1.225) / np.sqrt(ahead.area)
    assert ahead.speed_there == pytest.approx(faster, rel=0.05)
    assert "would lower the points" not in " ".join(outlook_in_words(ahead, season(2027), 1.0))


def test_finals_without_a_measured_descent_advise_a_mass_and_no_parachute(run: Run) -> None:
    """An area chosen for an assumed descent would land the eggs at twice the speed."""
    body = ("--rocket", "Fresh", "--dry-mass", "480g", "--diameter", "66mm", "--rail-length", "1.8m")
    plan = ("finals", "--season", "2027", "--motor", "AeroTech F52T-8", *body)
    printed = run(*plan)
    assert "parachute area" not in printed.out.split("target ft")[1]
    assert "only the altitude is scored: the descent is not measured" in " ".join(printed.out.split())
    rows = json.loads(run(*plan, "--json").out)["finals"]
    assert {row["parachute_area"] for row in rows} == {None}
    assert [row["change_g"] for row in rows] == pytest.approx([row["dry_mass_g"] - 480 for row in rows])
    timed = json.loads(run(*plan, "--main-speed", "5m/s", "--json").out)["finals"]
    assert all(row["parachute_area"] > 0 for row in timed)


def test_the_command_scores_flights_and_a_plan(tmp_path: object, capsys: pytest.CaptureFixture[str]) -> None:
    ledger = ["--ledger", f"{tmp_path}/ledger.db"]
    assert main([*ledger, "import", str(REFERENCE_FLIGHTS)]) == 0
    capsys.readouterr()
    plan = ["--motor", "F24", "--cut", "60", "--declared", "2,3,9", "--json"]
    assert main([*ledger, "contest", "--season", "2027", *plan]) == 0
    document = json.loads(capsys.readouterr().out)
    assert len(document["flights"]) == 12
    assert 0 <= document["qualifies"]["chance"] <= 1
    points = {one["flight_id"]: one["points"] for one in document["flights"]}
    assert document["score"]["points"] == pytest.approx(points["3"] + points["9"])
    assert not document["plan"]["timed"]


@pytest.mark.parametrize("text", ["40-37", "37", "37-x", "-1-4", "nan-3"])
def test_an_invalid_window_is_refused(text: str) -> None:
    assert read_window("37-40 s") == (37.0, 40.0)
    with pytest.raises(BadValue, match="such as 37-40"):
        read_window(text)


def test_the_day_of_a_contest_is_saved_with_its_season(tmp_path: Path) -> None:
    day = Day(target=785 * FOOT, window=(38.0, 41.0), cut=60.0, declared=("4", "5"))
    with Ledger.open(tmp_path / "ledger.db") as ledger:
        keep_day(ledger, 2027, day)
        assert (day_of(ledger, 2027), day_of(ledger, 2026)) == (day, Day())
    rule = day.rule(season(2027))
    assert (rule.target, rule.window, rule.year) == (day.target, day.window, 2027)
    assert Day().rule(rule) == rule


# As it is judged


@pytest.mark.parametrize(
    ("year", "target", "window"),
    [
        (2019, 856, (43, 46)),
        (2020, 800, (40, 43)),
        (2021, 800, (40, 43)),
        (2022, 835, (41, 44)),
        (2023, 850, (42, 45)),
        (2024, 820, (43, 46)),
        (2025, 790, (41, 44)),
        (2026, 750, (36, 39)),
        (2027, 800, (37, 40)),
    ],
)
def test_every_season_has_its_target_and_window(year: int, target: float, window: tuple[float, float]) -> None:
    rule = season(year)
    assert rule.target / FOOT == pytest.approx(target)
    assert rule.window == window
    assert (rule.per_second, rule.best, rule.declared) == (4.0, 2, 3)
    assert rule.per_metre * FOOT == pytest.approx(1.0)


@pytest.mark.parametrize(
    ("year", "mass", "length", "eggs"),
    [(year, 0.65, 0.65, eggs) for year, eggs in ((2019, 3), (2020, 1), (2021, 1), (2022, 2), (2023, 1))]
    + [(year, 0.65, 0.65, eggs) for year, eggs in ((2024, 1), (2025, 2), (2026, 1), (2027, 2))],
)
def test_every_season_limits_mass_and_length_and_names_its_eggs(
    year: int, mass: float, length: float, eggs: int
) -> None:
    rule = season(year)
    assert (rule.mass, rule.length, rule.impulse) == (mass, length, 80.0)
    assert rule.eggs.startswith(f"{eggs} egg")
    assert rule.source
    assert rule.mark in "OT"


def test_two_timers_are_averaged_to_a_hundredth_and_halves_are_rounded_up() -> None:
    def timed(one: str, two: str) -> float | None:
        return judged_duration(Flight(duration=1.0, extra={"timer_1_s": one, "timer_2_s": two}))

    assert timed("38.42", "38.43") == 38.43
    assert timed("38,40", "38,44") == 38.42
    assert timed("38.42", "") == 38.42
    assert timed("", "") == 1.0
    with pytest.raises(BadValue, match="timer_2_s"):
        timed("38.4", "late")


def test_a_cracked_egg_is_an_attempt_without_a_score() -> None:
    rule = season(2027)
    flights = [
        Flight(flight_id="4", apogee=800 * FOOT, duration=38.0, extra={"eggs": "cracked"}),
        Flight(flight_id="5", apogee=810 * FOOT, duration=38.0, extra={"eggs": "intact"}),
        Flight(flight_id="6", apogee=805 * FOOT, duration=38.0),
        Flight(flight_id="7", apogee=801 * FOOT, duration=38.0, tags=("disqualified",)),
    ]
    scored = score(rule, flights)
    assert [points is None for _, points in scored] == [True, False, False, True]
    assert declared_score(rule, scored, ["4", "5", "6"]) == pytest.approx(15.0)
    with pytest.raises(BadValue, match=r"found 1 with a score.*4 \(eggs: cracked\)"):
        declared_score(rule, scored, ["4", "6", "7"])


def test_altitude_is_scored_in_whole_feet() -> None:
    (_, points), *_ = score(season(2027), [Flight(apogee=246.9, duration=38.0)])  # 810.04 ft
    assert points == pytest.approx(10.0)


def test_a_motor_list_is_a_file_of_the_flyer(tmp_path: Path) -> None:
    found, rule = catalogue().resolve("F24-4W"), season(2027)
    assert approved_motors(2027, tmp_path) is None
    assert motor_line(rule, found, None).verdict == "unknown"
    (tmp_path / "2027_motors.txt").write_text("# of June\nAeroTech F24W\nEstes F15\n")
    assert motor_line(rule, found, approved_motors(2027, tmp_path)).verdict == "ok"
    other = catalogue().resolve("F39T")
    assert motor_line(rule, other, approved_motors(2027, tmp_path)).verdict == "unsafe"


TEAMS = Path(__file__).parents[3] / "shared" / "data" / "contest_teams.csv"


@pytest.mark.skipif(not TEAMS.exists(), reason="no flights of teams here")
def test_points_of_teams_agree_with_hand_calculations() -> None:
    """Source: |altitude - 750| in whole feet and four points a second outside 36 to 39 s, in plain arithmetic."""
    with TEAMS.open(encoding="utf-8") as file:
        rows = list(csv.DictReader(file))
    flights = [
        Flight(flight_id=row["flight_id"], apogee=float(row["apogee_m"]), duration=float(row["duration_s"]))
        for row in rows
    ]
    scored = dict(zip((row["flight_id"] for row in rows), score(season(2026), flights), strict=True))
    for row in rows:
        feet, seconds = int(float(row["apogee_m"]) / 0.3048 + 0.5), float(row["duration_s"])
        outside = max(36 - seconds, seconds - 39, 0)
        assert scored[row["flight_id"]][1] == pytest.approx(abs(feet - 750) + 4 * outside)
    assert scored["Team2-05"][1] == pytest.approx(33.0)  # 783 ft, in the window


@pytest.mark.skipif(not TEAMS.exists(), reason="no flights of teams here")
def test_the_command_computes_the_points_of_teams(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """A table as kept by teams, imported and scored by the command, compared with plain arithmetic for every flight."""
    with TEAMS.open(encoding="utf-8") as file:
        rows = {row["flight_id"]: row for row in csv.DictReader(file)}
    ledger = ["--ledger", str(tmp_path / "ledger.db")]
    assert main([*ledger, "import", str(TEAMS)]) == 0
    capsys.readouterr()
    scored = {}
    for team in {row["rocket"] for row in rows.values()}:
        assert main([*ledger, "contest", "--rocket", team, "--season", "2026", "--json"]) == 0
        flights = json.loads(capsys.readouterr().out)["flights"]
        scored |= {one["flight_id"]: one["points"] for one in flights}
    assert scored.keys() == rows.keys()
    for name, row in rows.items():
        feet, seconds = int(float(row["apogee_m"]) / 0.3048 + 0.5), float(row["duration_s"])
        assert scored[name] == pytest.approx(abs(feet - 750) + 4 * max(36 - seconds, seconds - 39, 0))


# Finals


def test_mass_and_parachute_are_optimized_together_and_higher_targets_need_less_mass() -> None:
    found, rule = catalogue().resolve("F39T-6"), season(2027)
    plan = Flight(rocket="Comet", dry_mass=0.4, diameter=0.066, temperature=290.0, delay=6.0)
    history = tuple(
        (plan.with_changes(flight_id=str(n), motor="F39T-6", apogee=height, duration=height / 5.5 + 7.0), found)
        for n, height in enumerate((236.0, 240.0, 238.0, 243.0))
    )
    flown = trials(Plan(RocketData(history, ()), plan, found), rule)
    assert [round(one / FOOT) for one in finals_targets(rule)] == [feet for feet in range(775, 826, 5) if feet != 800]
    table = finals_table(flown, rule, finals_targets(replace(rule, finals_never=None)))
    assert [round(one.target / FOOT) for one in table] == list(range(775, 826, 5))
    masses = [one.mass for one in table]
    assert masses == sorted(masses, reverse=True)
    assert masses[0] - masses[-1] > 0.01
    assert all(one.mass + found.motor.loaded_mass <= 0.65 + 1e-9 for one in table)
    assert abs(table[5].apogee[1] - 800 * FOOT) < 8.0
    assert rule.window[0] - 1.0 < table[5].duration[1] < rule.window[1] + 1.0
    alone = [float(rule.points(flown.apogee[row], flown.duration[11, row]).mean()) for row in range(len(flown.masses))]
    assert table[5].points <= min(alone)


def test_ballast_is_unchanged_if_the_gain_is_not_clear() -> None:
    found, rule = catalogue().resolve("F39T-6"), season(2027)
    plan = Flight(rocket="Comet", dry_mass=0.4, diameter=0.066)
    goal = Goal(rule.target, 3.0, "points", rule)
    heavy = plan.with_changes(dry_mass=0.58)
    near = ballast(Plan(RocketData((), ()), plan, found), goal, draws=80)
    legal = ballast(Plan(RocketData((), ()), heavy, found), goal, draws=80)
    assert near.gain is not None
    assert not near.clear
    assert near.advised.plan.dry_mass == plan.dry_mass
    assert near.forecast.plan.dry_mass == pytest.approx(near.mass)
    assert "no change" in " ".join(ballast_in_words(near, goal))
    assert legal.mass + found.motor.loaded_mass <= 0.65 + 1e-9


def test_a_rocket_over_the_limit_of_the_season_is_advised_to_lose_weight() -> None:
    found, rule = catalogue().resolve("F39T-6"), season(2027)
    heavy = Flight(rocket="Comet", dry_mass=0.62, diameter=0.066)
    best = ballast(Plan(RocketData((), ()), heavy, found), Goal(rule.target, 3.0, "points", rule), draws=80)
    assert best.too_heavy
    assert best.clear
    assert best.advised is best.forecast
    words = " ".join(ballast_in_words(best, Goal(rule.target, 3.0, "points", rule)))
    assert "at most 650 g on the pad" in words
    assert "no change" not in words


def test_the_table_of_finals_states_how_much_one_flight_would_narrow_it() -> None:
    found, rule = catalogue().resolve("F39T-6"), season(2027)
    plan = Flight(rocket="Comet", dry_mass=0.4, diameter=0.066, delay=6.0)
    finals = finals_plan(Plan(RocketData((), ()), plan, found), rule, lambda *_: [])
    apogee, descent = (
        int(number) for number in re.findall(r"would narrow .*?by (\d+)%", " ".join(finals_notes(finals)))
    )
    assert 10 < apogee < 80
    assert descent == 55  # from 30 % and 10 % to 10 % and 10 %, as the root of the sum of squares


@pytest.mark.thorough
def test_the_card_of_finals_is_one_picture(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    ledger = ["--ledger", f"{tmp_path}/ledger.db"]
    assert main([*ledger, "import", str(REFERENCE_FLIGHTS)]) == 0
    capsys.readouterr()
    plan = ["finals", "--season", "2027", "--motor", "F39T-6", "--config", "A", "--targets", "775-785", "--json"]
    weighed = ["--lift-off-mass", "400g", "--temperature", "25c", "--card", str(tmp_path / "card.png")]
    assert main([*ledger, *plan, *weighed]) == 0
    assert [row["target_ft"] for row in json.loads(capsys.readouterr().out)["finals"]] == pytest.approx([775, 780, 785])
    assert (tmp_path / "card.png").read_bytes().startswith(b"\x89PNG")
    assert main([*ledger, *plan[:-1], *weighed[:4]]) == 0
    assert f"finals: {season(2027).finals}" in " ".join(capsys.readouterr().out.split())


def test_checks_of_finals_are_those_of_flights_in_the_table(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """The rocket at the season's heaviest mass stays far below the ceiling; the flights of the table do not."""
    plan = ["finals", "--rocket", "Fresh", "--season", "2027", "--motor", "F39T-6", "--diameter", "66mm", "--json"]
    given = ["--dry-mass", "400g", "--waiver", "300m", "--wind", "3m/s", "--field-size", "1000ft"]
    assert main(["--ledger", f"{tmp_path}/ledger.db", *plan, *given]) == 0
    document = json.loads(capsys.readouterr().out)
    checks = {one["check"]: one for one in document["safety"]}
    highest = max(row["apogee_m"]["p95"] for row in document["finals"])
    assert highest > 300
    assert checks["ceiling"]["verdict"] == "unsafe"
    assert float(re.findall(r"below (\d+) m", checks["ceiling"]["text"])[0]) == pytest.approx(highest, rel=0.05)
    heaviest = max(row["lift_off_mass_g"] for row in document["finals"])
    assert checks["contest mass"]["text"].startswith(f"{heaviest:.4g} g")


def test_the_landing_of_a_contest_plan_has_the_area_of_its_parachute(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    plan = ["contest", "--rocket", "Fresh", "--season", "2027", "--motor", "F39T-6", "--diameter", "66mm", "--json"]
    given = ["--dry-mass", "400g", "--wind", "3m/s", "--field-size", "1000ft", "--rail-length", "1.5m"]
    lands = {}
    for area in ("50%", "100%", "200%"):
        assert main(["--ledger", f"{tmp_path}/ledger.db", *plan, *given, "--parachute", area]) == 0
        lines = json.loads(capsys.readouterr().out)["plan"]["safety"]
        (field,) = (one["text"] for one in lines if one["check"] == "field size")
        lands[area] = float(re.findall(r"lands (\d+) m", field)[0])
    assert lands["50%"] < 0.85 * lands["100%"]
    assert lands["200%"] > 1.15 * lands["100%"]


@pytest.mark.parametrize(
    ("motor", "line", "listed"),
    [
        ("F24-4W", "F24-4W", True),
        ("F24-4W", "AeroTech F24-4,7W", True),
        ("F39T", "F39-3,6,9T", True),
        ("F51NT", "AeroTech F51-6NT", True),
        ("F42T/L", "F42-4,8T", True),
        ("68F240", "68F240-15A", True),
        ("AeroTech F50T", "AeroTech F50", True),
        ("Estes F50", "F50T", False),
        ("AeroTech F50T", "F50", False),
        ("F24-4W", "Estes F24-4W", False),
        ("F24-4W", "F24C", False),
    ],
)
def test_a_motor_list_may_have_delays(tmp_path: Path, motor: str, line: str, listed: bool) -> None:
    (tmp_path / "2027_motors.txt").write_text(f"E16W\n{line}\n")
    found = catalogue().resolve(motor)
    assert motor_line(season(2027), found, approved_motors(2027, tmp_path)).verdict == ("ok" if listed else "unsafe")


@pytest.mark.parametrize(
    ("extra", "why"),
    [
        ({"eggs": "both intact"}, ""),
        ({"eggs": "Not cracked"}, ""),
        ({"eggs": "all OK"}, ""),
        ({"eggs": "one cracked"}, "eggs: one cracked"),
        ({"eggs": "2"}, "eggs: 2, which does not say intact or cracked"),
        ({"disqualified": "N"}, ""),
        ({"disqualified": "yes"}, "disqualified"),
    ],
)
def test_eggs_and_disqualification_are_read_as_teams_write_them(extra: dict[str, str], why: str) -> None:
    assert why_no_score(Flight(apogee=240.0, extra=extra)) == why


@pytest.mark.parametrize(
    ("year", "eggs", "why"),
    [
        (2027, "2 intact", ""),
        (2027, "2 eggs intact", ""),
        (2027, "Two OK", ""),
        (2027, "both ok", ""),
        (2027, "3 intact", ""),
        (2019, "all intact", ""),
        (2026, "1 intact", ""),
        (2027, "1 intact", "eggs: 1 intact, 2 needed"),
        (2019, "both ok", "eggs: both ok, 3 needed"),
        (2026, "0 intact", "eggs: 0 intact, 1 needed"),
        (2027, "2 intact, 1 cracked", "eggs: 2 intact, 1 cracked"),
        (2027, "2 eggs", "eggs: 2 eggs, which does not say intact or cracked"),
    ],
)
def test_counted_eggs_are_compared_with_the_number_of_their_season(year: int, eggs: str, why: str) -> None:
    rule, flight = season(year), Flight(apogee=240.0, duration=38.0, extra={"eggs": eggs})
    assert why_no_score(flight, rule.egg_count) == why
    ((_, points),) = score(rule, [flight])
    assert (points is None) == bool(why)


@pytest.mark.parametrize(
    "command", [["finals", "--targets", "795-800"], ["ballast"], ["contest"]], ids=["finals", "ballast", "contest"]
)
def test_every_plan_of_a_season_checks_the_length_of_the_rocket(
    command: list[str], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    body = ["--motor", "F67W-6", "--rocket", "Team", "--dry-mass", "560g", "--diameter", "66mm", "--season", "2027"]
    ledger = ["--ledger", str(tmp_path / "ledger.db")]
    assert main([*ledger, *command, *body, "--rocket-length", "649mm", "--json"]) == 0
    found = json.loads(capsys.readouterr().out)
    checks = {one["check"]: one for one in found.get("plan", found)["safety"]}
    assert checks["contest length"]["verdict"] == "unsafe"


def test_the_checks_of_ballast_are_those_of_the_mass_that_it_advises(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    body = ["--motor", "F67W-6", "--rocket", "Team", "--dry-mass", "560g", "--diameter", "66mm", "--season", "2027"]
    assert main(["--ledger", str(tmp_path / "ledger.db"), "ballast", *body, "--json"]) == 0
    found = json.loads(capsys.readouterr().out)
    advised = found["dry_mass_g"] if found["change"] else 560.0
    checks = {one["check"]: one for one in found["safety"]}
    loaded = catalogue().resolve("F67W").motor.loaded_mass * 1e3
    assert checks["contest mass"]["text"].startswith(f"{advised + loaded:.4g} g")
    assert not found["change"]
    assert found["dry_mass_g"] != pytest.approx(560.0, abs=5)


def test_a_score_without_a_duration_states_that_it_covers_only_altitude(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    table = tmp_path / "flights.csv"
    table.write_text("flight_id,rocket,motor,apogee_ft,duration_s\n1,Egg,F39T-6,801,38\n2,Egg,F39T-6,805,\n")
    ledger = ["--ledger", str(tmp_path / "ledger.db")]
    assert main([*ledger, "import", str(table)]) == 0
    assert main([*ledger, "contest", "--season", "2027", "--declared", "1,2"]) == 0
    printed = " ".join(capsys.readouterr().out.split())
    assert (
        "6.00 points, the best 2 of 1, 2; 2 without a duration: altitude only, too few points by 4 for each" in printed
    )


def test_misspelled_eggs_and_timers_are_refused_where_they_come_in(run: Run, tmp_path: Path) -> None:
    table = tmp_path / "flights.csv"
    table.write_text(
        "flight_id,rocket,motor,apogee_ft,Timer 1 (s),Eggs\n"
        "1,Egg,F39T-6,801,38.4,2 intact\n2,Egg,F39T-6,805,38.1,intakt\n3,Egg,F39T-6,805,38.4.1,intact\n"
        "4,Egg,F39T-6,790,39,2\n"
    )
    printed = run("import", table)
    assert "row 3, Eggs: found 'intakt'; did you mean intact?" in printed.err
    assert "row 4, Timer 1 (s): found '38.4.1', expected seconds such as 38.42" in printed.err
    added = run("add", "--rocket", "Egg", "--motor", "F39T-6", "--apogee", "801ft", "--eggs", "craked", status=None)
    assert (added.status, added.err.strip()) == (1, "eggs: found 'craked'; did you mean cracked?")
    edited = run("edit", "1", "eggs=2", status=None)
    assert "eggs: found '2', expected intact or cracked, such as 2 intact" in edited.err
    assert [one["flight_id"] for one in run("flights", "--json").document["flights"]] == ["1", "4"]
    assert run("import", table, "--json", status=None).document["duplicates"] == 2
    assert "which does not say intact or cracked" in run("contest", "--season", "2027").out


def test_contest_columns_count_however_a_spreadsheet_writes_their_headings() -> None:
    flight = Flight(apogee=240.0, duration=35.0)
    assert why_no_score(flight.with_changes(extra={"Eggs": "cracked"}), 2)
    assert why_no_score(flight.with_changes(extra={"Disqualified": "yes"})) == "disqualified"
    assert judged_duration(flight.with_changes(extra={"Timer 1 (s)": "38.41", "Timer 2 (s)": "38.44"})) == 38.43


def test_the_rules_are_printed_for_a_team_without_a_flight(run: Run) -> None:
    _, out, error = run("contest", "--season", "2027", "--target", "785ft")
    text = " ".join(out.split())
    assert "785 ft in 37 to 40 s; the best 2 of 3 declared" in text
    assert "1 point for each foot off the target, 4 for each second outside the window" in text
    assert "at most 650 g on the pad, at most 80 N s, at least 650 mm long" in text
    assert "eggs: 2 eggs of 55 to 63 g" in text
    assert "no flights yet" in error
