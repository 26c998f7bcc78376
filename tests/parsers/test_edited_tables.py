"""Logs edited by a spreadsheet or a script: other columns, another order, numbers as people write them."""

import re
from collections.abc import Callable, Sequence
from inspect import getmodule

import numpy as np
import pytest

from fieldkit.errors import DamagedLog
from fieldkit.flight import Series
from fieldkit.importing import Reading
from fieldkit.importing.recognize import claims, parser_for, parsers
from fieldkit.importing.tables.columns import Channel, read_columns
from tests.samples import SAMPLES

Edit = Callable[[list[str], int], list[str]]
CHANNELS = (Channel("time", 0, needed=True), Channel("altitude", 1, header="Alt"))


def text(name: str) -> str:
    (sample,) = (one for one in SAMPLES if one.name.startswith(name))
    log = sample.read_bytes()
    return log.decode("utf-16" if log[1:2] == b"\xfe" else "utf-8-sig").replace("\r\n", "\n")


def clocks(log: bytes, parser: str) -> list[Series]:
    return [clock for one in parsers()[parser].read(log) if isinstance(one, Reading) for clock in one.clocks]


def edited(log: str, edit: Edit) -> bytes:
    """A table below its header with the cells of each line edited."""
    lines = log.rstrip("\n").split("\n")
    separator = max(",;\t", key=lines[-2].count)
    start = next(i for i, line in enumerate(lines) if line.count(separator) >= 3)
    rows = [separator.join(edit(line.split(separator), i)) for i, line in enumerate(lines[start:])]
    return "\n".join([*lines[:start], *rows, ""]).encode()


def numbered(cells: list[str], row: int) -> list[str]:
    """A table with the row numbers that a saved data frame has, below an empty name."""
    return ["" if row == 0 else str(row), *cells]


def remarked(cells: list[str], row: int) -> list[str]:
    return [cells[0], "" if row else "remark", *cells[1:]]


def backward(cells: list[str], row: int) -> list[str]:
    return cells[::-1]


NUMBERED = ("aim_xtra", "altimetercloud__columns", "altos_csv__with", "blueraven_app__low", "cats__flight", "cats__two",
            "eggtimer__classic", "eggtimer__semicolons", "featherweight_gps__ground", "micropeak_csv",
            "raven_fip__edited", "rrc3__feet", "rrc3__utf16")  # fmt: skip
REMARKED = tuple(name for name in NUMBERED if not name.startswith(("aim_xtra", "raven")))
BACKWARD = tuple(name for name in REMARKED if not name.startswith("altos"))
EDITS = [*((name, numbered) for name in (*NUMBERED, "raven_fip__channels")), *((name, remarked) for name in REMARKED),
         *((name, backward) for name in BACKWARD)]  # fmt: skip


@pytest.mark.parametrize(("name", "edit"), EDITS, ids=[f"{edit.__name__} {name}" for name, edit in EDITS])
def test_columns_are_found_by_their_names(name: str, edit: Edit) -> None:
    plain, parser = text(name), name.partition("__")[0]
    log = edited(plain, edit)
    assert claims(log) == [parser]
    expected, got = clocks(plain.encode(), parser), clocks(log, parser)
    assert len(expected) == len(got) >= 1
    for one, other in zip(expected, got, strict=True):
        for channel in one.__slots__:
            np.testing.assert_array_equal(getattr(other, channel), getattr(one, channel), channel)


@pytest.mark.parametrize("order", [(0, 2, 1, 3, 4), (1, 0, 4, 3, 2), (4, 1, 0, 2, 3)])
def test_the_columns_of_a_pf2_are_those_in_its_header(order: Sequence[int]) -> None:
    plain = text("perfectflite__drogue_and_main")
    names = ["Time", "Altitude", "Velocity", "Temperature (F)", "Voltage"]
    lines = [
        f"Data: ({', '.join(names[i] for i in order)})" if line.startswith("Data:") else line
        for line in plain.splitlines()
    ]
    lines = [", ".join(line.split(", ")[i] for i in order) if re.match(r"[\d.]+, ", line) else line for line in lines]
    (expected,), (got,) = (
        clocks(plain.encode(), "perfectflite"),
        clocks("\n".join([*lines, ""]).encode(), "perfectflite"),
    )
    np.testing.assert_array_equal(got.altitude, expected.altitude)
    np.testing.assert_array_equal(got.voltage, expected.voltage)


def test_a_pf2_with_one_more_column_has_the_same_heights() -> None:
    plain = text("perfectflite__drogue_and_main")
    lines = [re.sub(r"^([\d.]+|Data: \(Time),", r"\1, 7,", line) for line in plain.splitlines()]
    lines = [line.replace("Time, 7,", "Time, Row,") for line in lines]
    (expected,), (got,) = (
        clocks(plain.encode(), "perfectflite"),
        clocks("\n".join([*lines, ""]).encode(), "perfectflite"),
    )
    np.testing.assert_array_equal(got.altitude, expected.altitude)


def test_an_empty_name_before_a_clock_is_not_a_comment_of_a_simulation() -> None:
    log = edited(text("mapped_table__time_three_axes"), numbered)
    assert claims(log) == ["mapped_table"]


def test_rows_of_an_aim_xtra_may_end_at_their_last_number() -> None:
    plain = text("aim_xtra")
    log = "\n".join(line.rstrip(",") for line in plain.splitlines()) + "\n"
    for one, other in zip(clocks(plain.encode(), "aim_xtra"), clocks(log.encode(), "aim_xtra"), strict=True):
        np.testing.assert_array_equal(other.time, one.time)


