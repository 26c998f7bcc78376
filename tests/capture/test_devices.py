"""Every protocol with a unit that works, and with one that does not."""

import random
from collections.abc import Callable, Iterable, Sequence
from dataclasses import replace
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from fieldkit.capture import (
    Back,
    CaptureEvent,
    CaptureOptions,
    Ended,
    FlightsListed,
    Instruction,
    Lost,
    Port,
    PortOpened,
    Progress,
    Recognised,
    capture,
    known_devices,
    logs_in,
    read_capture,
    resume,
)
from fieldkit.capture.captured import Captured, TapeMark
from fieldkit.capture.protocols import altimulti, altos, blue_raven, mawd, micropeak, stratologger
from fieldkit.errors import PortTrouble
from tests.capture import devices
from tests.capture.devices import Wire, played
from tests.effort import examples

CHECK_SHAPES = False

pytestmark = pytest.mark.skipif(not hasattr(__import__("os"), "openpty"), reason="needs pseudo-terminals")

QUICK = CaptureOptions(wait=30, silence=30, reconnect=30)
BRIEF = replace(QUICK, silence=1.5)
LASTING = replace(QUICK, silence=8.0)
"""Timeout for a megabyte, which takes seconds on a busy machine."""
BOTH_RATES = replace(QUICK, silence=3.0)
"""Timeout for a unit whose two downloads each end in silence."""


@pytest.fixture(autouse=True)
def _answers_at_once(monkeypatch: pytest.MonkeyPatch) -> None:
    """No unit here takes long to wake up."""
    monkeypatch.setattr(altimulti, "GREETING", 0.2)
    monkeypatch.setattr(micropeak, "TAIL", 0.3)


@pytest.fixture
def impatient(monkeypatch: pytest.MonkeyPatch) -> None:
    """For units that stop in the middle or never start."""
    monkeypatch.setattr(altimulti, "ANSWER", 0.3)
    monkeypatch.setattr(altimulti, "GREETINGS", 2)
    monkeypatch.setattr(altos, "TRIES", 2)
    monkeypatch.setattr(mawd, "TRIES", 2)
    monkeypatch.setattr("fieldkit.capture.altus.ANSWER", 0.2)
    monkeypatch.setattr(mawd, "ANSWER", 0.3)
    monkeypatch.setattr(micropeak, "PAUSE", 0.5)


def run(events: Iterable[CaptureEvent], *wires: Wire) -> list[CaptureEvent]:
    """All events of a capture; units that send without being asked start when the port is open."""
    seen = []
    for event in events:
        seen.append(event)
        if isinstance(event, PortOpened):
            for wire in wires:
                wire.opened.set()
    return seen


def ended(events: Sequence[CaptureEvent]) -> Ended:
    last = events[-1]
    assert isinstance(last, Ended)
    return last


def text_of(events: Sequence[CaptureEvent]) -> str:
    return "\n".join(event.text for event in events if isinstance(event, Instruction))


def heard(
    wire: Wire,
    device: str | None,
    folder: Path,
    wishes: CaptureOptions = QUICK,
    stop: Callable[[], bool] = lambda: False,
) -> list[CaptureEvent]:
    return run(capture(Port(wire.name), device, folder=folder, wishes=wishes, stop=stop), wire)


def test_every_protocol_has_a_title_and_a_baud_rate() -> None:
    assert len(known_devices()) >= 8
    for name, protocol in known_devices().items():
        assert name == name.lower()
        assert protocol.title
        assert protocol.settings.baud in (9600, 19_200, 38_400, 115_200)


# --- MicroPeak

THREE = [(0, ""), (1, ""), (2, "0123456-07-89ABCDEF")]
PAYLOADS = [
    devices.micropeak_payload(100_000, 99_000, [99_990 - 5 * n for n in range(100)], model) for model, _ in THREE
]


