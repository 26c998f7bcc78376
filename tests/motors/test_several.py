"""Clusters and two stages: thrusts add, air starts burn later, boosters drop, and impossible setups are refused."""

from pathlib import Path

import numpy as np
import pytest

from fieldkit.errors import UnknownMotor
from fieldkit.flight import Flight
from fieldkit.ledger import Ledger
from fieldkit.motors import PLUGGED_DELAY, Found, Motor, catalogue
from fieldkit.motors.motor import impulse
from fieldkit.motors.several import Booster, names_several
from fieldkit.physics.flight import fly
from fieldkit.physics.history import field_setup
from fieldkit.physics.state import FlightResult
from fieldkit.planning.classification import build_of
from fieldkit.planning.safety import thrust_to_weight
from tests.commands import Run

pytestmark = pytest.mark.fast

CHECK_SHAPES = False
MOTORS = catalogue()


def several(text: str, *booster_masses: float) -> Motor:
    return MOTORS.resolve_several(text, tuple(map(Booster, booster_masses))).motor


def flown(motor: Motor, dry_mass: float, drag_area: float, rail: float = 1.0, wind: float = 0.0) -> FlightResult:
    flight = Flight(dry_mass=dry_mass, diameter=0.05, rail_length=rail)
    setup = field_setup([flight], [Found(motor, None)], np.array([drag_area]))
    return fly(setup.with_changes(wind=np.array([wind])))


def test_the_thrusts_and_masses_of_a_cluster_add() -> None:
    one, three = MOTORS.resolve("Estes C6").motor, several("3 x Estes C6-5")
    at = np.linspace(0, 2, 40)
    assert np.interp(at, three.time, three.thrust) == pytest.approx(3 * np.interp(at, one.time, one.thrust))
    assert three.total_impulse == pytest.approx(3 * one.total_impulse)
    assert impulse(three.time, three.thrust) == pytest.approx(three.total_impulse)
    assert three.loaded_mass == pytest.approx(3 * one.loaded_mass)
    assert MOTORS.resolve_several("3 x Estes C6-5").delay == 5.0
    assert several("3 x Estes C6-5") is three
    build = build_of(three, 0.2)
    assert (build.complex, len(build.motors)) == (True, 3)
    assert build.impulse == pytest.approx(three.total_impulse)


@pytest.mark.parametrize(
    ("text", "delay"),
    [
        ("C6-0 + C6-5", 5.0),  # a booster has no charge
        ("2 x C6-P + C6-5", 5.01),  # nor has a plugged motor
        ("A10-3 + C6-5", 2.205),  # at 1.05 + 3 s, before 1.85 + 5 s
        ("C6-5 + A10-3", 2.205),
        ("D12-5 + 2 x C6-7@1.5", 3.285),  # 5 s after the burnout of the D12, not of the motors lit later
        ("2 x C6-0", 0.0),
        ("C6-0 x2", 0.0),
        ("2 x C6-P", PLUGGED_DELAY),
        ("2 x C6", None),
    ],
)
def test_the_first_charge_of_a_cluster_fires_after_the_delay_of_its_own_motor(text: str, delay: float | None) -> None:
    found = MOTORS.resolve_several(text)
    assert found.delay == pytest.approx(delay, abs=0.002)


def test_three_motors_lift_three_rockets_tied_together_as_high_as_one() -> None:
    one, three = MOTORS.resolve("Estes C6").motor, several("3 x Estes C6-5")
    alone, tied = flown(one, 0.05, 0.0004), flown(three, 0.15, 0.0012)
    assert tied.apogee == pytest.approx(alone.apogee, rel=1e-4)


def test_an_air_start_burns_later_and_its_propellant_stays_until_then() -> None:
    main_motor, late = MOTORS.resolve("Estes C6").motor, several("C6-5 + 2 x B6-4@1.5")
    at = np.array([0.5, 1.0])
    assert np.interp(at, late.time, late.thrust) == pytest.approx(np.interp(at, main_motor.time, main_motor.thrust))
    assert late.time[-1] > 2.0
    assert late.spent is not None
    before = float(np.interp(1.45, late.time, late.spent)) * late.propellant_mass
    assert before <= main_motor.propellant_mass + 1e-9
    with pytest.raises(Exception, match="lit at the start"):
        several("C6-5@1 + B6-4@2")


