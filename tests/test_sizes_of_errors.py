"""Notes say by how much an apogee is off: the sizes that they state are those of the flights that they name."""

import re
from collections.abc import Callable
from contextlib import suppress
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from fieldkit.errors import BadValue
from fieldkit.flight import Flight
from fieldkit.flight.recovery import STABILITY
from fieldkit.motors import Found, catalogue
from fieldkit.motors.draft import PER_IMPULSE
from fieldkit.motors.motor import normalised
from fieldkit.motors.search import CURVE_ERROR
from fieldkit.motors.several import ONE_UNLIT, STAGES_NOTE
from fieldkit.openrocket.parts import PER_AREA, PER_MASS
from fieldkit.paths import REFERENCE_FLIGHTS
from fieldkit.physics.effect import effects
from fieldkit.physics.flight import fly
from fieldkit.physics.history import field_setup
from fieldkit.physics.single import field_flight
from fieldkit.planning.air import OTHER_AIR
from fieldkit.planning.check import OFF_APOGEE
from fieldkit.planning.quick_guide import QUICK_ERROR
from fieldkit.planning.rule_lines import STABLE
from fieldkit.presentation.planning_text import BREEZE, IN_A_BREEZE, OFF_VERTICAL
from fieldkit.units import STANDARD_GRAVITY
from tests.commands import Run
from tools.motors import falling
from tools.strings import texts

FAST, SLOW, LIGHT = ("F24-4W", 322, 66), ("A8-3", 40, 25), ("C6-5", 60, 25)
STAGED = (("C6-5/C6-0", 60, 25, "--booster-mass", "30g"), ("F24-7W/E28-0", 322, 66, "--booster-mass", "150g"))
"""Motor, dry mass [g] and diameter [mm] of the rockets."""
Apogee = Callable[..., float]


@pytest.fixture
def apogee(run: Run) -> Apogee:
    """The apogee of a rocket, by default with a Cd of 0.6 [m]."""

    def of(motor: str, mass: float, diameter: float, *more: object, cd: float = 0.6) -> float:
        body = ("--dry-mass", f"{mass}g", "--diameter", f"{diameter}mm", "--cd", cd)
        return float(run("simulate", "--motor", motor, *body, *more, "--json").document["apogee_m"])

    return of


def ends(note: str) -> list[float]:
    """The ends of the range that a note states. [%]"""
    found = re.search(r"([\d.]+) to ([\d.]+)%", note)
    assert found
    return [float(end) for end in found.groups()]


def test_a_wind_that_is_not_given_lowers_the_apogee_by_the_stated_part(apogee: Apogee) -> None:
    lost = [100 * (1 - apogee(*one, "--wind", f"{BREEZE}m/s") / apogee(*one)) for one in (FAST, SLOW, LIGHT)]
    assert [round(min(lost)), round(max(lost))] == ends(IN_A_BREEZE)


def test_a_rail_off_vertical_lowers_the_apogee_by_the_stated_part(apogee: Apogee) -> None:
    lost = [100 * (1 - apogee(*one, "--rail-angle", 5) / apogee(*one)) for one in (FAST, SLOW, LIGHT)]
    assert [round(min(lost), 1), round(max(lost), 1)] == ends(OFF_VERTICAL)


def flown(one: tuple[str, int, int], **more: Any) -> dict[str, float]:
    """The figures of a flight with a Cd of 0.6, by column."""
    motor, mass, diameter = one
    found = catalogue().resolve(motor)
    plan = Flight("1", motor=motor, dry_mass=mass / 1000, diameter=diameter / 1000, delay=found.delay)
    return field_flight(plan.with_changes(**more), found, 0.6, 1.0)


def test_a_larger_margin_lowers_the_apogee_in_a_wind_by_the_stated_part() -> None:
    lost = []
    for one in (FAST, SLOW, LIGHT):
        two, four = (flown(one, wind=BREEZE, extra={STABILITY: margin})["apogee_m"] for margin in ("2", "4"))
        lost.append(100 * (1 - four / two))
    assert [round(min(lost), 1), round(max(lost), 1)] == ends(STABLE)


def test_a_charge_far_from_apogee_shortens_the_way_down_by_the_stated_part() -> None:
    lost = []
    for one in (FAST, SLOW, LIGHT):
        delay = catalogue().resolve(one[0]).delay
        assert delay is not None
        delay -= flown(one)["apogee_to_eject_s"]
        best, early, late = (flown(one, delay=delay + off)["duration_s"] for off in (0, -2, 2))
        lost += [100 * (1 - early / best), 100 * (1 - late / best)]
    assert [round(min(lost)), round(max(lost))] == ends(OFF_APOGEE)


