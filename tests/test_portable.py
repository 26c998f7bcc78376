"""Rules for Windows and macOS, checked on any system."""

import ast
import os
import re
import subprocess
import sys
from pathlib import Path, PureWindowsPath

import pytest

from fieldkit.ledger import whereabouts
from fieldkit.tui.widgets.bars import shortened

ROOT = Path(__file__).parents[1]
SOURCES = [path for folder in ("fieldkit", "parsers", "models") for path in (ROOT / folder).rglob("*.py")]
UNIX = ("fcntl", "grp", "pty", "pwd", "readline", "resource", "syslog", "termios", "tty")
"""Modules of Python that Windows lacks."""
UNIX_NAMES = {
    "os": "chown fork forkpty getegid geteuid getgid getuid killpg mkfifo openpty setsid statvfs sync ttyname",
    "signal": "SIGALRM SIGCHLD SIGHUP SIGKILL SIGPIPE SIGQUIT SIGUSR1 SIGUSR2 SIGWINCH alarm pause setitimer",
    "socket": "AF_UNIX",
    "select": "epoll kqueue poll",
    "time": "tzset clock_settime pthread_getcpuclockid",
}
"""Names that those modules lack on Windows."""

WITHOUT = f"""
import os, select, signal, socket, sys, time
for name in {UNIX!r}:
    sys.modules[name] = None
for module, names in {UNIX_NAMES!r}.items():
    for name in names.split():
        vars(sys.modules[module]).pop(name, None)
from fieldkit.cli.main import main
for line in sys.argv[1:]:
    if main(line.split()):
        sys.exit(line)
"""
SESSION = (
    f"import {(ROOT / 'fieldkit' / 'data' / 'reference_flights.csv').as_posix()}",
    "add --rocket Astra --motor F24-4W --apogee 281m",
    "undo",
    "flights",
    "predict --motor F24-4W --config A",
    "export",
    "backups",
    "backups restore --yes",
    "capture --help",
    "docs start",
)


@pytest.mark.thorough
def test_a_session_works_without_unix_only_modules(tmp_path: Path) -> None:
    flyer = {**os.environ, "FIELDKIT_HOME": str(tmp_path), "PYTHONPATH": str(ROOT)}
    done = subprocess.run([sys.executable, "-c", WITHOUT, *SESSION], env=flyer, cwd=tmp_path, capture_output=True)
    assert done.returncode == 0, done.stderr.decode()


def test_unix_only_names_are_used_only_if_their_absence_is_handled() -> None:
    words = re.compile(rf"\b({'|'.join([*UNIX, *' '.join(UNIX_NAMES.values()).split()])})\b")
    sources = {path: path.read_text(encoding="utf-8") for path in SOURCES}
    named = {path: text for path, text in sources.items() if words.search(text)}
    assert named
    assert [(path, name) for path, text in named.items() for name in unguarded(ast.parse(text))] == []


def unguarded(tree: ast.AST) -> list[str]:
    """Unix-only names, except in code that handles their absence."""
    if isinstance(tree, ast.Try) and any("ImportError" in ast.unparse(one.type or tree) for one in tree.handlers):
        return []
    if isinstance(tree, ast.With) and "suppress(ImportError)" in ast.unparse(tree.items[0]):
        return []
    names: list[str] = []
    match tree:
        case ast.Import(names=aliases):
            names = [one.name for one in aliases if one.name in UNIX]
        case ast.ImportFrom(module=str(module)) if module in UNIX:
            names = [module]
        case ast.Attribute(value=ast.Name(id=module), attr=attr) if attr in UNIX_NAMES.get(module, "").split():
            names = [f"{module}.{attr}"]
    return names + [name for child in ast.iter_child_nodes(tree) for name in unguarded(child)]


def test_a_path_with_a_drive_letter_is_a_path_and_not_a_url() -> None:
    for path in (r"C:\Users\me\flights.db", "C:/Users/me/flights.db", r"\\club\share\flights.db"):
        url = whereabouts.location(path)
        assert whereabouts.name_of(url) == path
        assert str(whereabouts.file_of(url)) == path
    url = whereabouts.location("sqlite:///C:/Users/me/flights.db")
    assert PureWindowsPath(str(whereabouts.file_of(url))) == PureWindowsPath(r"C:\Users\me\flights.db")


def test_notices_shorten_paths_of_every_system_to_file_names() -> None:
    assert shortened(r"C:\Users\me\logs\cold.csv: found 'x'") == "cold.csv: found 'x'"
    assert shortened("/home/me/logs/cold.csv: found 'x'") == "cold.csv: found 'x'"
    assert shortened(r"\\club\share\cold.csv: found 'x'") == "cold.csv: found 'x'"
    assert shortened(r"no backup could be made in C:\Users\me\flights.db-backups (full)").endswith(
        "in flights.db-backups (full)"
    )
    assert shortened("COM3: cannot be opened") == "COM3: cannot be opened"
