"""The day sheet: a row for each plan, and every check that did not pass."""

import re
from dataclasses import replace
from pathlib import Path

import pytest

from fieldkit.cli.main import main
from fieldkit.errors import BadValue
from fieldkit.flight import Flight
from fieldkit.flight.site import Site
from fieldkit.motors import catalogue
from fieldkit.planning.forecasts import Plan, RocketData
from fieldkit.planning.limits import limits
from fieldkit.planning.planned_flight import PlannedFlight, planned_flight
from fieldkit.presentation.report.day_sheet import ROWS, day_sheet

CHECK_SHAPES = False
PLANS = (
    "flight_id,rocket,dry_mass_g,diameter_mm,motor,delay_s,wind_mps,main_altitude_m\n"
    "first,Alpha,40,25,C6-5,,,\n"
    "second,Big Red,1400,56.6,H242T-10,,2,150\n"
)
SITE = Site(name="Meadow", size=300.0, people=30.0)


@pytest.fixture(scope="module")
def planned() -> PlannedFlight:
    found = catalogue().resolve("C6-5")
    plan = Flight(flight_id="1", rocket="Alpha", motor="C6-5", dry_mass=0.04, diameter=0.025, wind=3.0, delay=5.0)
    return planned_flight(Plan(RocketData((), ()), plan, found), SITE, limits())


def text_of(content: bytes) -> str:
    """The text of a picture: letters in an SVG are shapes, with the text of each row in a comment."""
    return content.decode().replace("&gt;", ">")


def test_a_row_summarizes_a_plan_with_its_failed_checks_below(planned: PlannedFlight) -> None:
    sheet = text_of(day_sheet("Saturday", SITE, [planned], ".svg"))
    for text in ("Saturday", "Meadow, field 300 m, people 30 m, ceiling not given", "recommended rail", "C6-5"):
        assert text in sheet
    failed = [line for line in planned.lines if line.failed]
    assert failed
    for line in failed:
        assert f"{line.name}: {line.verdict}" in sheet
    american = text_of(day_sheet("Saturday", SITE, [planned], ".svg", "US"))
    assert "field 984 ft" in american
    assert "field 300 m" not in american


def test_the_columns_and_marks_are_explained(planned: PlannedFlight) -> None:
    sheet = text_of(day_sheet("Saturday", SITE, [planned], ".svg"))
    for words in ("charge: seconds after (+) or before (-) apogee", "⊘ unsafe, ! caution, ? not checked"):
        assert words in sheet


def test_checks_that_are_unknown_for_every_flight_are_listed_once(planned: PlannedFlight) -> None:
    alone = text_of(day_sheet("Saturday", SITE, [planned], ".svg"))
    assert alone.count("to be checked by you") == 1
    assert "every flight" not in alone
    other = replace(planned, lines=[line for line in planned.lines if line.name != "sky"])
    sheet = text_of(day_sheet("Saturday", SITE, [other, planned], ".svg"))
    assert sheet.count("to be checked by you") == 2
    assert "every flight  ? not checked, or to be checked by you: " in sheet
    assert re.search(r"<!-- {4}\? not checked, or to be checked by you: sky -->", sheet) is not None


def test_names_that_differ_at_their_ends_stay_different(planned: PlannedFlight) -> None:
    one = planned.prediction
    plans = [one.plan.with_changes(flight_id=f"qualification-{n}") for n in (11, 12)]
    several = [replace(planned, prediction=replace(one, plan=plan)) for plan in plans]
    sheet = text_of(day_sheet("Saturday", SITE, several, ".svg"))
    assert "<!-- qual…on-11 -->" in sheet
    assert "<!-- qual…on-12 -->" in sheet


def test_many_flights_take_several_pages_and_no_line_is_lost(planned: PlannedFlight) -> None:
    many = day_sheet("Saturday", SITE, [planned] * (ROWS + 1), ".pdf")
    assert many.startswith(b"%PDF")
    assert many.count(b"/Type /Page\n") + many.count(b"/Type /Page ") >= 2
    with pytest.raises(BadValue, match="at most 12 for a picture"):
        day_sheet("Saturday", SITE, [planned] * (ROWS + 1), ".png")