@pytest.mark.parametrize(("payload", "model"), zip(PAYLOADS, THREE, strict=True), ids=["MicroPeak", "MicroKite", "2"])
def test_a_micropeak_is_read_through_noise_a_few_bytes_at_a_time(
    tmp_path: Path, payload: bytes, model: tuple[int, str]
) -> None:
    record = devices.micropeak_stream(payload, chip=model[1])
    with played(devices.talking(b"\x00\xfeM\x01" + record, random.Random(1))) as wire:
        end = ended(heard(wire, "micropeak", tmp_path))
    assert (end.whole, end.samples, end.damaged) == (True, 100, 0)
    (log,) = logs_in(end.file)
    assert log.content.strip() == record.strip()
    assert not wire.received


def test_a_micropeak_with_wrapping_pressures_and_a_long_flight_of_a_micropeak_2(tmp_path: Path) -> None:
    wraps = devices.micropeak_payload(65_600, 65_400, [65_590, 65_500, 65_400])
    assert wraps.hex() == "4000010078ff000003003600dcff78ff"
    long = devices.micropeak_payload(100_000, 99_000, [99_000 + n % 7 for n in range(5000)], 2)
    for payload, count in ((wraps, 3), (long, 5000)):
        with played(devices.talking(devices.micropeak_stream(payload))) as wire:
            end = ended(heard(wire, "micropeak", tmp_path))
        assert end.whole
        assert end.samples == pytest.approx(count, abs=2)
        assert logs_in(end.file)[0].content.strip() == devices.micropeak_stream(payload).strip()


def test_a_micropeak_with_a_wrong_checksum_can_be_switched_on_again(tmp_path: Path) -> None:
    wrong, right = devices.micropeak_stream(PAYLOADS[0], crc=0x1234), devices.micropeak_stream(PAYLOADS[0])
    with played(devices.talking(wrong + b"\x7f" + right)) as wire:
        events = heard(wire, "micropeak", tmp_path)
    assert "damaged; switch the unit off and on to receive it again" in text_of(events)
    assert ended(events).whole
    (log,) = logs_in(ended(events).file)
    assert log.content.strip() == right.strip()


def test_a_micropeak_that_was_never_flown_is_not_an_error(tmp_path: Path) -> None:
    with played(devices.talking(devices.micropeak_stream(b"\xff" * 10))) as wire:
        events = heard(wire, "micropeak", tmp_path)
    assert ended(events).whole
    assert "holds no flight" in text_of(events)


@pytest.mark.usefixtures("impatient")
def test_bytes_of_a_micropeak_that_stops_midway_for_good_are_kept(tmp_path: Path) -> None:
    half = devices.micropeak_stream(PAYLOADS[0])[:160]
    with played(devices.talking(half)) as wire:
        events = heard(wire, "micropeak", tmp_path, replace(QUICK, wait=1.5))
    assert "stopped in the middle" in text_of(events)
    assert not ended(events).whole
    assert read_capture(ended(events).file).raw == half
    assert logs_in(ended(events).file)[0].content == half


# --- AltiMulti

FLIGHTS = [devices.altimulti_data(0, 40), devices.altimulti_data(1, 1500), devices.altimulti_data(2, 30)]


def flown(content: bytes) -> list[bytes]:
    return [line + b"\n" for line in content.splitlines() if line.startswith(b"$data,")]


def test_all_flights_of_an_altimulti_are_read_between_telemetry_and_noise(tmp_path: Path) -> None:
    between = devices.TELEMETRY + b"\x00\x8f\n"
    short = [FLIGHTS[0], FLIGHTS[2]]
    device = devices.altimulti(short, dribble=random.Random(2), between=between, deaf=2)
    with played(device) as wire:
        events = heard(wire, "altimulti", tmp_path)
    end = ended(events)
    assert (end.whole, end.samples, end.damaged) == (True, 70, 0)
    assert end.about["model"] == "AltiMulti"
    (log,) = logs_in(end.file)
    assert flown(log.content) == short[0] + short[1]
    assert next(event for event in events if isinstance(event, FlightsListed)).chosen == (0, 1)
    seen = [event.sample for event in events if isinstance(event, Progress) and event.sample]
    assert seen[-1].altitude == 123
    assert seen[-1].state == "flying"


