"""Open apps on one ledger have separate drafts, and no draft is lost."""

import subprocess
import sys
from pathlib import Path

import pytest

from fieldkit.errors import FieldkitError
from fieldkit.ledger import Ledger
from fieldkit.services.manual_entry import DRAFT
from fieldkit.services.own_draft import OwnDraft, take_draft

pytestmark = pytest.mark.fast
KILLED = """
import os, signal, sys
from fieldkit.ledger import Ledger
from fieldkit.services.own_draft import take_draft
with Ledger.open(sys.argv[1]) as ledger:
    own = take_draft(ledger)
    ledger.keep_draft(own.name, {"apogee": "923ft"})
    os.kill(os.getpid(), signal.SIGKILL)
"""


@pytest.fixture
def ledger(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Ledger:
    monkeypatch.setenv("FIELDKIT_HOME", str(tmp_path / "home"))
    return Ledger.open(tmp_path / "ledger.db")


def test_each_open_app_has_its_own_draft(ledger: Ledger) -> None:
    first, second = take_draft(ledger), take_draft(ledger)
    assert first.name == DRAFT
    assert second.name != first.name
    assert second.started != first.started
    first.release()
    assert take_draft(ledger).name == DRAFT


def test_an_unfinished_flight_is_continued_before_a_new_one_is_started(ledger: Ledger) -> None:
    first, second = take_draft(ledger), take_draft(ledger)
    ledger.keep_draft(second.name, {"apogee": "923ft"})
    for own in (first, second):
        own.release()
    assert [take_draft(ledger).name for _ in range(2)] == [second.name, first.name]


@pytest.mark.skipif(sys.platform == "win32", reason="no SIGKILL")
def test_the_draft_of_a_killed_app_is_offered_once(ledger: Ledger) -> None:
    open_app = take_draft(ledger)
    subprocess.run([sys.executable, "-c", KILLED, ledger.name], check=False)
    left = take_draft(ledger)
    assert left.name not in (DRAFT, open_app.name)
    assert ledger.draft(left.name) == {"apogee": "923ft"}
    assert ledger.draft(take_draft(ledger).name) is None


def test_without_a_folder_for_locks_there_is_one_draft(ledger: Ledger, monkeypatch: pytest.MonkeyPatch) -> None:
    def refused(*_: object) -> None:
        raise FieldkitError("read-only")

    monkeypatch.setattr("fieldkit.services.own_draft.hold", refused)
    assert take_draft(ledger) == OwnDraft()
