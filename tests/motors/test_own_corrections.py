"""The flyer's own corrections and lots, and the catalog compared with a table of tests."""

import json
from pathlib import Path

import pytest

from fieldkit.cli.main import main
from fieldkit.errors import BadValue
from fieldkit.motors import catalogue
from fieldkit.motors.catalogue import split_lot
from fieldkit.motors.comparison import compare_tests
from fieldkit.motors.motor import impulse
from fieldkit.motors.own import known_motors
from fieldkit.motors.own_corrections import FILE_NAME, HEADER, read_own_corrections

pytestmark = pytest.mark.fast
SHARED = Path(__file__).parents[3] / "shared"

ROWS = (
    "AeroTech,F24W,total_impulse_ns,47.3,45.0,sure,my stand,,\n"
    'AeroTech,F24W,delays,,"4,7,9",sure,the bag,,\n'
    "AeroTech,F24W,total_impulse_ns,,50.0,sure,my stand,0412,2025-03-01\n"
    "AeroTech,F39T,loaded_g,,70,open,a rumour,,\n"
)


def test_own_corrections_replace_the_catalogs_figures(tmp_path: Path) -> None:
    (tmp_path / FILE_NAME).write_text(HEADER + ROWS)
    motors, errors = known_motors(tmp_path)
    assert not errors
    found = motors.resolve("AeroTech F24W").motor
    assert found.total_impulse == 45.0
    assert impulse(found.time, found.thrust) == pytest.approx(45.0)
    assert found.delays == (4.0, 7.0, 9.0)
    assert "my stand" in found.corrections[-2].source
    assert motors.resolve("F39T").motor.loaded_mass == catalogue().resolve("F39T").motor.loaded_mass  # it is open
    assert len(motors) == len(catalogue())


def test_a_lot_has_its_own_figures_and_an_unknown_lot_is_reported(tmp_path: Path) -> None:
    (tmp_path / FILE_NAME).write_text(HEADER + ROWS)
    motors, _ = known_motors(tmp_path)
    lot = motors.resolve("F24-4W lot 0412")
    assert (lot.motor.total_impulse, lot.delay) == (50.0, 4.0)
    assert any("lot 0412 of 2025-03-01" in note for note in lot.notes)
    assert motors.resolve("F24-4W lot 0412").motor is lot.motor
    other = motors.resolve("F24-4W, lot 99")
    assert other.motor.total_impulse == 45.0
    assert any("no figures for lot 99" in note for note in other.notes)
    assert split_lot("Lots of F24") == ("Lots of F24", "")


@pytest.mark.parametrize("name", ["F24W lot 0412", "F24-4W (Lot: 0412)", "f24w batch 0412", "F24W lot no. 0412"])
def test_a_search_for_a_lot_shows_its_own_figures(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch, name: str
) -> None:
    monkeypatch.setenv("FIELDKIT_HOME", str(tmp_path))
    (tmp_path / "motors").mkdir()
    (tmp_path / "motors" / FILE_NAME).write_text(HEADER + ROWS)
    assert main(["motors", *name.split(), "--json"]) == 0
    (motor,) = json.loads(capsys.readouterr().out)["motors"]
    assert motor["total_impulse_ns"] == pytest.approx(50.0)
    assert main(["motors", "F24W", "lot", "99"]) == 0
    shown = capsys.readouterr()
    assert shown.out.count("AeroTech F24W") == 1
    assert "no figures for lot 99" in shown.err


def test_a_correction_of_an_unknown_motor_is_reported_with_its_row(tmp_path: Path) -> None:
    (tmp_path / FILE_NAME).write_text(HEADER + ROWS + "Aerotek,F24W,total_impulse_ns,,46,,my stand,,\n")
    _, (error,) = known_motors(tmp_path)
    assert str(error).startswith(f"{FILE_NAME}, row 6: ")


def test_a_lot_is_drilled_from_the_delay_on_its_bag(tmp_path: Path) -> None:
    (tmp_path / FILE_NAME).write_text(HEADER + "AeroTech,H128W,total_impulse_ns,,200,sure,own test,7,\n")
    motors, _ = known_motors(tmp_path)
    found = motors.resolve("AeroTech H128W-17A lot 7")
    assert found.motor.total_impulse == 200
    assert found.motor.delays == motors.resolve("AeroTech H128W-17A").motor.delays == (17.0,)
    assert motors.resolve("AeroTech H128W-17A lot 7").motor is found.motor


