"""Files that commands may write: never one of fieldkit's data files, and no existing file without confirmation.

The commands and their files come from the command tree, so that a new command is included automatically.
"""

import ast
import os
import re
import shlex
import shutil
import stat
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
import typer

from fieldkit import files, paths
from fieldkit.cli.main import app, main
from fieldkit.errors import FieldkitError
from fieldkit.ledger import Ledger
from tests.effort import THOROUGH, part

ROOT = Path(__file__).parents[2]
CHECK_SHAPES = False
FILLERS = {
    "what": "1",
    "recipe": "paper",
    "motor": "F24-4W",
    "rocket": "Astra",
    "config": "A",
    "number": "1",
    "out": "written.png",
}
"""Other required arguments of commands, by name."""


def commands(tree: Any, names: tuple[str, ...] = ()) -> Iterator[tuple[tuple[str, ...], Any]]:
    """Every command of the tree, including groups that are commands."""
    if names:
        yield names, tree
    for name, child in getattr(tree, "commands", {}).items():
        yield from commands(child, (*names, name))


def with_files() -> list[tuple[tuple[str, ...], Any, Any]]:
    """Every command with a file name, and its parameter."""
    found = [
        (names, one, command) for names, command in commands(typer.main.get_command(app)) for one in command.params
    ]
    return [(names, one, command) for names, one, command in found if one.type.name == "path"]


WITH_FILES = with_files()


TOGETHER = {"plans": ["--out", "filled.csv"], "stock": ["--fit", "Astra"]}
"""Options that another one requires, by its name."""


def line(names: tuple[str, ...], parameter: Any, command: Any, file: Path) -> list[str]:
    """A command line with a file and otherwise only required arguments."""
    words = list(names)
    for one in command.params:
        value = str(file) if one is parameter else FILLERS.get(str(one.name), "1")
        if one is not parameter and not one.required:
            continue
        words += [value] if one.param_type_name == "argument" else [one.opts[0], value]
    return words + TOGETHER.get(str(parameter.name), [])


