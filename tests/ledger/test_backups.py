"""The backups of a ledger, and a damaged ledger: detected, reported, restored."""

import os
import re
import sqlite3
import stat
import zlib
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from contextlib import closing
from pathlib import Path
from typing import Any

import pytest

from fieldkit.cli.main import main
from fieldkit.errors import LedgerError
from fieldkit.flight import Flight
from fieldkit.importing.incoming import IncomingFlight, Original
from fieldkit.ledger import Ledger, backups, restoring, soundness
from fieldkit.ledger.schema import STEPS
from tests.commands import Run


def add(file: Path, *ids: str) -> None:
    """Flights added one by one, each as a separate change."""
    with Ledger.open(file) as ledger:
        for id in ids:
            ledger.add([Flight(flight_id=id, rocket="Astra", apogee=100.0)])


def flown(file: Path) -> list[str]:
    with Ledger.open(file) as ledger:
        return [flight.flight_id for flight in ledger.flights()]


@pytest.fixture
def file(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """The path of a ledger that is copied before every change."""
    monkeypatch.setattr(backups, "CHANGES_PER_BACKUP", 1)
    return tmp_path / "ledger.db"


def test_the_last_ten_backups_are_kept_and_each_is_a_sound_ledger(file: Path) -> None:
    add(file, *map(str, range(14)))
    kept = backups.backups(file)
    assert [one.flights for one in kept] == [13, 12, 11, 10, 9, 8, 7, 6, 5, 4]
    assert not any(soundness.fault(one.file) for one in kept)
    assert len(list(backups.folder_of(file).iterdir())) == 10, "and nothing half-made beside them"


def test_one_backup_a_day_is_made_until_there_are_many_changes(tmp_path: Path) -> None:
    add(tmp_path / "ledger.db", *map(str, range(8)))
    assert [one.flights for one in backups.backups(tmp_path / "ledger.db")] == [1]


def test_a_restore_can_be_reverted_by_another(file: Path, run: Run) -> None:
    add(file, "1", "2", "3")
    run("backups", "restore", "1", "--yes")
    assert flown(file) == ["1"]
    run("backups", "restore", "--yes")
    assert flown(file) == ["1", "2", "3"]


@pytest.mark.parametrize("hurt", [False, True])
def test_a_restore_from_which_a_page_was_not_read_changes_nothing(
    file: Path, hurt: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    """If a disk does not return a page, SQLite reads zeros without an error."""
    add(file, "1", "2", "3")
    first = next(one for one in backups.backups(file) if one.number == 1)
    content, size = first.file.read_bytes(), 4096
    twin = file.with_name("twin.db")
    real = soundness.opened
    monkeypatch.setattr(restoring, "opened", lambda asked: real(twin if asked == first.file else asked))
    if hurt:
        file.write_bytes(file.read_bytes()[:5000])
    before = file.read_bytes()
    for at in range(size, len(content), size):
        twin.write_bytes(content[:at] + bytes(size) + content[at + size :])
        with pytest.raises(LedgerError, match="nothing was changed"):
            restoring.restore(file, first)
        assert file.read_bytes() == before if hurt else flown(file) == ["1", "2", "3"]
    twin.write_bytes(content)
    restoring.restore(file, first)
    assert flown(file) == ["1"]


@pytest.mark.parametrize("times", [1, 2])
def test_a_restore_that_cannot_be_checked_is_reverted_and_reports_it(
    file: Path, times: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    """With `times` 2 it cannot be reverted either."""
    add(file, "1", "2", "3")
    first, real, calls = next(one for one in backups.backups(file) if one.number == 1), restoring.opened, []

    def full(ledger: sqlite3.Connection, target: Path) -> None:
        raise sqlite3.OperationalError("disk I/O error")

    def failing(asked: Path) -> Any:
        calls.append(asked)
        if asked == first.file:  # everything is kept: the next copy is the one for the check
            monkeypatch.setattr(restoring, "copy", full)
        elif times == 2 and first.file in calls:
            raise sqlite3.OperationalError("disk I/O error")
        return real(asked)

    monkeypatch.setattr(restoring, "opened", failing)
    expected = "disk I/O error.*nothing was changed" if times == 1 else "may be damaged; its former content is in .*000"
    with pytest.raises(LedgerError, match=expected):
        restoring.restore(file, first)
    monkeypatch.undo()
    assert flown(file) == (["1", "2", "3"] if times == 1 else ["1"])


def test_a_linked_ledger_is_restored_at_its_target_with_its_own_mode(file: Path) -> None:
    link = file.with_name("link.db")
    link.symlink_to(file)
    add(link, "1", "2", "3")
    for hurt in (False, True):
        file.chmod(0o640)
        if hurt:
            file.write_bytes(file.read_bytes()[:5000])
        assert main(["--ledger", str(link), "backups", "restore", "1", "--yes"]) == 0
        assert link.is_symlink()
        assert stat.S_IMODE(file.stat().st_mode) == 0o640
        assert flown(file) == flown(link) == ["1"]
    assert {stat.S_IMODE(one.file.stat().st_mode) for one in backups.backups(file)[:1]} == {0o640}
    assert not backups.folder_of(link).exists()


def test_a_restore_locks_the_ledger_from_copy_to_replacement(file: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    add(file, "1", "2")
    taken, refused = restoring.taken, []

    def meddled(*given: Any) -> Any:
        made = taken(*given)
        with closing(sqlite3.connect(file, timeout=0)) as other:
            try:
                other.execute("DELETE FROM flights")
                other.commit()
            except sqlite3.OperationalError as error:
                refused.append(error.sqlite_errorname)
        return made

    monkeypatch.setattr(restoring, "taken", meddled)
    restoring.restore(file, backups.backups(file)[-1])
    assert refused == ["SQLITE_BUSY"]


def test_a_writer_that_waits_during_a_restore_does_not_write_into_the_replaced_ledger(file: Path) -> None:
    add(file, "1", "2")
    with closing(sqlite3.connect(file)) as waiting:
        assert waiting.execute("SELECT count(*) FROM flights").fetchone() == (2,)
        with closing(sqlite3.connect(file)) as hurt:
            hurt.execute("UPDATE flights SET rocket = 'Asura' WHERE entry = 1")
            hurt.commit()
        aside = restoring.restore(file, backups.backups(file)[-1])
        assert aside is not None
        assert "damaged" in aside.name
        with pytest.raises(sqlite3.OperationalError, match="readonly"):
            waiting.execute("DELETE FROM flights")
    assert flown(file) == ["1"]


def test_simultaneous_backups_get_different_numbers(file: Path) -> None:
    add(file, "1", "2")

    def copied(_: int) -> int:
        with closing(sqlite3.connect(file)) as ledger:
            return backups.take(ledger, file, 2).number

    with ThreadPoolExecutor(8) as pool:
        numbers = list(pool.map(copied, range(8)))
    assert len(set(numbers)) == 8
    assert [one.number for one in backups.backups(file)][:8] == sorted(numbers, reverse=True)


def test_one_backup_is_made_if_many_begin_to_write(file: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    add(file, "1")
    backups.folder_of(file).mkdir()
    claim = backups._claim(file)[1]
    add(file, "2")
    assert backups.backups(file) == [], "another process is at it"
    os.utime(claim, (0, 0))
    add(file, "3")
    assert [one.flights for one in backups.backups(file)] == [2]
    assert not claim.exists(), "of a process that was killed"


CHANGES = (
    ("UPDATE flights SET rocket = 'Asura' WHERE entry = 1", "a row of 1 of Asura does not match its checksum"),
    ("UPDATE tags SET tag = 'mind' WHERE entry = 1", "a row of 1 of Astra does not match its checksum"),
    ("DELETE FROM tags WHERE entry = 1", "a row of 1 of Astra does not match its checksum"),
    ("INSERT INTO tags VALUES (1, 7, 'new')", "a row of 1 of Astra does not match its checksum"),
    ("UPDATE journal SET what = 'some' WHERE number = 1", "a row of 1 does not match its checksum"),
    ("UPDATE logs SET size = size - 1", "whose size differs"),
    (f"UPDATE logs SET content = x'{zlib.compress(b'a lag').hex()}'", "the bytes of the log .* do not match"),
    ("PRAGMA foreign_keys = OFF; DELETE FROM logs", "a row of flights refers to a missing row of logs"),
    ("ALTER TABLE flights RENAME COLUMN notes TO nodes", "column notes of flights is missing"),
)


@pytest.mark.sampled
@pytest.mark.parametrize(("change", "message"), CHANGES)
def test_damage_that_sqlite_does_not_detect_never_replaces_a_good_backup(
    change: str, message: str, tmp_path: Path
) -> None:
    file, copy = tmp_path / "ledger.db", tmp_path / "copy.db"
    with Ledger.open(file) as ledger:
        ledger.add(
            [IncomingFlight(Flight(flight_id="1", rocket="Astra", apogee=100.0, tags=("mine",)), Original.of(b"a log"))]
        )
        ledger.add([Flight(flight_id="2", rocket="Astra")])
    copy.write_bytes(file.read_bytes())
    with Ledger.open(file) as ledger:
        ledger.add([Flight(flight_id="3", rocket="Astra")])
    kept = backups.backups(file)
    assert soundness.fault(file) == soundness.fault(file, since=copy) == ""
    with closing(sqlite3.connect(file)) as raw:
        raw.executescript(change)
        assert soundness.file_fault(file) == ""
        for since in (None, copy, tmp_path / "none.db"):
            assert re.search(message, soundness.fault(file, since=since))
        with pytest.raises(LedgerError, match=rf"the file is damaged \(.*{message}.*`fieldkit backups restore`"):
            backups.take(raw, file, 9)
    assert backups.backups(file) == kept


def test_a_damaged_backup_neither_hides_nor_causes_damage(file: Path) -> None:
    add(file, "1", "2", "3")
    rotten = backups.backups(file)[0].file
    for rot in (bytes(100), bytes(4096), b"\xff" * 8192):
        rotten.write_bytes(rotten.read_bytes()[:4096] + rot + rotten.read_bytes()[4096 + len(rot) :])
        assert soundness.fault(file, since=rotten) == ""
    with closing(sqlite3.connect(file)) as raw, raw:
        raw.execute("UPDATE flights SET apogee = 101.0 WHERE entry = 1")
    assert "a row of 1 of Astra" in soundness.fault(file, since=rotten)


def test_a_row_that_changed_on_the_disk_stops_the_next_change_and_is_restored(file: Path, run: Run) -> None:
    add(file, "1", "2", "3")
    with closing(sqlite3.connect(file)) as raw, raw:
        raw.execute("UPDATE flights SET rocket = 'Asura' WHERE entry = 1")
    kept = backups.backups(file)
    with pytest.raises(LedgerError, match=r"damaged .*`fieldkit backups restore`"):
        add(file, "4")
    assert backups.backups(file) == kept
    assert "ledger.db.damaged-" in run("backups", "restore", "--yes").err
    assert flown(file) == ["1", "2"]
    with closing(sqlite3.connect(kept[0].file)) as raw, raw:
        raw.execute("UPDATE flights SET rocket = 'Asura' WHERE entry = 1")
    assert "this backup is damaged too (a row of 1 of Asura" in run("backups", "restore", "--yes", status=1).err


def cut(content: bytes) -> bytes:
    return content[: len(content) // 2]


def without_tables(_: bytes) -> bytes:
    """Damage that SQLite itself does not detect."""
    with closing(sqlite3.connect(":memory:")) as empty:
        empty.execute("CREATE TABLE alembic_version (version_num TEXT)")
        empty.execute("INSERT INTO alembic_version VALUES (?)", (STEPS[-1],))
        empty.commit()
        return empty.serialize()


DAMAGES = [cut, without_tables, lambda _: b"", lambda content: content[:100], lambda c: c[:100] + bytes(len(c) - 100)]


@pytest.mark.parametrize("damage", DAMAGES, ids=["cut", "no tables", "empty", "a header", "zeros"])
def test_a_damaged_ledger_is_reported_with_its_backup_and_restored(
    damage: Callable[[bytes], bytes], file: Path, run: Run
) -> None:
    add(file, "1", "2", "3")
    hurt = damage(file.read_bytes())
    file.write_bytes(hurt)
    (message,) = run("flights", status=1).err.splitlines()
    assert str(file) in message
    assert "`fieldkit backups restore`" in message
    assert file.read_bytes() == hurt, "a damaged file is evidence"
    run("backups", "restore", "--yes")
    assert flown(file) == ["1", "2"]
    aside = list(file.parent.glob("ledger.db.damaged-*"))
    assert [one.read_bytes() for one in aside] == ([hurt] if hurt else [])


def test_an_invalid_text_is_damage_that_sqlite_does_not_detect(file: Path, run: Run) -> None:
    add(file, "1", "2")
    file.write_bytes(file.read_bytes().replace(b"Astra", b"A\xf3tra"))
    (message,) = run("flights", status=1).err.splitlines()
    assert "the file is damaged (Could not decode" in message
    assert "`fieldkit backups restore`" in message
    run("backups", "restore", "--yes")
    assert flown(file) == ["1"]
    (aside,) = file.parent.glob("ledger.db.damaged-*")
    assert b"A\xf3tra" in aside.read_bytes(), "what was there is kept, and counts as no copy"


def test_a_damaged_ledger_displaces_no_good_backup(file: Path) -> None:
    add(file, "1", "2")
    content = bytearray(file.read_bytes())
    content[-4096:] = b"\x5a" * 4096
    kept = backups.backups(file)
    file.write_bytes(content)
    with closing(sqlite3.connect(file)) as ledger, pytest.raises(LedgerError, match="damaged"):
        backups.take(ledger, file, 9)
    assert backups.backups(file) == kept


def test_a_folder_without_space_for_backups_gives_a_warning_and_not_a_refusal(file: Path, run: Run) -> None:
    add(file, "1")
    backups.folder_of(file).write_text("in the way")
    assert "warning: no backup could be made" in run("add", "--rocket", "Astra", "--apogee", "100m").err
    assert len(flown(file)) == 2


def test_a_refused_change_is_one_line_even_if_no_backup_could_be_made(file: Path, run: Run) -> None:
    add(file, "1")
    backups.folder_of(file).write_text("in the way")
    assert run("remove", "no such flight", status=1).err.count("\n") == 1


def test_a_file_whose_name_is_not_a_time_is_not_a_backup(file: Path) -> None:
    add(file, "1", "2")
    known = backups.backups(file)
    (backups.folder_of(file) / "000009_20269999T999999Z_5.db").write_bytes(b"")
    assert backups.backups(file) == known
    add(file, "3")


def test_a_backup_that_another_process_deleted_is_not_created_by_looking_at_it(file: Path) -> None:
    add(file, "1", "2")
    first = backups.backups(file)[-1]
    first.file.unlink()
    assert (first.flights, first.size) == (None, 0)
    assert not first.file.exists()


def test_a_backup_that_cannot_be_deleted_does_not_prevent_a_restore(
    file: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    add(file, "1", "2", "3")
    monkeypatch.setattr(backups, "MAX_BACKUPS", 1)

    def refused(*_: object) -> None:
        raise PermissionError

    first = backups.backups(file)[-1]
    monkeypatch.setattr(Path, "unlink", refused)
    backups.rotate(file)
    monkeypatch.undo()
    assert first in backups.backups(file)


@pytest.mark.skipif(os.name == "nt", reason="Windows has no modes of groups")
def test_everyone_who_may_write_the_ledger_may_write_its_backups(tmp_path: Path) -> None:
    file = tmp_path / "shared.db"
    before = os.umask(0o077)
    try:
        Ledger.open(file).close()
        file.chmod(0o664)
        add(file, "1", "2")
    finally:
        os.umask(before)
    assert stat.S_IMODE(backups.folder_of(file).stat().st_mode) == 0o775
    assert {stat.S_IMODE(one.file.stat().st_mode) for one in backups.backups(file)} == {0o664}


def test_a_folder_of_backups_that_cannot_be_listed_gives_a_warning(file: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    add(file, "1")

    def refused(*_: object) -> None:
        raise PermissionError(13, "Permission denied")

    with Ledger.open(file) as ledger:
        monkeypatch.setattr(Path, "iterdir", refused)
        ledger.tag("1", "mine")
        assert ledger.trouble.startswith("no backup could be made")
        assert backups.offer(file).endswith("cannot be read (Permission denied)")