def test_a_correction_states_the_catalogs_figure_even_if_its_row_does_not(tmp_path: Path) -> None:
    fields = {"total_impulse_ns": "44", "loaded_g": "62", "burn_s": "1.9", "delays": '"4,7,9"', "length_mm": "71"}
    (tmp_path / FILE_NAME).write_text(
        HEADER + "".join(f"AeroTech,F24W,{field},,{fields[field]},,,L1,\n" for field in fields)
    )
    motors, errors = known_motors(tmp_path)
    assert not errors
    before = catalogue().resolve("F24W").motor
    lines = dict(
        zip(fields, (one.text() for one in motors.resolve("F24-4W lot L1").motor.corrections[-5:]), strict=True)
    )
    assert f"instead of {before.total_impulse:.4g}" in lines["total_impulse_ns"]
    assert f"instead of {before.loaded_mass * 1e3:.4g}" in lines["loaded_g"]
    assert not any("none" in line for line in lines.values())
    assert not any("instead" in one.text() for one in read_own_corrections(tmp_path)[0])


@pytest.mark.parametrize(
    ("row", "named"),
    [
        ("AeroTech,F24W,mass,,1,sure,x,,", "row 2, field"),
        ("AeroTech,F24W,loaded_g,,heavy,sure,x,,", "row 2, value"),
        *(
            (f'AeroTech,F24W,delays,,"{delays}",sure,x,,', "row 2, value")
            for delays in ("soon", "nan,4", "-5", "1e300", "")
        ),
        ("AeroTech,F24W,loaded_g,,1,sure,x,,", "more than its propellant"),
    ],
)
def test_an_invalid_row_is_named_and_does_not_stop_anything(tmp_path: Path, row: str, named: str) -> None:
    (tmp_path / FILE_NAME).write_text(HEADER + row + "\n")
    motors, errors = known_motors(tmp_path)
    assert named in str(errors[0])
    assert motors.resolve("F24W").motor.total_impulse == catalogue().resolve("F24W").motor.total_impulse


