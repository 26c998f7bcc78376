"""What the pages work on: the ledger, the motors, the settings. Opened when first asked for, by whichever worker."""

from collections.abc import Sequence
from dataclasses import replace
from functools import cached_property
from importlib import import_module
from pathlib import Path
from threading import RLock
from typing import TYPE_CHECKING, Any

from fieldkit.errors import FieldkitError
from fieldkit.settings import Settings, change_settings, read_settings

if TYPE_CHECKING:
    from fieldkit.ledger import Ledger
    from fieldkit.motors import Catalogue
    from fieldkit.services.pickers import Names


FIRST_ROWS_ENGINE = ("fieldkit.ledger", "fieldkit.services.launch_day", "fieldkit.presentation.home_text")
"""What the first rows are read with, before their forecasts."""
LEDGER_ENGINE = (
    "fieldkit.ledger",
    "fieldkit.motors",
    "fieldkit.services.saved_forecasts",
    "fieldkit.services.launch_day",
    "fieldkit.presentation.home_text",
)
"""What the first page reads the ledger with: its rows come before the rest is imported."""
ENGINE = (
    *LEDGER_ENGINE,
    "fieldkit.services.imports",
    "fieldkit.services.forecasts",
    "fieldkit.services.pickers",
    "fieldkit.inference.network.field_ensemble",
    "fieldkit.planning.motor_guide",
    "fieldkit.tui.widgets.plots",
)
"""What pages work and draw with, imported by the first worker."""


class Resources:
    """One flyer's things. `settings` is replaced as a whole by `choose`."""

    def __init__(self, where: str | Path | None = None, settings_file: Path | None = None) -> None:
        self._where = where
        self._file = settings_file
        self._lock = RLock()
        self.settings: Settings = read_settings(settings_file)
        self.complaints: list[FieldkitError] = []

    def import_engine(self, engine: Sequence[str] = ENGINE) -> None:
        """Import the modules of an engine, one worker at a time.

        A worker that imports a part of a package, while another is in the midst of the package itself, is let through
        by Python and finds it half there.
        """
        with self._lock:
            for name in engine:
                import_module(name)

    @property
    def name(self) -> str:
        """The ledger's name, as far as it is known without opening it."""
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
    def motors(self) -> "Catalogue":
        """The motors known here; `complaints` holds what was wrong with the flyer's own files."""
        with self._lock:
            return self._motors

    @cached_property
    def _motors(self) -> "Catalogue":
        from fieldkit.motors.own import known_motors
        from fieldkit.paths import motor_folder

        motors, errors = known_motors(motor_folder())
        self.complaints += errors
        return motors

    def names(self) -> "Names":
        """What can be picked as an answer in a form. Raises LedgerError."""
        self.import_engine()
        from fieldkit.services.pickers import names_of

        return names_of(self.ledger, self.motors)

    def forget_motors(self) -> None:
        """Read the motors again when they are next asked for."""
        with self._lock:
            self.__dict__.pop("_motors", None)

    def choose(self, **changes: Any) -> None:
        """Change settings and keep what was changed, beside what another app has kept since. Raises FieldkitError if
        it cannot be kept."""
        self.settings = replace(self.settings, **changes)
        self.settings = change_settings(changes, self._file)

    def close(self) -> None:
        """Let go of the ledger, if it was opened."""
        with self._lock:
            if "_ledger" in self.__dict__:
                self._ledger.close()
