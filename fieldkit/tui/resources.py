"""The resources of the pages: the ledger, the motors, the settings. Each is opened by the first worker that needs
it."""

from collections.abc import Sequence
from dataclasses import replace
from functools import cached_property
from importlib import import_module
from pathlib import Path
from threading import RLock
from typing import TYPE_CHECKING, Any

from fieldkit.errors import FieldkitError
from fieldkit.paths import motor_folder
from fieldkit.settings import Settings, change_settings, read_settings

if TYPE_CHECKING:
    from fieldkit.ledger import Ledger
    from fieldkit.motors import Catalogue
    from fieldkit.services.own_draft import OwnDraft
    from fieldkit.services.pickers import Names


FIRST_ROWS_ENGINE = ("fieldkit.services.listed_flights", "fieldkit.presentation.home_text")
"""Modules for reading the first rows, before their forecasts."""
LEDGER_ENGINE = (
    "fieldkit.ledger.ledger",
    "fieldkit.motors",
    "fieldkit.services.saved_forecasts",
    "fieldkit.services.launch_day",
    "fieldkit.presentation.home_text",
)
"""Modules for the first page's rows, which appear before the rest is imported."""
ENGINE = (
    *LEDGER_ENGINE,
    "fieldkit.services.imports",
    "fieldkit.services.forecasts",
    "fieldkit.services.pickers",
    "fieldkit.inference.network.field_ensemble",
    "fieldkit.planning.motor_guide",
    "fieldkit.tui.widgets.plots",
)
"""Modules for computing and drawing, imported by the first worker."""


class Resources:
    """One flyer's resources. `choose` replaces `settings` as a whole."""

    def __init__(self, where: str | Path | None = None, settings_file: Path | None = None) -> None:
        self._where = where
        self._file = settings_file
        self._lock = RLock()
        self.settings: Settings = read_settings(settings_file)
        self.complaints: list[FieldkitError] = []

    def import_engine(self, engine: Sequence[str] = ENGINE) -> None:
        """Import the modules of an engine, one worker at a time.

        Without the lock, a worker that imports a part of a package while another one imports the package could find it
        half initialized.
        """
        with self._lock:
            for name in engine:
                import_module(name)

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
        with self._lock:
            return self._ledger

    @cached_property
    def _ledger(self) -> "Ledger":
        from fieldkit.ledger import Ledger

        return Ledger.open(self._where)

    @property
    def own_draft(self) -> "OwnDraft":
        """The draft of this app, apart from those of other open apps. Raises LedgerError."""
        with self._lock:
            return self._own_draft

    @cached_property
    def _own_draft(self) -> "OwnDraft":
        from fieldkit.services.own_draft import take_draft

        return take_draft(self._ledger)

    @property
    def motors(self) -> "Catalogue":
        """The known motors; `complaints` has the errors in the flyer's files."""
        with self._lock:
            return self._motors

    @cached_property
    def _motors(self) -> "Catalogue":
        from fieldkit.motors.own import known_motors

        motors, errors = known_motors(motor_folder())
        self.complaints += errors
        return motors

    def names(self) -> "Names":
        """The answers that forms offer. Raises LedgerError if the ledger cannot be read."""
        self.import_engine()
        from fieldkit.services.pickers import names_of

        return names_of(self.ledger, self.motors)

    def forget_motors(self) -> None:
        """Read the motors again on their next use."""
        with self._lock:
            self.__dict__.pop("_motors", None)

    def choose(self, **changes: Any) -> None:
        """Change settings and save the changes, keeping those that another app has saved since. Raises FieldkitError if
        they cannot be saved; this app uses them anyway."""
        self.settings = replace(self.settings, **changes)
        self.settings = change_settings(changes, self._file)

    def close(self) -> None:
        """Close the ledger if it is open, and leave an unfinished flight to the next app."""
        with self._lock:
            if (draft := self.__dict__.pop("_own_draft", None)) is not None:
                draft.release()
            if "_ledger" in self.__dict__:
                self._ledger.close()