@pytest.mark.parametrize("booster_mass", [0.03, 0.2])
def test_the_speed_gained_by_two_stages_is_the_integral_of_thrust_over_mass(booster_mass: float) -> None:
    """In vacuum, the speed at the end is the integral of thrust over mass less gravity."""
    dry, motor = 0.08, several("D12-0/C6-7", booster_mass)
    booster, upper = MOTORS.resolve("D12-0").motor, MOTORS.resolve("C6-7").motor
    assert motor.loaded_mass == pytest.approx(booster.loaded_mass + upper.loaded_mass + booster_mass)

    def burned(one: Motor, t: float) -> float:
        at = np.linspace(0, t, 400)
        return float(np.trapezoid(np.interp(at, one.time, one.thrust), at) / one.total_impulse)

    def first(t: float) -> float:
        mass = dry + motor.loaded_mass - burned(booster, t) * booster.propellant_mass
        return float(np.interp(t, booster.time, booster.thrust)) / mass

    def second(t: float) -> float:
        mass = dry + upper.loaded_mass - burned(upper, t) * upper.propellant_mass
        return float(np.interp(t, upper.time, upper.thrust)) / mass

    result = flown(motor, dry, 1e-9)
    lit = float(result.rise_time[0] - result.coast_time[0])  # from lift-off to the end of the burn
    gained = 0.0
    for push, end in ((first, booster.thrust_end), (second, upper.thrust_end)):
        at = np.linspace(0, end, 400)
        gained += float(np.trapezoid([push(float(t)) for t in at], at))
    speed = float(result.coast_time[0]) * 9.80665  # at the end of the burn, in vacuum
    assert speed == pytest.approx(gained - 9.80665 * lit, rel=0.02)


@pytest.mark.parametrize("drag", [1.0, 2.5])
def test_three_stages_agree_with_a_simple_integration(drag: float) -> None:
    """Top speed by Euler's method in air of constant density, each booster and its drag dropped when its motor ends."""
    text, boosters, dry, area = "C6-0/B6-0/A8-5", (0.02, 0.01), 0.04, 4e-4
    motor = MOTORS.resolve_several(text, tuple(Booster(mass, drag) for mass in boosters)).motor
    stages = [MOTORS.resolve(name).motor for name in ("C6-0", "B6-0", "A8-5")]
    speed, top, step = 0.0, 0.0, 2e-4
    for number, one in enumerate(stages):
        above = dry + sum(boosters[number:]) + sum(other.loaded_mass for other in stages[number + 1 :])
        at = np.arange(0.0, one.thrust_end, step)
        push = np.interp(at, one.time, one.thrust)
        left = above + one.loaded_mass - one.propellant_mass * np.cumsum(push) / push.sum()
        wide = area * (drag if number < 2 else 1.0)
        for thrust, mass in zip(push, left, strict=True):
            speed = max(speed + step * ((thrust - 0.5 * 1.225 * wide * speed**2) / mass - 9.80665), 0.0)
            top = max(top, speed)
    result = flown(motor, dry, area)
    assert float(result.top_speed[0]) == pytest.approx(top, rel=0.01)
    assert (motor.drag is None) is (drag == 1.0)


def test_a_booster_that_is_not_dropped_costs_height() -> None:
    two = flown(several("D12-0/C6-7", 0.06), 0.08, 0.0004).apogee
    one = flown(MOTORS.resolve("C6-7").motor, 0.08, 0.0004).apogee
    assert two > 1.5 * one


@pytest.mark.parametrize(
    ("text", "named"),
    [
        ("D12-0/C6-0/B6-0/A8-5", "4 stages"),
        ("D12-0/C6-0/B6-4", "60g/40g"),
        ("D12-0/C6-7", "--booster-mass"),
        ("30 x C6-5", "30 motors"),
        ("2 x Zonk", "no motor 'Zonk', expected"),
    ],
)
def test_an_impossible_combination_of_motors_is_reported(text: str, named: str) -> None:
    with pytest.raises(UnknownMotor, match=named):
        MOTORS.resolve_several(text)


