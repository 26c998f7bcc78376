"""Sentences of a satellite receiver: the fixes are a log with heights above sea level."""

from datetime import datetime, timedelta

import numpy as np
import pytest

from fieldkit.analysis import measure
from fieldkit.importing import Reading
from fieldkit.importing.recognize import open_log
from tests.analysis.recordings import LARGE, Logger, fly, log

FIELD = 545.4
"""Height of the field above sea level. [m]"""
START = datetime(2026, 5, 3, 13, 4, 5)


def sentence(content: str) -> str:
    checksum = 0
    for character in content:
        checksum ^= ord(character)
    return f"${content}*{checksum:02X}"


def fix(time: float, height: float, quality: int = 1) -> str:
    clock = (START + timedelta(seconds=time)).strftime("%H%M%S.%f")[:9]
    return sentence(f"GPGGA,{clock},4807.038,N,01131.500,W,{quality},08,0.9,{height + FIELD:.1f},M,46.9,M,,")


def text(*, quality: int = 1, before: str = "") -> str:
    (series,) = log(fly(LARGE), Logger(start=0.0, wait=20.0, rate=5.0, noise=0.5), np.random.default_rng(4))
    rmc = sentence("GPRMC,130405.00,A,4807.038,N,01131.000,E,0.0,0.0,030526,,,A")
    pairs = zip(series.time, np.asarray(series.altitude), strict=True)
    return "".join(f"{before}{fix(time, height, quality)}\r\n{rmc}\r\n" for time, height in pairs)


@pytest.mark.parametrize("before", ["", "13:04:05.123 -> ", "[RX] "])
def test_fixes_are_read_as_a_log(before: str) -> None:
    (reading,) = [item for item in open_log(text(before=before).encode(), "a", None).found if isinstance(item, Reading)]
    (series,) = reading.clocks
    assert np.asarray(series.latitude)[0] == pytest.approx(48 + 7.038 / 60)
    assert np.asarray(series.longitude)[0] == pytest.approx(-11.525)
    apogee = measure(reading.clocks).figures["apogee"]
    assert apogee.source == "GPS altitude"
    assert abs(apogee.value - fly(LARGE).readouts()["apogee"]) < 3 * apogee.sd


def test_sentences_with_a_wrong_checksum_and_without_a_fix_are_left_out() -> None:
    lines = text().splitlines()
    lines[100] = lines[100].replace("546", "946").replace("545", "945")
    lines[200] = fix(0.0, 9000.0, quality=0)
    (reading,) = [item for item in open_log("\n".join(lines).encode(), "a", None).found if isinstance(item, Reading)]
    assert reading.clocks[0].time.size == len(lines) / 2 - 2