def test_a_chosen_flight_with_a_wrapping_clock_is_read_alone(tmp_path: Path) -> None:
    with played(devices.altimulti(FLIGHTS)) as wire:
        end = ended(heard(wire, "altimulti", tmp_path, replace(QUICK, choose=lambda flights: [1])))
    assert end.whole
    (log,) = logs_in(end.file)
    assert flown(log.content) == FLIGHTS[1]
    assert [one for one in wire.commands if one[:1] == b"r"] == [b"r1;"]


def test_a_flight_with_a_wrong_checksum_is_read_again(tmp_path: Path) -> None:
    with played(devices.altimulti(FLIGHTS[:1], spoil=1)) as wire:
        events = heard(wire, "altimulti", tmp_path)
    assert "flight 0: 1 sentence with a wrong checksum; reading it again" in text_of(events)
    assert ended(events).whole
    assert flown(logs_in(ended(events).file)[0].content) == FLIGHTS[0]


def test_a_flight_whose_checksum_never_matches_is_kept_as_received(tmp_path: Path) -> None:
    with played(devices.altimulti(FLIGHTS[:1], spoil=9)) as wire:
        events = heard(wire, "altimulti", tmp_path)
    assert not ended(events).whole
    assert len(flown(logs_in(ended(events).file)[0].content)) == len(FLIGHTS[0]) - 1


def test_telemetry_of_an_altimulti_is_followed_until_it_is_stopped(tmp_path: Path) -> None:
    enough: list[int] = []
    with played(devices.altimulti(FLIGHTS)) as wire:
        events = []
        wishes = replace(QUICK, live=True)
        for event in capture(Port(wire.name), "altimulti", folder=tmp_path, wishes=wishes, stop=lambda: bool(enough)):
            events.append(event)
            if isinstance(event, Progress) and event.samples > 20:
                enough.append(1)
        wire.listen(0.2)
    assert ended(events).why == "stopped"
    assert b"y0;" in wire.received
    assert b"$telemetry" in logs_in(ended(events).file)[0].content


def test_a_lost_altimulti_continues_on_another_port_with_the_missing_flights(tmp_path: Path) -> None:
    unit = Port("", 0x1A86, 0x7523, "A1")
    with played(devices.altimulti(FLIGHTS, unplug_after=10_000)) as first, played(devices.altimulti(FLIGHTS)) as second:
        events = run(
            capture(
                replace(unit, name=first.name),
                "altimulti",
                folder=tmp_path,
                wishes=QUICK,
                look=lambda: [Port("/dev/other"), replace(unit, name=second.name)],
            )
        )
    assert any(isinstance(event, Lost) for event in events)
    assert ended(events).whole
    assert flown(logs_in(ended(events).file)[0].content) == [row for flight in FLIGHTS for row in flight]
    assert [one for one in second.commands if one[:1] == b"r"] == [b"r1;", b"r2;"]


def test_a_capture_continues_on_another_day_but_not_with_another_unit(tmp_path: Path) -> None:
    with played(devices.altimulti(FLIGHTS, unplug_after=10_000)) as first:
        wishes = replace(QUICK, reconnect=0)
        end = ended(run(capture(Port(first.name), "altimulti", folder=tmp_path, wishes=wishes, look=list)))
    assert not end.whole
    assert "the port disappeared" in end.why
    with (
        played(devices.altimulti(FLIGHTS[:1])) as other,
        pytest.raises(PortTrouble, match="not the unit that was being captured"),
    ):
        run(resume(end.file, Port(other.name), wishes=QUICK))
    with played(devices.altimulti(FLIGHTS)) as again:
        end = ended(run(resume(end.file, Port(again.name), wishes=QUICK)))
    assert end.whole
    assert flown(logs_in(end.file)[0].content) == [row for flight in FLIGHTS for row in flight]


# --- AltOS


def altos_memory(blocks: int, start: int = 0x10) -> dict[int, bytes]:
    """Flash of a TeleMetrum: full records, the last block half erased."""
    rng = random.Random(5)
    records = [devices.altos_record(b"A", 65_500 + n, rng.randbytes(12)) for n in range(16 * blocks - 8)]
    flash = b"".join(records).ljust(256 * blocks, b"\xff")
    return {start + n: flash[256 * n : 256 * (n + 1)] for n in range(blocks)}


