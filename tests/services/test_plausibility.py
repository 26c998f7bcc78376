"""Implausible flights are named when they are imported and excluded from every fit."""

import math
import re
import shutil
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from bench.faults import session
from fieldkit import units
from fieldkit.errors import BadValue
from fieldkit.flight import BY_NAME, Flight
from fieldkit.flight import COLUMNS as FLIGHT_COLUMNS
from fieldkit.flight.limits import LIMITS
from fieldkit.flight.plausibility import (
    READ_TOO_HIGH,
    best_apogee,
    best_speed,
    descent_ratio,
    doubts,
    far_from_usual,
    implausible,
    not_measured,
)
from fieldkit.flight.recovery import IN_EVERY_FIT, RECOVERY_NAMES, recovery_header
from fieldkit.importing.manual_entry import implausible_answers, read_answer
from fieldkit.ledger import Ledger
from fieldkit.model.readout_data import observe
from fieldkit.motors import Catalogue, Found, catalogue
from fieldkit.motors.motor import Motor
from fieldkit.physics.history import history_of
from fieldkit.services.plausible_flights import (
    MAX_EXCLUDED,
    exclusions,
    followed,
    incomplete_flights,
    outlying,
    without_delay,
)
from fieldkit.units import STANDARD_GRAVITY
from tests.commands import Output, Run

CHECK_SHAPES = False
COLUMNS = (
    "flight_id",
    "date_time",
    "rocket",
    "config",
    "dry_mass_g",
    "diameter_mm",
    "motor",
    "rail_angle_deg",
    "apogee_m",
)
F24 = catalogue().resolve("F24-4W").motor
GOOD = Flight(flight_id="1", rocket="Astra", motor="F24-4W", dry_mass=0.322, diameter=0.066, apogee=250.0)
FITS = {
    "predict": ["--motor", "F24-4W", "--config", "A"],
    "loop": [],
    "score": [],
    "ballast": ["--motor", "F24-4W", "--target", "240m"],
    "delay": ["--motor", "F24-4W"],
    "motors": ["--fit", "Astra", "--class", "F", "--target", "240m"],
    "infer": [],
    "study": ["shortfall"],
}
"""Commands that fit a rocket's flights, or infer from each."""


def season(count: int, **changes: object) -> list[dict[str, object]]:
    """Flights of a rocket whose apogees scatter by a few meters."""
    apogees = np.random.default_rng(1).normal(250, 6, count)
    return [
        {
            "flight_id": number + 1,
            "date_time": f"2025-05-{number + 1:02d}T10:00",
            "rocket": "Astra",
            "config": "A",
            "dry_mass_g": 322,
            "diameter_mm": 66,
            "motor": "F24-4W",
            "rail_angle_deg": "",
            "apogee_m": round(float(apogee), 1),
            **changes,
        }
        for number, apogee in enumerate(apogees)
    ]


def with_one(**changes: object) -> list[dict[str, object]]:
    """Ten flights, of which the last is changed."""
    rows = season(10)
    rows[-1] |= changes
    return rows


IMPOSSIBLE = {
    "one that no motor lifts": with_one(dry_mass_g=32200),
    "one from a rail that lies": with_one(rail_angle_deg=90),
    "one ten times too high": with_one(apogee_m=2500),
    "one narrower than its motor": with_one(diameter_mm=6.6),
    "all too heavy": season(6, dry_mass_g=32200),
    "all at 200 km": season(5, apogee_m=200_000),
}
WHOLLY = ("one that no motor lifts", "all too heavy", "all at 200 km")
"""Flights with which slow commands are tested too."""
SLOW = ("loop", "score", "study")
WITHOUT_A_LEDGER = ("capture", "demo", "docs", "learn", "paper", "study reference")
"""Commands whose result no flight in the ledger changes."""
USAGE = 2
"""Exit status of a usage error."""


