"""Logs wrapped line by line by a mail program or a spreadsheet are read like the plain ones."""

from collections.abc import Callable

import numpy as np
import pytest

from fieldkit.flight import Series
from fieldkit.importing import Reading
from fieldkit.importing.recognize import open_log
from fieldkit.importing.tables.wrapped_lines import unwrapped
from tests.samples import SAMPLES

WRAPPED = [
    *(
        "altimetercloud__columns_first.csv",
        "altos_csv__a_barometer_alone.csv",
        "bdureau__eight_bit_board_that_wraps.txt",
    ),
    *("altos_eeprom__easymini.eeprom", "eggtimer__semicolons_in_metres.csv", "eggtimer__trs_console_in_feet.txt"),
    *("micropeak__a_small_flight.mpd", "openrocket__as_it_comes.csv", "perfectflite__drogue_and_main.pf2"),
]


def cited(log: str) -> str:
    return "".join(f"> {line}\n" for line in log.splitlines())


def quoted(log: str) -> str:
    return "".join('"' + line.replace('"', '""') + '"\r\n' for line in log.splitlines())


def monitored(log: str) -> str:
    return "".join(f"12:01:{place / 1000:06.3f} -> {line}\n" for place, line in enumerate(log.splitlines()))


def logged_by_a_terminal(log: str) -> str:
    return "".join(f"[9:01:02] {line}\n" for line in log.splitlines())


def clocks(log: bytes) -> list[Series]:
    return [clock for one in open_log(log, "log", None).found if isinstance(one, Reading) for clock in one.clocks]


@pytest.mark.parametrize("wrap", [cited, quoted, monitored, logged_by_a_terminal])
@pytest.mark.parametrize("name", WRAPPED)
def test_a_wrapped_log_has_the_samples_of_the_plain_one(name: str, wrap: Callable[[str], str]) -> None:
    plain = next(path for path in SAMPLES if path.name == name).read_bytes()
    expected, got = clocks(plain), clocks(wrap(plain.decode("latin-1")).encode("latin-1"))
    assert len(expected) == len(got) >= 1
    for one, other in zip(expected, got, strict=True):
        for channel in one.__slots__:
            np.testing.assert_array_equal(getattr(other, channel), getattr(one, channel), channel)


def test_the_time_before_each_line_is_the_clock_of_a_table_without_one() -> None:
    lines = ["altitude (m),acceleration (g)", *(f"{place},1.0" for place in range(50))]
    (series,) = clocks("".join(f"12:00:{place:06.3f} -> {line}\n" for place, line in enumerate(lines)).encode())
    assert series.altitude is not None
    np.testing.assert_allclose(np.diff(series.time), 1.0)
    np.testing.assert_array_equal(series.altitude, np.arange(50))


@pytest.mark.parametrize("log", [b"", b"> 1,2", b'"a","b"\n"1","2"\n', b"> a\nb\n", b'"a,b"\n1,2\n'])
def test_a_log_with_an_unwrapped_line_is_not_changed(log: bytes) -> None:
    assert unwrapped(log) == log