def test_an_altos_flight_is_read_block_by_block_up_to_erased_memory(tmp_path: Path) -> None:
    memory = altos_memory(6)
    device = devices.altos(memory, [(3, 0x10, 0x40), (4, 0x40, 0x41)], dribble=random.Random(3), spoil=[0x12])
    with played(device) as wire:
        events = heard(wire, "altos", tmp_path)
    end = ended(events)
    assert end.whole
    assert "block 12: 2 lines arrived incomplete; reading it again" in text_of(events)
    assert (end.about["serial"], end.about["firmware"]) == ("2094", "1.9.14")
    have = altos.blocks(read_capture(end.file))
    assert {number: have[number].content for number in memory} == memory
    asked = [one for one in wire.commands if one[:1] == b"e"]
    assert asked == [b"e %x\n" % n for n in (0x10, 0x11, 0x12, 0x12, 0x13, 0x14, 0x15, 0x16, 0x40)]


def test_pulling_an_altos_cable_loses_one_block_and_not_the_flight(tmp_path: Path) -> None:
    memory = altos_memory(5)
    wishes = replace(QUICK, reconnect=0)
    with played(devices.altos(memory, [(1, 0x10, 0x15)], unplug_at=0x13)) as wire:
        end = ended(run(capture(Port(wire.name), "altos", folder=tmp_path, wishes=wishes, look=list)))
    assert not end.whole
    stranger = devices.altos(memory, [(1, 0x10, 0x15)], identity=devices.IDENTITY.replace(b"2094", b"17"))
    with played(stranger) as other, pytest.raises(PortTrouble, match="serial number 17, expected 2094"):
        run(resume(end.file, Port(other.name), wishes=QUICK))
    with played(devices.altos(memory, [(1, 0x10, 0x15)])) as again:
        end = ended(run(resume(end.file, Port(again.name), wishes=QUICK)))
    assert end.whole
    assert [one for one in again.commands if one[:1] == b"e"] == [b"e 13\n", b"e 14\n"]
    have = altos.blocks(read_capture(end.file))
    assert {number: have[number].content for number in memory} == memory


# --- TeleDongle


def test_packets_of_a_teledongle_show_the_height_as_they_arrive(tmp_path: Path) -> None:
    packets = [devices.telem(devices.telem_sensor(65_530 + 10 * n, 30 * n, 55.5)) for n in range(30)]
    packets[4:4] = [
        devices.telem(devices.telem_sensor(1, 9999, 0), status=0x2F),
        b"CRC INVALID RSSI -80\n",
        b"TELEM 22\n",
    ]
    with played(devices.teledongle(packets, noise=b"")) as wire:
        wishes = replace(QUICK, frequency=434.65e6)
        stop = devices.arrived(tmp_path, devices.IDENTITY + b"".join(packets))
        events = heard(wire, "teledongle", tmp_path, wishes, stop)
        wire.listen(0.2)
    end = ended(events)
    assert (end.samples, end.damaged) == (30, 3)
    last = [event.sample for event in events if isinstance(event, Progress)][-1]
    assert last is not None
    assert (last.altitude, last.speed, last.state) == (870, 55.5, "boost")
    assert b"c F 434650\nm 20\n" in wire.received
    assert wire.received.endswith(b"m 0\n")
    assert logs_in(end.file)[0].content == b"".join(packets)


# --- Blue Raven

LOW = [
    devices.raven_frame("LOG_LOW", 600 + n * 0.02, f"Bo: 7712 {49_000 - n} V: 4012 Vel: {n} 0 0 Pos: {n} ang: 12 0 15")
    for n in range(60)
]
HIGH = [
    devices.raven_frame("LOG_HIR", 600 + n * 0.002, "gyro: 1 2 3 accel: 10 20 1000 q: 30000 0 0 0") for n in range(300)
]


