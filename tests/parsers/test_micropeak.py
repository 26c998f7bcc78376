"""MicroPeak: the transmission and its checksum."""

import struct

import pytest

from fieldkit.errors import DamagedLog
from fieldkit.importing import Note, Reading
from fieldkit.importing.recognize import parsers
from fieldkit.importing.tables.checksums import crc_x25

pytestmark = pytest.mark.fast

SMALL = "a0860100b8820100030096863c86b882"
WIDE = "a0860100b88201000320000096863c86b882"
WRAP = "4000010078ff000003003600dcff78ff"


def flights(log: bytes) -> list[Reading]:
    return [item for item in parsers()["micropeak"].read(log) if isinstance(item, Reading)]


@pytest.mark.parametrize(("payload", "crc", "step"), [(SMALL, "8027", 0.192), (WIDE, "872d", 0.1)])
def test_a_transmission_is_read_with_its_ground_and_minimum_pressure(payload: str, crc: str, step: float) -> None:
    (reading,) = flights(f"~junk MP\r\n{payload[:20]}\r\n{payload[20:]}\r\n{crc}\r\n".encode())
    (series,) = reading.clocks
    assert series.pressure is not None
    assert series.pressure.tolist() == [99990, 99900, 99000]
    assert series.time == pytest.approx([step, 2 * step, 3 * step])
    assert series.altitude is not None
    assert series.altitude[2] == pytest.approx(reading.stated["apogee"])
    assert reading.stated["apogee"] == pytest.approx(84.4, abs=0.2)  # by the standard atmosphere


def test_the_high_bits_of_a_sample_are_those_nearest_to_the_previous_one() -> None:
    (reading,) = flights(f"MP{WRAP}3901".encode())
    assert reading.clocks[0].pressure.tolist() == [65590, 65500, 65400]  # type: ignore[union-attr]


def test_a_wrong_checksum_loses_only_its_flight() -> None:
    found = parsers()["micropeak"].read(f"MP{SMALL}8026\r\nMP{WRAP}3901".encode())
    assert [type(item) for item in found] == [DamagedLog, Reading]
    with pytest.raises(DamagedLog, match="found checksum 8026, expected 8027"):
        parsers()["micropeak"].read(f"MP{SMALL}8026".encode())


def test_the_samples_of_a_truncated_transmission_are_kept() -> None:
    reading, note = parsers()["micropeak"].read(f"MP{SMALL[:-4]}".encode())
    assert isinstance(reading, Reading)
    assert len(reading.clocks[0].time) == 2
    assert isinstance(note, Note)


@pytest.mark.parametrize("complete", [True, False])
def test_a_line_that_a_terminal_saved_twice_is_read_once(complete: bool) -> None:
    """The checksum proves it; without one, a pressure that changes cannot repeat to the last digit."""
    samples = [*[100_000 % 65536] * 21, *(int(99_990 - 9 * step) % 65536 for step in range(100))]
    payload = struct.pack("<IIH", 100_000, 99_000, len(samples)) + struct.pack(f"<{len(samples)}H", *samples)
    lines = [payload[begin : begin + 16].hex() for begin in range(0, len(payload), 16)]
    lines = [*lines, f"{crc_x25(payload):04x}"] if complete else lines[:-2]
    right, twice = ("\r\n".join(["MP", *some]).encode() for some in (lines, [*lines[:9], *lines[8:]]))
    (usual, *_), (reading, *notes) = parsers()["micropeak"].read(right), parsers()["micropeak"].read(twice)
    assert isinstance(usual, Reading)
    assert isinstance(reading, Reading)
    assert reading.clocks[0].pressure == pytest.approx(usual.clocks[0].pressure)
    assert any(isinstance(note, Note) and note.text == "has 1 line twice, read once" for note in notes)


def test_a_log_without_a_checksum_ends_where_a_line_lost_its_end() -> None:
    """What follows is displaced: its bytes look like other pressures."""
    samples = [*[100_000 % 65536] * 21, *(int(99_990 - 9 * step) % 65536 for step in range(100))]
    payload = struct.pack("<IIH", 100_000, 99_000, 200) + struct.pack(f"<{len(samples)}H", *samples)
    lines = [payload[begin : begin + 16].hex() for begin in range(0, len(payload), 16)]
    lines[9] = lines[9][:11]
    (reading, *notes) = parsers()["micropeak"].read("\r\n".join(["MP", *lines]).encode())
    assert isinstance(reading, Reading)
    pressure = reading.clocks[0].pressure
    assert pressure is not None
    assert pressure == pytest.approx([*[100_000] * 21, *(99_990 - 9 * step for step in range(pressure.size - 21))])
    assert [note.text for note in notes if isinstance(note, Note)] == [
        "is cut off: 69 of 200 samples, without a checksum"
    ]


def test_erased_memory_is_neither_a_flight_nor_an_error() -> None:
    assert [type(item) for item in parsers()["micropeak"].read(b"MP" + b"f" * 64)] == [Note]
