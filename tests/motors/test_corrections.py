"""Corrections of the catalog: each figure with its document, open questions unchanged, the rule for tests."""

import importlib.util
import json
from pathlib import Path
from types import ModuleType
from typing import Any

import pytest

from fieldkit.cli.main import main
from fieldkit.errors import BadValue
from fieldkit.motors import PLUGGED_DELAY, Motor, catalogue, describe
from fieldkit.motors.corrections import CONFIDENCES, Correction, read_corrections
from fieldkit.planning.classification import build_of, why_high_power
from fieldkit.planning.rules import rule_sets

TOOLS = Path(__file__).parents[2] / "tools"


def _tool(name: str) -> ModuleType:
    spec = importlib.util.spec_from_file_location(f"tool_{name}", TOOLS / f"{name}.py")
    assert spec
    assert spec.loader
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def _motor(text: str) -> Motor:
    return catalogue().find(text).motor


@pytest.mark.parametrize(
    ("name", "impulse", "nominal"),
    [("Estes A3", 2.22, 2.5), ("Estes A8", 2.32, 2.5), ("Estes B4", 4.29, 5.0)],
)
def test_a_tested_impulse_scales_the_curve_and_not_the_nominal_one(name: str, impulse: float, nominal: float) -> None:
    """Source: static tests by NAR as the curve files of ThrustCurve.org keep them."""
    motor = _motor(name)
    assert motor.total_impulse == impulse
    (found,) = [one for one in motor.corrections if one.field == "total_impulse_ns"]
    assert (float(found.was), float(found.value), found.confidence) == (nominal, impulse, "sure")
    assert "static-test" in found.source or "NAR" in found.source


@pytest.mark.parametrize(
    ("name", "impulse"),
    [("Estes B6", 4.33), ("Estes C6", 8.82), ("Estes C11", 8.8), ("Estes D12", 16.84), ("Estes F15", 49.61)],
)
def test_motors_whose_tests_agree_are_left_alone(name: str, impulse: float) -> None:
    assert _motor(name).total_impulse == impulse
    assert not [one for one in _motor(name).corrections if one.field == "total_impulse_ns"]


FIGURES: dict[str, dict[str, float]] = {
    "Estes B4": {"loaded_mass": 0.0189},
    "H283ST": {"propellant_mass": 0.097, "loaded_mass": 0.247},
    "25E75-17A": {"propellant_mass": 0.0104, "loaded_mass": 0.052},
    "J234-BG": {"length": 0.922},
    "K62N": {"length": 0.37425},
    "273H225-14A": {"loaded_mass": 0.293},
    "N2700W": {"total_impulse": 10322.0, "certified_average": 2716.9, "certified_peak": 4624.6, "loaded_mass": 9.0582},
    "F52C": {"certified_peak": 74.6, "total_impulse": 66.2},
    "H13ST": {"certified_peak": 50.4, "total_impulse": 211.2},
    "K1100T": {"certified_peak": 1245.0},
    "56F31-12A": {"propellant_mass": 0.032, "loaded_mass": 0.102},
    "41F36-11A": {"propellant_mass": 0.035, "loaded_mass": 0.104},
    "6026M1670-P": {"propellant_mass": 3.101, "loaded_mass": 5.231},
    "RATT J160": {"propellant_mass": 0.3279, "loaded_mass": 0.544},
    "G80T AeroTech": {"certified_average": 77.99},
    "I110-LW": {"propellant_mass": 0.289, "loaded_mass": 0.588},
    "I175WS": {"propellant_mass": 0.168},
    "543I297-15A": {"length": 0.367},
    "2014K1200-16A": {"length": 0.488},
    "338I180-14A": {"length": 0.245},
}
"""Source: letters, makers' sheets and lists as `motor_corrections.csv` names them."""


@pytest.mark.parametrize(("name", "figures"), FIGURES.items())
def test_errors_of_the_catalog_are_fixed(name: str, figures: dict[str, float]) -> None:
    motor = _motor(name)
    for field, value in figures.items():
        assert getattr(motor, field) == pytest.approx(value, rel=1e-6), field
    assert not motor.estimated
    assert motor.corrections
    assert all(one.source for one in motor.corrections)


def test_known_delays_are_recorded() -> None:
    assert _motor("Estes B4").delays == (2.0, 4.0, 6.0)
    assert _motor("I110-LW").delays == (5.0, 8.0, 10.0)
    assert _motor("J234-BG").delays == _motor("Hypertek 835CC172J-J317").delays == (PLUGGED_DELAY,)
    for name in ("H238T", "H148R", "H165R", "H242T"):
        assert _motor(name).delays == (6.0, 8.0, 10.0, 12.0, 14.0)


