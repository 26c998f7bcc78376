"""Command lines run as a flyer does, on a ledger of their own."""

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any, NamedTuple

import pytest


class Output(NamedTuple):
    """The exit status of a command, and what it printed."""

    status: int
    out: str
    err: str

    @property
    def document(self) -> Any:
        return json.loads(self.out)


Run = Callable[..., Output]


@pytest.fixture
def run(tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch) -> Run:
    """Runs a command line on the ledger of the test, in a wide terminal; its user has no other files.

    A command that exits with another status than `status` fails the test; None allows any status.
    """
    from fieldkit.cli.main import main

    monkeypatch.setenv("FIELDKIT_HOME", str(tmp_path / "home"))
    monkeypatch.setenv("COLUMNS", "200")

    def run(*arguments: object, status: int | None = 0) -> Output:
        capsys.readouterr()
        found = main(["--ledger", str(tmp_path / "ledger.db"), *map(str, arguments)])
        output = Output(found, *capsys.readouterr())
        assert status in (None, found), output.err
        return output

    return run
