"""Faults that a ledger survives, and its errors after the others."""

import os
import sqlite3
import subprocess
import sys
import threading
import time
from collections.abc import Callable, Sequence
from contextlib import closing
from pathlib import Path

import pytest
from alembic.autogenerate import compare_metadata
from alembic.migration import MigrationContext
from sqlalchemy import create_engine, event, make_url

from fieldkit.cli.main import main
from fieldkit.errors import LedgerError
from fieldkit.flight import Flight
from fieldkit.importing.incoming import IncomingFlight, Original
from fieldkit.ledger import Ledger, backups, opening, schema, soundness, whereabouts
from fieldkit.ledger.first_rows import first_rows
from fieldkit.ledger.tables import metadata
from fieldkit.rocket import Configuration
from tests.new_ledgers import SYNCHRONOUS

FIRST = Flight(flight_id="1", rocket="Astra", apogee=281.3, tags=("mine",))

ADDS = """
import sys
from fieldkit.flight import Flight
from fieldkit.importing.incoming import IncomingFlight, Original
from fieldkit.ledger import Ledger
with Ledger.open(sys.argv[1]) as ledger:
    for number in range(100000):
        flight = Flight(flight_id=str(number), rocket="Astra", tags=("a", "b"))
        ledger.add([IncomingFlight(flight, Original.of(bytes(20000)))])
        print(number, flush=True)
"""


def test_a_killed_process_loses_at_most_the_command_in_flight(tmp_path: Path) -> None:
    moments = {tmp_path / "a.db": 0.0, tmp_path / "b.db": 0.013, tmp_path / "c.db": 0.041}
    command = [sys.executable, "-c", ADDS]
    running = {file: subprocess.Popen([*command, file], stdout=subprocess.PIPE, text=True) for file in moments}
    for file, moment in moments.items():
        adding = running[file]
        assert adding.stdout
        first = adding.stdout.readline()
        time.sleep(moment)
        adding.kill()
        finished = len((first + adding.communicate()[0]).splitlines())
        with Ledger.open(file) as ledger:
            kept = ledger.flights()
            assert len(kept) in (finished, finished + 1)
            assert [flight.flight_id for flight in kept] == [str(number) for number in range(len(kept))]
            assert all(flight.tags == ("a", "b") for flight in kept)
            assert len(ledger.history()) == len(kept)
            assert ledger.log("0") == bytes(20000)
            ledger.undo()
        with sqlite3.connect(file) as raw:
            assert raw.execute("PRAGMA integrity_check").fetchone() == ("ok",)
            assert raw.execute("PRAGMA foreign_key_check").fetchall() == []
        raw.close()


