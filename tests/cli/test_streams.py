"""Open streams that receive results, streams that the parent process has closed, and files that only look like one."""

import io
import os
import shutil
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path
from tempfile import mkdtemp

import pytest

from fieldkit import files
from fieldkit.cli.main import main
from fieldkit.cli.screen import complain
from fieldkit.errors import FieldkitError
from fieldkit.flight import Flight
from fieldkit.ledger import Ledger
from fieldkit.settings import Settings, change_settings, read_settings

ROOT = Path(__file__).parents[2]
CHECK_SHAPES = False
ENVIRONMENT = {name: value for name, value in os.environ.items() if name != "PYTHONUNBUFFERED"} | {
    "PYTHONPATH": str(ROOT)
}
MEMORY = Path("/dev/shm")
ADD = ("add", "--rocket", "Astra", "--flight-id", "9", "--apogee", "100m")

pytestmark = pytest.mark.skipif(sys.platform == "win32", reason="Windows names no streams, and its shell closes none")


@pytest.fixture
def in_memory() -> Iterator[Path]:
    if not MEMORY.is_dir():
        pytest.skip("there is no file system under /dev")
    folder = Path(mkdtemp(dir=MEMORY))
    yield folder
    shutil.rmtree(folder)


@pytest.fixture
def ledger(tmp_path: Path) -> str:
    return str(tmp_path / "ledger.db")


def fieldkit(ledger: str, arguments: tuple[str, ...], closed: str = "") -> "subprocess.CompletedProcess[str]":
    """Run a command from a shell, with redirections such as `>&-`."""
    command = [sys.executable, "-m", "fieldkit.cli.main", "--ledger", ledger, *arguments]
    return subprocess.run(
        ["sh", "-c", f'"$@" {closed}', "sh", *command],
        env=ENVIRONMENT,
        capture_output=True,
        text=True,
        stdin=subprocess.DEVNULL,
    )


def flights(ledger: str) -> list[str]:
    with Ledger.open(ledger) as opened:
        return [one.flight_id for one in opened.flights()]


@pytest.mark.fast
def test_a_regular_file_in_dev_is_written_and_replaced_like_any_other(in_memory: Path) -> None:
    file = in_memory / "flights.csv"
    files.write(file, b"first")
    with pytest.raises(FieldkitError, match="found an existing file"):
        files.write(file, b"2")
    assert file.read_bytes() == b"first"
    assert files.is_taken(file)
    files.write(file, b"2", force=True)
    assert file.read_bytes() == b"2"


@pytest.mark.fast
@pytest.mark.parametrize("name", ["/dev/fd/{}", "/proc/self/fd/{}"])
def test_an_open_stream_is_written_at_its_position(tmp_path: Path, name: str) -> None:
    with (tmp_path / "out.txt").open("wb", buffering=0) as out:
        if not Path(name.format(out.fileno())).exists():
            pytest.skip("this system has no such names")
        out.write(b"head\n")
        files.write(Path(name.format(out.fileno())), b"flights\n")
        out.write(b"tail\n")
    assert (tmp_path / "out.txt").read_bytes() == b"head\nflights\ntail\n"


@pytest.mark.fast
def test_a_long_name_in_letters_of_three_bytes_can_be_written(tmp_path: Path) -> None:
    file = tmp_path / ("飛" * 80 + ".csv")
    files.write(file, b"flights")
    assert file.read_bytes() == b"flights"


@pytest.mark.fast
def test_a_linked_settings_file_stays_a_link_and_keeps_its_mode(tmp_path: Path) -> None:
    link, file = tmp_path / "settings.json", tmp_path / "kept" / "mine.json"
    file.parent.mkdir()
    file.write_text("{}")
    file.chmod(0o600)
    link.symlink_to(file)
    change_settings({"units": "US"}, link)
    assert link.is_symlink()
    assert read_settings(file) == Settings(units="US")
    assert file.stat().st_mode & 0o777 == 0o600


@pytest.mark.fast
@pytest.mark.parametrize("text", ["a file of somebody else", '{"name": "a package"}', "[1]"])
def test_a_link_to_something_else_than_settings_is_not_written_through(tmp_path: Path, text: str) -> None:
    link, file = tmp_path / "settings.json", tmp_path / "other"
    file.write_text(text)
    link.symlink_to(file)
    with pytest.raises(FieldkitError, match="not fieldkit's settings"):
        change_settings({"units": "US"}, link)
    assert file.read_text() == text


@pytest.mark.fast
def test_a_settings_path_that_links_to_a_device_leaves_the_device_alone(tmp_path: Path) -> None:
    link = tmp_path / "settings.json"
    link.symlink_to(os.devnull)
    change_settings({"units": "US"}, link)
    assert Path(os.devnull).is_char_device()
    assert read_settings(link).units == "US"