OPENROCKET = [
    ("Estes B6-4", 1.0, 0.076, 0.02479, 0.75, 112.01, 4.06, 0.86),
    ("Estes C6-5", 1.0, 0.081, 0.02479, 0.753, 271.99, 5.57, 1.86),
    ("Estes C6-7", 1.0, 0.071, 0.025, 0.621, 319.75, 6.0, 1.86),
    ("Estes C11-5", 3.048, 0.158, 0.07874, 0.21, 98.29, 3.82, 0.81),
    ("Estes D12-7", 1.0, 0.076, 0.02479, 1.778, 282.23, 4.28, 1.65),
    ("AeroTech H669N", 3.048, 1.613, 0.05664, 0.811, 592.72, 9.99, 0.33),
    ("AeroTech H999N", 3.048, 1.692, 0.05664, 0.819, 897.47, 11.91, 0.33),
    ("4 x Estes B4-4", 1.0, 0.246, 0.055, 0.607, 142.21, 4.32, 1.03),
    ("4 x Estes C6-5", 1.0, 0.262, 0.055, 0.61, 306.96, 5.57, 1.86),
    ("4 x Estes C6-7", 1.0, 0.262, 0.055, 0.61, 307.26, 5.6, 1.86),
]
"""Motors, rod [m], lift-off mass [kg], diameter [m], Cd of the coast, apogee [m], best delay [s], burnout [s]: stored
simulations of OpenRocket 24.12 in 2 m/s of wind, of its examples whose motor burns as long as the catalog's, and
whose charge does not fire early."""


@pytest.mark.parametrize("stored", OPENROCKET, ids=[f"{row[0]}, {row[3] * 1e3:g} mm" for row in OPENROCKET])
def test_results_agree_with_openrockets_stored_simulations(
    stored: tuple[str, float, float, float, float, float, float, float],
) -> None:
    """Source: openrocket/openrocket@8fa969d, examples; apogee within 2%, best delay within 0.3 s."""
    name, rod, mass, diameter, cd, apogee, delay, burnout = stored
    motor = several(name)
    assert motor.burnout == pytest.approx(burnout, rel=0.03)
    result = flown(motor, mass - motor.loaded_mass, cd * np.pi / 4 * diameter**2, rod, wind=2.0)
    assert float(result.apogee[0]) == pytest.approx(apogee, rel=0.02)
    assert float(result.coast_time[0]) == pytest.approx(delay, abs=0.3)


def test_simulate_supports_a_cluster_and_two_stages(run: Run) -> None:
    body = ["--dry-mass-g", "100", "--diameter-mm", "30", "--cd", "0.6", "--json"]
    heights = {}
    for name, more in (("C6-5", []), ("3 x C6-5", []), ("D12-0/C6-7", ["--booster-mass", "50g"])):
        captured = run("simulate", "--motor", name, *more, *body)
        heights[name] = captured.document["true_apogee_m"]
        assert ("cluster" in captured.err) is (name == "3 x C6-5")
    assert heights["3 x C6-5"] > 2 * heights["C6-5"]
    assert heights["D12-0/C6-7"] > 2 * heights["C6-5"]
    wide = ["--motor", "D12-0/C6-7", "--booster-mass", "50g", "--booster-cd", "1.5"]
    assert run("simulate", *wide, *body).document["true_apogee_m"] < 0.99 * heights["D12-0/C6-7"]
    assert "--booster-cd" in run("simulate", *wide, "--booster-mass", "50g/40g", *body, status=2).err
    assert "--booster-mass" in run("simulate", "--motor", "D12-0/C6-7", *body, status=1).err


def test_stages_are_simulated_from_mass_and_diameter_alone_with_the_rules_that_govern_them(
    run: Run,
) -> None:
    """A ruler and a scale give no Cd; no other command flies stages, so this one names their codes."""
    body = ["simulate", "--motor", "D12-0/C6-7", "--booster-mass", "60g", "--dry-mass", "100g", "--diameter", "30mm"]
    captured = run(*body, "--json")
    found = captured.document
    assert f"Cd not given: {found['cd']:.2f}, the median of other rockets" in captured.err
    for end in ("p05", "p95"):
        cd = found["cd_p95" if end == "p05" else "cd_p05"]
        assert run(*body, "--cd", cd, "--json").document["apogee_m"] == pytest.approx(found[f"apogee_m_{end}"])
    checks = {one["check"]: one for one in found["safety"]}
    total = several("D12").total_impulse + several("C6").total_impulse
    assert f"{total:.0f} N s" in checks["class"]["text"]
    assert "305 m across" in checks["field size"]["text"]
    assert checks["complex rocket"]["verdict"] == "caution"
    assert "people at least 9 m away" in checks["complex rocket"]["text"]
    first = thrust_to_weight(several("D12"), 0.160 + several("C6").loaded_mass)[0]
    assert f"{first:.1f} in the first half second" in checks["thrust to weight"]["text"]
    run(*body[:3], *body[5:], "--cd", "0.6", "--json", status=1)
    assert "safety" not in run("simulate", "--motor", "C6-5", *body[5:], "--json").document
    assert "--cd" in run("simulate", "--motor", "F24", *body[5:], "--physics", "paper", status=2).err


