"""If two programs change a file of fieldkit at the same time, no change is lost."""

import subprocess
import sys
import threading
import time
from pathlib import Path

import pytest

from fieldkit import file_lock
from fieldkit.errors import FieldkitError
from fieldkit.file_lock import changing
from fieldkit.importing.tables.mapping import remembered
from fieldkit.paths import LOCK_NAME, motor_folder
from fieldkit.services.kits import kits
from fieldkit.services.learn import keep_card, own_card
from fieldkit.settings import read_settings

CHECK_SHAPES = False
CHANGES = """
import sys
from fieldkit.importing.reading import ColumnChoice
from fieldkit.importing.tables.mapping import remember
from fieldkit.planning.kits import Kit
from fieldkit.services.kits import save_kit
from fieldkit.settings import change_settings
own = sys.argv[1]
print("ready", flush=True)
sys.stdin.readline()
for number in range(12):
    save_kit(Kit(f"{own}{number}", 0.1, 0.04, None))
    remember(ColumnChoice({"altitude": "#2"}, (own, str(number))))
    change_settings({"units": "US"} if own == "a" else {"target": 250.0})
"""
"""Changes to every kind of file, made by another program."""


@pytest.fixture(autouse=True)
def home(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.setenv("FIELDKIT_HOME", str(tmp_path))
    return tmp_path


def test_three_programs_that_change_every_file_at_once_lose_nothing() -> None:
    running = [
        subprocess.Popen([sys.executable, "-c", CHANGES, own], stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True)
        for own in "abc"
    ]
    for one in running:
        assert one.stdout is not None
        assert one.stdout.readline() == "ready\n"
    for one in running:
        assert one.stdin is not None
        one.stdin.write("go\n")
        one.stdin.flush()
    for one in running:
        one.communicate()
        assert one.returncode == 0
    wanted = {(own, str(number)) for own in "abc" for number in range(12)}
    assert {kit.name for kit in kits()} == {own + number for own, number in wanted}
    assert {choice.headers for choice in remembered()} == wanted
    assert (read_settings().units, read_settings().target) == ("US", 250.0)


def test_a_card_saved_by_another_program_in_the_meantime_is_kept() -> None:
    before = own_card()
    own = keep_card("theirs", before)
    with pytest.raises(FieldkitError, match="another program has saved a card"):
        keep_card("ours", before)
    assert own.read_text() == "theirs"
    assert keep_card("ours", own_card()).read_text() == "ours"


def test_a_lock_that_stays_held_is_reported_in_one_line(home: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(file_lock, "PATIENCE", 0.1)
    again = pytest.raises(FieldkitError, match=r"kits\.toml: another program")
    with changing(home / "kits.toml"), again, changing(home / "kits.toml"):
        pass


def test_the_next_program_waits_until_the_first_has_finished(home: Path) -> None:
    order: list[str] = []
    held = threading.Event()

    def first() -> None:
        with changing(home / "a"):
            held.set()
            time.sleep(0.05)
            order.append("first")

    thread = threading.Thread(target=first)
    thread.start()
    held.wait(5)
    with changing(home / "b"):
        order.append("second")
    thread.join()
    assert order == ["first", "second"]


def test_a_lock_ends_with_its_block_and_with_its_process(home: Path) -> None:
    killed = "import os, signal; from pathlib import Path; from fieldkit.file_lock import changing\n"
    killed += f"with changing(Path({str(home / 'a')!r})): os._exit(9)"
    assert subprocess.run([sys.executable, "-c", killed]).returncode == 9
    for _ in range(2):
        with changing(home / "a"):
            assert (home / LOCK_NAME).is_file()


def test_a_folder_that_cannot_be_created_is_reported_in_one_line(home: Path) -> None:
    (home / "file").write_text("")
    with pytest.raises(FieldkitError, match="cannot be written"), changing(home / "file" / "kits.toml"):
        pass


def test_a_loop_of_links_is_reported_in_one_line(home: Path) -> None:
    (home / "kits.toml").symlink_to(home / "kits.toml")
    with pytest.raises(FieldkitError, match="cannot be written"), changing(home / "kits.toml"):
        pass


@pytest.mark.skipif(not file_lock.NO_LINK, reason="links are followed here")
@pytest.mark.parametrize("target", ["elsewhere", LOCK_NAME])
def test_a_lock_that_is_a_link_is_refused_and_its_target_is_not_created(home: Path, target: str) -> None:
    (home / LOCK_NAME).symlink_to(home / target)
    with pytest.raises(FieldkitError, match="cannot be written"), changing(home / "kits.toml"):
        pass
    assert not (home / "elsewhere").exists()


def test_a_file_system_without_locks_is_written_without_one(home: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def none(number: int) -> None:
        raise OSError(95, "Operation not supported")

    monkeypatch.setattr(file_lock, "_locked", none)
    with changing(home / "kits.toml"), changing(home / "kits.toml"):
        pass


def test_the_lock_is_not_read_as_a_motor_file() -> None:
    with changing(motor_folder() / "motor_corrections.csv"):
        pass
    from fieldkit.motors.own import own_motors

    assert own_motors(motor_folder()) == ([], [])
