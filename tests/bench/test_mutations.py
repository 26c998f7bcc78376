"""The mutation bench: it notices a wrong readout, and a table that says the truth in other words is read."""

from dataclasses import replace

import numpy as np
import pytest

from bench.mutations import programs
from bench.mutations.__main__ import KINDS, Count, _judge, main
from bench.mutations.files import FILES
from bench.mutations.tables import Log, log_of, plain
from bench.recorders.flights import draw
from fieldkit.analysis.channels import heights
from fieldkit.errors import DamagedLog
from fieldkit.importing import Reading
from fieldkit.importing.recognize import open_log
from fieldkit.importing.tables.mapping import read_choice

pytestmark = pytest.mark.sampled


RIGHT = (
    "lines of a serial monitor",
    "lines of a serial monitor, the only clock",
    "lines of a terminal",
    "days of a spreadsheet",
    "minutes and seconds over an hour",
    "hours, minutes and seconds in one number",
    "the minus of a spreadsheet",
    "twelve empty columns",
    "the first barometer of two fails in the climb",
    "a barometer that fails in the climb",
    "a barometer that fails in the descent",
    "cut off in the coast, a barometer alone",
    "heights alone with points between thousands",
    "numbered packets, some lost",
    "heights zeroed when the flight is noticed",
    "a vacuum chamber before the flight",
    "heights held for ten rows",
    "a position without units that points down",
    "north, east and down without units",
    "a position in words that points down",
    "microseconds since the row before, without a unit",
    "steps beside a clock",
    "rows of the ESP32's library",
    "lines of the ESP32's library in color, with units",
    "lines of Arduino for the ESP32",
    "seconds in brackets before each line",
    "JSON lines with a date",
    "JSON of columns",
    "JSON of numbered columns",
    "JSON of names and rows",
    "a tracker in feet without a unit",
    "a tracker's elevation",
    "a track of a watch",
    "a magnitude without a unit",
    "a magnitude without gravity",
    "the time of the loop beside a clock",
    "two columns without names",
    "two columns without names, pressures",
    "zeros before a fix",
    "44 km before a reading",
    "an accelerometer behind a slow filter",
)
REFUSED = (
    "cut off in the boost",
    "cut off in the boost, a barometer alone",
    "milliseconds called seconds",
    "a tracker in feet by the name of meters",
    "pressures of 16 bits",
    "four columns without names",
)


OF_NO_FLIGHT = {
    "decimeters called meters": r"gravity before apogee implies to be in dm; write --map 'altitude=#2 \[dm\]'",
    "a clock in tenths of microseconds": "timestamp: found no unit, and nothing that implies one",
    "flights in columns": "found two columns for altitude that differ",
}
"""Tables of other programs that are refused, and what the message says."""


@pytest.fixture(scope="module")
def log() -> Log:
    (path,) = draw(np.random.default_rng(77), 1)
    return log_of(path, np.random.default_rng(1))


@pytest.mark.parametrize("kind", programs.KINDS)
def test_a_table_of_another_program_has_the_times_and_heights_of_its_flight(kind: str, log: Log) -> None:
    sheet = programs.KINDS[kind](log)
    choices = [read_choice(sheet.maps)] if sheet.maps else []
    if kind in OF_NO_FLIGHT:
        with pytest.raises(DamagedLog, match=f"log.csv.*{OF_NO_FLIGHT[kind]}"):
            open_log(sheet.text(), "log.csv", None, choices)
        return
    found = open_log(sheet.text(), "log.csv", None, choices).found
    (reading,) = [item for item in found if isinstance(item, Reading)]
    track = heights(reading.clocks)
    assert track is not None
    assert np.ptp(track.time) == pytest.approx(np.ptp(log.time), abs=0.3)
    assert track.height.max() - np.median(track.height[:5]) == pytest.approx(log.height.max(), abs=3.0)
    top = track.time[np.argmax(track.height)] - track.time[0]
    assert top == pytest.approx(log.time[np.argmax(log.height)] - log.time[0], abs=0.6)


def test_there_are_at_least_160_kinds_of_tables() -> None:
    assert len(KINDS) >= 160
    assert not KINDS.keys() & FILES.keys()


def test_a_table_of_another_flight_is_silently_wrong() -> None:
    (path,) = draw(np.random.default_rng(4), 1)
    log = log_of(path, np.random.default_rng(1))
    count = Count()
    _judge(count, "low", plain(replace(log, height=0.8 * log.height)).text(), (), path.readouts())
    _judge(count, "true", plain(log).text(), (), path.readouts())
    assert (len(count.wrong), count.right) == (1, 1)
    assert "low: " in count.wrong[0]


def test_feet_that_are_called_meters_are_refused(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["--flights", "2", "--only", "feet called meters"]) == 0
    out = capsys.readouterr().out
    assert "| feet called meters | 0 | 2 | 0 |" in out
    assert "| **4 variants** | 0 | 4 | 0 |" in out


@pytest.mark.parametrize("kind", [*RIGHT, *REFUSED])
def test_a_table_as_flyers_hand_it_on_is_read_or_refused(kind: str) -> None:
    (path,) = draw(np.random.default_rng(99), 1)
    sheet = KINDS[kind](log_of(path, np.random.default_rng(1)))
    count = Count()
    _judge(count, kind, sheet.text(), sheet.maps, (sheet.path or path).readouts())
    assert not count.wrong
    assert (count.right, count.refused) == ((1, 0) if kind in RIGHT else (0, 1))