def test_a_blue_raven_is_read_at_both_rates_while_its_status_continues(tmp_path: Path) -> None:
    status = devices.raven_frame("BLR_STAT", 1, "HG: 100 A: 0 0 1000 Bo: 9800")
    overprinted = LOW[20][:70] + LOW[21]
    low = [*LOW[:20], overprinted, *LOW[22:]]
    with played(devices.blue_raven(low, HIGH, status)) as wire:
        events = heard(wire, "blue_raven", tmp_path, BRIEF)
    end = ended(events)
    assert end.whole
    assert (end.samples, end.damaged) == (len(LOW) - 1 + len(HIGH), 0)
    assert wire.commands == [b"download l\r\n", b"download h\r\n"]
    (log,) = logs_in(end.file)
    frames = [blue_raven.frame(line) for line in log.content.splitlines()]
    kept = [one for one in frames if one and b"LOG_" in one]
    assert kept == [line.strip() for line in [*LOW[:20], *LOW[21:], *HIGH]]


def test_only_the_frame_with_a_wrong_checksum_is_lost(tmp_path: Path) -> None:
    low = [*LOW[:5], LOW[5].replace(b"Vel: 5", b"Vel: 6"), *LOW[6:]]
    with played(devices.blue_raven(low, [])) as wire:
        events = heard(wire, "blue_raven", tmp_path, BRIEF)
    assert (ended(events).samples, ended(events).damaged) == (len(LOW) - 1, 1)
    assert "no high-rate data" in text_of(events)


# --- PerfectFlite

HEIGHTS = [-2, 0, *(round(900 * (1 - (n / 100 - 1) ** 2)) for n in range(200)), 0]


@pytest.mark.usefixtures("impatient")
def test_a_mawd_is_asked_again_for_a_flight_that_stopped(tmp_path: Path) -> None:
    with played(devices.mawd(HEIGHTS, dribble=random.Random(4), cut=1)) as wire:
        events = heard(wire, "mawd", tmp_path)
    end = ended(events)
    assert end.whole
    assert "101 of 203 samples arrived; reading it again" in text_of(events)
    assert end.about == {"model": "PerfectFlite miniAlt/WD", "firmware": "Version 1.4"}
    assert set(wire.received) <= set(b"IVSD")


def test_lines_of_a_stratologger_are_stamped_with_their_arrival_times(tmp_path: Path) -> None:
    lines = b"812\r\n" + b"".join(b"%d\r\n" % height for height in (0, 1, 40, 160, 300, 290, 100, 0))
    lines = lines.replace(b"160\r\n", b"160\r\n4x0\r\n")
    with played(devices.talking(lines, pause=0.03)) as wire:
        events = heard(wire, "stratologger", tmp_path, stop=devices.arrived(tmp_path, lines))
    end = ended(events)
    assert (end.samples, end.damaged) == (9, 1)
    rows = logs_in(end.file)[0].content.decode().splitlines()
    assert rows[0] == stratologger.TITLE
    table = [row.split(",") for row in rows[rows.index("seconds,feet") + 1 :]]
    assert [feet for _, feet in table] == ["812", "0", "1", "40", "160", "", "300", "290", "100", "0"]
    times = [float(seconds) for seconds, _ in table]
    assert times == sorted(times)
    assert times[-1] - times[0] >= 0.2
    assert not wire.received


# --- Eggtimer

TRS = (
    b"Eggtimer TRS\r\nApogee 1204\r\n\r\nT,Alt,Veloc,FAlt,FVeloc,FVeloc2,LDA,LowV,Apogee,N-O,Drogue,Main\r\n"
    + b"".join(b"%d,%d,0,%d,0,0,0,0,0,0,0,0\r\n" % (n * 50, n * 12, n * 12) for n in range(100))
)


def test_the_text_of_an_eggtimer_is_kept_unchanged(tmp_path: Path) -> None:
    with played(devices.talking(TRS, random.Random(6))) as wire:
        end = ended(heard(wire, "eggtimer", tmp_path, BRIEF))
    assert (end.samples, end.why) == (100, "it went silent")
    assert logs_in(end.file)[0].content == TRS
    assert not wire.received


# --- A cable that is pulled in the middle, and the unit back on another port