def test_an_eggtimer_log_with_two_byte_order_marks_is_read() -> None:
    assert parser_for(b"\xef\xbb\xbf" * 2 + text("eggtimer__classic").encode()).title == "Eggtimer"
    assert clocks(b"\xef\xbb\xbf" * 2 + text("eggtimer__classic").encode(), "eggtimer")


@pytest.mark.parametrize(
    ("separator", "rows"),
    [
        (",", ['0.05,"998.5"', '0.1,"1,002.5"', '0.15,"-1,234,567"']),
        (",", ['"0,05","998,5"', '"0,1","1.002,5"', '"0,15","-1.234.567"']),
        (";", ["0,05;998,5", "0,1;1.002,5", "0,15;-1.234.567"]),
        ("\t", ["0.05\t998.5", "0.1\t1,002.5", "0.15\t-1,234,567"]),
    ],
)
def test_thousands_may_be_separated_as_in_a_spreadsheet(separator: str, rows: Sequence[str]) -> None:
    table = read_columns("\n".join([*rows, ""]).encode(), CHANNELS, after=0, separator=separator)
    assert table.values["time"].tolist() == [0.05, 0.1, 0.15]
    assert table.values["altitude"].tolist() == [998.5, 1002.5, -1234567]
    assert not table.found


def test_whole_thousands_beside_decimal_commas_are_thousands() -> None:
    table = read_columns(b"0,05;998\n0,1;1.002\n", CHANNELS, after=0, separator=";")
    assert table.values["altitude"].tolist() == [998, 1002]


@pytest.mark.parametrize(
    ("heights", "read"),
    [
        (["998", "999", "997", "1.002", "1.250", "1.249", "1.000"], [998, 999, 997, 1002, 1250, 1249, 1000]),
        (["998", "999", "997", "1.002", "1.25", "1.249", "1.001"], [998, 999, 997, 1.002, 1.25, 1.249, 1.001]),
        (["998.000", "0.999", "1.002", "1.250"], [998, 0.999, 1.002, 1.25]),
        (["998", "999", "997", "1002", "1.002", "1.250", "1.249"], [998, 999, 997, 1002, 1.002, 1.25, 1.249]),
    ],
)
def test_points_separate_thousands_where_only_whole_numbers_below_a_thousand_lack_them(
    heights: Sequence[str], read: Sequence[float]
) -> None:
    log = "".join(f"{50 * place};{height}\n" for place, height in enumerate(heights))
    table = read_columns(log.encode(), CHANNELS, after=0, separator=";", decimal=".")
    assert table.values["altitude"].tolist() == read


def test_a_cell_in_quotation_marks_may_contain_the_separator() -> None:
    log = b'0.5,"windy, cold",10\n1.5,calm,20\n'
    table = read_columns(log, (CHANNELS[0], Channel("altitude", 2)), after=0, widths={3})
    assert table.values["altitude"].tolist() == [10, 20]
    assert not table.found


def test_a_column_in_which_a_comma_means_two_things_is_refused() -> None:
    rows = [f"{i / 20};{text}" for i, text in enumerate(["0,512", "1,002", "2,250"])]
    with pytest.raises(DamagedLog, match="found '1,002' in a column with other decimal marks"):
        read_columns(
            "\n".join([*(f"{i};1.25" for i in range(5)), *rows, ""]).encode(), CHANNELS, after=0, separator=";"
        )


def counted(milliseconds: Sequence[int]) -> bytes:
    flights, rows_of_flight = np.divmod(np.arange(len(milliseconds)), 1230)
    heights = np.maximum(0, 30 * rows_of_flight / 20 - 4.9 * (rows_of_flight / 20) ** 2) / (1 + flights)
    rows = [f"{time},{height:.2f}" for time, height in zip(milliseconds, heights, strict=True)]
    return "\n".join(["time_ms,altitude_m", *rows, ""]).encode()


def test_a_second_flight_within_the_range_of_a_counter_is_not_an_overflow() -> None:
    steps = [50 * i for i in range(1230)]
    assert [one.time[-1] for one in clocks(counted(steps + steps), "mapped_table")] == pytest.approx([61.45, 61.45])
    (whole,) = clocks(counted([(50_000 + step) % 65_536 for step in steps]), "mapped_table")
    assert np.ptp(whole.time) == pytest.approx(61.45)


def test_an_impossible_first_time_loses_only_its_row() -> None:
    rows = [f"{1_700_000_000 + i / 20:.2f},{max(0, i - 20)}" for i in range(100)]
    log = "\n".join(["timestamp_s,altitude_m", "99999999999999,0", *rows, ""]).encode()
    (reading,) = (one for one in parsers()["mapped_table"].read(log) if isinstance(one, Reading))
    assert reading.extra["log_started_utc"] == "2023-11-14T22:13:20Z"
    assert np.ptp(reading.clocks[0].time) == pytest.approx(4.95)


def test_repeated_starts_of_a_micropeak_without_a_header_are_read_in_linear_time() -> None:
    start: re.Pattern[bytes] = vars(getmodule(parsers()["micropeak"].read))["START"]
    assert not list(start.finditer(b"MP0 " * 5000))
    assert len(list(start.finditer(b"MP0 MPa0860100b88201000300"))) == 1
