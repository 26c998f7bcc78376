"""How well the logs of recorders are read: every readout against the truth, in standard deviations and in percent."""

import zlib
from collections.abc import Iterable, Iterator, Mapping
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
"""An error beyond such a part of the truth [1] is grave if it is beyond so many standard deviations [1]."""
LEAST = {"apogee_to_eject": 2.0, "eject_altitude": 20.0, "burn_time": 0.5}
"""Parts of a readout near zero are parts of so much. [SI]"""


@dataclass(frozen=True, slots=True)
class Miss:
    """One readout of one flight: how far it is from the truth, its standard deviation and the truth. [SI]"""

    recorder: str
    flight: int
    readout: str
    error: float
    sd: float
    truth: float

    @property
    def sds(self) -> float:
        """How many standard deviations it is off."""
        return self.error / self.sd if self.sd > 0 else np.inf

    @property
    def relative(self) -> float:
        """By which part of the truth it is off."""
        return abs(self.error) / max(abs(self.truth), LEAST.get(self.readout, 0.0))

    @property
    def grave(self) -> bool:
        """Whether it is far off and does not say so."""
        return self.relative > GROSS and abs(self.sds) > HONEST


def judged(name: str, recorder: Recorder, count: int, seed: int) -> tuple[list[Miss], list[str]]:
    """The readouts of some flights as one recorder has them, and what went wrong altogether."""
    rng = np.random.default_rng([seed, zlib.crc32(name.encode())])
    misses: list[Miss] = []
    wrong: list[str] = []
    for flight, path in enumerate(draw(rng, count, sonic=recorder.sonic, lean=float(np.radians(recorder.lean)))):
        try:
            right = path.readouts(barometric=recorder.baro > 0)
            misses += compared(name, flight, right, read(written(path, recorder, rng)))
        except FieldkitError as error:
            wrong.append(f"{name} {flight}: {error}")
    return misses, wrong


def read(log: bytes) -> Recorded:
    """What is measured in a log, as an import does it. Raises FieldkitError for one that is refused."""
    found = open_log(log, "log", None).found
    readings = [item for item in found if isinstance(item, Reading) and item.clocks]
    return measure(readings[0].clocks, readings[0].events) if readings else Recorded()


def compared(name: str, flight: int, right: Mapping[str, float], recorded: Recorded) -> Iterator[Miss]:
    """Each readout that was measured, beside the truth."""
    for readout, truth in right.items():
        figure = recorded.figures.get(readout)
        if figure is not None and readout in READOUTS:
            yield Miss(name, flight, readout, figure.value - truth, figure.sd, truth)


def table(misses: Iterable[Miss], flights: int) -> Iterator[str]:
    """Lines of a table: a row a recorder, and of each readout how many in a hundred lie within two deviations.

    A cell is `measured/within/grave`: how many flights of a hundred have it, and how many of these are within two
    standard deviations and how many are gravely off.
    """
    found = list(misses)
    yield "| recorder | " + " | ".join(READOUTS) + " |"
    yield "|---" * (len(READOUTS) + 1) + "|"
    names = list(dict.fromkeys(one.recorder for one in found))
    for name in names:
        own = [one for one in found if one.recorder == name]
        yield f"| {name} | " + " | ".join(_cell([m for m in own if m.readout == r], flights) for r in READOUTS) + " |"
    whole = flights * len(names)
    yield "| **all** | " + " | ".join(_cell([m for m in found if m.readout == r], whole) for r in READOUTS) + " |"


def _cell(misses: list[Miss], flights: int) -> str:
    if not misses:
        return "-"
    within = sum(abs(one.sds) <= 2 for one in misses) / len(misses)
    grave = sum(one.grave for one in misses)
    return f"{100 * len(misses) / flights:.0f}/{100 * within:.0f}/{grave}"