@pytest.fixture
def run_command(run: Run, tmp_path: Path) -> Run:
    """Runs a command, or imports rows of a table."""

    def command(*words: str, rows: list[dict[str, object]] | None = None) -> Output:
        if rows is None:
            return run(*words, status=None)
        columns = dict.fromkeys([*COLUMNS, *rows[0]])
        table = [",".join(columns), *(",".join(str(row[name]) for name in columns) for row in rows)]
        (tmp_path / "flights.csv").write_text("\n".join(table))
        return run("import", tmp_path / "flights.csv", status=None)

    return command


@pytest.mark.sampled
@pytest.mark.parametrize(
    "what", [pytest.param(WHOLLY[0], marks=pytest.mark.thorough), *(what for what in IMPOSSIBLE if what != WHOLLY[0])]
)
def test_an_impossible_flight_is_named_and_no_command_shows_an_invalid_number(what: str, run_command: Run) -> None:
    rows = IMPOSSIBLE[what]
    implausible_count = len(rows) if what.startswith("all") else 1
    _, out, err = run_command(rows=rows)
    assert out.startswith(f"Imported {len(rows)},")
    assert err.count("excluded from every fit") == implausible_count
    few = {name: words for name, words in FITS.items() if what in WHOLLY or name not in SLOW}
    for command, words in few.items():
        status, out, err = run_command(command, *words)
        last = rows[-1]["flight_id"]
        assert re.search(rf"flight {last}\b|more notes?", err), f"{command}: {err}"
        assert not re.search(r"\bnan\b|\binf\b|Traceback|\w+Warning\b", out + err, re.IGNORECASE), command
        assert status == 0 or what.startswith("all"), err


