"""The commands for records, used by a flyer and by a script."""

import csv
import os
import subprocess
import sys
from pathlib import Path

import pytest

from fieldkit.cli.main import GROUPS, main
from fieldkit.ledger import Ledger
from fieldkit.settings import change_settings
from tests.commands import Run

CHECK_SHAPES = False

TABLE = """flight_id,rocket,config,motor,dry_mass_g,diameter_mm,apogee_m,tags,notes,log,Lot
1,Astra,A,F24-4W,322,66,281.3,,good,,B7
2,Astra,A,F24-4W,322,66,246.6,off_axis,,,
3,Astra,B,E35-5W,448,66,169.8,,,,
"""


@pytest.fixture(autouse=True)
def _narrow(run: Run, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("COLUMNS", "80")


@pytest.fixture
def table(tmp_path: Path) -> Path:
    path = tmp_path / "table.csv"
    path.write_text(TABLE, encoding="utf-8")
    return path


@pytest.fixture
def full(run: Run, table: Path) -> Run:
    """The same with the table imported."""
    run("import", table)
    return run


def test_record_commands_do_not_import_numpy(table: Path, tmp_path: Path) -> None:
    code = (
        "import sys; from fieldkit.cli.main import main\n"
        "ledger = ['--ledger', sys.argv[1]]\n"
        "main([*ledger, 'flights']); main([*ledger, 'tag', '1', 'mine']); main([*ledger, 'undo'])\n"
        "slow = {'numpy', 'scipy', 'alembic', 'fieldkit.motors', 'fieldkit.importing.reading'}\n"
        "print(*(slow & set(sys.modules)), file=sys.stderr)"
    )
    assert main(["--ledger", str(tmp_path / "l.db"), "import", str(table)]) == 0
    command = [sys.executable, "-c", code, str(tmp_path / "l.db")]
    done = subprocess.run(command, capture_output=True, text=True, check=True)
    assert done.stderr == "\n"
    assert "Undone: tag 1 mine" in done.stdout


def test_every_group_of_commands_is_listed(run: Run) -> None:
    text = run("--help").out
    assert len(GROUPS) >= 5
    commands = "import export add flights show edit tag untag remove undo redo history motors"
    assert all(f" {command} " in text for command in commands.split(" "))


def test_the_version_is_reported(run: Run) -> None:
    assert run("--version").out.startswith("fieldkit ")


def test_wrong_usage_exits_with_status_two(run: Run) -> None:
    run("flights", "--no-such-option", status=2)
    run("no-such-command", status=2)
    run("edit", "1", "apogee", status=2)
    run("import", status=2)


def test_import_counts_new_flights_and_duplicates(run: Run, table: Path) -> None:
    first = run("import", table, "--json").document
    files = first.pop("files")
    assert first == {"imported": 3, "duplicates": 0, "rejected": [], "joined": [], "flights": ["1", "2", "3"]}
    assert [one["format"] for one in files] == ["flight_table"]
    assert run("import", table, "--json").document["duplicates"] == 3
    assert run("import", table).out.splitlines()[0] == "Imported 0, 3 duplicates, 0 rejected"


def test_a_dry_run_changes_nothing(run: Run, table: Path) -> None:
    assert run("import", table, "--dry-run").out.startswith("Would import 3, ")
    assert run("flights", "--json").document == {"flights": []}


def test_rejected_rows_are_named_on_stderr_and_the_rest_is_imported(run: Run, table: Path) -> None:
    table.write_text(TABLE.replace("281.3", "28l.3").replace("E35-5W", "ZZ99"), encoding="utf-8")
    outcome = run("import", table, "--json")
    assert outcome.document["imported"] == 1
    bad = {row["column"]: row for row in outcome.document["rejected"]}
    assert (bad["apogee_m"]["row"], bad["motor"]["row"]) == (2, 4)
    first, second = outcome.err.splitlines()
    assert first.startswith(f"{table}, row 2, apogee_m: found")
    assert "ZZ99" in second


def test_values_that_a_file_lacks_can_be_set(run: Run, table: Path) -> None:
    settings = ["--set", "wind=4mph", "--set", "config=Z", "--set", "notes=calm"]
    run("import", table, *settings)
    first, second, _ = run("flights", "--json").document["flights"]
    assert (first["config"], first["notes"], second["notes"]) == ("A", "good", "calm")
    assert abs(second["wind_mps"] - 1.78816) < 1e-9
    run("import", table, "--set", "motor=ZZ99", status=1)
    run("import", table, "--set", "motor", status=2)


def test_a_file_name_that_is_not_unicode_is_accepted(run: Run, table: Path) -> None:
    try:
        unreadable = table.with_name(os.fsdecode(b"odd\xff.csv"))
        unreadable.write_text(TABLE, encoding="utf-8")
    except (UnicodeError, OSError):
        pytest.skip("this system has no such names")
    run("import", unreadable)
    assert "odd\ufffd.csv" in run("history", "--json").document["changes"][0]["what"]
    outcome = run("flights", "--rocket", os.fsdecode(b"\xff"), status=1)
    assert len(outcome.err.splitlines()) == 1


@pytest.mark.thorough
def test_a_terminal_that_lacks_a_character_still_gets_the_line(table: Path, tmp_path: Path) -> None:
    table.write_text(TABLE.replace("good", "Größe →"), encoding="utf-8")
    environment = {**os.environ, "FIELDKIT_LEDGER": str(tmp_path / "l.db"), "PYTHONIOENCODING": "ascii"}
    command = [sys.executable, "-m", "fieldkit.cli.main"]
    subprocess.run([*command, "import", table], env=environment, check=True, capture_output=True)
    shown = subprocess.run([*command, "show", "1"], env=environment, check=True, capture_output=True)
    assert b"Gr??e ?" in shown.stdout
    table = subprocess.run([*command, "export"], env=environment, check=True, capture_output=True)
    assert "Größe →" in table.stdout.decode("utf-8")


def test_a_changed_row_is_rejected_with_advice_to_edit(full: Run, table: Path) -> None:
    table.write_text(TABLE.replace("281.3", "290"), encoding="utf-8")
    outcome = full("import", table, "--json").document
    assert outcome["duplicates"] == 2
    (row,) = outcome["rejected"]
    assert row["row"] == 2
    assert "fieldkit edit" in row["error"]


def test_a_missing_or_unreadable_file_exits_with_status_one_and_the_others_are_imported(run: Run, table: Path) -> None:
    junk = table.with_name("junk.csv")
    junk.write_bytes(bytes(range(256)) * 64)
    for bad in (table.with_name("absent.csv"), junk):
        outcome = run("import", table, bad, status=1)
        assert bad.name in outcome.err
        assert len(outcome.err.splitlines()) == 1
    run("import", table, "--format", "nonsense", status=1)
    assert len(run("flights", "--json").document["flights"]) == 3


def test_several_files_are_imported_by_one_command(run: Run, table: Path) -> None:
    other = table.with_name("other.csv")
    other.write_text(TABLE.replace("Astra", "Comet"), encoding="utf-8")
    outcome = run("import", table, other, "--json").document
    assert outcome["imported"] == 6
    assert outcome["flights"][0] == "Astra/1"
    run("undo")
    assert run("flights", "--json").document == {"flights": []}


def test_a_log_named_by_a_table_is_kept_with_its_flight(run: Run, table: Path, tmp_path: Path) -> None:
    (tmp_path / "logs").mkdir()
    log = tmp_path / "logs" / "one.txt"
    log.write_bytes(b"0.0,1.0\n")
    table.write_text(TABLE.replace("good,,", "good,logs/one.txt,"), encoding="utf-8")
    outcome = run("import", table, "--json")
    assert outcome.document["imported"] == 3
    assert "row 2, log: stored but not read" in outcome.err
    with Ledger.open(tmp_path / "ledger.db") as ledger:
        assert ledger.log("1") == b"0.0,1.0\n"
        assert ledger.log("2") == table.read_bytes()


def test_a_log_fills_in_the_readouts_that_its_row_lacks(run: Run, table: Path, tmp_path: Path) -> None:
    one = "flight_id,rocket,motor,apogee_m,duration_s\n1,Astra,F24-4W,300,48.5\n"
    (tmp_path / "one.csv").write_text(one, encoding="utf-8")
    table.write_text(TABLE.replace("good,,", "good,one.csv,"), encoding="utf-8")
    run("import", table)
    outcome = run("show", "1", "--json").document
    assert (outcome["apogee_m"], outcome["duration_s"]) == (281.3, 48.5)


@pytest.mark.parametrize("path", ["logs/one.csv", "logs\\one.csv", ".\\logs\\one.csv"])
def test_a_table_from_another_operating_system_finds_its_logs(run: Run, table: Path, path: str) -> None:
    (table.parent / "logs").mkdir()
    one = "flight_id,rocket,motor,apogee_m,duration_s\n1,Astra,F24-4W,300,48.5\n"
    (table.parent / "logs" / "one.csv").write_text(one, encoding="utf-8")
    table.write_text(TABLE.replace("good,,", f"good,{path},"), encoding="utf-8")
    run("import", table)
    assert run("show", "1", "--json").document["duration_s"] == 48.5


def test_a_missing_log_does_not_stop_its_row(run: Run, table: Path) -> None:
    table.write_text(TABLE.replace("good,,", "good,gone.csv,"), encoding="utf-8")
    outcome = run("import", table)
    assert outcome.out.startswith("Imported 3")
    assert "row 2, log: found 'gone.csv', which cannot be read" in outcome.err


def test_flights_are_listed_within_eighty_columns(full: Run) -> None:
    full("edit", "1", "rocket=" + "A very long name of a rocket " * 4, "notes=x" * 50)
    lines = full("flights").out.splitlines()
    assert max(map(len, lines)) <= 80
    assert "281.3 m" in full("flights").out


def test_flights_can_be_chosen_by_rocket_and_tag(full: Run) -> None:
    full("edit", "3", "rocket=Comet")
    ids = [
        [f["flight_id"] for f in full("flights", *how, "--json").document["flights"]]
        for how in (("--rocket", "Comet"), ("--tag", "off_axis"), ("--rocket", "Comet", "--tag", "off_axis"))
    ]
    assert ids == [["3"], ["2"], []]
    assert "No matching flights" in full("flights", "--tag", "nonsense").err


def test_an_empty_ledger_reports_it(run: Run) -> None:
    outcome = run("flights")
    assert outcome.out == ""
    assert "No flights in" in outcome.err
    assert "No changes in" in run("history").err


def test_the_json_of_flights_has_the_columns_of_the_table(full: Run) -> None:
    first, *_ = full("flights", "--json").document["flights"]
    assert first["apogee_m"] == 281.3
    assert first["duration_s"] is None
    assert (first["notes"], first["Lot"]) == ("good", "B7")


def test_escape_sequences_from_a_file_do_not_reach_the_terminal(run: Run, table: Path) -> None:
    table.write_text(TABLE.replace("good", "\x1b[31m[bold]red[/bold]\u202e"), encoding="utf-8")
    run("import", table)
    run("edit", "2", "rocket=[red]x[/red]")
    for outcome in (run("show", "1"), run("flights"), run("history"), run("import", table)):
        assert "\x1b" not in outcome.out + outcome.err
        assert "\u202e" not in outcome.out + outcome.err
    assert "[bold]red[/bold]" in run("show", "1").out
    assert "[red]" in run("flights").out


def test_show_uses_only_the_chosen_units(full: Run) -> None:
    outcome = full("show", "1").out
    assert "Apogee    281.3 m\n" in outcome
    assert "322 g\n" in outcome
    change_settings({"units": "US"})
    outcome = full("show", "1").out
    assert "Apogee    922.9 ft\n" in outcome
    assert "11.36 oz\n" in outcome
    assert "Duration" not in outcome


def test_an_unknown_flight_is_reported_with_similar_ids(full: Run) -> None:
    for command in (["show", "11"], ["edit", "11", "apogee=3"], ["tag", "11", "a"], ["remove", "1", "11"]):
        outcome = full(*command, status=1)
        assert outcome.err == "no flight '11'; did you mean 1?\n"
    assert len(full("flights", "--json").document["flights"]) == 3


def test_two_rockets_with_one_flight_id_are_distinguished(full: Run, table: Path) -> None:
    table.write_text(TABLE.replace("Astra", "Comet"), encoding="utf-8")
    full("import", table)
    outcome = full("show", "2", status=1)
    assert outcome.err == "2 is ambiguous: Astra/2 or Comet/2\n"
    assert full("show", "Comet/2", "--json").document["rocket"] == "Comet"
    assert "Comet/2" in full("flights").out


def test_edit_accepts_units_in_the_name_or_with_the_value(full: Run) -> None:
    full("edit", "1", "apogee=923ft", "top_speed_mph=140", "tags=Weak launch; mine", "Lot=C1")
    outcome = full("show", "1", "--json").document
    assert abs(outcome["apogee_m"] - 281.3304) < 1e-9
    assert abs(outcome["top_speed_mps"] - 62.5856) < 1e-9
    assert (outcome["tags"], outcome["Lot"]) == ("weak_launch;mine", "C1")
    full("edit", "1", "apogee=", "Lot=", "date_time=2026-05-01 10:30")
    outcome = full("show", "1", "--json").document
    assert (outcome["apogee_m"], outcome["date_time"]) == (None, "2026-05-01T10:30:00")
    assert "Lot" not in outcome
    assert "unchanged" in full("edit", "1", "apogee=").out


def test_edit_accepts_the_options_of_add(full: Run) -> None:
    full("edit", "1", "2", "--dry-mass", "17.2oz", "--date", "2026-05-01 10:30", "notes=calm")
    for id in ("1", "2"):
        outcome = full("show", id, "--json").document
        assert (outcome["date_time"], outcome["notes"]) == ("2026-05-01T10:30:00", "calm")
        assert outcome["dry_mass_g"] == pytest.approx(487.6, abs=0.1)
    assert "note: dry mass 332 g, without F24-4W" in full("edit", "1", "--lift-off-mass", "395g").err
    full("edit", "1", "--notes", "")
    assert full("show", "1", "--json").document["notes"] == ""
    assert "found apogee twice" in full("edit", "1", "--apogee", "815ft", "apogee=3", status=2).err
    assert "expected COLUMN=VALUE" in full("edit", "1", status=2).err
    assert "--dry-mass" in full("add", "--help").out
    assert "--dry-mass" not in full("edit", "--help").out


def test_edit_notes_a_new_name_like_a_known_one(full: Run) -> None:
    assert full("edit", "1", "rocket=Astrra").err.startswith("note: no rocket 'Astrra'; did you mean Astra?\n")
    assert full("edit", "Astrra", "rocket=Astra").err == ""
    assert full("edit", "Astra", "rocket=Astrra").err == ""


def test_edit_accepts_the_mass_weighed_with_the_motor(full: Run) -> None:
    output = full("edit", "1", "lift_off_mass=395g")
    assert "note: dry mass 332 g, without F24-4W" in output.err
    assert full("show", "1", "--json").document["dry_mass_g"] == pytest.approx(332, abs=1)
    for wrong, why in (
        (("lift_off_mass=60g",), "expected more than the mass of 62.9 g of AeroTech F24W"),
        (("lift_off_mass=1", "dry_mass=2"), "one of them"),
    ):
        output = full("edit", "1", *wrong, status=1)
        assert why in output.err


@pytest.mark.parametrize(
    ("change", "found"),
    [
        ("apogee=high", "apogee: found 'high', expected a number, such as"),
        ("apogee=3kg", "found the unit 'kg', expected one of m, mm"),
        ("apogee=1e9", "apogee: found 1e+09 m, expected"),
        ("apogee=900000ft", "apogee: found 900000 ft, expected 0.3281 to 656168 ft, such as 700ft"),
        ("temperature=200F", "temperature: found 200 °F, expected -130 to 158 °F, such as"),
        ("apogge_m=3", "no column 'apogge_m'; did you mean apogee_m"),
        ("motor=ZZ99", "motor: no motor 'ZZ99'"),
        ("date_time=soon", "date: found 'soon', expected a date"),
        ("flight_id=2", "flight 2 of Astra is already in the ledger"),
        ("flight_id=", "found an empty id of a flight"),
    ],
)
def test_a_bad_change_is_refused_in_one_line(full: Run, change: str, found: str) -> None:
    outcome = full("edit", "1", "notes=other", change, status=1)
    assert found in outcome.err
    assert len(outcome.err.splitlines()) == 1
    assert full("show", "1", "--json").document["notes"] == "good"


def test_tags_are_added_and_removed(full: Run) -> None:
    undo = " `fieldkit undo` to undo.\n"
    tagged = "Flight 1 has the tags off_axis; mine, and is not used in forecasts."
    assert full("tag", "1", "Off-axis", "mine").out == tagged + undo
    assert full("tag", "1", "mine").out == "Flight 1 has the tags off_axis; mine\n"
    assert full("untag", "1", "off axis").out == "Flight 1 has the tag mine, and is used in forecasts again." + undo
    assert full("untag", "1", "mine").out == "Flight 1 has no tags." + undo
    outcome = full("untag", "1", "mine", status=1)
    assert outcome.err == "1 has no tag 'mine', it has none\n"


def test_every_change_can_be_undone_and_redone(full: Run) -> None:
    full("tag", "1", "mine")
    assert full("remove", "1", "2").out.startswith("Removed 2 flights.")
    assert full("undo").out == "Undone: remove 1, 2\n"
    assert full("undo").out == "Undone: tag 1 mine\n"
    assert full("redo").out == "Redone: tag 1 mine\n"
    full("undo")
    full("undo")
    outcome = full("undo", status=1)
    assert outcome.err == "nothing left to undo\n"
    changes = full("history", "--json").document["changes"]
    assert [change["command"] for change in changes][:3] == ["import", "tag", "remove"]
    assert len(full("history").out.splitlines()) == len(changes) + 1
    assert len(full("history", "--last", "2", "--json").document["changes"]) == 2


@pytest.mark.parametrize("name", ["out.csv", "out.json"])
def test_an_export_imports_into_the_same_ledger_as_duplicates(full: Run, tmp_path: Path, name: str) -> None:
    full("edit", "1", "temperature=71.3F", "apogee=923ft", 'notes=a, "b"; ü', "log=gone.csv", "wind=4.4mph")
    before = full("flights", "--json").out
    full("export", tmp_path / name)
    outcome = full("import", tmp_path / name, "--json").document
    assert (outcome["imported"], outcome["duplicates"], outcome["rejected"]) == (0, 3, [])
    full("remove", "1", "2", "3")
    assert full("import", tmp_path / name, "--json").document["imported"] == 3
    assert full("flights", "--json").out == before


def test_export_writes_to_standard_output_or_explains_why_it_cannot_write(full: Run, tmp_path: Path) -> None:
    rows = list(csv.DictReader(full("export").out.splitlines()))
    assert [row["flight_id"] for row in rows] == ["1", "2", "3"]
    documents = full("export", "--format", "json", "--rocket", "Astra").document
    assert len(documents["flights"]) == 3
    outcome = full("export", tmp_path / "absent" / "out.csv", status=1)
    assert "absent" in outcome.err


def test_export_of_an_unknown_rocket_is_refused_and_writes_nothing(full: Run, tmp_path: Path) -> None:
    file = tmp_path / "nope.csv"
    outcome = full("export", file, "--rocket", "Nope", status=1)
    assert outcome.err == "no rocket 'Nope', expected one of: Astra\n"
    assert not file.exists()


def test_motors_are_found_and_shown(run: Run) -> None:
    assert "F24W" in run("motors", "f24").out
    documents = run("motors", "F24", "--json").document["motors"]
    assert documents[0]["name"] == "F24"
    assert max(map(len, run("motors", "24mm").out.splitlines())) <= 80
    assert "more" in run("motors").err
    assert run("motors", "--about").out.startswith("motors: ")
    assert run("motors", "--about", "--json").document["motors"] > 500


def test_a_users_own_motor_can_be_added_and_flown(run: Run, tmp_path: Path, table: Path) -> None:
    own = tmp_path / "mine.eng"
    own.write_text("G999 24 70 4-7 0.019 0.0629 Mine\n0.014 36.1\n1.0 20\n2.13 0\n", encoding="utf-8")
    table.write_text(TABLE.replace("E35-5W", "G999"), encoding="utf-8")
    assert run("import", table, "--json").document["imported"] == 2
    run("motors", "--import", own)
    outcome = run("import", table, "--json").document
    assert (outcome["imported"], outcome["duplicates"]) == (1, 2)
    run("motors", "--import", tmp_path / "absent.eng", status=1)


def test_the_ledger_comes_from_the_environment_if_no_option_names_it(
    tmp_path: Path, table: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setenv("FIELDKIT_LEDGER", str(tmp_path / "mine.db"))
    assert main(["import", str(table)]) == 0
    assert (tmp_path / "mine.db").exists()
    monkeypatch.delenv("FIELDKIT_LEDGER")
    assert main(["import", str(table)]) == 0
    capsys.readouterr()


def test_a_plan_without_a_mass_is_one_clear_line(capsys: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    assert main(["--ledger", str(tmp_path / "empty.db"), "predict", "--motor", "F24-4W"]) == 1
    shown = capsys.readouterr()
    assert shown.out == ""
    assert shown.err == "the plan: no dry mass, expected the rocket's mass without its motor\n"


def test_of_many_rejected_rows_the_first_are_named_and_the_rest_counted(run: Run, tmp_path: Path) -> None:
    table = tmp_path / "bad.csv"
    rows = "".join(f"{number},Astra,F24-4W,300,x{number}\n" for number in range(150))
    table.write_text(f"flight_id,rocket,motor,dry_mass_g,apogee_m\n{rows}")
    outcome = run("import", table)
    lines = outcome.err.splitlines()
    assert sum("found 'x" in line for line in lines) == 100
    assert "50 more rejected rows; --json lists them all" in lines
    assert len(run("import", table, "--json").document["rejected"]) == 150
