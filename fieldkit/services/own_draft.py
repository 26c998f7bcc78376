"""The draft of one open app: two apps on one ledger do not share what is typed, and a killed app's draft is continued
by the next one.

Drafts are numbered. An app holds the lock of one number, which ends with its process; the draft of a free number is one
that nobody continues.
"""

import hashlib
import os
from dataclasses import dataclass
from pathlib import Path

from fieldkit.errors import FieldkitError
from fieldkit.file_lock import hold
from fieldkit.ledger import Ledger
from fieldkit.paths import data_file
from fieldkit.services.manual_entry import DRAFT, STARTED_DRAFT

MAX_DRAFTS = 20
"""Number of apps on one ledger with separate drafts; later ones share the first. [1]"""


@dataclass(frozen=True, slots=True)
class OwnDraft:
    """The names under which the ledger saves an app's draft and the day on which it was started; `lock` is an open
    file, None without one."""

    name: str = DRAFT
    started: str = STARTED_DRAFT
    lock: int | None = None

    def release(self) -> None:
        """Leave the draft, if there is one, to the next app."""
        if self.lock is not None:
            os.close(self.lock)


def take_draft(ledger: Ledger) -> OwnDraft:
    """The first draft that no open app holds, or else a new one; the first one if no lock can be written.

    Raises LedgerError if the ledger cannot be read.
    """
    free: list[OwnDraft] = []
    for number in range(1, MAX_DRAFTS + 1):
        suffix = "" if number == 1 else f" {number}"
        try:
            lock = hold(_lock_file(ledger, number))
        except FieldkitError:
            break
        if lock is not None:
            free.append(OwnDraft(DRAFT + suffix, STARTED_DRAFT + suffix, lock))
            if ledger.draft(free[-1].name) is not None:
                return _only(free[-1], free)
    return _only(free[0], free) if free else OwnDraft()


def _only(taken: OwnDraft, free: list[OwnDraft]) -> OwnDraft:
    """The taken draft; the locks of the others are released."""
    for one in free:
        if one is not taken:
            one.release()
    return taken


def _lock_file(ledger: Ledger, number: int) -> Path:
    """The lock of a draft of a ledger."""
    where = Path(ledger.name).resolve() if Path(ledger.name).exists() else ledger.name
    return data_file("drafts") / f"{hashlib.sha256(str(where).encode()).hexdigest()[:16]}-{number}.lock"
