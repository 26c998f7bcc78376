"""Notes say by how much an apogee is off: the sizes that they state are those of the flights that they name."""

import re
from collections.abc import Callable
from pathlib import Path

import pytest

from fieldkit.motors.several import STAGES_NOTE
from fieldkit.openrocket.parts import PER_AREA, PER_MASS
from fieldkit.presentation.planning_text import BREEZE, IN_A_BREEZE
from tests.commands import Run

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
    found = re.search(r"by ([\d.]+) to ([\d.]+)%", note)
    assert found
    return [float(end) for end in found.groups()]


def test_a_wind_that_is_not_given_lowers_the_apogee_by_the_stated_part(apogee: Apogee) -> None:
    lost = [100 * (1 - apogee(*one, "--wind", f"{BREEZE}m/s") / apogee(*one)) for one in (FAST, SLOW, LIGHT)]
    assert [round(min(lost)), round(max(lost))] == ends(IN_A_BREEZE)


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
    assert (min(shown), max(shown)) == (2, 3)
    gains = [
        [round(100 * (now[1] / then[1] - 1), 1) for now, then in zip(air, usual, strict=True)] for air in (warm, high)
    ]
    assert [(min(gain), max(gain)) for gain in gains] == [(0.6, 1.4), (0.5, 1.2)]
    page = " ".join((Path(__file__).parents[1] / "docs" / "predictions.md").read_text(encoding="utf-8").split())
    assert "2 to 3% too high for what the altimeter shows, 0.6 to 1.4% too low for the true apogee" in page
    assert "too low, by 0.5 to 1.2%" in page