def test_figures_on_which_documents_disagree_are_reported_and_not_changed() -> None:
    motor = _motor("J99N")
    assert motor.total_impulse == 945.2
    assert motor.loaded_mass == pytest.approx(0.899)
    unapplied = [one for one in motor.corrections if not one.applied]
    assert {"total_impulse_ns", "loaded_g"} <= {one.field for one in unapplied}
    assert "945.2; 935.24 N s in another document (open" in unapplied[0].text()
    assert _motor("Quest B6W").loaded_mass == pytest.approx(0.0193)
    for name in ("I316-SF", "AeroTech J1799N", "J275W", "AeroTech K250W", "L952W", "M6000ST"):
        assert [one.applied for one in _motor(name).corrections if one.field == "total_impulse_ns"] == [False]
    assert _motor("H123W AeroTech").delays == (4.0, 6.0, 8.0, 10.0)


@pytest.mark.parametrize(
    ("old", "new"),
    [
        ("G142T", "AeroTech G142"),
        ("H283ST", "AeroTech H283ST-15A"),
        ("AMW 1422K535-P", "AMW 1442K535-P"),
        ("M2700W-PS", "AeroTech N2700W-PS"),
        ("AeroTech M2700W", "AeroTech N2700W-PS"),
    ],
)
def test_a_changed_name_still_finds_its_motor(old: str, new: str) -> None:
    for search in (catalogue().find, catalogue().resolve):
        motor = search(old).motor
        assert f"{motor.maker} {motor.designation}" == new


@pytest.mark.parametrize(
    ("name", "why"),
    [
        ("AeroTech G80T", ""),  # certified 77.99 N, its curve averages more than 80 N
        ("PML G80T", ""),
        ("G72DM", "its certified average thrust of 80.8 N"),
        ("G75M-11", "its certified average thrust of 87.5 N"),
        ("HP-G75M", "the HP in its designation"),
        ("AeroTech G79W", ""),  # 79 is the number of its name; 108.6 N s in 1.42 s are 76.5 N
        ("AeroTech H238T", "more than 160 N s"),
        ("F115SN", "its certified average thrust of 114.2 N"),
        ("H128W", "more than 160 N s"),
        ("F24W", ""),
    ],
)
def test_the_certified_average_thrust_determines_what_is_high_power(name: str, why: str) -> None:
    """Source: TMT letters of 20 May 2019 and 29 April 2020, NAR sheet of November 2007."""
    found = why_high_power(build_of(catalogue().resolve(name).motor, 0.3), rule_sets())
    assert why in found if why else not found


def test_an_average_that_only_repeats_the_name_is_not_certified() -> None:
    motor = _motor("I284W")
    assert motor.certified_average is None
    assert motor.rated_thrust == motor.total_impulse / 1.94


def test_the_table_of_corrections_is_complete() -> None:
    known = {(motor.maker, one.was) for motor in catalogue().motors for one in motor.corrections}
    shipped = [one for motor in catalogue().motors for one in motor.corrections]
    written = read_corrections()
    assert known
    shipped = [one for one in shipped if one.field != "motor"]
    assert {one.confidence for ones in written.values() for one in ones} == set(CONFIDENCES)
    assert catalogue().about["corrections"] == {
        sure: sum(one.confidence == sure for ones in written.values() for one in ones) for sure in CONFIDENCES
    }
    assert set(shipped) <= {one for ones in written.values() for one in ones}


@pytest.mark.parametrize(
    ("name", "impulse", "peak", "burn"),
    [
        ("F115SN", 79.15, 146.7, 0.69),
        ("G73C", 128.64, 89.9, 1.85),
        ("J550ST", 732.0, 649.0, 1.31),
        ("N3120X-PS", 10329.0, 4084.0, 3.31),
    ],
)
def test_a_motor_added_from_a_letter_has_its_impulse_peak_and_burn_time(
    name: str, impulse: float, peak: float, burn: float
) -> None:
    """Source: TMT letters of 16 October 2025."""
    motor = _motor(name)
    assert motor.total_impulse == impulse
    assert motor.peak_thrust == pytest.approx(peak, rel=0.001)
    assert motor.burn_time == pytest.approx(burn, rel=0.02)
    assert motor.estimated == ("thrust curve", "diameter")
    assert motor.corrections[0].text().startswith("motor added (likely: TMT draft letter")


def test_figures_that_no_falling_curve_can_have_are_refused(tmp_path: Path) -> None:
    tool = _tool("motors")
    table = tmp_path / "additions.csv"
    header, first, *_ = tool.ADDITIONS.read_text(encoding="utf-8").splitlines()
    table.write_text(f"{header}\n{first.replace('146.7', '46.7')}\n", encoding="utf-8")
    with pytest.raises(BadValue, match=r"F115SN-12A: found a peak of 46.7 N"):
        tool.additions(table)