RADIO = [devices.telem(devices.telem_sensor(65_530 + 10 * n, 30 * n, 55.5)) for n in range(30)]
FEET = [b"%d\r\n" % height for height in (812, 0, 1, 40, 160, 300, 290, 100, 0)]
REMEMBERED: list[tuple[str, Callable[[], devices.Device], int]] = [
    ("micropeak", lambda: devices.talking(devices.micropeak_stream(PAYLOADS[0]) * 2), 150),
    ("altimulti", lambda: devices.altimulti(FLIGHTS), 10_000),
    ("altos", lambda: devices.altos(altos_memory(5), [(1, 0x10, 0x15)]), 3000),
    ("mawd", lambda: devices.mawd(HEIGHTS), 700),
    ("blue_raven", lambda: devices.blue_raven(LOW, HIGH), len(b"".join(LOW)) // 2),
]
STREAMED: list[tuple[str, Callable[[list[bytes]], devices.Device], list[bytes]]] = [
    ("teledongle", devices.teledongle, RADIO),
    ("stratologger", lambda lines: devices.talking(b"".join(lines)), FEET),
    ("eggtimer", lambda lines: devices.talking(b"".join(lines)), TRS.splitlines(keepends=True)),
]


def pulled_and_back(
    device: str, first: Wire, second: Wire, folder: Path, stop: Callable[[], bool] = lambda: False
) -> Ended:
    """The end of a capture whose unit is lost on one wire and found on another."""
    unit, moved = Port(first.name, 0x1A86, 0x7523, "A1"), []
    look = [Port("/dev/other"), replace(unit, name=second.name)]
    for event in capture(unit, device, folder=folder, wishes=BRIEF, look=lambda: look, stop=stop):
        if isinstance(event, PortOpened):
            first.opened.set()
        elif isinstance(event, Back):
            second.opened.set()
            moved.append(event.port)
    assert isinstance(event, Ended)
    assert moved == [second.name]
    return event


@pytest.mark.parametrize(("device", "unit", "after"), REMEMBERED, ids=[one for one, *_ in REMEMBERED])
def test_a_memory_read_over_two_ports_equals_that_over_one(
    tmp_path: Path, device: str, unit: Callable[[], devices.Device], after: int
) -> None:
    with played(unit()) as wire:
        calm = ended(heard(wire, device, tmp_path, BRIEF))
    with played(devices.pulled(unit(), after)) as first, played(unit()) as second:
        end = pulled_and_back(device, first, second, tmp_path)
    assert calm.whole
    assert end.whole
    assert [log.content.strip() for log in logs_in(end.file)] == [log.content.strip() for log in logs_in(calm.file)]


@pytest.mark.parametrize(("device", "unit", "lines"), STREAMED, ids=[one for one, *_ in STREAMED])
def test_a_stream_over_two_ports_loses_only_the_interrupted_line(
    tmp_path: Path, device: str, unit: Callable[[list[bytes]], devices.Device], lines: list[bytes]
) -> None:
    half = len(lines) // 2
    identity = len(devices.IDENTITY) if device == "teledongle" else 0
    after = identity + len(b"".join(lines[:half])) + 2
    with played(devices.pulled(unit(lines[: half + 1]), after)) as first, played(unit(lines[half + 1 :])) as second:
        content = b"".join([*lines[:half], *lines[half + 1 :]]) + (identity + 1) * 2 * b"?"
        end = pulled_and_back(device, first, second, tmp_path, devices.arrived(tmp_path, content))
    (log,) = logs_in(end.file)
    kept = [line.rpartition(b",")[2] if device == "stratologger" else line for line in log.content.splitlines()]
    wanted = [line.strip() for line in [*lines[:half], *lines[half + 1 + (device != "teledongle") :]]]
    assert kept[kept.index(wanted[0]) :] == wanted


# --- A megabyte of nothing: noise, memory that was never written, blank lines

FLOOD = devices.noise(500_000).translate(None, b"0123456789") + b"\r\n" * 125_000 + bytes(275_000)
BABBLING = [*STREAMED, ("blue_raven", lambda low: devices.blue_raven(low, HIGH), LOW)]


@pytest.mark.sampled
@pytest.mark.parametrize("place", [0, 1], ids=["before", "within"])
@pytest.mark.parametrize(("device", "unit", "after"), REMEMBERED[:-1], ids=[one for one, *_ in REMEMBERED[:-1]])
def test_a_megabyte_of_noise_in_the_answers_does_not_change_the_memory_read(
    tmp_path: Path, device: str, unit: Callable[[], devices.Device], after: int, place: int
) -> None:
    with played(unit()) as wire:
        calm = ended(heard(wire, device, tmp_path, BRIEF))
    with played(devices.flooded(unit(), after * place, FLOOD + b"\r\n")) as wire:
        end = ended(heard(wire, device, tmp_path, LASTING))
    assert end.whole
    assert len(read_capture(end.file).raw) > 900_000  # opening a port drops what has arrived by then, up to its buffer
    for log, wanted in zip(logs_in(end.file), logs_in(calm.file), strict=True):
        lines = [line for line in wanted.content.splitlines() if line]
        assert [line for line in log.content.splitlines() if line in lines] == lines


@pytest.mark.sampled
@pytest.mark.parametrize(("device", "unit", "lines"), BABBLING, ids=[one for one, *_ in BABBLING])
def test_a_megabyte_of_noise_in_a_stream_loses_only_the_interrupted_line(
    tmp_path: Path, device: str, unit: Callable[[list[bytes]], devices.Device], lines: list[bytes]
) -> None:
    half = len(lines) // 2
    identity = devices.IDENTITY if device == "teledongle" else b""
    after = len(identity + b"".join(lines[:half])) + 2
    with played(devices.flooded(unit(lines), after, FLOOD)) as wire:
        stop = devices.arrived(tmp_path, identity + b"".join(lines) + FLOOD)
        both = device == "blue_raven"
        end = ended(heard(wire, device, tmp_path, BOTH_RATES if both else LASTING, (lambda: False) if both else stop))
    (log,) = logs_in(end.file)
    kept = [line.rpartition(b",")[2] if device == "stratologger" else line for line in log.content.splitlines()]
    wanted = [line.strip() for line in [*lines[:half], *lines[half + 1 :]] if line.strip()]
    assert [line for line in kept if line in wanted] == wanted
    assert len(read_capture(end.file).raw) > 1_000_000


# --- Units without a name


@pytest.mark.parametrize(
    ("device", "content"),
    [
        ("micropeak", b"\x01\x02" + devices.micropeak_stream(PAYLOADS[0])),
        ("eggtimer", TRS),
        ("stratologger", b"".join(b"%d\r\n" % n for n in range(0, 900, 3))),
        ("altimulti", devices.TELEMETRY * 20),
        ("teledongle", devices.telem(devices.telem_sensor(5, 100, 0)) * 20),
        ("blue_raven", devices.raven_frame("BLR_STAT", 1, "HG: 100 A: 0 0 1000 Bo: 9800") * 20),
    ],
    ids=lambda one: one if isinstance(one, str) else "",
)
def test_a_unit_that_sends_unprompted_is_recognized_and_no_byte_is_lost(
    tmp_path: Path, device: str, content: bytes
) -> None:
    seen = []
    with played(devices.talking(content)) as wire:
        for event in capture(Port(wire.name), folder=tmp_path, wishes=QUICK):
            wire.opened.set()
            seen.append(event)
            if isinstance(event, Recognised):
                break
        assert not wire.received
    assert seen[-1] == Recognised(device)
    (file,) = tmp_path.glob("*.raw")
    kept = read_capture(file)
    assert kept.device == device
    assert content.startswith(kept.raw)


def test_a_port_is_opened_again_at_the_rate_at_which_its_unit_was_recognized(tmp_path: Path) -> None:
    """At once after a loss, and in a later session."""
    unit, rate = Port("", 0x1A86, 0x7523, "A1"), 19_200
    lines, wishes = b"".join(b"%d\r\n" % n for n in range(0, 900, 3)), replace(QUICK, silence=0.5)
    with played(devices.at_rate(rate, lines)) as first, played(devices.talking(lines)) as second:

        def look() -> list[Port]:
            return [replace(unit, name=second.name)]

        events = []
        for event in capture(replace(unit, name=first.name), folder=tmp_path, wishes=wishes, look=look):
            first.opened.set()
            if isinstance(event, Back):
                second.opened.set()
            events.append(event)
        assert any(isinstance(event, Back) for event in events)
        assert second.baud == rate
    with played(devices.talking(lines)) as third:
        for _ in resume(ended(events).file, replace(unit, name=third.name), wishes=wishes):
            third.opened.set()
        assert third.baud == rate


@pytest.mark.usefixtures("impatient")
@pytest.mark.parametrize("device", [*known_devices(), None])
def test_a_unit_that_never_answers_is_reported_in_one_line_and_leaves_no_file(
    tmp_path: Path, device: str | None
) -> None:
    with played(devices.deaf) as wire, pytest.raises(PortTrouble) as trouble:
        heard(wire, device, tmp_path, replace(QUICK, wait=0.3, silence=0.2))
    assert str(trouble.value).startswith(wire.name)
    assert len(str(trouble.value).splitlines()) == 1
    assert not list(tmp_path.iterdir())


LINES = b"TELEM 22\r\n\r\n" * 50
CHATTER = [
    ("altimulti", devices.TELEMETRY * 20),
    ("altos", LINES),
    ("teledongle", devices.noise(2000)),
    ("mawd", LINES),
    ("blue_raven", devices.noise(2000)),
]


@pytest.mark.usefixtures("impatient")
@pytest.mark.parametrize(("device", "chatter"), CHATTER, ids=[device for device, _ in CHATTER])
def test_a_unit_that_sends_but_never_answers_is_given_up(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, device: str, chatter: bytes
) -> None:
    monkeypatch.setattr(altimulti, "GREETINGS", 1)
    for module in (altos, mawd):
        monkeypatch.setattr(module, "TRIES", 1)

    def chattering(wire: Wire) -> None:
        while True:
            wire.say(chatter)
            wire.listen(0.01)

    with played(chattering) as wire, pytest.raises(PortTrouble, match=wire.name):
        heard(wire, device, tmp_path, replace(QUICK, silence=0.2))
    (file,) = tmp_path.glob("*.raw")
    assert file.stat().st_size > 1000


@pytest.mark.parametrize("device", ["pnut", "RRC3", "aim", "walkie-talkie"])
def test_a_unit_that_cannot_be_captured_is_refused_with_an_alternative(tmp_path: Path, device: str) -> None:
    with pytest.raises(PortTrouble, match=r"not public|expected one of: altimulti"):
        list(capture(Port("/dev/null"), device, folder=tmp_path))


# --- Unlikely captures

WORDS = [
    *(b"$start;", b"$end;", devices.TELEMETRY, FLIGHTS[0][1], b"$data,0,1", b"MP", b"a0860100", b"f" * 30, b"\r\n"),
    *(b"flight 1 start 0 end 2\ndone\n", devices.IDENTITY, devices.SETTINGS, b"0 1 2 3 4 5 6 7 8\n", b"TELEM 22"),
    *(
        LOW[0],
        HIGH[0],
        LOW[0][:50],
        b"G00812\r\nA01204\r\n",
        b" 0012\r\n",
        b"812\r\n",
        b"T,Alt,Veloc\r\n",
        b"1,2,3\r\n",
    ),
]
ASKED = [
    "h;",
    "b;",
    "r0;",
    "r99999999999;",
    "v\n",
    "l\n",
    "e 0\n",
    "e ffffff\n",
    "download l\r\n",
    "I",
    "S",
    "D",
    "\xff",
]


@pytest.mark.parametrize("name", [*known_devices()])
@given(
    pieces=st.lists(st.tuples(st.sampled_from(ASKED), st.sampled_from(WORDS) | st.binary(max_size=30)), max_size=25),
    shift=st.integers(-40, 40),
)
@examples(20)
def test_extracting_logs_works_on_any_truncated_capture(name: str, pieces: list[tuple[str, bytes]], shift: int) -> None:
    raw, marks = b"", []
    for command, piece in pieces:
        marks.append(TapeMark(max(0, len(raw) + shift), float(len(raw)), {"sent": command}))
        raw += piece
    protocol = known_devices()[name]
    assert protocol.recognizes_stream(raw) in (True, False)
    for log in protocol.logs(Captured(Path("a.raw"), raw, tuple(marks))):
        assert log.content
    protocol.logs(Captured(Path("a.raw"), raw))