def at_home(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Let commands use the ledger and the data in a folder."""
    monkeypatch.setenv("FIELDKIT_HOME", str(folder / "home"))
    monkeypatch.setenv("FIELDKIT_LEDGER", str(folder / "ledger.db"))
    monkeypatch.chdir(folder)


@pytest.fixture(scope="module")
def three_flights(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with a ledger of three flights, a backup of it, and settings, which is copied for each test."""
    folder = tmp_path_factory.mktemp("three")
    table = folder / "three.csv"
    rows = [f"{n},2025-05-0{n}T10:00,Astra,A,322,66,F24-4W,{250 + n}" for n in (1, 2, 3)]
    table.write_text("\n".join(["flight_id,date_time,rocket,config,dry_mass_g,diameter_mm,motor,apogee_m", *rows]))
    with pytest.MonkeyPatch.context() as patch:
        at_home(folder, patch)
        assert main(["import", str(table)]) == 0
        assert main(["tag", "1", "windy"]) == 0  # before which a backup is made
    (folder / "home" / "motors").mkdir(parents=True)
    (folder / "home" / "settings.json").write_text('{"units": "US"}')
    (folder / "home" / "motors" / "own.eng").write_text("; nothing")
    return folder


@pytest.fixture
def home(three_flights: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Those flights in a folder, with links to the ledger and the settings."""
    at_home(tmp_path, monkeypatch)
    shutil.copytree(three_flights, tmp_path, dirs_exist_ok=True)
    for name, target in (("linked.db", "ledger.db"), ("linked.json", "home/settings.json")):
        (tmp_path / name).symlink_to(tmp_path / target)
    for name, target in (("hard.db", "ledger.db"), ("hard.json", "home/settings.json")):
        os.link(tmp_path / target, tmp_path / name)
    return tmp_path


def own_files(home: Path) -> list[Path]:
    """Every path by which a command could reach fieldkit's files, and paths that would harm them if created."""
    (backup, *_) = (home / "ledger.db-backups").iterdir()
    names = (
        "ledger.db",
        "linked.db",
        "hard.db",
        "linked.json",
        "hard.json",
        "home/settings.json",
        "home/motors/own.eng",
    )
    beside = ("ledger.db-journal", "ledger.db-wal", "ledger.db-shm", "linked.db-journal", "ledger.db-backups/out.csv")
    return [*(home / name for name in (*names, *beside)), backup]


def bytes_of(home: Path) -> dict[str, bytes]:
    """All files by name, except temporary files of running commands."""
    return {str(file.relative_to(home)): file.read_bytes() for file in sorted(home.rglob("*")) if file.is_file()}


def test_the_command_tree_is_walked() -> None:
    found = {" ".join(names) for names, _, _ in WITH_FILES}
    assert {"export", "report", "loop", "score", "study reference", "study rockets", "train", "import"} <= found


@pytest.mark.sampled
@pytest.mark.parametrize(("names", "parameter", "command"), WITH_FILES, ids=lambda one: str(getattr(one, "name", one)))
def test_no_command_overwrites_fieldkits_own_files(
    home: Path, names: tuple[str, ...], parameter: Any, command: Any
) -> None:
    before = bytes_of(home)
    for file in part(own_files(home), WITH_FILES.index((names, parameter, command))):
        for suffix in ("", *_suffixes(parameter)):
            target = file if not suffix else _under(home, file, suffix)
            force = ["--force"] if any("--force" in one.opts for one in command.params) else []
            words = [*line(names, parameter, command, target), *force]
            status = main(words)
            if force:
                assert status, shlex.join(words)
            assert {**before, **bytes_of(home)} == {**bytes_of(home), **before}, shlex.join(words)
    with Ledger.open() as ledger:
        assert len(ledger.flights()) == 3


def _suffixes(parameter: Any) -> tuple[str, ...]:
    """File suffixes that a command requires, which a link may have."""
    return tuple(end for end in (".html", ".png") if end in (getattr(parameter, "help", None) or ""))


def _under(home: Path, file: Path, suffix: str) -> Path:
    """A link to a file with another suffix."""
    link = home / f"another{suffix}"
    link.unlink(missing_ok=True)
    link.symlink_to(file)
    return link


@pytest.mark.parametrize(("names", "parameter", "command"), WITH_FILES, ids=lambda one: str(getattr(one, "name", one)))
def test_no_command_replaces_a_file_by_default(
    home: Path, names: tuple[str, ...], parameter: Any, command: Any
) -> None:
    for suffix in ("", *_suffixes(parameter)):
        mine = home / f"mine{suffix}"
        mine.write_text("what I wrote")
        main(line(names, parameter, command, mine))
        assert mine.read_text() == "what I wrote"


def test_a_file_is_replaced_with_confirmation(home: Path, capsys: pytest.CaptureFixture[str]) -> None:
    out = home / "out.csv"
    assert main(["export", str(out)]) == 0
    out.chmod(0o640)
    (link := home / "link.csv").symlink_to(out)
    assert main(["export", str(link)]) == 1
    assert "--force" in capsys.readouterr().err
    out.write_text("old")
    assert main(["export", str(link), "--force"]) == 0
    assert out.read_text().startswith("flight_id")
    assert link.is_symlink()
    assert stat.S_IMODE(out.stat().st_mode) == 0o640


def test_a_file_created_in_the_meantime_is_not_replaced(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    out = tmp_path / "out.csv"
    link = os.link

    def late(new: Path, target: Path) -> None:
        out.write_text("another's")
        link(new, target)

    monkeypatch.setattr(os, "link", late)
    with pytest.raises(FieldkitError, match="existing file"):
        files.write(out, b"mine")
    assert out.read_text() == "another's"
    assert [file.name for file in tmp_path.iterdir()] == ["out.csv"]


def test_a_failed_write_leaves_the_old_file(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    out = tmp_path / "out.csv"
    out.write_text("old")

    def full(_: int) -> None:
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(os, "fsync", full)
    with pytest.raises(FieldkitError, match="No space left"):
        files.write(out, b"new", force=True)
    assert bytes_of(tmp_path) == {"out.csv": b"old"}


def test_related_files_are_all_written_or_none_is(tmp_path: Path) -> None:
    (tmp_path / "b").write_text("mine")
    with pytest.raises(FieldkitError, match="existing file"):
        files.write_all({tmp_path / "a": b"a", tmp_path / "b": b"b"})
    assert bytes_of(tmp_path) == {"b": b"mine"}


def test_the_path_of_a_missing_or_damaged_ledger_is_not_overwritten(home: Path) -> None:
    ledger = home / "ledger.db"
    for harm in (lambda: ledger.write_bytes(b"\0" * 4096), ledger.unlink):
        harm()
        with pytest.raises(FieldkitError, match="never overwritten"):
            files.write(ledger, b"x", force=True)


def filled(home: Path) -> dict[Path, bytes]:
    """A file for every name in the data folder, a folder for each name without a suffix, and unknown names."""
    for name in (*paths.DATA_FILES, "of a later version", "folder/of/another.program"):
        file = paths.data_folder() / name
        if "." not in name and name in paths.DATA_FILES:
            file = file / "inside.txt"
        file.parent.mkdir(parents=True, exist_ok=True)
        if not file.exists():
            file.write_text("kept")
    return {file: file.read_bytes() for file in paths.data_folder().rglob("*") if file.is_file()}


def other_names(own: Path, home: Path) -> Iterator[Path]:
    """A file in the data folder, and other paths to it: a link, a hard link, a linked folder, a path with `..`."""
    yield own
    (link := home / "name.csv").symlink_to(own)
    yield link
    os.link(own, hard := home / "hard.csv")
    yield hard
    (folder := home / "folder").symlink_to(own.parent)
    yield folder / own.name
    yield own.parent / ".." / own.parent.name / own.name
    for name in (link, hard, folder):
        name.unlink()


def test_nothing_in_the_data_folder_is_ever_overwritten(home: Path) -> None:
    before = filled(home)
    assert {file.relative_to(paths.data_folder()).parts[0] for file in before} > set(paths.DATA_FILES)
    for own in before:
        for target in other_names(own, home):
            with pytest.raises(FieldkitError, match="never overwritten"):
                files.write(target, b"written over", force=True)
            assert main(["export", str(target), "--force"]) == 1
    assert {file: file.read_bytes() for file in before} == before


def test_the_target_of_a_link_in_the_data_folder_is_never_overwritten(home: Path) -> None:
    (shared := home / "shared").mkdir()
    (shared / "corrections.csv").write_text("kept")
    (alone := home / "alone.toml").write_text("kept")
    (paths.data_folder() / "rules").symlink_to(shared)
    (paths.data_folder() / "limits.toml").symlink_to(alone)
    (paths.data_folder() / "around").symlink_to(paths.data_folder())
    os.link(shared / "corrections.csv", hard := home / "hard.csv")
    for target in (shared / "corrections.csv", alone, hard):
        with pytest.raises(FieldkitError, match="never overwritten"):
            files.write(target, b"written over", force=True)
        assert target.read_text() == "kept"


@pytest.mark.parametrize(
    "name", [*paths.DATA_FILES, paths.LOCK_NAME, "motors/new.eng", "rules/new.toml", "seasons/2031.toml"]
)
def test_no_command_creates_a_file_that_fieldkit_would_take_for_its_own(home: Path, name: str) -> None:
    target = paths.data_folder() / name
    target.unlink(missing_ok=True) if target.is_file() else None
    assert main(["export", str(target)]) == 1
    assert not target.is_file()


def test_the_data_folder_may_also_contain_the_flyers_files(home: Path) -> None:
    files.write(paths.data_folder() / "season of 2025.csv", b"x")


def test_every_name_in_the_data_folder_is_known_to_the_guard() -> None:
    """Only `paths` builds paths in the data folder: the type of `data_file` lists every name."""
    for file in sorted((ROOT / "fieldkit").rglob("*.py")):
        if file.name != "paths.py":
            code = file.read_text(encoding="utf-8")
            assert not re.search(r"\b(data_folder|_data_path|user_data_path|user_config_path)\b", code), file


def test_the_flyers_own_folders_are_not_backups(tmp_path: Path) -> None:
    (tmp_path / "season-backups").mkdir()
    (tmp_path / "season").mkdir()
    files.write(tmp_path / "season-backups" / "out.csv", b"x")
    files.write(tmp_path / "season" / "out.csv", b"x")


def test_a_device_receives_what_is_written(tmp_path: Path) -> None:
    files.write(Path(os.devnull), b"x")


WRITERS = {"files.py", "capture/tape.py"}
"""The modules that may write files directly: the guard, and the tape, whose file is always new."""


def test_every_file_is_written_through_the_guard() -> None:
    for file in sorted((ROOT / "fieldkit").rglob("*.py")):
        if str(file.relative_to(ROOT / "fieldkit")) in WRITERS:
            continue
        for node in ast.walk(ast.parse(file.read_text(encoding="utf-8"))):
            if isinstance(node, ast.Call) and isinstance(node.func, ast.Attribute | ast.Name):
                name = node.func.attr if isinstance(node.func, ast.Attribute) else node.func.id
                texts = [one.value for one in node.args if isinstance(one, ast.Constant)]
                opens = name == "open" and any(isinstance(one, str) and set(one) & set("wax+") for one in texts)
                found = opens or name in ("write_text", "write_bytes", "FileIO")
                assert not found, f"{file}:{node.lineno}"


REPLACED_WHOLE = {
    "tui/crash.py": "a report with a new name",
    "parallel.py": "a result that only this item has",
    "cli/demo.py": "a new ledger",
    "motors/own.py": "a file that the flyer names, whatever it was before",
    "services/flight_logs.py": "measurements of these bytes, which nobody measures differently",
    "planning/kit_file.py": "kits, within the lock of `services/kits.py`",
}
"""The modules that replace a file of fieldkit without its lock, and which file."""


def test_every_shared_file_is_replaced_under_its_lock() -> None:
    found = set()
    for file in sorted((ROOT / "fieldkit").rglob("*.py")):
        code = file.read_text(encoding="utf-8")
        if re.search(r"from fieldkit\.files import .*\breplace\b|\bfiles\.replace\(", code):
            found.add(file.relative_to(ROOT / "fieldkit").as_posix())
            assert file.relative_to(ROOT / "fieldkit").as_posix() in REPLACED_WHOLE or "with changing(" in code, file
    assert set(REPLACED_WHOLE) < found


@pytest.mark.sampled
@pytest.mark.parametrize(("names", "parameter", "command"), WITH_FILES, ids=lambda one: str(getattr(one, "name", one)))
def test_a_minus_is_standard_output_and_not_a_file(
    home: Path,
    names: tuple[str, ...],
    parameter: Any,
    command: Any,
    capfd: pytest.CaptureFixture[str],
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    if names == ("train",):
        pytest.skip("it makes a folder")
    if not THOROUGH:  # the study takes seconds, and its parts have their own tests
        monkeypatch.setattr("studies.paper.study.study", lambda: None)
        monkeypatch.setattr("studies.paper.study_page.page", lambda _: "a page")
    status = main(line(names, parameter, command, Path("-")))
    assert not (home / "-").exists()
    shown = capfd.readouterr()
    assert status or shown.out
    assert "Traceback" not in shown.err


def test_an_export_to_standard_output_is_the_table(home: Path, capfd: pytest.CaptureFixture[str]) -> None:
    assert main(["export"]) == 0
    table = capfd.readouterr().out
    assert main(["export", "-"]) == 0
    assert capfd.readouterr().out == table


@pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="there are no pipes with names")
def test_a_pipe_without_a_reader_is_refused_and_one_with_a_reader_is_written(tmp_path: Path) -> None:
    pipe = tmp_path / "pipe"
    os.mkfifo(pipe)
    with pytest.raises(FieldkitError, match="no program reads"):
        files.write(pipe, b"flights")
    with os.fdopen(os.open(pipe, os.O_RDONLY | os.O_NONBLOCK), "rb") as reading:
        files.write(pipe, b"flights")
        assert reading.read() == b"flights"


READERS = {
    "files.py": "the bounded reader itself",
    "file_lock.py": "a lock without content",
    "__init__.py": "a file of the checkout",
    "plugins.py": "cards that come along",
    "cli/main.py": "nothing, in place of a stream that was closed",
    "cli/docs.py": "pages that come along",
    "cli/demo.py": "a ledger",
    "cli/completing.py": "a ledger",
    "cli/session.py": "a ledger",
    "tui/resources.py": "a ledger",
    "model/hyperprior.py": "the card that comes along",
    "motors/catalogue.py": "the catalog that comes along",
    "reference/flights.py": "the table that comes along",
    "planning/contest.py": "rules that come along",
    "importing/tables/flight_headings.py": "a table that comes along",
    "importing/tables/headings.py": "a table that comes along",
    "presentation/report/html.py": "a page that comes along",
    "inference/network/ensemble.py": "reads so many bytes and no more",
    "importing/tables/spreadsheet.py": "the first bytes of a member of an archive",
    "importing/tables/sheet_xml.py": "members of an archive, a part at a time within a budget",
    "openrocket/archive.py": "a member of an archive, so many bytes and no more",
    "parallel.py": "results of this program",
    "ledger/backups.py": "copies of a ledger",
    "capture/tape.py": "the names in a folder",
}
"""The modules that open files without `files.read`, and what they read."""


def test_every_untrusted_file_is_read_within_bounds() -> None:
    for file in sorted((ROOT / "fieldkit").rglob("*.py")):
        if file.relative_to(ROOT / "fieldkit").as_posix() in READERS:
            continue
        for node in ast.walk(ast.parse(file.read_text(encoding="utf-8"))):
            called = node.func if isinstance(node, ast.Call) else None
            name = called.attr if isinstance(called, ast.Attribute) else getattr(called, "id", "")
            assert name not in ("read_text", "read_bytes", "open"), f"{file}:{getattr(node, 'lineno', 0)}"


@pytest.mark.skipif(not Path("/dev/zero").exists(), reason="there is no file without an end")
@pytest.mark.parametrize(("names", "parameter", "command"), WITH_FILES, ids=lambda one: str(getattr(one, "name", one)))
def test_an_endless_file_is_refused_in_one_line(
    home: Path, names: tuple[str, ...], parameter: Any, command: Any, capsys: pytest.CaptureFixture[str]
) -> None:
    if parameter.name in WRITTEN or names == ("export",):
        pytest.skip("it is written")
    assert main(line(names, parameter, command, Path("/dev/zero"))) == 1
    assert "cannot be read" in capsys.readouterr().err


WRITTEN = ("out", "page", "card", "kml", "safety_sheet")
"""Parameters that name a file to write."""