def test_a_rocket_is_simulated_with_the_mass_of_all_its_stages(run: Run) -> None:
    stages = [
        "simulate",
        "--motor",
        "D12-0/C6-7",
        "--booster-mass",
        "60g",
        "--diameter",
        "30mm",
        "--cd",
        "0.6",
        "--json",
    ]
    motors = [catalogue().resolve(name).motor.loaded_mass * 1e3 for name in ("Estes D12", "Estes C6")]
    apogees = []
    for weighed in (["--dry-mass", "100g"], ["--lift-off-mass", f"{100 + 60 + sum(motors):.6f}g"]):
        apogees.append(run(*stages, *weighed).document["apogee_m"])
    assert apogees[0] == pytest.approx(apogees[1], rel=1e-6)


def test_a_cluster_is_planned_as_a_complex_rocket(run: Run) -> None:
    body = ["--motor", "3 x C6-5", "--dry-mass", "200g", "--diameter", "50mm", "--rocket", "Trio"]
    lines = {line["check"]: line for line in run("landing", *body, "--wind", "3m/s", "--json").document["safety"]}
    assert lines["complex rocket"]["verdict"] == "caution"
    assert "3 motors, forecast as if every one lights" in lines["complex rocket"]["text"]


def test_a_search_for_a_cluster_shows_its_totals(run: Run) -> None:
    one, three = (["motors", *text.split(), "--json"] for text in ("Estes C6", "3 x Estes C6"))
    found = []
    for command in (one, three):
        found.append(run(*command).document["motors"])
    assert len(found[1]) == 1
    assert found[1][0]["total_impulse_ns"] == pytest.approx(3 * found[0][0]["total_impulse_ns"], rel=1e-3)


def test_a_table_of_flights_on_several_motors_is_imported_and_used_in_no_fit(tmp_path: Path, run: Run) -> None:
    table = tmp_path / "flights.csv"
    header = "flight_id,date_time,rocket,dry_mass_g,diameter_mm,motor,apogee_m"
    rows = ["1,2026-05-01T10:00,Trio,200,66,3 x C6-5,190", "2,2026-05-01T11:00,Trio,100,30,D12-0/C6-7,400"]
    rows += ["3,2026-05-01T12:00,Trio,8000,130,K550W + 2 x I211W@1.5,1600"]
    table.write_text("\n".join([header, *rows]))
    assert run("import", table, "--json").document["imported"] == 3
    tags = {one["flight_id"]: one["tags"] for one in run("flights", "--json").document["flights"]}
    assert {id: "staged" if "staged" in given else "cluster" for id, given in tags.items() if given} == {
        "1": "cluster",
        "2": "staged",
        "3": "cluster",
    }
    document = run("predict", "--rocket", "Trio", "--motor", "C6-5", "--dry-mass", "60g", "--json").document
    (made,) = document["predictions"]
    assert made["flights"] == 0


@pytest.mark.parametrize("motor", ["D12-0/C6-7", "4 x D12-0/C6-7"])
@pytest.mark.parametrize(
    "command",
    [
        ["predict"],
        ["landing"],
        ["delay"],
        ["ballast", "--target", "800ft"],
        ["contest", "--season", "2026"],
        ["daysheet", "--out", "x.pdf"],
    ],
)
def test_no_plan_has_stages(command: list[str], motor: str, run: Run) -> None:
    body = ["--motor", motor, "--dry-mass", "200g", "--diameter", "50mm"]
    assert "expected fieldkit simulate with --booster-mass" in run(*command, *body, status=1).err


