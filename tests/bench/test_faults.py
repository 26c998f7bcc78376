"""Real kills, a few of each kind; `python -m bench.faults` runs more."""

import os
import random
import sqlite3
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator
from contextlib import closing
from pathlib import Path

import pytest

from fieldkit.errors import LedgerError
from fieldkit.flight import Flight
from fieldkit.ledger import Ledger, journal
from fieldkit.ledger.backups import backups

if not hasattr(os, "fork"):
    pytest.skip("the bench forks what it kills; Windows has no fork", allow_module_level=True)

from bench.faults import __main__ as bench
from bench.faults import (
    calls,
    clocks,
    damage,
    failing,
    histories,
    hostile,
    kills,
    laptops,
    ledgers,
    servers,
    session,
    statements,
    writers,
)

FIRST, SECOND = (Flight(flight_id=id, rocket="Astra", apogee=100.0) for id in "12")


@pytest.mark.parametrize(
    "name", [pytest.param("add", marks=pytest.mark.thorough), "migrate", pytest.param("undo", marks=pytest.mark.slow)]
)
def test_a_killed_command_leaves_the_ledger_as_before_or_as_after(
    name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(kills, "MEASURED", 1)
    case = next(case for case in kills.CASES if case.name == name)
    outcome = kills.kills(case, tmp_path / "kills", 3, seed=1)
    assert outcome.tried == 3
    assert outcome.faults == []


def test_the_bench_detects_a_half_written_change(tmp_path: Path) -> None:
    file = tmp_path / "ledger.db"
    states = []
    with Ledger.open(file) as ledger:
        for flight in (FIRST, SECOND):
            ledger.add([flight])
            states.append(ledgers.state(file))
    assert ledgers.after(file, states) == ("after", "")
    with closing(sqlite3.connect(file)) as raw:
        raw.execute("DELETE FROM journal WHERE number = 2")
        raw.commit()
    assert ledgers.after(file, states) == ("half", "neither as before nor as after the command")


def test_flipped_bits_are_detected_or_harmless(tmp_path: Path) -> None:
    assert damage.bits_flipped(tmp_path / "bits", 3, seed=1).faults == []
    assert damage.cut_short(tmp_path / "cut", 6, seed=1).faults == []


def test_acknowledged_changes_survive_concurrent_restores(tmp_path: Path) -> None:
    outcome = histories.restores_beside_writers(tmp_path / "ledger", writers=2, each=8, restores=3)
    assert outcome.tried >= 10
    assert outcome.faults == []


@pytest.mark.thorough
def test_a_clock_that_goes_back_and_other_zones_change_no_answer(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(clocks, "COMMANDS", (clocks.ADD, ("undo",), ("redo",), ("backups", "restore", "1", "--yes")))
    read_before = next(clocks.Backwards.passed)
    assert clocks.set_back(tmp_path / "back").faults == []
    assert next(clocks.Backwards.passed) > read_before + 4
    assert clocks.zones(tmp_path / "zones").faults == []


def test_processes_that_upgrade_a_ledger_at_once_all_answer(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(writers, "STEPS", (writers.STEPS[0], writers.STEPS[-1]))
    outcome = writers.concurrent_migrations(tmp_path, 3)
    assert outcome.faults == []
    assert outcome.tried == 3


@pytest.mark.thorough
def test_hostile_locks_and_modes_are_reported_or_harmless(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(hostile, "COMMANDS", (("tag", "1", "mine"), ("units", "US")))
    monkeypatch.setattr(hostile, "PLACES", hostile.PLACES[:1])
    monkeypatch.setattr(hostile, "MODES", (("data/ledger.db", 0o444), ("home", 0o555)))
    assert hostile.modes(tmp_path / "modes").faults == []
    assert hostile.objects(tmp_path / "objects").faults == []


@pytest.mark.thorough
def test_commands_beside_two_open_apps_lose_nothing(tmp_path: Path) -> None:
    assert writers.apps_and_commands(tmp_path, 1).faults == []


def test_every_command_of_the_tree_is_called_or_left_out_with_a_reason() -> None:
    called = {session.named(words) for words in (*session.lines(), *session.more())}
    assert set(session.commands()) == called | session.SEPARATE.keys() | session.LEFT_OUT.keys()
    assert not called & session.LEFT_OUT.keys()


def test_every_option_that_takes_a_file_is_called_unless_its_command_is_left_out() -> None:
    lines = [*session.lines(), *session.more()]
    uncalled = [
        (name, option)
        for name, option in session.files()
        if name not in {*session.LEFT_OUT, *session.SEPARATE}
        and not any(session.named(words) == name and option in words for words in lines)
    ]
    read = [("score", "--hyperprior"), ("motors", "--compare"), ("motors", "--in-stock")]
    assert uncalled == [*read, ("learn", "--high-power")]


@pytest.mark.slow
@pytest.mark.parametrize("name", session.SEPARATE)
def test_a_command_in_its_own_process_reports_the_truth(name: str, tmp_path: Path) -> None:
    outcome = failing.in_its_own_process(tmp_path, name, 1, 1)
    assert outcome.tried > 4
    assert outcome.faults == []


@pytest.mark.slow
def test_every_line_of_the_bench_succeeds_without_a_fault(tmp_path: Path) -> None:
    with ledgers.at_home(tmp_path / "home"):
        assert len(session.calls(tmp_path)) > 60


traced = pytest.mark.skipif(not calls.can_trace(), reason="there is no strace that may look at a process here")


@pytest.mark.thorough
@traced
def test_a_command_whose_calls_fail_reports_the_truth(tmp_path: Path) -> None:
    found = tmp_path / "found"
    found.mkdir()
    ledgers.season(found / "ledger.db")
    call = session.Call(("tag", "3", "mine"), found)
    outcome = failing.every_call(tmp_path / "trials", "tag", lambda: [call], 2)
    assert outcome.faults == []
    assert outcome.tried > 10
    assert {"refused in a line", "killed, before"} <= outcome.counts.keys()


@traced
def test_the_bench_detects_a_command_that_reports_falsely(tmp_path: Path) -> None:
    found = tmp_path / "found"
    found.mkdir()
    ledgers.season(found / "ledger.db")
    bench = failing.Bench(tmp_path / "trial", session.Call(("tag", "3", "mine"), found))
    bench.learn()
    done = calls.Ended(0, "", "", True)
    assert bench.judged(done) == ("finished anyway", "")
    assert bench.judged(calls.Ended(1, "", "x: nothing was changed", True))[1] == "it said that nothing was changed"
    bench.fresh()
    assert bench.judged(done)[1] == "it said that it was done"
    assert "traceback" in bench.judged(calls.Ended(calls.TRACEBACK, "", "Traceback: KeyError", True))[1]


@traced
def test_every_write_of_a_command_fails_in_turn(tmp_path: Path) -> None:
    found = tmp_path / "found"
    found.mkdir()
    ledgers.season(found / "ledger.db")
    bench = failing.Bench(tmp_path / "trial", session.Call(("export", "flights.csv"), found))
    bench.learn()
    assert bench.new == {"flights.csv"}
    seen = bench.from_first_write()
    assert [wrong for _, wrong in seen if wrong] == []
    assert {what for what, _ in seen} >= {"refused in a line", "killed, nothing to lose"}
    bench.fresh()
    assert "flights.csv" in bench.judged(calls.Ended(0, "", "", True))[1]
    assert bench.judged(calls.Ended(calls.HANGS, "", "", True))[1] == "it hangs"


@pytest.mark.thorough
@traced
def test_calls_of_the_backup_of_a_new_day_fail_too(tmp_path: Path) -> None:
    with ledgers.at_home(tmp_path / "home"):
        add, _ = session.new_day(tmp_path / "found")
    trial = failing.Bench(tmp_path / "trial", add)
    found = trial.learn()
    assert len(backups(trial.file)) == 2
    assert "rename" in {name for name, _ in found}  # of the backup, to its name
    rename = next(calls.Fault(*one, calls.EIO) for one in found if one[0] == "rename")
    assert trial.judged(trial.tried(rename)) == ("finished anyway", "")
    assert len(backups(trial.file)) == 1


@pytest.mark.thorough
@traced
def test_a_replay_contains_exactly_what_was_acknowledged_among_faults(tmp_path: Path) -> None:
    outcome = failing.history(tmp_path, 6, seed=3)
    assert outcome.faults == []
    assert outcome.tried == 6


@pytest.fixture(scope="module")
def server() -> Iterator[servers.Server]:
    """A PostgreSQL server that may be killed."""
    pytest.importorskip("psycopg", reason="needs the extra `postgres`")
    if not servers.binaries():
        pytest.skip("there is no PostgreSQL on this machine")
    memory = "/dev/shm" if Path("/dev/shm").is_dir() else None
    with tempfile.TemporaryDirectory(dir=memory) as scratch:
        Path(scratch).chmod(0o755)  # the server is another user
        with servers.server(Path(scratch) / "server") as ours:
            yield ours


@pytest.fixture
def url(server: servers.Server) -> str:
    """The URL of an empty ledger on that server."""
    servers.emptied(server.url)
    return server.url


def test_durations_are_in_seconds_below_two_minutes() -> None:
    assert [laptops.duration(seconds) for seconds in (7.6, 100, 360)] == ["8 s", "100 s", "6 min"]


@pytest.mark.thorough
@pytest.mark.postgres
def test_laptops_on_a_server_that_dies_lose_nothing_that_was_acknowledged(
    server: servers.Server, tmp_path: Path
) -> None:
    outcome = laptops.mixed_work(server, tmp_path / "laptops", 2, commands=20, kills=1, seed=5)
    assert outcome.faults == []
    assert outcome.counts["acknowledged"] > 5


@pytest.mark.thorough
@pytest.mark.postgres
def test_laptops_lose_nothing_when_a_standby_takes_over(server: servers.Server) -> None:
    folder = server.folder.with_name("laptops")
    outcome = laptops.failed_over(server, folder, 2, commands=20, seed=5)
    assert outcome.faults == []
    assert outcome.counts["acknowledged"] > 10


@pytest.mark.sampled
@pytest.mark.postgres
@pytest.mark.parametrize("of_the_server", [False, True])
def test_a_ledger_of_the_first_schema_on_a_server_that_dies_is_as_before(
    server: servers.Server, of_the_server: bool
) -> None:
    assert servers.crashes(server, "migrate", 1, seed=1, of_the_server=of_the_server).faults == []


@pytest.mark.postgres
@pytest.mark.parametrize("counts", [range(4, 5), pytest.param(range(1, 30), marks=pytest.mark.slow)])
def test_a_change_whose_server_process_is_killed_leaves_no_trace(url: str, counts: range) -> None:
    outcome = statements.process_killed(url, counts)
    assert outcome.faults == []
    assert outcome.tried >= len(statements.CHANGES)


@pytest.mark.postgres
def test_names_too_long_for_the_index_of_a_server_are_refused_in_a_line(url: str) -> None:
    name = random.Random(1).randbytes(3000).hex()  # names that repeat are compressed, and fit
    with Ledger.open(url) as ledger:
        with pytest.raises(LedgerError, match="expected at most 2600 bytes together; nothing was changed"):
            ledger.keep_prediction({}, digest="a digest", rocket="Astra", flight_id=name)
        assert ledger.predictions() == []


@pytest.mark.postgres
def test_a_server_that_dies_in_mid_transaction_loses_only_that_change(
    server: servers.Server, url: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    with Ledger.open(url) as ledger:
        ledger.add([FIRST])
        enter = journal._enter

        def as_the_server_dies(*arguments: object, **values: object) -> None:
            server.kill()
            enter(*arguments, **values)  # type: ignore[arg-type]

        monkeypatch.setattr(journal, "_enter", as_the_server_dies)
        with pytest.raises(LedgerError, match=r"127\.0\.0\.1") as error:
            ledger.add([SECOND])
        assert "\n" not in str(error.value)
        monkeypatch.setattr(journal, "_enter", enter)
        server.start()
        assert ledger.flights() == [FIRST]
        ledger.add([SECOND])
        assert [change.number for change in ledger.history()] == [1, 2]


def test_the_page_states_its_command_and_one_commit() -> None:
    page = bench.page([ledgers.Outcome("kill -9", "add", tried=3)], "python -m bench.faults", "aaaa111", 8)
    assert "\nWritten by `python -m bench.faults`, which ran from start to end on commit" in page
    assert page.count("aaaa111") == 1
    assert "| kill -9 | add | 3 |  | 0 |\n" in page


def test_commands_whose_calls_fail_share_a_row_of_the_page() -> None:
    found = [ledgers.Outcome("a call fails", name, 2, {"refused": 1, name: 1}, ["broken"]) for name in ("add", "edit")]
    untried = ledgers.Outcome("a call fails", "serve: not tried")
    page = bench.page([*found, untried], "python -m bench.faults", "aaaa111", 8)
    assert "| 2 commands and histories of commands | 4 | add: 1; edit: 1; refused: 2 | 2 |\n" in page
    assert "| a call fails | serve: not tried |  |  | 0 |\n" in page


def test_a_checkout_with_changed_files_has_no_commit(tmp_path: Path) -> None:
    def git(*arguments: str) -> None:
        subprocess.run(["git", "-c", "user.name=a", "-c", "user.email=a", *arguments], cwd=tmp_path, check=True)

    assert bench.commit(tmp_path) == ""
    page, code = tmp_path / "docs" / "faults.md", tmp_path / "code.py"
    page.parent.mkdir()
    for file in (page, code):
        file.write_text("1")
    git("init", "-q")
    git("add", ".")
    git("commit", "-q", "-m", "One")
    page.write_text("2")
    assert len(bench.commit(tmp_path)) >= 7
    code.write_text("2")
    assert bench.commit(tmp_path) == ""
    git("checkout", "-q", "code.py")
    (tmp_path / "new.py").write_text("1")
    assert bench.commit(tmp_path) == ""


@pytest.mark.parametrize("changed", [True, False])
def test_no_page_is_written_for_a_checkout_with_changed_files(
    changed: bool, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    commits = iter(["aaaa111", "" if changed else "aaaa111"])
    monkeypatch.setattr(bench, "commit", lambda: next(commits))
    monkeypatch.setattr(bench, "run", lambda *_: [ledgers.Outcome("a part", "of the bench")])
    monkeypatch.setattr(sys, "argv", ["bench.faults", "--kills", "6", "--out", str(tmp_path / "page.md")])
    if changed:
        with pytest.raises(SystemExit):
            bench.main()
        assert "no longer those of commit aaaa111" in capsys.readouterr().err
    else:
        assert bench.main() == 0
    assert (tmp_path / "page.md").exists() is not changed


def test_a_concurrent_part_ends_with_the_others(tmp_path: Path) -> None:
    found, started = ledgers.Outcome("a part", "beside the others", tried=3), tmp_path / "started"

    def endless() -> ledgers.Outcome:
        started.touch()
        time.sleep(600)
        return found

    with bench.beside(lambda: found, tmp_path / "one.json") as result:
        assert result() == found
    with bench.beside(lambda: 1 // 0, tmp_path / "two.json") as result, pytest.raises(RuntimeError, match="two"):
        result()
    began = time.monotonic()
    with bench.beside(endless, tmp_path / "three.json"):
        while not started.exists():
            time.sleep(0.01)
    assert time.monotonic() - began < 60
    assert not (tmp_path / "three.json").exists()


def test_an_interrupted_run_resumes_where_it_stopped_and_only_at_its_own_commit(tmp_path: Path) -> None:
    tried: list[int] = []

    def part() -> ledgers.Outcome:
        tried.append(1)
        return ledgers.Outcome("a part", "of the bench", tried=3)

    assert not bench.resumed(tmp_path, {"commit": "aaaa111", "kills": 60})
    for _ in range(2):
        assert bench.tried(part, tmp_path / "a_part.json").tried == 3
    assert len(tried) == 1
    assert not bench.resumed(tmp_path, {"commit": "aaaa111", "kills": 60})
    for other in ({"commit": "aaaa111", "kills": 61}, {"commit": "bbbb222", "kills": 60}):
        assert f"expected {other} or another folder" in bench.resumed(tmp_path, other)


def test_the_bench_detects_a_command_that_silently_loses_its_output(tmp_path: Path) -> None:
    found = tmp_path / "found"
    ledgers_folder = tmp_path / "home"
    with ledgers.at_home(ledgers_folder):
        found.mkdir()
        ledgers.season(found / "ledger.db")
        trial = failing.Bench(tmp_path / "trial", session.Call(("tag", "1", "mine"), found))
        trial.learn()
        assert trial.judged_full(trial.tried(full=True)) == ("refused, and done", "")
        silent = calls.Ended(0, "", "", came=True)
        assert trial.judged_full(silent)[1] == "its output is lost and it said that it was done"
