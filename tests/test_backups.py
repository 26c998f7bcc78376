"""The copies that are kept of a ledger, and what a damaged one says: found, offered, put back."""

import sqlite3
from collections.abc import Callable
from contextlib import closing
from pathlib import Path

import pytest

from fieldkit.cli.main import main
from fieldkit.errors import LedgerError
from fieldkit.flight import Flight
from fieldkit.ledger import Ledger, backups


def add(file: Path, *ids: str) -> None:
    """A flight after the other, each a change of its own."""
    with Ledger.open(file) as ledger:
        for id in ids:
            ledger.add([Flight(flight_id=id, rocket="Astra", apogee=100.0)])


def flown(file: Path) -> list[str]:
    with Ledger.open(file) as ledger:
        return [flight.flight_id for flight in ledger.flights()]


@pytest.fixture
def file(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Where a ledger may be that is copied before every change."""
    monkeypatch.setattr(backups, "EVERY", 1)
    return tmp_path / "ledger.db"


def test_the_last_ten_copies_are_kept_each_a_sound_ledger(file: Path) -> None:
    add(file, *map(str, range(14)))
    kept = backups.backups(file)
    assert [one.flights for one in kept] == [13, 12, 11, 10, 9, 8, 7, 6, 5, 4]
    assert not any(backups.fault(one.file) for one in kept)
    assert len(list(backups.folder_of(file).iterdir())) == 10, "and nothing half-made beside them"


def test_one_copy_a_day_is_enough_until_many_changes(tmp_path: Path) -> None:
    add(tmp_path / "ledger.db", *map(str, range(8)))
    assert [one.flights for one in backups.backups(tmp_path / "ledger.db")] == [1]


def test_a_restore_can_be_taken_back_by_another(file: Path) -> None:
    add(file, "1", "2", "3")
    assert main(["--ledger", str(file), "backups", "restore", "1", "--yes"]) == 0
    assert flown(file) == ["1"]
    assert main(["--ledger", str(file), "backups", "restore", "--yes"]) == 0
    assert flown(file) == ["1", "2", "3"]


def cut(content: bytes) -> bytes:
    return content[: len(content) // 2]


def without_tables(_: bytes) -> bytes:
    """What SQLite itself finds nothing wrong with."""
    with closing(sqlite3.connect(":memory:")) as empty:
        empty.execute("CREATE TABLE alembic_version (version_num TEXT)")
        empty.execute("INSERT INTO alembic_version VALUES ('m004_checksums')")
        empty.commit()
        return empty.serialize()


DAMAGES = [cut, without_tables, lambda _: b"", lambda content: content[:100], lambda c: c[:100] + bytes(len(c) - 100)]


@pytest.mark.parametrize("damage", DAMAGES, ids=["cut", "no tables", "empty", "a header", "zeros"])
def test_a_damaged_ledger_is_named_offered_its_copy_and_put_back(
    damage: Callable[[bytes], bytes], file: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    add(file, "1", "2", "3")
    hurt = damage(file.read_bytes())
    file.write_bytes(hurt)
    assert main(["--ledger", str(file), "flights"]) == 1
    (said,) = capsys.readouterr().err.splitlines()
    assert str(file) in said
    assert "`fieldkit backups restore`" in said
    assert file.read_bytes() == hurt, "a damaged file is evidence"
    assert main(["--ledger", str(file), "backups", "restore", "--yes"]) == 0
    assert flown(file) == ["1", "2"]
    aside = list(file.parent.glob("ledger.db.damaged-*"))
    assert [one.read_bytes() for one in aside] == ([hurt] if hurt else [])


def test_a_text_that_is_none_any_more_is_damage_that_sqlite_does_not_see(
    file: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    add(file, "1", "2")
    file.write_bytes(file.read_bytes().replace(b"Astra", b"A\xf3tra"))
    assert main(["--ledger", str(file), "flights"]) == 1
    (said,) = capsys.readouterr().err.splitlines()
    assert "the file is damaged (Could not decode" in said
    assert "`fieldkit backups restore`" in said
    assert main(["--ledger", str(file), "backups", "restore", "--yes"]) == 0
    assert flown(file) == ["1"]
    assert b"A\xf3tra" in backups.backups(file)[0].file.read_bytes(), "what was there is kept"


def test_a_damaged_ledger_pushes_no_good_copy_out(file: Path) -> None:
    add(file, "1", "2")
    content = bytearray(file.read_bytes())
    content[-4096:] = b"\x5a" * 4096
    kept = backups.backups(file)
    file.write_bytes(content)
    with closing(sqlite3.connect(file)) as ledger, pytest.raises(LedgerError, match="damaged"):
        backups.take(ledger, file, 9)
    assert backups.backups(file) == kept


def test_a_folder_without_room_for_copies_is_a_warning_and_no_refusal(
    file: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    add(file, "1")
    backups.folder_of(file).write_text("in the way")
    assert main(["--ledger", str(file), "add", "--rocket", "Astra", "--apogee", "100m"]) == 0
    assert "warning: no backup could be made" in capsys.readouterr().err
    assert len(flown(file)) == 2
