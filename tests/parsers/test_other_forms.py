"""Other forms of known formats, which loggers write besides those of the sample logs: each reads like its sample."""

import re
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from fieldkit.flight import Series
from fieldkit.importing import Reading
from fieldkit.importing.recognize import claims, open_log, parsers

LOGS = Path(__file__).parents[2] / "sample_logs"


def clocks(log: bytes) -> list[Series]:
    """The samples of a log, by the parser that recognizes it."""
    return [clock for item in open_log(log, "log", None).found if isinstance(item, Reading) for clock in item.clocks]


def flights_among_settings(log: bytes) -> bytes:
    return log.replace(b"{\n", b'{\n  "flights": 3,\n', 1)


def oldest(log: bytes) -> bytes:
    """A flash as the first program wrote it: no format name, numbers padded with spaces."""
    lines = log.decode("ascii", "replace").splitlines()
    start = next(i for i, line in enumerate(lines) if line.startswith("Config version"))
    kept = [line for line in lines[start:] if not re.match(r"log-format|[~>]", line)]
    records = (re.fullmatch(r"([A-Z]) ([0-9a-f]+) ([0-9a-f]+) ([0-9a-f]+)", line) for line in kept)
    padded = [
        f"{m[1]} {int(m[2], 16):4x} {int(m[3], 16):4x} {int(m[4], 16):4x}" if m else line
        for line, m in zip(kept, records, strict=True)
    ]
    return ("\n".join(padded) + "\n").encode()


def commas_below_blanks(log: bytes) -> bytes:
    head, _, rest = log.partition(b"\n")
    return head + b"\n" + rest.replace(b" ", b",")


def all_commas(log: bytes) -> bytes:
    return log.replace(b" ", b",")


def underscores(log: bytes) -> bytes:
    return log.replace(b"filteredAltitudeAGL,filteredAcceleration", b"filtered_altitude_AGL,filtered_acceleration")


def underscores_for_spaces(log: bytes) -> bytes:
    names, rows = log.split(b"\n", 1)
    return names.replace(b" ", b"_") + b"\n" + rows


def named_sensors(log: bytes) -> bytes:
    return re.sub(rb"^([-\d.]+),(\d),", rb"\1,BARO\2,", log, flags=re.MULTILINE)


def with_a_column(log: bytes) -> bytes:
    """A table to which a program has added a column, from its line of names on."""
    text = log.decode("utf-8-sig").replace("\r", "")
    mark = max(",\t", key=text.count)
    lines = text.splitlines()
    start = next(i for i, line in enumerate(lines) if "time" in line.lower())
    ends = [mark + "note"] + [mark + "7"] * (len(lines) - start - 1)
    added = [*lines[:start], *(line + end for line, end in zip(lines[start:], ends, strict=True))]
    return ("\n".join(added) + "\n").encode()


def with_a_comment(log: bytes) -> bytes:
    return b"# from a spreadsheet\n" + log


@pytest.mark.parametrize(
    ("name", "change"),
    [
        ("perfectflite__drogue_and_main.pf2", with_a_column),
        ("perfectflite_table__tabs.txt", with_a_comment),
        ("raven_fip__edited_by_hand.csv", with_a_column),
        ("raven_fip__channels_that_end_early.csv", with_a_column),
        ("raven_fip__channels_that_end_early.csv", underscores_for_spaces),
        ("altos_eeprom__easymini.eeprom", flights_among_settings),
        ("altos_eeprom__telemetrum_2_with_damage.eeprom", flights_among_settings),
        ("altos_eeprom__telemetrum_1_among_commands.eeprom", oldest),
        ("arts2__interpreted.csv", commas_below_blanks),
        ("arts2__interpreted.csv", all_commas),
        ("cats__filtered_data_info.csv", underscores),
        ("cats__two_barometers.csv", named_sensors),
    ],
)
def test_another_form_reads_like_the_sample(name: str, change: Callable[[bytes], bytes]) -> None:
    log = (LOGS / name).read_bytes()
    other = change(log)
    assert other != log
    assert claims(other)[0] == name.partition("__")[0]
    for one, two in zip(clocks(log), clocks(other), strict=True):
        for channel in one.__slots__:
            np.testing.assert_array_equal(getattr(one, channel), getattr(two, channel), channel)


def test_cells_with_units_belong_to_a_table_of_numbers() -> None:
    log = with_a_column((LOGS / "perfectflite_table__tabs.txt").read_bytes())
    (reading,) = (item for item in open_log(log, "log", None).found if isinstance(item, Reading))
    assert claims(log) == ["mapped_table"]
    assert reading.clocks[0].altitude is not None


def test_a_column_and_its_copy_are_read_as_one() -> None:
    log = (LOGS / "mapped_table__milliseconds_and_no_unit_of_height.csv").read_text().splitlines()
    copied = "\n".join(f"{line},{line.split(',')[2]}" if line.count(",") > 1 else line for line in log)
    before, after = clocks("\n".join(log).encode()), clocks(copied.encode())
    np.testing.assert_array_equal(before[0].pressure, after[0].pressure)


@pytest.mark.parametrize("silence", [0.0, 90.0])
def test_a_charge_in_a_radio_gap_fired_at_an_unknown_time(silence: float) -> None:
    log = (LOGS / "altos_telem__telemetrum_1.telem").read_bytes()
    (whole,) = (item for item in parsers()["altos_telem"].read(log) if isinstance(item, Reading))
    assert "drogue" in whole.events
    gap = (whole.events["drogue"] - 1.0, whole.events["drogue"] + silence - 1.0)
    start = None
    lines = []
    for line in log.decode().splitlines():
        tick = int.from_bytes(bytes.fromhex(line.split()[1])[3:5], "little") / 100 if line.startswith("TELEM") else None
        start = tick if start is None else start
        since = None if tick is None or start is None else (tick - start) % 655.36 + float(whole.clocks[0].time[0])
        if since is None or not gap[0] < since < gap[1]:
            lines.append(line)
    (received,) = (
        item for item in parsers()["altos_telem"].read("\n".join(lines).encode()) if isinstance(item, Reading)
    )
    assert ("drogue" in received.events) is (silence == 0)
