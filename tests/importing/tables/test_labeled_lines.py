"""Text of a serial monitor and JSON lines: the same flight as in a table, and no table is mistaken for them."""

import json
from collections.abc import Callable
from datetime import datetime, timedelta
from functools import cache

import numpy as np
import pytest

from fieldkit.errors import UnknownFormat
from fieldkit.importing import ColumnChoice, Reading
from fieldkit.importing.recognize import open_log
from fieldkit.importing.tables.labeled_lines import labeled_table
from tests.analysis.recordings import SMALL, Logger, fly, log

Line = Callable[[float, float, float], str]
START = datetime(2026, 5, 3, 13, 4, 5)


@cache
def samples() -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Times, heights and speeds of a small flight. [s], [m], [m/s]"""
    (series,) = log(fly(SMALL), Logger(start=0.0, wait=5.0), np.random.default_rng(4))
    height = np.asarray(series.altitude)
    return series.time, height, np.asarray(np.gradient(height, series.time))


def text_of(line: Line) -> bytes:
    return "".join(f"{line(*sample)}\n" for sample in zip(*samples(), strict=True)).encode()


def clock(time: float) -> str:
    return (START + timedelta(seconds=time)).strftime("%H:%M:%S.%f")[:-3]


LINES: dict[str, Line] = {
    "units": lambda t, h, v: f"Alt: {h:.2f} m, Vel: {v:.1f} m/s, Time: {1000 * t:.0f} ms",
    "units attached": lambda t, h, v: f"T={t:.2f}s | altitude={h:.2f}m | Temp=21.5C",
    "spaces": lambda t, h, v: f"time: {t:.2f} altitude: {h / 0.3048:.2f} ft Temp: 70.1 F state: BOOST",
    "decimal commas": lambda t, h, v: f"Zeit: {t:.2f} s; Höhe: {h:.2f} m".replace(".", ","),
    "units in labels": lambda t, h, v: f"millis: {1000 * t:.0f}\tAltitude (m): {h:.2f}\tState: COAST",
    "time before the line": lambda t, h, v: f"{clock(t)} -> Altitude: {h:.2f} m  Velocity: {v:.1f} m/s",
    "a value on each line": lambda t, h, v: f"Time: {t:.2f} s\r\nAltitude: {h:.2f} m\r\n\r",
    "JSON": lambda t, h, v: json.dumps({"time_ms": round(1000 * t), "altitude_m": round(h, 2), "state": "boost"}),
}


@pytest.mark.sampled
@pytest.mark.parametrize("line", LINES.values(), ids=list(LINES))
def test_labeled_values_are_read_like_a_table(line: Line) -> None:
    time, height, _ = samples()
    opened = open_log(text_of(line), "monitor.txt", None)
    (reading,) = [item for item in opened.found if isinstance(item, Reading)]
    (series,) = reading.clocks
    assert np.allclose(series.time - series.time[0], time - time[0], atol=0.006)
    assert series.altitude is not None
    assert np.allclose(series.altitude, height, atol=0.006)


def test_an_array_of_objects_is_read_like_lines() -> None:
    rows = [{"time_s": round(t, 3), "altitude_m": round(h, 2)} for t, h, _ in zip(*samples(), strict=True)]
    (reading,) = [item for item in open_log(json.dumps(rows).encode(), "a", None).found if isinstance(item, Reading)]
    assert reading.clocks[0].time.size == len(rows)


def test_labels_can_be_mapped() -> None:
    text = text_of(lambda t, h, v: f"time: {t:.2f} s, top: {h:.2f}")
    opened = open_log(text, "monitor.txt", None, [ColumnChoice({"altitude": "top [m]"})])
    (reading,) = [item for item in opened.found if isinstance(item, Reading)]
    assert np.allclose(np.asarray(reading.clocks[0].altitude), samples()[1], atol=0.006)


def test_labels_without_a_time_are_not_read() -> None:
    with pytest.raises(UnknownFormat):
        open_log(text_of(lambda t, h, v: f"Altitude = {h:.2f} m"), "monitor.txt", None)


def test_long_text_is_read_in_linear_time() -> None:
    assert labeled_table(b"a" * 2_000_000) is None
    assert labeled_table(b"a: 1 " * 400_000) is None
    assert labeled_table(b"a: " * 600_000) is None