def test_a_closed_output_is_reported_in_one_line_that_does_not_deny_what_was_done(ledger: str) -> None:
    done = fieldkit(ledger, ADD, ">&-")
    assert done.returncode == 1
    saved, unused, line = done.stderr.splitlines()
    assert saved.startswith("Saved flight 9.")
    assert "flight 9 is excluded from every fit" in unused
    assert line.startswith("the output: found Bad file descriptor")
    assert line.endswith("may have finished, check `fieldkit history`")
    assert flights(ledger) == ["9"]


@pytest.mark.thorough
@pytest.mark.sampled
@pytest.mark.parametrize("closed", ["2>&-", "2>/dev/full", "<&- 2>&-"])
def test_closed_stderr_does_not_change_what_a_command_does(ledger: str, closed: str) -> None:
    if "full" in closed and not Path("/dev/full").exists():
        pytest.skip("this system has no full device")
    done = fieldkit(ledger, ADD, closed)
    assert done.returncode == 0
    assert "Apogee" in done.stdout
    assert flights(ledger) == ["9"]
    assert fieldkit(ledger, ("show", "nothing such"), closed).returncode == 1


def test_a_closed_input_asks_nothing(ledger: str) -> None:
    done = fieldkit(ledger, ("tui",), "<&-")
    assert done.returncode == 1
    assert done.stderr == "the app needs a terminal; the commands do the same: fieldkit --help\n"


def unread(ledger: str, *arguments: str) -> "subprocess.CompletedProcess[bytes]":
    """Run a command whose output nobody reads."""
    reading, writing = os.pipe()
    os.close(reading)
    command = [sys.executable, "-m", "fieldkit.cli.main", "--ledger", ledger, *arguments]
    with os.fdopen(writing, "wb") as out:
        return subprocess.run(command, stdout=out, stderr=subprocess.PIPE, env=ENVIRONMENT)


def test_a_saved_flight_is_reported_even_if_nobody_reads_its_card(ledger: str) -> None:
    done = unread(ledger, *ADD)
    assert b"Saved flight 9." in done.stderr
    assert b"Traceback" not in done.stderr
    assert flights(ledger) == ["9"]


def test_a_command_that_finished_before_its_reader_left_succeeds(ledger: str) -> None:
    with Ledger.open(ledger) as opened:
        opened.add([Flight(flight_id="9", rocket="Astra", apogee=100.0)])
    done = unread(ledger, "tag", "9", "mine")
    assert (done.returncode, done.stderr) == (0, b"")


@pytest.mark.parametrize("terminal", [True, False])
def test_a_long_error_is_wrapped_between_words_on_a_terminal_and_whole_in_a_pipe(
    monkeypatch: pytest.MonkeyPatch, terminal: bool
) -> None:
    class Stream(io.StringIO):
        def isatty(self) -> bool:
            return terminal

        def fileno(self) -> int:
            return 2

    stream = Stream()
    monkeypatch.setattr("sys.stderr", stream)
    monkeypatch.setattr("os.get_terminal_size", lambda _: os.terminal_size((40, 24)))
    text = f"{'/folder' * 8}/log.csv: no parser recognizes this file; did you mean AeroTech F24-4W?\n\n  second line"
    complain(text)
    lines = stream.getvalue().splitlines()
    if not terminal:
        assert stream.getvalue() == text + "\n"
        return
    assert " ".join(" ".join(lines).split()) == " ".join(text.split())
    assert set(" ".join(lines).split()) == set(text.split())
    assert all(len(line) <= 40 for line in lines[1:])
    assert lines[-1] == "  second line"


def test_a_command_runs_its_small_matrices_on_one_thread() -> None:
    asked = (
        "import os, sys; from fieldkit.cli import main; sys.argv = ['fieldkit', '--version']\n"
        "import atexit; atexit.register(lambda: print(os.environ['OPENBLAS_NUM_THREADS'], 'numpy' in sys.modules))\n"
        "main.run()"
    )
    for preset, expected in (("", "1"), ("4", "4")):
        rest = {name: value for name, value in os.environ.items() if name != "OPENBLAS_NUM_THREADS"}
        own = rest | ({"OPENBLAS_NUM_THREADS": preset} if preset else {})
        done = subprocess.run([sys.executable, "-c", asked], env=own, capture_output=True, text=True, check=True)
        assert done.stdout.split()[-2:] == [expected, "False"]


def test_pictures_need_no_backend_of_the_environment(monkeypatch: pytest.MonkeyPatch) -> None:
    """A name that matplotlib does not know ended a report in a traceback."""
    monkeypatch.setenv("MPLBACKEND", "none_such")
    assert main(["--version"]) == 0
    code = "import matplotlib; print(matplotlib.get_backend())"
    assert subprocess.check_output([sys.executable, "-c", code], text=True).strip() == "agg"