def test_a_row_that_cannot_be_used_does_not_affect_the_others(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    bad = (
        "AeroTech,F99X,loaded_g,,60,sure,x,,\n"
        "AeroTech,F24W,loaded_g,,60,certain,x,,\n"
        "AeroTech,F24W,loaded_g,,1,sure,x,,\n"
    )
    monkeypatch.setenv("FIELDKIT_HOME", str(tmp_path))
    folder = tmp_path / "motors"
    folder.mkdir()
    (folder / FILE_NAME).write_text(HEADER + bad + ROWS)
    motors, errors = known_motors(folder)
    assert motors.resolve("F24W").motor.total_impulse == 45.0
    assert motors.resolve("F24W lot 0412").motor.total_impulse == 50.0
    assert {str(error).split(":")[0] for error in errors} == {
        f"{FILE_NAME}, row 2",
        f"{FILE_NAME}, row 3, confidence",
        f"{FILE_NAME}, row 4",
    }
    assert main(["motors", "--corrections"]) == 0
    assert len(capsys.readouterr().err.splitlines()) == len(errors)


@pytest.mark.parametrize("separator", [";", "\t"])
def test_a_table_saved_by_a_spreadsheet_is_read(tmp_path: Path, separator: str) -> None:
    rows = [
        HEADER.strip().split(","),
        ["AeroTech", "F24W", "total_impulse_ns", "", "45,5", "sure", "my stand", "0412", "2025-03-01"],
        ["AeroTech", "F24W", "delays", "", "4,7,9", "sure", "the bag", "", ""],
    ]
    text = "\n".join(separator.join(row) for row in rows)
    (tmp_path / FILE_NAME).write_text(f"\ufeff{text}\n", encoding="utf-8")
    motors, errors = known_motors(tmp_path)
    assert not errors
    assert motors.resolve("F24W").motor.delays == (4.0, 7.0, 9.0)
    assert motors.resolve("F24W lot 0412").motor.total_impulse == pytest.approx(45.5)


def test_a_table_without_the_needed_columns_is_named(tmp_path: Path) -> None:
    (tmp_path / FILE_NAME).write_text("maker,motor,field,value\nAeroTech,F24W,loaded_g,60\n")
    _, (error,) = known_motors(tmp_path)
    assert "found no column designation" in str(error)


ENG = "Q77 24 70 5-7 0.02 0.06 Homemade\n 0.05 50\n 0.9 40\n 1.0 0\n;\n"


def test_a_motor_of_the_flyers_own_has_lots_too(tmp_path: Path) -> None:
    (tmp_path / "own.eng").write_text(ENG.replace("Q77", "F77"))
    (tmp_path / FILE_NAME).write_text(HEADER + "Homemade,F77,total_impulse_ns,,41,sure,my stand,2,\n")
    motors, errors = known_motors(tmp_path)
    assert not errors
    assert motors.resolve("F77 lot 2").motor.total_impulse == pytest.approx(41)
    assert motors.resolve("F77").motor.total_impulse != pytest.approx(41)


TESTS = (
    "manufacturer,designation,common_name,tested_impulse_ns,tested_average_n,propellant_g,source,note\n"
    "AeroTech,F24W,F24,60,,,a stand,basis=curve\n"
    "AeroTech,F24W,F24,52,,,a letter,basis=letter; nine motors\n"
    "AeroTech,F24W,F24,54,,,a letter,basis=letter\n"
    'AeroTech/Quest,"B6W-4,6",B6,4.865,,,a letter,basis=letter\n'
    "Nobody,X1,X1,1,,,,\n"
)


def test_letters_take_precedence_over_curves_and_unknown_motors_are_named() -> None:
    found = compare_tests(catalogue(), TESTS.encode(), "tests.csv")
    assert (found.rows, found.motors, found.unknown) == (5, 2, ("Nobody X1",))
    (one,) = found.differences
    assert (one.field, one.tested, one.basis) == ("total_impulse_ns", 53.0, "letter")
    assert one.ratio == pytest.approx(53.0 / one.listed - 1)


def test_a_certified_curve_takes_precedence_over_another() -> None:
    head = "manufacturer,designation,tested_impulse_ns,source,note\n"
    rows = "AeroTech,F24W,60,a user,basis=curve; file class user\nAeroTech,F24W,52,NAR,basis=curve; file class cert\n"
    (one,) = compare_tests(catalogue(), (head + rows).encode(), "tests.csv").differences
    assert (one.tested, one.source, one.basis) == (52.0, "NAR", "curve")


def test_masses_that_mean_something_else_are_not_compared() -> None:
    """Curve files of Cesaroni and of Redline motors state the mass lost, and notes call single masses doubtful."""
    head = "manufacturer,designation,propellant_g,loaded_g,note\n"
    rows = (
        "Cesaroni,25E75-17A,16,60,basis=curve\n"
        "AeroTech,H148R,147.8,,basis=curve\n"
        "AeroTech,F24W,25.3,80,basis=curve; loaded mass of the file doubtful\n"
        "Cesaroni,26E31-15A,16.9,,basis=letter\n"
    )
    found = compare_tests(catalogue(), (head + rows).encode(), "tests.csv").differences
    assert {(one.motor.designation, one.field) for one in found} == {
        ("25E75-17A", "loaded_g"),
        ("F24W", "propellant_g"),
        ("26E31-15A", "propellant_g"),
    }


def test_delays_that_the_catalog_lacks_are_listed() -> None:
    head = "manufacturer,designation,delays,note\n"
    rows = (
        'AeroTech,F24W,"4,7,9",basis=letter\n'  # 9 is missing
        "AeroTech,H283ST,15A,basis=letter\n"  # only the longest, to be drilled
        "AeroTech,F39T,soon,basis=letter\n"
    )
    (one,) = compare_tests(catalogue(), (head + rows).encode(), "tests.csv").delays
    assert (one.motor.designation, one.tested, one.json()["catalogue"]) == ("F24W", (4.0, 7.0, 9.0), "4, 7")


@pytest.mark.parametrize(("text", "named"), [("a,b\n1,2\n", "columns"), (TESTS.replace("60", "many"), "row 2")])
def test_a_table_that_is_not_a_table_of_tests_is_named(text: str, named: str) -> None:
    with pytest.raises(BadValue, match=named):
        compare_tests(catalogue(), text.encode(), "tests.csv")


def test_the_commands_compare_and_name_the_file_of_corrections(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("FIELDKIT_HOME", str(tmp_path / "home"))
    table = tmp_path / "tests.csv"
    table.write_text(TESTS)
    assert main(["motors", "--compare", str(table), "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["differences"][0]["motor"] == "F24W"
    assert main(["motors", "--corrections"]) == 0
    assert "named with the motor: F24-4W lot 0412" in " ".join(capsys.readouterr().out.split())
    assert main(["motors", "--corrections", "--json"]) == 0
    file = Path(json.loads(capsys.readouterr().out)["file"])
    file.write_text(file.read_text(encoding="utf-8") + ROWS, encoding="utf-8")
    assert main(["motors", "--corrections"]) == 0
    assert "lot 0412 of 2025-03-01" in capsys.readouterr().out


@pytest.mark.skipif(not (SHARED / "data" / "motor_tests.csv").exists(), reason="no table of tests here")
def test_certification_letters_agree_with_the_catalog() -> None:
    """Source: the certification letters of a table of tests; 10% is twice the scatter that a lot may have."""
    content = (SHARED / "data" / "motor_tests.csv").read_bytes()
    found = compare_tests(catalogue(), content, "motor_tests.csv")
    assert found.rows == 781
    assert len(found.unknown) < 20
    assert {one.motor.designation for one in found.delays} == {"H148R", "H165R", "H238T", "H242T"}  # sold longer now
    letters = [one for one in found.differences if one.basis == "letter" and one.field == "total_impulse_ns"]
    assert len(letters) <= 4
