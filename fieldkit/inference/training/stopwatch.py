"""The time of a training that may be interrupted."""

import time
from pathlib import Path

from fieldkit.files import read_own, replace


class Stopwatch:
    """Seconds spent on a resumable run: those of earlier runs, saved in a file, and those since it was made. [s]"""

    def __init__(self, file: Path) -> None:
        self._file, self._began = file, time.perf_counter()
        self._before = float(read_own(file)) if file.exists() else 0.0

    @property
    def seconds(self) -> float:
        """Seconds of all runs. [s]"""
        return self._before + time.perf_counter() - self._began

    def save(self) -> None:
        """Save the seconds so far. Raises FieldkitError."""
        self._file.parent.mkdir(parents=True, exist_ok=True)
        replace(self._file, f"{self.seconds:.1f}".encode())
