"""Whatever is wrong with a file, the message begins with its name, for every parser and every way in, with or without
column mappings that the user saved."""

from collections.abc import Callable
from pathlib import Path

import pytest

from fieldkit.errors import FieldkitError
from fieldkit.importing import ColumnChoice
from fieldkit.importing.read import open_file, read_plans, read_recordings
from fieldkit.importing.recognize import parsers
from fieldkit.importing.tables.mapping import remember
from fieldkit.services.imports.mappings import table_columns
from tests.commands import Run

SAVED = (
    ColumnChoice({"apogee": "how high [m]", "rocket": "craft"}, ("when", "how high", "craft")),
    ColumnChoice({"time": "t [s]", "altitude": "h [m]"}, ("t", "h")),
    ColumnChoice({"time": "#1 [s]", "altitude": "#2 [m]"}, ("#1 0.00", "#2 0.0")),
)
BROKEN = {
    "binary": bytes(range(256)) * 64,
    "empty": b"",
    "nuls": bytes(4096),
    "words": b"the rocket went up\nand came down\n" * 20,
    "header only": b"time,altitude,pressure\n",
    "a table of words": b"time,altitude\nred,green\nblue,white\n",
    "no text": b"\xff\xfe\x00\xd8" * 500,
    "other columns": b"one,two\n1,2\n3,4\n5,6\n",
    "numbers": b"1,2,3\n" * 40,
    "an archive": b"PK\x03\x04" + bytes(200),
}


def rejection(way_in: Callable[[], object]) -> str:
    """The message with which a file is rejected; empty if it is accepted."""
    try:
        way_in()
    except FieldkitError as error:
        return str(error)
    return ""


@pytest.mark.parametrize("choices", [(), SAVED], ids=["no mappings", "saved mappings"])
@pytest.mark.parametrize("what", BROKEN)
@pytest.mark.parametrize("format", [None, *parsers()])
def test_every_parser_rejects_a_file_by_its_name(
    format: str | None, what: str, choices: tuple[ColumnChoice, ...]
) -> None:
    ways: list[Callable[[], object]] = [
        lambda: open_file("junk.csv", BROKEN[what], format, choices),
        lambda: read_recordings(BROKEN[what], "junk.csv", format, choices),
    ]
    assert all("junk.csv" in message for message in map(rejection, ways) if message)


@pytest.mark.parametrize("what", BROKEN)
def test_every_way_in_rejects_a_file_by_its_name(what: str, tmp_path: Path) -> None:
    file = tmp_path / "junk.csv"
    file.write_bytes(BROKEN[what])
    ways: list[Callable[[], object]] = [
        lambda: read_plans(BROKEN[what], "junk.csv", lambda motor: None),
        *(lambda of=of: table_columns(file, of) for of in ("", "samples", "flights")),  # type: ignore[misc]
    ]
    assert all("junk.csv" in message for message in map(rejection, ways) if message)


@pytest.mark.parametrize("choices", [(), SAVED], ids=["no mappings", "saved mappings"])
@pytest.mark.parametrize("what", BROKEN)
def test_import_and_inspect_reject_a_file_by_its_name(
    what: str, choices: tuple[ColumnChoice, ...], tmp_path: Path, run: Run
) -> None:
    for choice in choices:
        remember(choice)
    file = tmp_path / "junk.csv"
    file.write_bytes(BROKEN[what])
    for command in ("import", "inspect"):
        assert "junk.csv" in run(command, file, status=1).err
