"""The resources of the pages: the ledger, the motors, the settings. Each is opened by the first worker that needs it.

What opens it is imported there, not before the first paint: the ledger takes 0.14 s of processor time, the motors
0.08 s, and the answers of forms 0.25 s."""

from dataclasses import replace
from functools import cached_property
from pathlib import Path
from threading import RLock
from typing import TYPE_CHECKING, Any

from fieldkit.errors import FieldkitError
from fieldkit.paths import motor_folder
from fieldkit.settings import Settings, change_settings, read_settings

if TYPE_CHECKING:
    from fieldkit.ledger import Ledger
    from fieldkit.motors import Catalogue
    from fieldkit.services.one_offs import Comparisons
    from fieldkit.services.own_draft import OwnDraft
    from fieldkit.services.pickers import Names
IMPORTING = RLock()
"""Held while modules are imported or resources opened: a worker that imports a part of a package while another one
imports the package could find it half initialized."""


class Resources:
    """One flyer's resources. `choose` replaces `settings` as a whole."""

    def __init__(self, where: str | Path | None = None, settings_file: Path | None = None) -> None:
        self._where = where
        self._file = settings_file
        self.settings: Settings = read_settings(settings_file)
        self.complaints: list[FieldkitError] = []

    @property
    def where(self) -> str | Path | None:
        """The path or URL of the ledger, as given; None for the user's own."""
        return self._where

    @property
    def name(self) -> str:
        """The ledger's name without opening it."""
        return self._ledger.name if "_ledger" in self.__dict__ else str(self._where or "not opened yet")

    @property
    def ledger(self) -> "Ledger":
        """The ledger, opened once. Raises LedgerError."""
        with IMPORTING:
            return self._ledger

    @cached_property
    def _ledger(self) -> "Ledger":
        from fieldkit.ledger import Ledger

        return Ledger.open(self._where)

    @property
    def own_draft(self) -> "OwnDraft":
        """The draft of this app, apart from those of other open apps. Raises LedgerError."""
        with IMPORTING:
            return self._own_draft

    @cached_property
    def _own_draft(self) -> "OwnDraft":
        from fieldkit.services.own_draft import take_draft

        return take_draft(self._ledger)

    @property
    def motors(self) -> "Catalogue":
        """The known motors; `complaints` has the new errors in the flyer's files."""
        with IMPORTING:
            return self._motors

    @cached_property
    def _motors(self) -> "Catalogue":
        from fieldkit.motors.own import known_motors, unreported

        folder = motor_folder()
        motors, errors = known_motors(folder)
        self.complaints += unreported(errors, folder)
        return motors

    def names(self) -> "Names":
        """The answers that forms offer. Raises LedgerError if the ledger cannot be read."""
        with IMPORTING:
            from fieldkit.services.pickers import names_of

        return names_of(self.ledger, self.motors)

    @property
    def comparisons(self) -> "Comparisons":
        """The flights of rockets beside the others, for Home and the Loop page."""
        with IMPORTING:
            return self._comparisons

    @cached_property
    def _comparisons(self) -> "Comparisons":
        from fieldkit.services.one_offs import Comparisons

        return Comparisons()

    def forget_motors(self) -> None:
        """Read the motors again on their next use."""
        with IMPORTING:
            self.__dict__.pop("_motors", None)
            self.__dict__.pop("_comparisons", None)

    def choose(self, **changes: Any) -> None:
        """Change settings and save the changes, keeping those that another app has saved since. Raises FieldkitError if
        they cannot be saved; this app uses them anyway."""
        self.settings = replace(self.settings, **changes)
        self.settings = change_settings(changes, self._file)

    def close(self) -> None:
        """Close the ledger if it is open, and leave an unfinished flight to the next app."""
        with IMPORTING:
            if (draft := self.__dict__.pop("_own_draft", None)) is not None:
                draft.release()
            if "_ledger" in self.__dict__:
                self._ledger.close()
