"""A capture from a unit reads the same as the file from the vendor's program for the same memory."""

import json
import os
import re
from collections.abc import Sequence
from dataclasses import fields
from pathlib import Path

import numpy as np
import pytest

from fieldkit.capture import CaptureOptions, Ended, Port, PortOpened, capture, logs_in
from fieldkit.capture.protocols import altimulti, micropeak
from fieldkit.flight import Series
from fieldkit.importing import Reading
from fieldkit.importing.read import read_together
from fieldkit.importing.recognize import parser_for
from tests.capture import devices
from tests.capture.devices import Device, played
from tests.samples import any_motor

pytestmark = pytest.mark.skipif(not hasattr(os, "openpty"), reason="needs pseudo-terminals")
SAMPLES = Path(__file__).parents[2] / "sample_logs"


def sample(name: str) -> bytes:
    return (SAMPLES / name).read_bytes()


def bdureau_unit(log: bytes) -> Device:
    """An AltiMulti with the flights of a log."""
    pieces = [
        line.lstrip(b"$").rstrip(b";").rpartition(b",") for line in log.splitlines() if line.startswith(b"$data,")
    ]
    rows = [
        devices.sentence(*body.decode().split(","))
        for body, _, check in pieces
        if check == b"%d" % (sum(body + b",") % 256)
    ]
    numbers = dict.fromkeys(row.split(b",")[1] for row in rows)
    return devices.altimulti([[row for row in rows if row.split(b",")[1] == number] for number in numbers])


def altos_unit(log: bytes) -> Device:
    """A flight computer with the flash of a file in the new form."""
    end = log.index(b"}") + 1
    rows = [
        line.decode() if re.fullmatch(rb"(?:[0-9a-f]{2} ?){16}", line) else "ff" * 16
        for line in log[end:].split(b"\n")[1:]
    ]
    flash = bytes.fromhex("".join(rows)).rstrip(b"\xff")
    settings = {key.replace("_", "-"): value for key, value in json.loads(log[:end]).items()}
    count = -(-len(flash) // 256)
    memory = {0x20 + n: flash[256 * n :][:256].ljust(256, b"\xff") for n in range(count)}
    names = {"serial": "serial-number", "log-format": "log-format", "product": "product"}
    lines = [
        f"{names.get(key, key.replace('ms5607-', 'ms5607 '))}{': ' if 'ms5607' in key else ' '}{value}"
        for key, value in settings.items()
    ]
    identity = "\n".join(line for line in lines if "software" not in line) + "\nsoftware-version 1.9.18\n"
    return devices.altos(memory, [(settings["flight"], 0x20, 0x20 + count)], identity=identity.encode())


def blue_raven_unit(log: bytes) -> Device:
    lines = log.splitlines(keepends=True)
    return devices.blue_raven(
        [line for line in lines if b"LOG_HIR" not in line], [line for line in lines if b"LOG_HIR" in line]
    )


CASES = [
    ("micropeak", "micropeak__a_small_flight.mpd", devices.talking),
    ("altimulti", "bdureau__eight_bit_board_that_wraps.txt", bdureau_unit),
    ("altimulti", "bdureau__two_flights_and_telemetry_between.txt", bdureau_unit),
    ("altos", "altos_eeprom__easymini.eeprom", altos_unit),
    ("teledongle", "altos_telem__telemetrum_1.telem", lambda log: devices.teledongle(log.splitlines(keepends=True))),
    ("blue_raven", "blueraven_usb__low_and_high_rate.txt", blue_raven_unit),
    ("eggtimer", "eggtimer__trs_console_in_feet.txt", devices.talking),
    ("eggtimer", "eggtimer__classic.csv", devices.talking),
]


def readings(logs: Sequence[tuple[str, bytes]]) -> list[Reading]:
    found = [item for _, log in logs for item in parser_for(log).read(log)]
    return [item for item in found if isinstance(item, Reading)]


def same(one: Series, other: Series) -> bool:
    pairs = [(getattr(one, field.name), getattr(other, field.name)) for field in fields(Series)]
    return all((a is None) == (b is None) and (a is None or np.array_equal(a, b, equal_nan=True)) for a, b in pairs)


@pytest.mark.parametrize(("device", "name", "unit"), CASES, ids=[name for _, name, _ in CASES])
def test_a_captured_flight_is_the_flight_of_the_file(
    tmp_path: Path, device: str, name: str, unit: "type[Device]", monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(altimulti, "GREETING", 0.5)
    monkeypatch.setattr(micropeak, "TAIL", 0.3)
    with played(unit(sample(name))) as wire:  # type: ignore[call-arg]
        for event in capture(Port(wire.name), device, folder=tmp_path, wishes=CaptureOptions(wait=30, silence=0.6)):
            if isinstance(event, PortOpened):
                wire.opened.set()
    assert isinstance(event, Ended)
    assert event.whole
    logs = [(log.name, log.content) for log in logs_in(event.file)]
    expected, got = readings([(name, sample(name))]), readings(logs)
    assert len(got) == len(expected) >= 1
    for one, other in zip(got, expected, strict=True):
        assert len(one.clocks) == len(other.clocks)
        assert all(same(a, b) for a, b in zip(one.clocks, other.clocks, strict=True))
        assert one.events == other.events
        assert one.stated == other.stated
        assert one.serial == other.serial
    imported_files = read_together(logs, any_motor)
    assert sum(len(imported.flights) for imported in imported_files) == len(expected)
    assert not [row for imported in imported_files for row in imported.rejected]
