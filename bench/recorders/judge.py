"""How well the logs of recorders are read: each readout compared with the truth, in standard deviations and percent."""

import zlib
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from bench.recorders.flights import draw
from bench.recorders.models import Recorder
from bench.recorders.record import written
from fieldkit.analysis import Recorded, measure
from fieldkit.errors import FieldkitError
from fieldkit.importing import Reading
from fieldkit.importing.recognize import open_log

READOUTS = (
    "apogee",
    "top_speed",
    "burn_time",
    "peak_accel",
    "avg_accel",
    "time_to_apogee",
    "coast_to_apogee",
    "apogee_to_eject",
    "eject_altitude",
    "descent_speed",
    "duration",
)
GROSS, HONEST = 0.05, 3.0
"""An error is severe if it exceeds this fraction of the truth [1] and this number of standard deviations [1]."""
MIN_DENOMINATORS = {"apogee_to_eject": 2.0, "eject_altitude": 20.0, "burn_time": 0.5}
"""Smallest denominators of relative errors, for readouts near zero. [SI]"""


@dataclass(frozen=True, slots=True)
class Miss:
    """The error of one readout of one flight, its standard deviation, and the truth. [SI]"""

    recorder: str
    flight: int
    readout: str
    error: float
    sd: float
    truth: float

    @property
    def sds(self) -> float:
        """The error in standard deviations."""
        return self.error / self.sd if self.sd > 0 else np.inf

    @property
    def relative(self) -> float:
        """The error as a fraction of the truth."""
        return abs(self.error) / max(abs(self.truth), MIN_DENOMINATORS.get(self.readout, 0.0))

    @property
    def relative_sd(self) -> float:
        """The standard deviation as a fraction of the truth."""
        return self.sd / max(abs(self.truth), MIN_DENOMINATORS.get(self.readout, 0.0))

    @property
    def grave(self) -> bool:
        """Whether the error is severe."""
        return bool(self.relative > GROSS and abs(self.sds) > HONEST)


def judged(name: str, recorder: Recorder, count: int, seed: int) -> tuple[list[Miss], list[str]]:
    """The readouts of some flights from one recorder, and the logs that failed completely."""
    rng = np.random.default_rng([seed, zlib.crc32(name.encode())])
    misses: list[Miss] = []
    wrong: list[str] = []
    for flight, path in enumerate(
        draw(rng, count, sonic=recorder.sonic, launch_angle=float(np.radians(recorder.launch_angle)))
    ):
        try:
            right = path.readouts(barometric=recorder.baro > 0)
            misses += compared(name, flight, right, read(written(path, recorder, rng)))
        except FieldkitError as error:
            wrong.append(f"{name} {flight}: {error}")
    return misses, wrong


def read(log: bytes) -> Recorded:
    """Measure a log as an import does. Raises FieldkitError if it is rejected."""
    found = open_log(log, "log", None).found
    readings = [item for item in found if isinstance(item, Reading) and item.clocks]
    return measure(readings[0].clocks, readings[0].events) if readings else Recorded()


def compared(name: str, flight: int, right: Mapping[str, float], recorded: Recorded) -> Iterator[Miss]:
    """Compare each measured readout with the truth."""
    for readout, truth in right.items():
        figure = recorded.figures.get(readout)
        if figure is not None and readout in READOUTS:
            yield Miss(name, flight, readout, float(figure.value - truth), float(figure.sd), float(truth))


@dataclass(frozen=True, slots=True)
class Cell:
    """One readout of one recorder: the number of flights, how many have it, how many are within two standard
    deviations, how many are severely off, and the median error and standard deviation as fractions of the truth. [1]"""

    flights: int
    measured: int
    within: int
    grave: int
    error: float
    sd: float

    def __str__(self) -> str:
        """`measured/within/grave`: percent of flights measured, percent of these within two sds, number of severe
        errors."""
        if not self.measured:
            return "-"
        return f"{100 * self.measured / self.flights:.0f}/{100 * self.within / self.measured:.0f}/{self.grave}"


def cells(misses: Sequence[Miss], flights: int) -> dict[str, Cell]:
    """Every readout of one recorder."""
    found = {}
    for readout in READOUTS:
        own = [one for one in misses if one.readout == readout]
        found[readout] = Cell(
            flights,
            len(own),
            int(sum(abs(one.sds) <= 2 for one in own)),
            int(sum(one.grave for one in own)),
            float(np.median([one.relative for one in own])) if own else 0.0,
            float(np.median([one.relative_sd for one in own])) if own else 0.0,
        )
    return found


def table(rows: Mapping[str, Mapping[str, Cell]]) -> Iterator[str]:
    """Lines of a table with one row per recorder: for each readout, the percentage within two standard deviations.

    A cell is `measured/within/grave`: the percentage of flights that have the readout, and among these the percentage
    within two standard deviations and the number of severe errors. Below are the totals, and the medians over recorders
    of the error and the standard deviation, in percent of the truth.
    """
    yield "| recorder | " + " | ".join(READOUTS) + " |"
    yield "|---" * (len(READOUTS) + 1) + "|"
    for name, row in rows.items():
        yield f"| {name} | " + " | ".join(str(row[readout]) for readout in READOUTS) + " |"
    columns = {readout: [row[readout] for row in rows.values()] for readout in READOUTS}
    yield "| **all** | " + " | ".join(str(_sum(column)) for column in columns.values()) + " |"
    for title, part in (("error, %", "error"), ("sd, %", "sd")):
        middle = (np.median([getattr(c, part) for c in column if c.measured] or [0.0]) for column in columns.values())
        yield f"| **{title}** | " + " | ".join(f"{100 * one:.2g}" for one in middle) + " |"


def _sum(column: Sequence[Cell]) -> Cell:
    flights, measured, within, grave = (
        sum(getattr(one, part) for one in column) for part in ("flights", "measured", "within", "grave")
    )
    return Cell(flights, measured, within, grave, 0.0, 0.0)