def test_the_command_reads_a_table_of_plans_and_conditions_of_the_day(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    table, out = tmp_path / "plans.csv", tmp_path / "day.svg"
    table.write_text(PLANS)
    ledger = ["--ledger", str(tmp_path / "a.db")]
    given = ["--flights", str(table), "--wind", "4", "--field-size", "300m", "--title", "Our day"]
    assert main([*ledger, "daysheet", *given, "--out", str(out)]) == 0
    assert "the day sheet of 2 flights" in capsys.readouterr().err
    sheet = text_of(out.read_bytes())
    assert "Our day" in sheet
    assert "wind 4.0 m/s at the pad" in sheet  # of the first; the second has its own
    assert "altimeter" in sheet
    assert main([*ledger, "daysheet", *given, "--out", str(tmp_path / "day.doc")]) == 1
    assert "day.doc" in capsys.readouterr().err


def test_a_table_of_plans_may_have_clusters_and_a_bad_motor_is_named(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    table, out = tmp_path / "plans.csv", tmp_path / "day.svg"
    header = "flight_id,rocket,dry_mass_g,diameter_mm,motor\n"
    ledger = ["--ledger", str(tmp_path / "a.db")]
    table.write_text(f"{header}1,Trio,200,50,3 x C6-5\n")
    assert main([*ledger, "daysheet", "--flights", str(table), "--wind", "3", "--out", str(out)]) == 0
    assert "failed ignitions are not modeled" in capsys.readouterr().err
    sheet = text_of(out.read_bytes())
    assert "3 x C6-5" in sheet
    assert "complex rocket: caution: 3 motors, forecast as if every one lights" in sheet
    table.write_text(f"{header}1,Trio,200,50,3 x ZZ9-5\n")
    assert main([*ledger, "daysheet", "--flights", str(table), "--out", str(out), "--force"]) == 1
    assert "row 2, motor" in capsys.readouterr().err


@pytest.mark.thorough
def test_the_charge_column_shows_what_opens_the_parachute(tmp_path: Path) -> None:
    """An unknown delay does not mean an altimeter, a charge that never fires has no number, and two devices imply an
    altimeter whatever the motor's delay."""
    table, out = tmp_path / "plans.csv", tmp_path / "day.svg"
    header = "flight_id,rocket,dry_mass_g,diameter_mm,motor,delay_s,main_altitude_m\n"
    charges = {
        "Alpha,400,66,F39T,,": "unknown",
        "Alpha,400,66,F39T,6,150": "altimeter",
        "Alpha,1400,66,H128W-P,,": "altimeter",
        "Alpha,400,66,F39T,60,": "none",
        "Alpha,900,66,C6-3,3,": "none",
        "Alpha,40,25,C6-0,0,": "none",
    }
    for plan, charge in charges.items():
        table.write_text(f"{header}one,{plan}\n")
        command = ["daysheet", "--flights", str(table), "--wind", "3", "--out", str(out), "--force"]
        assert main(["--ledger", str(tmp_path / "a.db"), *command]) == 0
        sheet = text_of(out.read_bytes())
        assert f"<!-- {charge} -->" in sheet, plan
        assert "nan" not in sheet.replace("nance", "")
        unsafe = {"F39T,60": "the rocket hits the ground", "C6-3": "thrust to weight", "C6-0": "ejection speed"}
        (no_rail,) = [why for motor, why in unsafe.items() if motor in plan] or [""]
        assert ("recommended rail: none" in sheet) == bool(no_rail), plan
        assert f"recommended rail{': none: ' if no_rail else ''}" in sheet
        assert no_rail in sheet


def test_a_calm_row_is_not_given_the_wind_of_the_day(tmp_path: Path) -> None:
    table, out = tmp_path / "plans.csv", tmp_path / "day.svg"
    header = "flight_id,rocket,dry_mass_g,diameter_mm,motor,wind_mps\n"
    table.write_text(f"{header}1,Calm,400,66,F39T-6,0\n2,Rest,400,66,F39T-6,\n")
    ledger = ["--ledger", str(tmp_path / "a.db")]
    assert main([*ledger, "daysheet", "--flights", str(table), "--wind", "6", "--out", str(out)]) == 0
    calm, windy = (int(one) for one in re.findall(r"(\d+) m away", text_of(out.read_bytes()))[:2])
    assert calm < windy / 3