def test_a_motor_that_does_not_light_lowers_the_apogee_of_a_cluster_by_the_stated_part(apogee: Apogee) -> None:
    lost = [100 * (1 - apogee("2 x C6-5", *one) / apogee("3 x C6-5", *one)) for one in ((120, 42), (300, 66))]
    assert [round(min(lost)), round(max(lost))] == ends(ONE_UNLIT)
    for page in ("planning", "predictions"):
        assert "29 to 46%" in (Path(__file__).parents[1] / f"docs/{page}.md").read_text(encoding="utf-8")


def test_a_curve_that_lacks_impulse_lowers_the_apogee_by_the_stated_part(apogee: Apogee) -> None:
    lost = [10 * (1 - apogee(*one, "--alpha", 0.9) / apogee(*one)) for one in (FAST, SLOW, LIGHT)]
    assert [round(min(lost), 1), round(max(lost), 1)] == ends(PER_IMPULSE)


def test_an_estimated_curve_moves_nine_apogees_in_ten_by_less_than_stated() -> None:
    """On rockets whose motor starts them at 8 times their weight."""
    plans, listed, estimated = [], [], []
    for motor in catalogue().motors[::10]:
        with suppress(BadValue):
            time, thrust = np.array(falling(motor.total_impulse, float(motor.thrust.max()), motor.thrust_end)).T
            mass = max(motor.rated_thrust / (8 * STANDARD_GRAVITY) - motor.loaded_mass, motor.loaded_mass / 2)
            plans.append(Flight("1", dry_mass=mass, diameter=1.6 * motor.diameter, delay=30.0))
            listed.append(Found(motor, 30.0))
            shaped = replace(motor, time=time, thrust=normalised(time, thrust, motor.total_impulse))
            estimated.append(Found(shaped, 30.0))
    drag = 0.6 * np.pi / 4 * np.array([one.diameter or 0.0 for one in plans]) ** 2
    true, found = (fly(field_setup(plans, motors, drag)).apogee for motors in (listed, estimated))
    assert len(plans) > 50
    assert 0.5 * CURVE_ERROR < np.quantile(np.abs(found / true - 1), 0.9) < CURVE_ERROR


def test_missing_mass_and_area_raise_the_apogee_by_the_stated_part(apogee: Apogee) -> None:
    light = [
        10 * (apogee(motor, 0.9 * mass, *rest) / apogee(motor, mass, *rest) - 1) for motor, mass, *rest in (FAST, SLOW)
    ]
    assert [round(min(light), 1), round(max(light), 1)] == ends(PER_MASS)
    slender = [10 * (apogee(*one, cd=0.54) / apogee(*one) - 1) for one in (FAST, SLOW)]
    assert [round(min(slender), 1), round(max(slender), 1)] == ends(PER_AREA)


def test_boosters_that_drag_more_lower_the_apogee_by_the_stated_part(apogee: Apogee) -> None:
    lost = [100 * (1 - apogee(*one, "--booster-cd", 0.66) / apogee(*one)) for one in STAGED]
    assert [round(min(lost), 1), round(max(lost), 1)] == ends(STAGES_NOTE)


def test_air_that_is_not_given_moves_the_apogee_as_the_page_of_forecasts_says(run: Run) -> None:
    def apogees(one: tuple[str, int, int], *air: str) -> tuple[float, float]:
        motor, mass, diameter = one
        body = ("--dry-mass", f"{mass}g", "--diameter", f"{diameter}mm", "--cd", 0.6)
        found = run("simulate", "--motor", motor, *body, *air, "--json").document
        return found["apogee_m"], found["true_apogee_m"]

    rockets = (FAST, SLOW, LIGHT)
    usual = [apogees(one) for one in rockets]
    warm = [apogees(one, "--temperature", "25C") for one in rockets]
    high = [apogees(one, "--site-elevation", "300m") for one in rockets]
    shown = [round(100 * (1 - now[0] / then[0])) for now, then in zip(warm, usual, strict=True)]
    assert [min(shown), max(shown)] == ends(OTHER_AIR["temperature"][2]) == [2, 3]
    gains = [round(100 * (now[0] / then[0] - 1), 1) for now, then in zip(high, usual, strict=True)]
    assert [min(gains), max(gains)] == ends(OTHER_AIR["elevation"][2])
    moved = [
        abs(apogees(one, "--pressure", "1023.25hPa")[0] / then[0] - 1) for one, then in zip(rockets, usual, strict=True)
    ]
    assert f"up to {100 * max(moved):.1f}% either way" == OTHER_AIR["pressure"][2]
    true = [
        [round(100 * (now[1] / then[1] - 1), 1) for now, then in zip(air, usual, strict=True)] for air in (warm, high)
    ]
    assert [(min(gain), max(gain)) for gain in true] == [(0.6, 1.4), (0.5, 1.2)]
    page = " ".join((Path(__file__).parents[1] / "docs" / "predictions.md").read_text(encoding="utf-8").split())
    assert "2 to 3% too high for what the altimeter shows, 0.6 to 1.4% too low for the true apogee" in page
    assert "too low, by 0.5 to 1.2%" in page