def test_a_forecast_of_a_cluster_agrees_with_the_planning_commands_and_is_compared_with_its_flight(
    tmp_path: Path, run: Run
) -> None:
    body = ["--motor", "3 x C6-5", "--dry-mass", "200g", "--diameter", "50mm", "--rocket", "Trio"]
    plans = tmp_path / "plans.csv"
    plans.write_text("flight_id,rocket,dry_mass_g,diameter_mm,motor\n1,Trio,200,50,3 x C6\n")
    shown = run("predict", "--flights", plans, "--json")
    assert shown.err.count("failed ignitions are not modeled") == 1
    (made,) = shown.document["predictions"]
    body[1] = "3 x C6"  # a delay could end the coast before apogee
    assert made["coast_s"] == pytest.approx(run("delay", *body, "--json").document["coast_s"]["p50"], rel=0.02)
    run("add", "--flight-id", "1", *body, "--apogee", "190m", "--tags", "cluster")
    (kept,) = run("predictions", "--json").document["predictions"]
    assert kept["flown"]["apogee_m"] == 190


@pytest.mark.parametrize("text", ["Estes 3 x C6", "Estes C6 + 2 x Quest B6@1.5", "2 x AeroTech F24W + AeroTech E15W@1"])
def test_a_cluster_may_be_named_as_it_is_printed(text: str) -> None:
    motor = catalogue().resolve_several(text).motor
    again = catalogue().resolve_several(f"{motor.maker} {motor.designation}").motor
    assert (again.designation, again.parts) == (motor.designation, motor.parts)
    assert [one.designation for one in catalogue().search(text)] == [motor.designation]


def test_groups_of_motors_are_counted_together() -> None:
    with pytest.raises(UnknownMotor, match="more than 20 motors"):
        catalogue().resolve_several("11 x C6-5 + 10 x B6-4")


def test_one_motor_lit_later_is_a_complaint_and_not_an_error() -> None:
    assert catalogue().complaint_of_several("C6-5@1.5")
    catalogue().search("C6-5@1.5")


def test_no_motor_for_sale_is_read_as_several() -> None:
    assert [
        motor.designation for motor in catalogue().motors if names_several(f"{motor.maker} {motor.designation}")
    ] == []


@pytest.mark.parametrize("command", ["predict", "landing", "delay"])
def test_a_plan_with_a_cluster_states_what_is_not_modeled(command: str, run: Run) -> None:
    body = ["--motor", "3 x C6-5", "--lift-off-mass", "272g", "--diameter", "50mm"]
    assert run(command, *body).err.count("failed ignitions are not modeled") == 1


def test_a_flight_on_several_motors_is_recorded_as_flown(tmp_path: Path) -> None:
    with Ledger.open(str(tmp_path / "ledger.db")) as ledger:
        ledger.add([Flight(flight_id="1", rocket="Trio", motor="3 x C6-5", apogee=150.0)])
        assert ledger.flights("Trio")[0].motor == "3 x C6-5"


def test_a_plan_on_one_motor_does_not_take_the_mass_of_a_flight_with_boosters(tmp_path: Path, run: Run) -> None:
    table = tmp_path / "flights.csv"
    table.write_text(
        "flight_id,rocket,dry_mass_g,diameter_mm,motor,apogee_m\n1,Two,120,25,C6-5,150\n2,Two,190,26,D12-0/C6-5,300\n"
    )
    run("import", str(table))
    assert "120 g without the motor" in run("predict", "--rocket", "Two", "--motor", "C6-5").out
    run("add", "--rocket", "Two", "--motor", "C6-5", "--apogee", "160m")
    run("add", "--rocket", "Two", "--motor", "D12-0/C6-5", "--apogee", "310m")
    added = run("flights", "--json").document["flights"][2:]
    assert [one["dry_mass_g"] for one in added] == [120, 190]
    assert [one["tags"] for one in added] == ["", "staged"]
    run("edit", added[0]["flight_id"], "motor=2 x C6-5")
    run("edit", added[1]["flight_id"], "motor=C6-5", "tags=staged")
    edited = run("flights", "--json").document["flights"][2:]
    assert [one["tags"] for one in edited] == ["cluster", "staged"]