@pytest.mark.thorough
@pytest.mark.parametrize("rows", [[], season(6, dry_mass_g=32200)], ids=["none", "none plausible"])
def test_no_command_fails_unexpectedly_without_a_flight_to_fit(
    rows: list[dict[str, object]], run_command: Run, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Every line of the manual's session, each on a separate ledger without any flight that a fit could use."""
    session.furnished(tmp_path / "desk")
    monkeypatch.chdir(tmp_path / "desk")
    for words in dict.fromkeys((*session.lines(), *session.more())):
        if session.named(words) in WITHOUT_A_LEDGER:
            continue
        for left in tmp_path.glob("ledger.db*"):
            shutil.rmtree(left) if left.is_dir() else left.unlink()
        run_command(rows=rows or season(1))
        if not rows:
            run_command("undo")
        status, out, err = run_command(*words)
        assert not re.search(r"\bnan\b|Traceback|\w+Warning\b", out + err, re.IGNORECASE), words
        assert status != USAGE, (words, err)  # otherwise neither this test nor the fault bench would test anything


def test_a_flight_far_from_the_others_of_its_rocket_is_questioned_when_imported(run_command: Run) -> None:
    """Five times the usual apogee, which this motor could reach without drag; only new flights are questioned."""
    _, _, err = run_command(rows=with_one(apogee_m=1250))
    printed = "row 11: flight 10 of Astra: apogee 1250 m is 5 times the usual 252 m of this rocket and motor; check it"
    assert printed in err
    assert err.count("the usual") == 1
    assert "the usual" not in run_command(rows=with_one(apogee_m=1250)).err
    another = with_one(apogee_m=1250)[-1] | {"flight_id": 11}
    assert "flight 11 of Astra: apogee 1250 m" in run_command(rows=[another]).err


@pytest.mark.slow
def test_no_command_fails_unexpectedly_at_the_first_and_last_dates(
    run_command: Run, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Every line of the manual's session, on flights of the first and the last second that a date can have."""
    session.furnished(tmp_path / "desk")
    monkeypatch.chdir(tmp_path / "desk")
    dates = ("0001-01-01T00:00:00", "9999-12-31T23:59:58", "9999-12-31T23:59:59")
    rows = [row | {"date_time": date} for row, date in zip(season(3), dates, strict=True)]
    for words in dict.fromkeys((*session.lines(), *session.more())):
        if session.named(words) not in WITHOUT_A_LEDGER:
            run_command(rows=rows)
            run_command(*words)


DOWN = GOOD.with_changes(
    burn_time=2.0,
    coast_to_apogee=6.0,
    apogee_to_eject=1.0,
    eject_altitude=245.0,
    descent_speed=5.0,
    duration=58.0,
)
"""A way down of 49 s at 5 m/s from 245 m."""


@pytest.mark.parametrize(
    ("changes", "phrase"),
    [
        ({}, ""),
        ({"eject_altitude": 230.0}, ""),
        ({"eject_altitude": 145.0, "apogee": 146.0}, "duration 58 s is too long for a descent from 145 m at 5 m/s"),
        ({"descent_speed": 2.2}, "duration 58 s is too short"),
        ({"duration": 158.0}, "duration 158 s is too long"),
        ({"duration": 5.8}, "duration 5.8 s is too short"),
        ({"duration": None}, ""),
        ({"duration": 158.0, "source": {"descent_speed": "baro"}}, ""),
    ],
)
def test_a_way_down_that_contradicts_itself_is_questioned(changes: dict[str, object], phrase: str) -> None:
    found = [str(one) for one in doubts(DOWN.with_changes(**changes))]
    assert [phrase in one for one in found] == [True] * bool(phrase)
    marked = [name for name in BY_NAME if implausible_answers(DOWN.with_changes(**changes), name)]
    assert marked == (["eject_altitude", "descent_speed", "duration"] if phrase else [])


def test_a_way_down_after_an_undetected_coast_says_nothing() -> None:
    assert descent_ratio(DOWN) == pytest.approx(1.0)
    assert descent_ratio(DOWN.with_changes(coast_to_apogee=0.0)) is None


def test_a_ratio_to_the_usual_is_written_in_digits(run_command: Run) -> None:
    assert "apogee 199900 m is 790 times the usual 252 m" in run_command(rows=with_one(apogee_m=199_900)).err


def test_after_a_flight_too_heavy_to_lift_off_no_next_forecast_is_shown(run_command: Run) -> None:
    """Its readouts may be right, but a forecast for a mistyped mass would be 0 m from 0 to 0."""
    run_command(rows=season(10))
    typed = ("--rocket", "Astra", "--config", "A", "--motor", "F24-4W", "--diameter", "66mm", "--apogee", "250m")
    status, out, err = run_command("add", *typed, "--dry-mass", "32kg")
    assert status == 0
    assert "Next on" not in out
    assert "excluded from every fit" in err
    assert "Next on" in run_command("add", *typed, "--dry-mass", "322g", "--flight-id", "12").out


def test_learning_a_card_leaves_out_impossible_flights_and_names_them(run_command: Run, tmp_path: Path) -> None:
    run_command(rows=with_one(dry_mass_g=32200))
    status, _, err = run_command("learn", str(tmp_path / "flights.csv"), "--out", str(tmp_path / "card.json"))
    assert status == 0
    assert "flight 10 of Astra is excluded from every fit" in err


def test_the_loop_reports_which_flights_were_not_used(run_command: Run) -> None:
    run_command(rows=with_one(dry_mass_g=32200))
    document = run_command("loop", "--look", "--json").document
    (line,) = document["implausible"]
    assert "flight 10" in line
    assert document["n_flights"] == 9


def median(run_command: Run, rows: list[dict[str, object]]) -> dict[str, Any]:
    run_command(rows=rows)
    plan = ["--motor", "F24-4W", "--config", "A", "--dry-mass", "322g", "--diameter", "66mm"]
    (made,) = run_command("predict", *plan, "--json").document["predictions"]
    return dict(made)


@pytest.mark.sampled
@pytest.mark.parametrize("what", [name for name in IMPOSSIBLE if name.startswith("one")])
def test_one_impossible_flight_changes_no_forecast(what: str, run_command: Run) -> None:
    rows = IMPOSSIBLE[what]
    without = median(run_command, rows[:-1])
    beside = median(run_command, rows)
    assert beside["apogee_m"] == without["apogee_m"]
    assert beside["flights"] == without["flights"] == 9
    assert "flight 10 of Astra" in beside["left_out"][0]


def test_an_implausible_flight_is_questioned_when_entered(run_command: Run) -> None:
    words = ["--rocket", "Astra", "--motor", "F24-4W", "--apogee", "250m", "--dry-mass", "32200g"]
    status, _, err = run_command("add", *words)
    assert status == 0
    assert "excluded from every fit: a dry mass of 32200 g is more than" in err


def test_the_defaults_of_a_plan_come_from_a_setup_that_can_fly(run_command: Run) -> None:
    run_command(rows=IMPOSSIBLE["one that no motor lifts"])
    _, out, _ = run_command("predict", "--motor", "F24-4W")
    assert "322 g without the motor" in out


def test_residuals_that_are_all_equal_have_a_dash(run_command: Run) -> None:
    run_command(rows=season(6, apogee_m=0.1))
    _, out, _ = run_command("loop")
    assert "nan" not in out


UNUSUAL_BUT_POSSIBLE = (
    {"dry_mass": 1.5, "apogee": 20.0},
    {"rail_angle": math.radians(40)},
    {"diameter": 0.3},
    {"diameter": 0.024},
    {"apogee": 900.0, "diameter": None},
    {"dry_mass": None},
    {"apogee": 1.0},
)


@pytest.mark.parametrize("changes", UNUSUAL_BUT_POSSIBLE, ids=str)
def test_a_merely_unusual_flight_passes(changes: dict[str, object]) -> None:
    assert implausible(GOOD.with_changes(**changes), F24) is None


BEYOND = {
    "dry mass": {"dry_mass": 32.2},
    "rail angle": {"rail_angle": math.radians(90)},
    "apogee": {"apogee": 2500.0},
    "diameter": {"diameter": 0.0066},
    "top speed": {"top_speed": 900.0},
    "coast to apogee": {"coast_to_apogee": 60.0},
    "wind": {"wind": math.nan},
    "pressure": {"pressure": math.inf},
}


@pytest.mark.parametrize("name", BEYOND)
def test_the_reason_names_the_value_as_the_screen_does(name: str) -> None:
    printed = implausible(GOOD.with_changes(**BEYOND[name]), F24)
    assert printed is not None
    assert printed.removeprefix("a ").startswith((f"{name} of ", f"{name}: found "))
    assert "_" not in printed


MOTORS = [motor for motor in catalogue().motors if motor.total_impulse > 1]


@given(st.sampled_from(MOTORS), st.floats(0.02, 50.0), st.floats(0.9, 1.15))
def test_no_flight_simulated_without_drag_exceeds_the_bound(motor: Motor, dry_mass: float, alpha: float) -> None:
    top, speed = climbed(motor, dry_mass, alpha)
    assert top <= best_apogee(dry_mass, motor) * (1 + 1e-3)
    assert speed <= best_speed(dry_mass, motor) * (1 + 1e-3)
    flight = Flight(dry_mass=dry_mass, apogee=top or None, top_speed=speed or None)
    if (
        0.5 < top < LIMITS["apogee"][1] and speed < LIMITS["top_speed"][1]
    ):  # beyond them no rocket of a flyer is believed
        assert implausible(flight, motor) is None


def climbed(motor: Motor, dry_mass: float, alpha: float) -> tuple[float, float]:
    """Apogee [m] and top speed [m/s] straight up without drag on a motor's curve, integrated step by step."""
    time = np.linspace(0, motor.thrust_end, 4001)
    thrust = alpha * np.interp(time, motor.time, motor.thrust)
    step = time[1]
    burned = np.concatenate([[0], np.cumsum((thrust[1:] + thrust[:-1]) / 2 * step)]) / (alpha * motor.total_impulse)
    mass = dry_mass + motor.casing_mass + motor.propellant_mass * (1 - np.clip(burned, 0, 1))
    height = speed = highest = fastest = 0.0
    for push, own in zip(thrust, mass, strict=True):
        speed += (push / own - STANDARD_GRAVITY) * step
        speed = max(speed, 0.0) if height <= 0 else speed
        height += speed * step
        highest, fastest = max(highest, height), max(fastest, speed)
    return max(highest, height + max(speed, 0.0) ** 2 / (2 * STANDARD_GRAVITY)), fastest


@given(st.floats(1e-4, 1e3), st.floats(1e-3, 3.0), st.floats(0, math.pi / 2), st.floats(0.1, 2e5))
def test_accepted_flights_are_within_the_bound_whatever_was_typed(
    dry_mass: float, diameter: float, angle: float, apogee: float
) -> None:
    flight = GOOD.with_changes(dry_mass=dry_mass, diameter=diameter, rail_angle=angle, apogee=apogee)
    assert bool(followed([flight], catalogue())) == (implausible(flight, F24) is None)
    if implausible(flight, F24) is None:
        assert apogee <= READ_TOO_HIGH * best_apogee(dry_mass, F24)


def test_the_motor_of_each_name_is_looked_up_once(monkeypatch: pytest.MonkeyPatch) -> None:
    """The search for names similar to an unknown one takes long."""
    asked: list[str] = []
    resolve = Catalogue.resolve

    def counted(self: Catalogue, text: str, maker: str = "") -> Found:
        asked.append(text)
        return resolve(self, text, maker)

    monkeypatch.setattr(Catalogue, "resolve", counted)
    names = ["F24-4W", "nothing like it", "", "F39-6T"]
    flights = [GOOD.with_changes(flight_id=str(i), motor=names[i % 4]) for i in range(40)]
    found = followed(flights, catalogue())
    assert [flight.flight_id for flight, _ in found] == [str(i) for i in range(40) if i % 4 in (0, 3)]
    assert {flight.motor: one.motor.name for flight, one in found} == {"F24-4W": "F24", "F39-6T": "F39"}
    assert sorted(asked) == sorted(names)


@pytest.mark.parametrize(
    ("one", "other", "same"),
    [
        ("F24-4W", "f24-7W", True),
        ("F24-4W lot 0412", "F24-4W", True),
        ("Q-Jet C12-4", "Q-Jet C12-6", True),
        ("Q-Jet A3-4", "Q-Jet D16-6", False),
        ("HP-I205W-6", "HP-H550ST-14A", False),
        ("C6-5", "C6-5 + 2 x B6-4", False),
        ("1/2A3-2T", "A3-4T", False),
    ],
)
def test_flights_are_compared_on_the_same_motor_with_any_delay(one: str, other: str, same: bool) -> None:
    assert (without_delay(one) == without_delay(other)) == same


def test_flights_that_no_fit_can_use_are_named_by_what_they_lack() -> None:
    lacks_mass = [GOOD.with_changes(flight_id=str(number), dry_mass=None) for number in range(2, 9)]
    other = GOOD.with_changes(rocket="Bird", flight_id="1", motor="X99-0")
    unused = [
        GOOD.with_changes(flight_id="10", dry_mass=None, tags=("cato",)),
        GOOD.with_changes(flight_id="11", dry_mass=None, apogee=None),
    ]
    assert incomplete_flights([GOOD, *lacks_mass, other, *unused], catalogue()) == [
        "Astra: flights 2, 3, 4, 5, 6, and 2 others are excluded from every fit: no dry mass; edit to add it",
        "Bird: flight 1 is excluded from every fit: no known motor; edit to add it",
    ]


@pytest.mark.thorough
def test_flights_without_a_mass_are_named_when_they_are_imported_and_in_every_fit(run_command: Run) -> None:
    rows = season(6)
    for row in rows[1:3]:
        row["dry_mass_g"] = ""
    note = "Astra: flights 2 and 3 are excluded from every fit: no dry mass; edit to add it"
    assert note in " ".join(run_command(rows=rows).err.split())
    for command in ("predict", "loop", "ballast"):
        assert note in " ".join(run_command(command, *FITS[command]).err.split()), command


def test_of_very_many_excluded_flights_the_first_are_named_and_the_others_counted() -> None:
    flight = Flight(rocket="Astra", motor="F24-4W", dry_mass=0.31, diameter=0.066, apogee=5000.0)
    lines = exclusions([flight.with_changes(flight_id=str(number)) for number in range(500)], catalogue())
    assert len(lines) == MAX_EXCLUDED + 1
    assert lines[-1] == f"and {500 - MAX_EXCLUDED} more notes like these"


def test_a_higher_flight_on_a_larger_motor_is_not_far_from_those_on_a_smaller_one() -> None:
    small = [Flight(str(number), "Comet", motor="Q-Jet A3-4", apogee=60.0 + number) for number in range(4)]
    large = Flight("9", "Comet", motor="Q-Jet D16-6", apogee=400.0)
    assert outlying([*small, large], {"9"}, catalogue()) == []
    assert outlying([*small, large.with_changes(motor="Q-Jet A3-6")], {"9"}, catalogue()) != []


def test_implausible_flights_do_not_make_a_right_one_look_wrong() -> None:
    right = [Flight(number, "Comet", motor="F39-6", dry_mass=0.45, apogee=190.0) for number in ("8", "9", "10")]
    high = [one.with_changes(flight_id=f"high {one.flight_id}", apogee=200_000.0) for one in right]
    high.append(high[0].with_changes(flight_id="another"))
    assert outlying([*high, *right], {"8", "9", "10"}, catalogue()) == []


@pytest.mark.sampled
@pytest.mark.parametrize("end", ["lowest", "next to zero", "highest"])
def test_no_value_within_its_limits_makes_a_forecast_fail(end: str, run_command: Run, tmp_path: Path) -> None:
    """Not even one close to zero, whose logarithm and inverse are large; numpy's warnings are errors here."""
    run_command(rows=season(4))
    odd = []
    for column in FLIGHT_COLUMNS:
        if column.name in LIMITS:
            low, high = LIMITS[column.name]
            number = {"lowest": low, "next to zero": max(low, 1e-300), "highest": high}[end]
            value = units.unit(column.quantity, column.unit).to_si(number)
            odd.append(GOOD.with_changes(flight_id=column.name, config="A", **{column.name: value}))
    with Ledger.open(tmp_path / "ledger.db") as ledger:
        ledger.add(odd)
    for words in (["predict", "--rocket", "Astra", "--motor", "F24-4W", "--config", "A"], ["loop", "--quick"]):
        status, out, messages = run_command(*words)
        assert status == 0, messages
        assert not re.search(r"\bnan\b|\binf\b|Warning", out + messages, re.IGNORECASE)


def test_a_value_beyond_its_limits_in_an_old_ledger_is_named_and_not_used(run_command: Run, tmp_path: Path) -> None:
    run_command(rows=season(4))
    with Ledger.open(tmp_path / "ledger.db") as ledger:
        ledger.add([GOOD.with_changes(flight_id="odd", config="A", descent_speed=0.0)])
    status, out, messages = run_command("loop", "--quick")
    assert status == 0
    assert "flight odd of Astra is excluded from every fit: descent speed: found 0 m/s, expected 0.1 to" in messages
    assert "nan" not in out


@pytest.mark.parametrize("text", ["x", "nan", "1e300"])
def test_a_recovery_column_that_cannot_be_read_stops_no_forecast(text: str, run_command: Run, tmp_path: Path) -> None:
    """A spreadsheet's own column may have the same name; only columns that a fit uses exclude the flight."""
    run_command(rows=season(4))
    names = [recovery_header(name) for name in RECOVERY_NAMES]
    with Ledger.open(tmp_path / "ledger.db") as ledger:
        ledger.add([GOOD.with_changes(flight_id=name, config="A", extra={name: text}) for name in names])
    for words in (["predict", "--rocket", "Astra", "--motor", "F24-4W", "--config", "A"], ["loop", "--quick"]):
        status, _, messages = run_command(*words)
        assert status == 0, messages
        assert set(re.findall(r"flight (\w+) of Astra is excluded", messages)) <= {
            *(recovery_header(name) for name in IN_EVERY_FIT),
            "rail_direction",
        }
        assert "is excluded" in messages


BOOST = {"top_speed": 75.0, "burn_time": 2.0, "peak_accel": 80.0, "avg_accel": 37.5}
"""Consistent readouts of a boost on an F24. [SI]"""


@pytest.mark.parametrize(
    ("changes", "excluded"),
    [
        ({}, set()),
        ({"peak_accel": 500.0}, {"peak_accel"}),
        ({"burn_time": 0.5, "avg_accel": 78.0}, {"burn_time"}),
        ({"burn_time": 2.0, "avg_accel": 300.0}, {"avg_accel", "peak_accel"}),
        ({"burn_time": 6.0, "avg_accel": 12.5}, {"burn_time"}),
        ({"burn_time": 3.0, "avg_accel": 25.0}, set()),
        ({"peak_accel": 30.0}, {"peak_accel"}),
        ({"peak_accel": 30.0, "top_speed": 40.0}, {"peak_accel", "avg_accel"}),
        ({"coast_to_apogee": 0.0, "apogee_to_eject": 0.0}, {"coast_to_apogee", "avg_accel", "apogee_to_eject"}),
        ({"coast_to_apogee": 5.0, "apogee_to_eject": 0.0}, set()),
    ],
)
def test_readouts_that_cannot_be_measurements_are_excluded(changes: dict[str, float], excluded: set[str]) -> None:
    flight = GOOD.with_changes(**BOOST, **{name: value for name, value in changes.items() if name not in BOOST})
    flight = flight.with_changes(**changes)
    assert set(not_measured(flight, F24)) == excluded
    motors = [catalogue().resolve("F24-4W")]
    seen = observe(history_of([flight], motors, used_in_fit=[True])).seen[0]
    expected = observe(history_of([flight.with_changes(**dict.fromkeys(excluded))], motors, used_in_fit=[True])).seen[0]
    assert (seen == expected).all()
    assert seen[0]


def test_an_excluded_readout_is_named_and_changes_no_forecast(run_command: Run) -> None:
    run_command(rows=season(6, peak_accel_g=8.2, coast_to_apogee_s=5.5))
    words = ["predict", "--motor", "F24-4W", "--config", "A", "--json"]

    def apogee(peak: str) -> float:
        assert run_command("edit", "6", f"peak_accel={peak}").status == 0
        (made,) = run_command(*words).document["predictions"]
        return float(made["apogee_m"]["p50"])

    assert apogee("51g") == apogee("-") != apogee("9g")
    assert run_command("edit", "6", "peak_accel=51g").status == 0
    excluded = "peak acceleration is excluded from every fit: 51 g is more than"
    assert f"flight 6 of Astra: {excluded}" in run_command(*words).err
    assert f"flight 6 of Astra: {excluded}" in run_command("loop", "--look").out
    run_command("tag", "6", "checked")
    assert excluded not in run_command(*words).err
    late = season(7)[-1] | {"peak_accel_g": 51.0}
    assert f"row 2: flight 7 of Astra: {excluded}" in run_command(rows=[late]).err


def test_the_example_beside_a_mistake_has_the_unit_that_was_typed_or_that_of_the_form() -> None:
    for text, example in (("1.6x4", "in"), ("-3cm", "cm"), ("four", "in")):
        with pytest.raises(BadValue, match=rf"such as [\d.]+{example}$"):
            read_answer("diameter", text, "in")


@pytest.mark.parametrize(
    ("ratio", "words"),
    [(4.84, "4.8 times"), (0.171, "17% of"), (3e9, "more than 1000 times"), (1e-9, "less than 1/1000 of")],
)
def test_a_ratio_is_in_plain_figures(ratio: float, words: str) -> None:
    flight = Flight(motor="F24-4W", apogee=1e-3 * ratio)
    assert f" is {words} the usual " in next(far_from_usual(flight, {"apogee": 1e-3}))[0]


def test_a_readout_on_the_other_side_of_zero_is_far_from_the_usual_one() -> None:
    (phrase, _), *_ = far_from_usual(Flight(motor="F24-4W", eject_altitude=-100.0), {"eject_altitude": 100.0})
    assert "is -100% of the usual 100 m" in phrase