def test_drag_near_the_speed_of_sound_lowers_the_apogee_as_the_page_of_forecasts_says() -> None:
    high = []
    for motor, mass, diameter, mach in (("G80T-7", 300, 38, 0.8), ("G80T-7", 200, 29, 1.1)):
        plan = Flight("1", motor=motor, dry_mass=mass / 1000, diameter=diameter / 1000, delay=20.0)
        setup = field_setup([plan], [catalogue().resolve(motor)], np.array([0.6 * np.pi / 4 * diameter**2 / 1e6]))
        without = fly(setup)
        assert round(float(without.top_speed.item()) / 340, 1) == mach
        for rise in (0.5, 1.0):
            risen = fly(effects()["mach_drag"].bend_setup(setup, np.asarray(rise)))
            high.append(round(100 * (without.apogee.item() / risen.apogee.item() - 1)))
    page = " ".join((Path(__file__).parents[1] / "docs" / "predictions.md").read_text(encoding="utf-8").split())
    assert f"too high: by {high[0]} to {high[1]}% at Mach 0.8 and {high[2]} to {high[3]}% at Mach 1.1" in page


@pytest.mark.thorough
def test_quick_figures_and_the_guide_are_off_by_at_most_the_stated_part(run: Run, tmp_path: Path) -> None:
    """Of motors that fit the reference rocket: quick apogees beside those of the guide, the guide beside forecasts with
    all simulations."""
    run("import", REFERENCE_FLIGHTS)
    listed = [one for one in run("motors", "--fit", "Astra", "--json").document["motors"] if one["fits"]]
    at_once = run("motors", "--fit", "Astra", "--quick", "--json").document["motors"]
    quick = {one["motor"]: one["apogee_m"]["p50"] for one in at_once}
    off = [abs(quick[one["motor"]] / one["apogee_m"]["p50"] - 1) for one in listed]
    assert len(off) > 20
    assert 0.03 < max(off) < 0.10, QUICK_ERROR
    rows = [f"{one['maker']} {one['motor']},{one['delay_s']},448,66" for one in listed]
    plans = tmp_path / "plans.csv"
    head = "rocket,config,motor,delay_s,dry_mass_g,diameter_mm"
    plans.write_text("\n".join([head, *(f"Astra,B,{row}" for row in rows)]), encoding="utf-8")
    flown = [one["apogee_m"] for one in run("predict", "--flights", plans, "--json").document["predictions"]]
    for level, stated in (("p50", 0.03), ("p05", 0.12), ("p95", 0.12)):
        beside = [abs(one["apogee_m"][level] / whole[level] - 1) for one, whole in zip(listed, flown, strict=True)]
        assert 0.5 * stated < max(beside) < stated


VAGUE = re.compile(
    r"\b(slightly|somewhat|marginally|approximately|optimistic|pessimistic|conservative|a bit (high|low|wide|narrow))\b"
)
"""Words that speak of an error without its size."""


def test_pages_and_messages_state_the_size_of_an_error_in_figures() -> None:
    """So do those that call an answer provisional, in the same paragraph or by a link to its page."""
    pages = [page.read_text(encoding="utf-8") for page in sorted((Path(__file__).parents[1] / "docs").glob("*.md"))]
    shown = [part for page in pages for part in re.split(r"```\w*\n.*?```|\n\n|\n- ", page, flags=re.DOTALL)]
    shown += [text for _, _, text in texts(("fieldkit", "parsers"))]
    assert len(shown) > 5000
    assert [text for text in shown if VAGUE.search(text)] == []
    provisional = [text for text in shown if re.search(r"\bprovisional\b", text, re.IGNORECASE)]
    assert len(provisional) > 5
    assert [text for text in provisional if not re.search(r"\d%|a tenth|\(quick-answers\.md\)", text)] == []