def test_a_finished_change_is_on_the_disk(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(opening, "SYNCHRONOUS_MODE", SYNCHRONOUS)
    extra = 3  # also the folder, which names the rollback journal
    with opening.connect(make_url(f"sqlite:///{tmp_path / 'ledger.db'}")).connect() as connection:
        assert connection.exec_driver_sql("PRAGMA synchronous").scalar() == extra


def test_two_simultaneous_writers_both_succeed(tmp_path: Path) -> None:
    file = tmp_path / "ledger.db"

    def add(rocket: str) -> None:
        with Ledger.open(file) as ledger:
            for number in range(15):
                ledger.add([Flight(flight_id=str(number), rocket=rocket)])

    writers = [threading.Thread(target=add, args=[name]) for name in ("Astra", "Comet", "Drake")]
    for writer in writers:
        writer.start()
    for writer in writers:
        writer.join()
    with Ledger.open(file) as ledger:
        assert len(ledger.flights()) == 45
        assert [change.number for change in ledger.history()] == list(range(1, 46))


def test_a_failure_in_the_middle_of_a_command_changes_nothing(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    with Ledger.open(tmp_path / "ledger.db") as ledger:
        ledger.add([FIRST])
        monkeypatch.setattr("fieldkit.ledger.journal._enter", lambda *_, **__: 1 / 0)
        for change in (lambda: ledger.add([FIRST.with_changes(flight_id="2")]), lambda: ledger.remove("1")):
            with pytest.raises(ZeroDivisionError):
                change()
        assert ledger.flights() == [FIRST]


def test_a_file_that_is_not_a_ledger_is_reported_as_such(tmp_path: Path) -> None:
    junk = tmp_path / "junk.db"
    junk.write_bytes(bytes(range(256)) * 64)
    with pytest.raises(LedgerError, match=r"junk\.db: this file is not a ledger"):
        Ledger.open(junk)
    assert junk.read_bytes() == bytes(range(256)) * 64


def test_another_programs_database_is_left_alone(tmp_path: Path) -> None:
    file = tmp_path / "other.db"
    with sqlite3.connect(file) as raw:
        raw.execute("CREATE TABLE songs (name TEXT)")
    raw.close()
    with pytest.raises(LedgerError, match="found another program's tables"):
        Ledger.open(file)


def test_a_ledger_of_a_newer_program_is_not_touched(tmp_path: Path) -> None:
    file = tmp_path / "ledger.db"
    Ledger.open(file).close()
    with sqlite3.connect(file) as raw:
        raw.execute("UPDATE alembic_version SET version_num = 'm999_telepathy'")
    raw.close()
    with pytest.raises(LedgerError, match=r"made by a newer fieldkit \(m999_telepathy\)"):
        Ledger.open(file)


def test_an_unknown_version_is_damage(tmp_path: Path) -> None:
    file = tmp_path / "ledger.db"
    Ledger.open(file).close()
    with closing(sqlite3.connect(file)) as raw, raw:
        raw.execute("UPDATE alembic_version SET version_num = substr(version_num, 1, 8) || '}'")
    with pytest.raises(LedgerError, match=r"the file is damaged \(found the version m\d{3}_"):
        Ledger.open(file)


def test_a_version_that_is_not_text_means_another_programs_database(tmp_path: Path) -> None:
    file = tmp_path / "ledger.db"
    Ledger.open(file).close()
    with closing(sqlite3.connect(file)) as raw:
        raw.execute("UPDATE alembic_version SET version_num = ?", (b"m0\xff",))
        raw.commit()
    with pytest.raises(LedgerError, match="another program's tables"):
        Ledger.open(file)


def test_ids_of_many_slashes_stay_within_the_values_of_a_query(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    many = Flight(flight_id="/".join("1" * 200), rocket="Astra", apogee=100.0)
    with Ledger.open(tmp_path / "ledger.db") as ledger:
        event.listen(
            ledger._engine, "connect", lambda raw, _: raw.setlimit(sqlite3.SQLITE_LIMIT_VARIABLE_NUMBER, 32_766)
        )
        ledger._engine.dispose()
        ledger.add([many.with_changes(flight_id=f"{many.flight_id}{number}") for number in range(90)])
        assert len([one for page in ledger.pages() for one in page]) == 90
        assert ledger.flight(f"Astra/{many.flight_id}7").rocket == "Astra"
        with pytest.raises(LedgerError, match="no flight"):
            ledger.flight("/" * 40_000)


def test_the_damage_of_every_page_is_described_in_one_line(tmp_path: Path) -> None:
    file = tmp_path / "ledger.db"
    with Ledger.open(file) as ledger:
        ledger.add([FIRST])
    sound = file.read_bytes()
    for start in range(0, len(sound), 4096):
        file.write_bytes(sound[:start] + bytes(4096) + sound[start + 4096 :])
        found = soundness.file_fault(file)
        assert found
        assert "\n" not in found
        assert "***" not in found


def test_a_damaged_ledger_is_reported_as_damaged(tmp_path: Path) -> None:
    file = tmp_path / "ledger.db"
    with Ledger.open(file) as ledger:
        ledger.add([FIRST.with_changes(flight_id=str(n)) for n in range(200)])
    content = bytearray(file.read_bytes())
    content[4096:] = b"\x5a" * (len(content) - 4096)
    file.write_bytes(content)
    with pytest.raises(LedgerError, match="damaged"), Ledger.open(file) as ledger:
        ledger.flights()


@pytest.mark.parametrize(
    ("column", "value"),
    [("extra", "'null'"), ("extra", "'[1]'"), ("entered", "'{'"), ("rocket", "x'fe'"), ("apogee", "'high'")],
)
def test_a_row_that_no_fieldkit_wrote_is_damage_and_not_a_crash(column: str, value: str, tmp_path: Path) -> None:
    file = tmp_path / "ledger.db"
    with Ledger.open(file) as ledger:
        ledger.add([FIRST])
        ledger.tag(FIRST.flight_id, "mine")
    with closing(sqlite3.connect(file)) as raw, raw:
        raw.execute(f"UPDATE flights SET {column} = {value}")
    with Ledger.open(file) as ledger:
        for ask in (ledger.flights, lambda: ledger.flight(FIRST.flight_id)):
            with pytest.raises(LedgerError, match=r"the file is damaged.*`fieldkit backups restore`"):
                ask()


CHANGES = (
    "UPDATE flights SET notes = 'Qual flaght 2'",
    "UPDATE flights SET apogee = 46.475",
    "UPDATE flights SET humidity = 0.0",
    """UPDATE flights SET extra = '{"Weather": "gray"}'""",
    "UPDATE flights SET checksum = NULL",
    "UPDATE tags SET tag = 'mind'",
    "DELETE FROM tags",
    "UPDATE journal SET images = replace(images, '281.3', '281.7')",
    "UPDATE versions SET payload = replace(payload, 'wind', 'wand')",
    "UPDATE active_versions SET number = 1",
    "UPDATE predictions SET payload = replace(payload, '250.0', '250.5')",
    "UPDATE configurations SET dry_mass = 0.35",
    "UPDATE drafts SET content = replace(content, '923ft', '933ft')",
    "PRAGMA foreign_keys = OFF; DELETE FROM logs",
)


@pytest.mark.sampled
@pytest.mark.parametrize("change", CHANGES)
def test_a_row_that_differs_from_what_was_written_is_damage(change: str, tmp_path: Path) -> None:
    file = tmp_path / "ledger.db"
    with Ledger.open(file) as ledger:
        ledger.add(
            [
                IncomingFlight(
                    FIRST.with_changes(notes="Qual flight 2", extra={"Weather": "grey"}), Original.of(b"a log")
                )
            ]
        )
        for effect in ("wind", "wear"):
            ledger.keep_version("Astra", {"effect": effect})
        ledger.keep_prediction({"apogee_m": 250.0}, digest="d", rocket="Astra")
        ledger.keep_design(Configuration("Astra", "A", 0.3))
        ledger.keep_draft("add", {"apogee": "923ft"})
    asked = (
        lambda ledger: ledger.flight("1"),
        lambda ledger: ledger.log("1"),
        lambda ledger: ledger.versions("Astra"),
        lambda ledger: ledger.predictions(),
        lambda ledger: ledger.rocket("Astra").configurations,
        lambda ledger: ledger.draft("add"),
        lambda ledger: ledger.before([FIRST]),
    )
    assert failures(file, asked) == []
    with closing(sqlite3.connect(file)) as raw:
        raw.executescript(change)
    messages = failures(file, asked)
    assert messages
    assert all("the file is damaged" in one and "backup" in one for one in messages)


def failures(file: Path, asked: Sequence[Callable[[Ledger], object]]) -> list[str]:
    """The error of a ledger that cannot be read."""
    messages = []
    with Ledger.open(file) as ledger:
        for ask in asked:
            try:
                ask(ledger)
            except LedgerError as error:
                messages.append(str(error))
    return messages


def test_sound_changes_can_be_undone_and_damaged_ones_cannot(tmp_path: Path) -> None:
    file = tmp_path / "ledger.db"
    with Ledger.open(file) as ledger:
        ledger.add([FIRST])
        ledger.edit("1", apogee=290.0)
        ledger.remove("1")
        ledger.undo()
        ledger.undo()
        assert ledger.flights() == [FIRST]
        ledger.redo()
    for table, column in (("flights", "notes"), ("journal", "what")):
        with closing(sqlite3.connect(file)) as raw, raw:
            raw.execute(f"UPDATE {table} SET {column} = 'else'")
        with Ledger.open(file) as ledger, pytest.raises(LedgerError, match="the file is damaged"):
            ledger.undo()


def test_a_missing_column_and_a_wrong_index_are_damage(tmp_path: Path) -> None:
    file, other = tmp_path / "ledger.db", tmp_path / "other.db"
    for one in (file, other):
        with Ledger.open(one) as ledger:
            ledger.add([FIRST])
    with closing(sqlite3.connect(file)) as raw, raw:
        raw.execute("ALTER TABLE flights RENAME COLUMN notes TO nodes")
    with Ledger.open(file) as ledger, pytest.raises(LedgerError, match=r"damaged.*column notes of flights"):
        ledger.flights()
    content = other.read_bytes()
    assert content.count(b"Astra1") >= 2  # the row, and an index of rocket and flight_id
    other.write_bytes(content[: content.rindex(b"Astra1")] + b"Astra2" + content[content.rindex(b"Astra1") + 6 :])
    with Ledger.open(other) as ledger, pytest.raises(LedgerError, match=r"damaged.*missing from index"):
        ledger.flight("1")


def test_a_schema_that_is_no_longer_text_is_damage(tmp_path: Path) -> None:
    file = tmp_path / "ledger.db"
    with Ledger.open(file) as ledger:
        ledger.add([FIRST])
    file.write_bytes(file.read_bytes().replace(b"rail_length", b"rail_leng\xffh"))
    with Ledger.open(file) as ledger, pytest.raises(LedgerError, match="the file is damaged"):
        ledger.flights()


def test_an_empty_prediction_is_damage(tmp_path: Path) -> None:
    file = tmp_path / "ledger.db"
    with Ledger.open(file) as ledger:
        ledger.keep_prediction({"apogee_m": 250.0}, digest="d", rocket="Astra")
        ledger.keep_version("Astra", {"effects": []})
    with closing(sqlite3.connect(file)) as raw, raw:
        raw.execute("UPDATE predictions SET payload = 'null'")
        raw.execute("UPDATE versions SET payload = '7'")
    with Ledger.open(file) as ledger:
        for ask in (ledger.predictions, lambda: ledger.versions("Astra")):
            with pytest.raises(LedgerError, match="the file is damaged"):
                ask()


def test_a_read_only_ledger_can_be_read_and_the_refused_change_is_explained(tmp_path: Path) -> None:
    file = tmp_path / "ledger.db"
    with Ledger.open(file) as ledger:
        ledger.add([FIRST])
    with Ledger.open(f"sqlite:///file:{file}?mode=ro&uri=true") as ledger:
        assert ledger.flights() == [FIRST]
        with pytest.raises(LedgerError, match="read-only"):
            ledger.undo()


def test_a_full_disk_changes_nothing_and_reports_it(tmp_path: Path) -> None:
    with Ledger.open(tmp_path / "ledger.db") as ledger:
        ledger.add([FIRST])
        event.listen(ledger._engine, "begin", lambda conn: conn.exec_driver_sql("PRAGMA max_page_count = 1"))
        with pytest.raises(LedgerError, match="disk is full"):
            ledger.add([IncomingFlight(FIRST.with_changes(flight_id="2"), Original.of(os.urandom(100_000)))])
        assert ledger.flights() == [FIRST]


def test_a_lock_that_is_never_released_is_reported(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    file = tmp_path / "ledger.db"
    Ledger.open(file).close()
    other = sqlite3.connect(file, isolation_level=None)
    other.execute("BEGIN IMMEDIATE")
    monkeypatch.setattr(opening, "PATIENCE", 0.05)
    with Ledger.open(file) as ledger, pytest.raises(LedgerError, match="another program"):
        ledger.add([FIRST])
    other.close()


def test_a_missing_folder_is_named(tmp_path: Path) -> None:
    with pytest.raises(LedgerError, match=r"absent.*cannot open the file"):
        Ledger.open(tmp_path / "absent" / "ledger.db")
    with pytest.raises(LedgerError, match="found a folder or a device, expected a file"):
        Ledger.open(tmp_path)


@pytest.mark.parametrize(
    ("url", "found"),
    [
        ("mysql://host/db", "found a ledger on mysql, expected sqlite or postgresql"),
        ("://", "expected a path or a URL"),
        ("sqlite+telepathy:///x.db", "telepathy"),
        ("sqlite://", "would store nothing"),
        (":memory:", "would store nothing"),
        ("sqlite:///:memory:", "would store nothing"),
        ("sqlite:///file:x?mode=memory&uri=true", "would store nothing"),
        ("sqlite:///file::memory:?uri=true", "would store nothing"),
        ("sqlite:///file:?uri=true", "would store nothing"),
        ("sqlite:///file:/x.db?vfs=memdb&uri=true", "nothing after it"),
        ("sqlite:///file:x.db%3Fmode=memory?uri=true", "nothing after it"),
        ("sqlite:///x.db?mode=ro", "nothing after it"),
    ],
)
def test_an_impossible_url_is_refused(url: str, found: str) -> None:
    with pytest.raises(LedgerError, match=found):
        Ledger.open(url)


@pytest.mark.parametrize("name", ["", "  "])
def test_an_empty_ledger_name_is_not_the_default_ledger(
    name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """For example from an unset variable of a script."""
    monkeypatch.setenv("FIELDKIT_LEDGER", str(tmp_path / "usual.db"))
    with pytest.raises(LedgerError, match="expected a path or a URL"):
        Ledger.open(name)
    assert list(tmp_path.iterdir()) == []


@pytest.mark.skipif(not Path("/dev/null").exists(), reason="a device of Unix")
def test_a_folder_or_a_device_is_not_a_ledger(tmp_path: Path) -> None:
    for place in (tmp_path, "/dev/null"):
        with pytest.raises(LedgerError, match="found a folder or a device, expected a file"):
            Ledger.open(place)


def test_a_server_that_does_not_answer_is_named_without_its_password() -> None:
    with pytest.raises(LedgerError, match=r"127\.0\.0\.1") as error:
        Ledger.open("postgresql://me:secret@127.0.0.1:1/db?connect_timeout=1")
    assert "secret" not in str(error.value)
    assert "\n" not in str(error.value)


def test_a_password_stays_out_of_messages() -> None:
    url = whereabouts.location("postgresql://me:secret@host/db")
    assert url.drivername == "postgresql+psycopg"
    assert "secret" not in whereabouts.name_of(url)


def test_the_environment_can_name_the_ledger(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("FIELDKIT_LEDGER", str(tmp_path / "mine.db"))
    with Ledger.open() as ledger:
        assert ledger.name == str(tmp_path / "mine.db")
    monkeypatch.delenv("FIELDKIT_LEDGER")
    monkeypatch.setenv("FIELDKIT_HOME", str(tmp_path / "data"))
    assert whereabouts.location(None).database == str(tmp_path / "data" / "ledger.db")


def test_opening_a_current_ledger_does_not_import_alembic(tmp_path: Path) -> None:
    Ledger.open(tmp_path / "ledger.db").close()
    code = (
        "import sys; from fieldkit.rocket import Configuration; from fieldkit.ledger import Ledger\n"
        f"with Ledger.open({str(tmp_path / 'ledger.db')!r}) as ledger: ledger.flights()\n"
        "print([name for name in ('alembic', 'sqlalchemy.orm', 'torch', 'scipy') if name in sys.modules])"
    )
    assert subprocess.check_output([sys.executable, "-c", code], text=True) == "[]\n"


def test_the_migrations_make_the_tables_that_the_code_expects(tmp_path: Path) -> None:
    Ledger.open(tmp_path / "ledger.db").close()
    engine = create_engine(f"sqlite:///{tmp_path / 'ledger.db'}")
    with engine.connect() as connection:
        context = MigrationContext.configure(connection, opts={"compare_type": True})
        assert compare_metadata(context, metadata) == []
    engine.dispose()


@pytest.mark.parametrize("step", schema.STEPS)
def test_every_old_schema_is_upgraded_and_keeps_its_flights(step: str, tmp_path: Path) -> None:
    made = Path(__file__).parent / "old_ledgers" / f"{step}.sql"
    file = tmp_path / "ledger.db"
    with closing(sqlite3.connect(file)) as raw:
        raw.executescript(made.read_text(encoding="utf-8"))
    Ledger.open(file).close()
    assert len(backups.backups(file)) == (step != schema.STEPS[-1]), "an older one is copied before"
    with Ledger.open(file) as ledger:
        assert [flight.flight_id for flight in ledger.flights()] == ["1", "2"]
        assert ledger.flight("2").tags == ("weak_launch",)
        assert ledger.flight("1").extra == {"Weather": "grey"}
        assert ledger.flight("1").apogee == 281.3
        assert ledger.log("1") == b"a log"
        assert ledger.active_version("Astra").payload == {"effect": "wind"}
        assert ledger.predictions()[0].digest == "d1"
        assert [one.dry_mass for one in ledger.rocket("Skylark").configurations] == ([0.4] if step >= "m002" else [])
        assert ledger.keep_design(Configuration("Lark", "", 0.3))
        while ledger.history()[0].undone is False:
            ledger.undo()
        assert ledger.flights() == []


MEASURED = {
    "apogee": 1.0,
    "top_speed": 4.2,
    "burn_time": 0.13,
    "peak_accel": 1.9 * 9.80665,
    "avg_accel": 0.73 * 9.80665,
    "coast_to_apogee": 0.094,
    "apogee_to_eject": 0.12,
    "eject_altitude": 1.0,
    "descent_speed": 0.27,
}
"""Standard deviations in the extra columns of a flight measured in a log. [SI]"""


@pytest.fixture
def measured(tmp_path: Path) -> Path:
    """A ledger before standard deviations had columns: a log and two rows of a table, one of which was edited."""
    made = Path(__file__).parent / "old_ledgers" / "measured" / "m004_checksums.sql"
    with closing(sqlite3.connect(tmp_path / "old.db")) as raw:
        raw.executescript(made.read_text(encoding="utf-8"))
    return tmp_path / "old.db"


def test_measurements_move_out_of_the_extra_columns_and_can_still_be_undone(measured: Path) -> None:
    with Ledger.open(measured) as ledger:
        (id,) = [flight.flight_id for flight in ledger.flights("Lark")]
        edited, entered = ledger.flight(id), ledger.entered(id)
        assert entered is not None
        assert entered.sd == MEASURED
        assert (edited.apogee, edited.sd) == (100.0, {n: sd for n, sd in MEASURED.items() if n != "apogee"})
        assert not any("_sd_" in name for name in edited.extra if name != "time_to_apogee_sd_s")
        assert ledger.flight("7").sd == {"coast_to_apogee": 0.25}
        assert ledger.flight("7").extra == {"apogee_sd_m": "about 2", "Crew": "Bob"}, "no number: it stays a text"
        assert ledger.flight("8").extra == {"apogee_sd_m": "3"}, "beside no readout it is of nothing"
        for _ in range(4):
            ledger.undo()
        assert ledger.flight(id).sd == MEASURED
        assert ledger.flight(id).apogee == 162.765
        assert ledger.flight("7").extra["Crew"] == "Ann"
        for _ in range(2):
            ledger.undo()
        assert ledger.flights() == []
        for _ in range(6):
            ledger.redo()
        assert ledger.flight(id) == edited
        assert soundness.fault(measured) == ""


def test_a_row_that_was_damaged_before_an_upgrade_is_found_after_it(measured: Path) -> None:
    with closing(sqlite3.connect(measured)) as raw:
        raw.execute("UPDATE flights SET apogee = 101 WHERE rocket = 'Lark'")
        raw.commit()
    with pytest.raises(LedgerError, match="does not match its checksum"), Ledger.open(measured) as ledger:
        ledger.flights()


def test_a_ledger_deleted_while_open_is_reported_and_not_created_again(tmp_path: Path) -> None:
    file = tmp_path / "ledger.db"
    with Ledger.open(file) as ledger:
        ledger.add([Flight(flight_id="1", rocket="Astra", apogee=100.0)])
        file.unlink()
        with pytest.raises(LedgerError, match=r"the file (is gone while it is open|was moved, removed or replaced)"):
            ledger.add([Flight(flight_id="2", rocket="Astra", apogee=100.0)])
        assert not file.exists()
        ledger.close()  # which closes the connections to the removed file
        with pytest.raises(LedgerError, match="the file is gone while it is open"):
            ledger.flights()
    assert not file.exists()


@pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="pipes and links of Unix")
@pytest.mark.parametrize("command", ["flights", "tag 1 a", "undo", "backups"])
def test_a_path_that_sqlite_must_not_open_is_refused_at_once(
    command: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    good = tmp_path / "good.db"
    with Ledger.open(good) as ledger:
        ledger.add([FIRST])
    content = good.read_bytes()
    loop, piped, linked, journal = (tmp_path / name for name in ("loop.db", "piped.db", "linked.db", "link.db"))
    loop.symlink_to(loop)
    for file in (piped, journal, tmp_path / os.fsdecode(b"bad\xff.db")):
        file.write_bytes(content)
    os.mkfifo(tmp_path / "piped.db-journal")
    linked.symlink_to(piped)
    (tmp_path / "link.db-wal").symlink_to(good)
    for file, found in (
        (loop, "a loop of links"),
        ("/", "found a folder, expected a file"),
        (piped, "piped.db-journal"),
        (linked, "piped.db-journal"),
        (f"sqlite:///file:{piped}?uri=true", "piped.db-journal"),
        (journal, "found a link named link.db-wal"),
        (tmp_path / os.fsdecode(b"bad\xff.db"), "not UTF-8"),
    ):
        assert main(["--ledger", str(file), *command.split()]) == 1
        message = capsys.readouterr().err
        assert found in message
        assert message.count("\n") == 1
        assert first_rows(file, 5) == []
    assert good.read_bytes() == content


@pytest.mark.parametrize(
    ("statement", "found"),
    [
        ("CREATE TRIGGER t AFTER INSERT ON tags BEGIN DELETE FROM flights; END", "found the trigger t in it"),
        ("CREATE VIEW v AS SELECT randomblob(1000000000)", "found the view v in it"),
        ("CREATE VIRTUAL TABLE f USING fts5(a)", "found the virtual table f in it"),
        ("ALTER TABLE flights ADD COLUMN g AS (abs(apogee)) VIRTUAL", "found the computed column g in it"),
        ("ALTER TABLE tags ADD COLUMN g AS (abs(entry)) VIRTUAL", "found the computed column g in it"),
        ("CREATE INDEX i ON flights(abs(apogee))", "found the index of an expression i in it"),
        ("INSERT INTO alembic_version VALUES ('m001_flights')", "found two versions of its tables"),
    ],
)
def test_a_ledger_of_foreign_make_is_refused(statement: str, found: str, tmp_path: Path) -> None:
    file = tmp_path / "ledger.db"
    with Ledger.open(file) as ledger:
        ledger.add([FIRST])
        with ledger._reading() as connection:
            assert connection.exec_driver_sql("PRAGMA trusted_schema").scalar() == 0
    with closing(sqlite3.connect(file)) as raw:
        raw.execute(statement)
        raw.commit()
    with pytest.raises(LedgerError, match=found):
        Ledger.open(file)


@pytest.mark.parametrize("column", ["rocket", "flight_id", "config", "motor", "site", "site_elevation"])
@pytest.mark.parametrize("value", ["x'ff'", "x'41'"])
def test_a_name_that_is_no_text_is_a_line_of_every_command(
    column: str, value: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    file = tmp_path / "ledger.db"
    with Ledger.open(file) as ledger:
        ledger.add([FIRST])
    with closing(sqlite3.connect(file)) as raw:
        raw.execute(f"UPDATE flights SET {column} = {value}")
        raw.commit()
    plan = ["--rocket", FIRST.rocket, "--motor", "F24-4W", "--quick"]
    listed = [["sites"]] if column.startswith("site") else []
    shown = [["flights"], ["show", "1"], ["show", "x"], ["loop", *plan[:2], "--quick"], ["predict", *plan]]
    for command in shown + listed:
        assert main(["--ledger", str(file), *command]) == 1
        message = capsys.readouterr().err
        assert "the file is damaged" in message or "no flight" in message
        assert message.count("\n") == 1


def test_backups_that_do_not_exist_are_named_as_such(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    file = tmp_path / "ledger.db"
    Ledger.open(file).close()
    assert main(["--ledger", str(file), "backups", "restore", "--yes"]) == 1
    assert "has no backups yet" in capsys.readouterr().err


def test_a_commit_that_waits_in_vain_for_a_reader_leaves_nothing_locked(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """As while another process reads a long ledger: the change is refused, the next one and other processes work."""
    monkeypatch.setattr(opening, "PATIENCE", 0.05)
    file = tmp_path / "ledger.db"
    with Ledger.open(file) as ledger, Ledger.open(file) as other:
        ledger.add([FIRST])
        with ledger._reading() as connection:
            connection.exec_driver_sql("SELECT * FROM flights").fetchone()
            with pytest.raises(LedgerError, match="another program has locked it"):
                other.add([FIRST.with_changes(flight_id="2", apogee=212.0)])
            assert len(other.flights()) == len(ledger.flights()) == 1
        other.add([FIRST.with_changes(flight_id="3", apogee=213.0)])
        assert [one.flight_id for one in ledger.flights()] == [FIRST.flight_id, "3"]
