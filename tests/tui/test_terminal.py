"""A session in a real terminal, driven by keys and read from its screen."""

import os
import shutil
import subprocess
import sys
import time
from collections.abc import Iterator
from pathlib import Path

import pytest

from fieldkit.ledger import Ledger
from fieldkit.services.manual_entry import DRAFT
from tests.pressing import ROOT, season

PATIENCE = 60.0
"""Time limit for a screen on a busy machine. [s]"""


class Terminal:
    """A tmux session of 80x24 in which the app runs."""

    def __init__(self, folder: Path) -> None:
        self.socket = str(folder / "tmux")

    def tmux(self, *arguments: str) -> str:
        """The output of a tmux command."""
        command = ["tmux", "-S", self.socket, "-f", "/dev/null", *arguments]
        return subprocess.run(command, check=True, capture_output=True, text=True).stdout

    def start(self, ledger: Path, home: Path) -> None:
        """The app in a new session, as `fieldkit` without a command."""
        settings = {"FIELDKIT_HOME": home, "PYTHONPATH": ROOT, "FIELDKIT_LEDGER": ledger}
        flags = [part for name, value in settings.items() for part in ("-e", f"{name}={value}")]
        program = f"{sys.executable} -m fieldkit.cli.main; echo left with $?; sleep 60"
        self.tmux("new-session", "-d", "-x", "80", "-y", "24", *flags, "-c", str(home), "sh", "-c", program)

    def press(self, *keys: str) -> None:
        """Send keys; a text that is not the name of a key is typed."""
        self.tmux("send-keys", *keys)

    def screen(self) -> str:
        """The current screen."""
        return self.tmux("capture-pane", "-p")

    def until(self, text: str) -> str:
        """The screen once it shows a text."""
        ends = time.monotonic() + PATIENCE
        while time.monotonic() < ends:
            screen = self.screen()
            if text in screen:
                return screen
            time.sleep(0.1)
        raise AssertionError(f"{text!r} did not come; the screen is\n{self.screen()}")


@pytest.fixture
def terminal(tmp_path: Path) -> Iterator[Terminal]:
    terminal = Terminal(tmp_path)
    yield terminal
    subprocess.run(["tmux", "-S", terminal.socket, "kill-server"], check=False, capture_output=True)


@pytest.mark.skipif(shutil.which("tmux") is None, reason="tmux is not installed")
def test_a_day_at_the_field_using_only_keys(terminal: Terminal, tmp_path: Path) -> None:
    file, home = tmp_path / "ledger.db", tmp_path / "home"
    home.mkdir()
    season(file)
    terminal.start(file, home)
    terminal.until("Which?")
    terminal.press("SI", "Enter")
    terminal.until("No flights yet today")
    terminal.press("1")
    terminal.until("12 of 12")
    screen = terminal.until("▸12")
    assert max(map(len, screen.splitlines())) <= 80
    terminal.press("a")
    terminal.until("Save this flight")
    for text in ("650ft", "120mph", "2.1", "7.5", "2.6", "4.9", "0.3", "640ft", "14mph", "41"):
        terminal.press(text, "Enter")
    terminal.until("burn time agree")
    terminal.press("Enter")
    terminal.until("Saved flight 13")
    terminal.press("Escape", "Escape", "1")
    terminal.until("▸13")
    terminal.press("t")
    terminal.until("With these tags")
    terminal.press("Enter")
    terminal.until("[x] weak_launch")
    terminal.press("u")
    terminal.until("Undone: tag 13 weak_launch")
    terminal.press("Escape", "Escape", "4")
    terminal.until("on the altimeter")
    terminal.press("T")
    terminal.until("theme sun")
    terminal.press("q")
    terminal.until("left with 0")
    with Ledger.open(file) as ledger:
        flight = ledger.flight("13")
    assert flight.apogee == pytest.approx(198.12)
    assert len(flight.readouts()) == 10
    assert flight.tags == ()
    assert '"theme": "sun"' in (home / "settings.json").read_text()


@pytest.mark.thorough
@pytest.mark.skipif(sys.platform == "win32", reason="no pseudo-terminals here")
@pytest.mark.parametrize(("keys", "shown"), [(b"a923ft", b"923"), (b"5S", b"searching")], ids=["typing", "computing"])
def test_the_app_ends_when_its_terminal_disappears_without_a_signal(tmp_path: Path, keys: bytes, shown: bytes) -> None:
    season(tmp_path / "ledger.db")
    (tmp_path / "settings.json").write_text('{"units": "SI"}')  # otherwise the first start asks for the units
    held, given = os.openpty()
    command = [sys.executable, "-m", "fieldkit.cli.main", "--ledger", str(tmp_path / "ledger.db")]
    environment = os.environ | {"FIELDKIT_HOME": str(tmp_path), "PYTHONPATH": str(ROOT), "TERM": "xterm-256color"}
    # in a separate session without this terminal, so it gets no signal
    with subprocess.Popen(
        command, stdin=given, stdout=given, stderr=given, env=environment, start_new_session=True
    ) as app:
        os.close(given)
        painted = b""
        while b"No flights yet today" not in painted:
            painted += os.read(held, 65536)
        os.write(held, keys)
        while shown not in painted:
            painted += os.read(held, 65536)
        os.close(held)
        try:
            app.wait(PATIENCE)
        finally:
            app.kill()
    assert app.returncode == 0
    with Ledger.open(tmp_path / "ledger.db") as ledger:
        assert shown != b"923" or (ledger.draft(DRAFT) or {}).get("apogee", "").startswith("92")