@pytest.mark.parametrize(
    ("row", "why"),
    [("Me,X1,colour,,red,sure,a letter", "colour"), ("Me,X1,loaded_g,1,2,certain,a letter", "sure, likely, open")],
)
def test_an_invalid_table_is_refused_with_the_row(tmp_path: Path, row: str, why: str) -> None:
    table = tmp_path / "corrections.csv"
    table.write_text(f"maker,designation,field,was,value,confidence,source\n{row}\n")
    with pytest.raises(BadValue, match=rf"corrections.csv, row 2: .*{why}"):
        read_corrections(table)


def test_a_correction_holds_only_for_the_figure_that_it_corrects() -> None:
    tool = _tool("motors")
    motor = {"manufacturerAbbrev": "Me", "designation": "E1", "totalWeightG": 50}
    right = Correction("loaded_g", "50", "60", "sure", "a letter")
    asked = Correction("loaded_g", "50", "70", "open", "another letter")
    (changed,) = tool.corrected([motor], {("Me", "E1"): [right, asked]})
    assert changed["totalWeightG"] == 60
    assert [one[3] for one in changed["corrections"]] == ["sure", "open"]
    for key, one in ((("Me", "E1"), Correction("loaded_g", "51", "60", "sure", "x")), (("Me", "E2"), right)):
        with pytest.raises(BadValue, match=r"E1, loaded_g: found 50|no motor Me E2"):
            tool.corrected([motor], {key: [one]})


def _test(impulse: float, note: str, peak: float = 10.0, name: str = "A8") -> dict[str, str]:
    return {
        "manufacturer": "Me",
        "designation": name,
        "tested_impulse_ns": str(impulse),
        "tested_peak_n": str(peak),
        "note": note,
    }


CERT, USER = "basis=curve; NAR; file class cert; 20 points", "basis=curve; file class user; 20 points"


def _replaced(total: float, *tests: dict[str, str], peak: float = 9.73) -> str | None:
    found: dict[str, Any] | None = _tool("tested_impulses").replacement(
        {"totImpulseNs": total, "maxThrustN": peak}, tests, 0.024
    )
    return found and found["tested_impulse_ns"]


def test_a_test_replaces_only_a_nominal_impulse_and_only_beyond_scatter() -> None:
    """The cases of Estes A8, B4 and B6, of AeroTech E6 and H268R, as their curve files have them."""
    assert _replaced(2.5, _test(2.15, CERT, 9.555), _test(2.32, CERT, 9.73)) == "2.32"
    assert _replaced(5, _test(4.29, USER)) == "4.29"
    assert _replaced(4.33, _test(3.5, CERT)) is None
    assert _replaced(40, _test(38.33, CERT)) is None
    assert _replaced(320, _test(309.5, CERT)) is None
    assert _replaced(2.5) is None
    letter = _test(2.4, "basis=letter; TMT letter")
    assert _replaced(2.5, _test(2.0, CERT), letter) is None
    assert _replaced(2.5, _test(2.49, USER), _test(2.2, CERT)) == "2.2"


def test_the_scatter_of_tests_is_that_among_tests_of_one_motor() -> None:
    tool = _tool("tested_impulses")
    tests = [
        _test(total * (1 + off), CERT, name=name) for name, total in (("A8", 2.0), ("B6", 4.0)) for off in (0, 0.04)
    ]
    assert tool.scatter([*tests, _test(9.0, USER)]) == pytest.approx(1.4826 * 0.0392 / 2**0.5, rel=0.01)


def test_a_search_prints_the_average_thrust_that_rules_refer_to(capsys: pytest.CaptureFixture[str]) -> None:
    """The G80T is certified with 77.99 N and its curve averages more than 80: the latter would read as high power."""
    assert main(["motors", "AeroTech G80T"]) == 0
    shown = capsys.readouterr().out
    assert "77.99" in shown
    assert f"{_motor('AeroTech G80T').average_thrust:.4g}" not in shown


def test_corrections_are_shown_with_their_motor(capsys: pytest.CaptureFixture[str]) -> None:
    assert json.dumps(describe(_motor("Estes B4")))
    assert main(["motors", "Estes B4", "--json"]) == 0
    (unapplied,) = json.loads(capsys.readouterr().out)["motors"][:1]
    assert unapplied["total_impulse_ns"] == 4.29
    assert {"field", "was", "value", "confidence", "source"} == set(unapplied["corrections"][0])
    assert main(["motors", "Estes B4"]) == 0
    assert "total impulse 4.29 N s instead of 5 (sure" in capsys.readouterr().err
