"""Captured bytes are saved whatever happens to the cable, the program, the disk or the parser, and are imported."""

import errno
import os
import re
import signal
import subprocess
import sys
import time
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from dataclasses import replace
from importlib import import_module
from io import StringIO
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from fieldkit.capture import (
    Back,
    CaptureEvent,
    CaptureOptions,
    Ended,
    Instruction,
    Port,
    PortOpened,
    Progress,
    Sample,
    capture,
    captures,
    logs_in,
    read_capture,
    resume,
    unfinished,
)
from fieldkit.capture.line import PortSettings, open_line
from fieldkit.capture.port import again
from fieldkit.capture.tape import JOURNAL, _new, begin, go_on
from fieldkit.cli.capture import View
from fieldkit.cli.main import main
from fieldkit.errors import CaptureTrouble, PortLost, PortTrouble
from fieldkit.importing.tables.checksums import crc_buypass, crc_x25, sum_256
from tests.capture import devices
from tests.capture.devices import Device, Unplugged, Wire, played
from tests.commands import Run
from tests.effort import examples

pytestmark = pytest.mark.fast

ROOT = Path(__file__).parents[2]
terminals = pytest.mark.skipif(not hasattr(os, "openpty"), reason="needs pseudo-terminals")


@pytest.fixture(autouse=True)
def _home(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("FIELDKIT_HOME", str(tmp_path / "home"))
    monkeypatch.setenv("COLUMNS", "80")
    monkeypatch.setenv("FIELDKIT_LEDGER", str(tmp_path / "ledger.db"))


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    """The folder of the flyer's captures."""
    return tmp_path / "home" / "captures"


def test_checksums_agree_with_the_manufacturers() -> None:
    assert crc_x25(b"123456789") == 0x906E
    assert crc_buypass(b"123456789") == 0xFEE8
    assert sum_256(b"testTrame,Bear altimeters are the best!!!!,") == 240
    assert sum_256(b"data,0,50,12,21,100873,") == 48
    assert sum_256(b"nbrOfFlight,3,") == 224


def followed(events: Iterable[CaptureEvent], wire: Wire) -> Ended:
    """How a capture ended; a unit that sends without being asked starts when its port is open."""
    for event in events:
        if isinstance(event, PortOpened):
            wire.opened.set()
    assert isinstance(event, Ended)
    return event


# --- The tape


@given(chunks=st.lists(st.binary(max_size=50)), cut=st.floats(0, 1), torn=st.floats(0, 1))
@examples(15)
def test_a_capture_truncated_anywhere_is_read_up_to_there_and_continued(
    tmp_path_factory: pytest.TempPathFactory, chunks: list[bytes], cut: float, torn: float
) -> None:
    with begin(tmp_path_factory.mktemp("c"), {"device": "eggtimer"}) as tape:
        for chunk in chunks:
            tape.note(sent="h;")
            tape.heard(chunk)
    content = b"".join(chunks)
    whole = read_capture(tape.file)
    assert whole.raw == content
    assert b"".join(answer.content for answer in whole.answers()) == content
    assert [answer.content for answer in whole.answers()[1:]] == chunks
    times = whole.received_at(range(len(content)))
    assert times == sorted(times)
    journal = tape.file.with_suffix(JOURNAL)
    head = len(journal.read_bytes().splitlines()[0]) + 1
    os.truncate(tape.file, round(cut * len(content)))
    os.truncate(journal, head + round(torn * (journal.stat().st_size - head)))
    kept = read_capture(tape.file)
    assert content.startswith(kept.raw)
    assert b"".join(answer.content for answer in kept.answers()) == kept.raw
    assert kept.began is not None
    with go_on(tape.file, kept.began) as more:
        more.note(sent="n;")
        more.heard(b"more")
    after = read_capture(tape.file)
    assert after.raw == kept.raw + b"more"
    assert after.answers()[-1].content == b"more"


def test_a_capture_without_the_start_of_its_journal_still_yields_its_flights(tmp_path: Path) -> None:
    record = devices.micropeak_stream(devices.micropeak_payload(100_000, 99_000, range(99_000, 99_100)))
    with begin(tmp_path, {"device": "micropeak"}) as tape:
        tape.heard(b"junk" + record)
    tape.file.with_suffix(JOURNAL).write_bytes(b'{"at": 0, "t": 0')
    assert [log.content.strip() for log in logs_in(tape.file)] == [record.strip()]
    with pytest.raises(CaptureTrouble, match="its journal is damaged"):
        next(resume(tape.file, Port("port")))


def test_two_captures_in_the_same_second_get_different_files(tmp_path: Path) -> None:
    with begin(tmp_path, {}) as one, begin(tmp_path, {}) as two:
        one.heard(b"one")
        two.heard(b"two")
    assert {read_capture(file).raw for file in captures(tmp_path)} == {b"one", b"two"}


def test_a_full_disk_is_reported_in_one_line(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    class Full:
        closed = True

        def write(self, content: bytes) -> int:
            raise OSError(28, "No space left on device")

    with begin(tmp_path, {}) as tape:
        tape.heard(b"before")
        with monkeypatch.context() as patch:
            patch.setattr(tape, "_raw", Full())
            with pytest.raises(CaptureTrouble, match=r"\.raw: cannot be written \(No space left on device\)"):
                tape.heard(b"after")
    assert read_capture(tape.file).raw == b"before"


def test_a_disk_that_fails_once_does_not_end_a_capture_and_is_reported(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    real, calls = os.fsync, iter(range(1000))

    def failing(number: int) -> None:
        if next(calls) == 4:
            raise OSError(errno.EIO, "Input/output error")
        real(number)

    monkeypatch.setattr(os, "fsync", failing)
    tape = begin(tmp_path, {})
    for chunk in (b"one ", b"two ", b"three"):
        time.sleep(0.3)
        tape.heard(chunk)
    with pytest.raises(CaptureTrouble, match=r"\.raw: the disk failed \(Input/output error\)"):
        tape.close()
    assert read_capture(tape.file).raw == b"one two three"


def test_bytes_are_synchronized_a_few_times_a_second_even_if_no_more_arrive(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    synced: list[int] = []
    monkeypatch.setattr(os, "fsync", synced.append)
    with begin(tmp_path, {}) as tape:
        tape.heard(b"one")
        before = len(synced)
        time.sleep(0.3)
        tape.tick()
        assert len(synced) >= before + 2
        quiet = len(synced)
        time.sleep(0.3)
        tape.tick()
        assert len(synced) == quiet


# --- Ports


def test_a_unit_is_found_again_by_its_ids_and_not_confused_with_another(tmp_path: Path) -> None:
    unit = Port("COM3", 0x0403, 0x6015, "A1")
    other = Port("COM4", 0x0403, 0x6015, "B2")
    assert again(unit, [other]) is None
    assert again(unit, [other, replace(unit, name="COM7")]) == "COM7"
    assert again(unit, [other, replace(unit, name="COM7"), unit]) == "COM3"
    plain = Port(str(tmp_path / "ttyS1"))
    assert again(plain, [Port("/dev/ttyS0")]) is None
    assert again(plain, [Port("/dev/ttyS0"), plain]) == plain.name
    (tmp_path / "ttyS1").touch()  # a terminal that the system does not list
    assert again(plain, []) == plain.name
    assert again(replace(unit, name=plain.name), []) is None


def test_a_system_without_unix_terminals_has_ports_too(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.setattr("serial.Serial", _absent)
    monkeypatch.setitem(sys.modules, "termios", None)
    with pytest.raises(PortTrouble, match=r"COM3: cannot be opened \(no such port\)"):
        list(capture(Port("COM3"), "eggtimer", folder=tmp_path))
    assert not captures(tmp_path)


def _absent(*_: object, **__: object) -> None:
    raise OSError(2, "no such port")


def test_ports_and_devices_are_listed_for_people_and_scripts(run: Run, monkeypatch: pytest.MonkeyPatch) -> None:
    here = [Port("/dev/ttyACM0", 0xFFFE, 0x000B, "2094", "TeleMetrum"), Port("/dev/ttyUSB0", 0x0403, 0x6015)]
    monkeypatch.setattr("fieldkit.capture.ports", lambda: here)
    document = run("capture", "--list", "--json").document
    assert [port["device"] for port in document["ports"]] == ["altos", None]
    assert "MicroPeak" in document["ports"][1]["about"]
    assert set(document["devices"]) >= {"altimulti", "micropeak", "mawd"}
    assert "not public" in document["not_public"]["rrc3"]
    listed = run("capture", "--list")
    assert "fffe:000b" in listed.out
    assert "TeleMetrum" in listed.out
    assert ".pf2" in listed.err


@pytest.mark.parametrize(
    ("arguments", "complaint"),
    [
        (["/dev/no-such-port", "--device", "mawd"], "/dev/no-such-port: cannot be opened"),
        (["--device", "rrc3", "/dev/null"], "mDACS"),
        (["--resume"], "no unfinished capture"),
    ],
)
def test_what_cannot_be_captured_is_reported_in_one_line(
    run: Run, arguments: list[str], complaint: str, folder: Path
) -> None:
    printed = run("capture", *arguments, status=1)
    assert not printed.out
    assert complaint in printed.err
    assert len(printed.err.splitlines()) == 1
    assert not captures(folder)


# --- From the port to the ledger


HEIGHTS = [0, 0, *(round(900 * (1 - (n / 100 - 1) ** 2)) for n in range(200)), 0]


@terminals
def test_a_mawd_is_captured_and_imported_and_importing_it_again_changes_nothing(run: Run, folder: Path) -> None:
    with played(devices.mawd(HEIGHTS)) as wire:
        document = run("capture", wire.name, "--device", "mawd", "--json", "--set", "rocket=Astra").document
    assert (document["imported"], document["samples"], document["whole"]) == (1, len(HEIGHTS), True)
    assert Path(document["file"]).parent == folder
    (flight,) = run("flights", "--json").document["flights"]
    assert flight["apogee_m"] == pytest.approx(900 * 0.3048, rel=0.01)  # a jump into flight looks like a lag
    assert flight["rocket"] == "Astra"
    again = run("import", "--set", "rocket=Astra", "--json", document["file"]).document
    assert (again["imported"], again["duplicates"]) == (0, 1)


@terminals
def test_a_fault_in_a_parser_loses_nothing(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch, folder: Path
) -> None:
    def faulty(*_: object, **__: object) -> None:
        raise ZeroDivisionError

    monkeypatch.setattr(import_module("fieldkit.services.imports.gather"), "open_file", faulty)
    with played(devices.mawd(HEIGHTS)) as wire, pytest.raises(ZeroDivisionError):
        main(["capture", wire.name, "--device", "mawd"])
    monkeypatch.undo()
    (file,) = folder.glob("*.raw")
    assert str(file) in capsys.readouterr().err
    assert main(["--ledger", str(folder / "ledger.db"), "import", str(file)]) == 0
    assert "Imported 1" in capsys.readouterr().out


@terminals
def test_a_fault_in_a_protocol_loses_nothing(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def faulty(*_: object) -> None:
        raise ZeroDivisionError

    monkeypatch.setattr("fieldkit.capture.protocols.micropeak.Stream.feed", faulty)
    with played(devices.talking(b"precious")) as wire, pytest.raises(ZeroDivisionError):
        followed(capture(Port(wire.name), "micropeak", folder=tmp_path, wishes=CaptureOptions(silence=0.5)), wire)
    (file,) = captures(tmp_path)
    assert read_capture(file).raw == b"precious"


# --- Kill, stop, pull


def counting(wire: Wire) -> None:
    """A unit that sends increasing numbers while the port is open."""
    wire.wait_until_opened()
    for number in range(10**9):
        wire.say(b"%d,%d,0,0\r\n" % (number, number % 977))
        if number % 20 == 0:
            time.sleep(0.002)


@contextmanager
def running(*arguments: str) -> Iterator["subprocess.Popen[bytes]"]:
    """`fieldkit` in a separate process."""
    environment = os.environ | {"PYTHONPATH": str(ROOT)}
    command = [sys.executable, "-m", "fieldkit.cli.main", *arguments]
    process = subprocess.Popen(
        command, env=environment, stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.PIPE
    )
    try:
        yield process
    finally:
        process.kill()
        process.communicate()


def until(done: object, patience: float = 60.0) -> None:
    """Wait for a condition. [s]"""
    ends = time.monotonic() + patience
    while not done():  # type: ignore[operator]
        assert time.monotonic() < ends
        time.sleep(0.02)


def size(folder: Path) -> int:
    return sum(file.stat().st_size for file in folder.glob("*.raw"))


@terminals
def test_a_killed_capture_keeps_all_received_bytes_and_continues_on_another_port(folder: Path) -> None:
    text = b"".join(b"%d,%d,0,0\r\n" % (number, number % 977) for number in range(200_000))
    with played(counting) as wire, running("capture", wire.name, "--device", "eggtimer") as process:
        assert process.stderr is not None
        assert process.stderr.readline().startswith(b"eggtimer on ")
        wire.opened.set()
        until(lambda: size(folder) > 5_000)
        seen = size(folder)
        os.kill(process.pid, signal.SIGKILL)
        process.wait(20)
    (file,) = captures(folder)
    first = read_capture(file).raw
    assert len(first) >= seen
    assert text.startswith(first)
    assert unfinished(folder) == file
    with played(devices.talking(text[:2000])) as wire:
        end = followed(resume(file, Port(wire.name), stop=devices.arrived(folder, first + text[:2000])), wire)
    assert end.whole
    assert read_capture(file).raw == first + text[:2000]
    assert unfinished(folder) is None


def packets(wire: Wire) -> None:
    devices.teledongle([devices.telem(devices.telem_sensor(n, n, 1)) for n in range(100)])(wire)


@terminals
def test_ctrl_c_ends_a_stream_cleanly(folder: Path) -> None:
    with played(packets) as wire, running("capture", wire.name, "--device", "teledongle", "--no-import") as process:
        until(lambda: folder.is_dir() and size(folder) > 5_000)
        process.send_signal(signal.SIGINT)
        _, stderr = process.communicate(timeout=30)
        until(lambda: bytes(wire.received).endswith(b"m 0\n"))
    assert process.returncode == 0
    assert re.search(rb"stopped: \d+ samples", stderr)  # as many as had come by then


@terminals
def test_a_pulled_cable_is_reported_and_resume_takes_the_newest(run: Run, folder: Path) -> None:
    def torn(wire: Wire) -> None:
        try:
            devices.mawd(HEIGHTS)(Halved(wire))
        except Unplugged:
            wire.unplug()
            raise

    class Halved:
        """A wire that breaks after a number of bytes."""

        def __init__(self, wire: Wire) -> None:
            self.wire, self.left = wire, 600

        def say(self, content: bytes, dribble: object = None) -> None:
            self.wire.say(content[: self.left])
            self.left -= len(content)
            if self.left <= 0:
                time.sleep(0.3)
                raise Unplugged

        def command(self, ends: bytes) -> bytes:
            return self.wire.command(ends)

    with played(torn) as wire:
        err = run("capture", wire.name, "--device", "mawd", "--reconnect", "0", status=1).err
    (file,) = captures(folder)
    assert f"fieldkit capture --resume {file.name}" in err
    assert "the port disappeared" in err
    with played(devices.mawd(HEIGHTS)) as wire:
        assert "Imported 1" in run("capture", "--resume", wire.name).out
    with pytest.raises(CaptureTrouble, match="is no longer there; current ports"):
        list(resume(file, look=lambda: [Port("/dev/other")]))


def test_captures_that_start_within_one_second_are_in_their_order(tmp_path: Path) -> None:
    began = []
    for _ in range(11):
        file, raw = _new(tmp_path, "20260601-120000")
        raw.close()
        file.with_suffix(JOURNAL).write_text("")
        began.append(file)
    assert captures(tmp_path) == began
    assert unfinished(tmp_path) == began[-1]


@terminals
def test_a_port_that_returns_and_disappears_again_is_given_up(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def gone(self: object) -> bytes:
        raise PortLost("port: the port disappeared (loose contact)")

    monkeypatch.setattr("fieldkit.capture.line.SerialLine.hear", gone)
    monkeypatch.setattr("fieldkit.capture.session.PAUSE", 0.0)
    with played(devices.deaf) as wire:
        port = Port(wire.name)
        events = list(capture(port, "eggtimer", folder=tmp_path, look=lambda: [port]))
    assert isinstance(events[-1], Ended)
    assert events[-1].why == "port: the port disappeared (loose contact)"
    assert 2 <= sum(isinstance(event, Back) for event in events) < 20


@terminals
def test_a_port_in_use_is_reported(tmp_path: Path) -> None:
    def quiet(wire: Wire) -> None:
        devices.deaf(wire)

    device: Device = quiet
    with played(device) as wire:
        first = capture(Port(wire.name), "eggtimer", folder=tmp_path, wishes=CaptureOptions(wait=5))
        assert isinstance(next(first), PortOpened)
        with pytest.raises(PortTrouble, match="another program"):
            next(capture(Port(wire.name), "eggtimer", folder=tmp_path))
        first.close()  # type: ignore[attr-defined]


@pytest.mark.parametrize(
    "damaged",
    ['{"at": Infinity, "t": 1}', '{"at": 1, "t": NaN}', '{"at": -3, "t": 1}', '{"at": 1, "t": ' + "9" * 400 + "}"],
)
def test_impossible_numbers_in_a_journal_are_left_out(tmp_path: Path, damaged: str) -> None:
    with begin(tmp_path, {"device": "eggtimer"}) as tape:
        tape.heard(b"100,5\n")
    sound = read_capture(tape.file)
    with tape.file.with_suffix(JOURNAL).open("a", encoding="ascii") as journal:
        journal.write(damaged + "\n")
    assert read_capture(tape.file) == sound


def test_the_first_and_last_years_of_the_calendar_are_not_valid_starts_of_a_capture(tmp_path: Path) -> None:
    with begin(tmp_path, {"device": "eggtimer"}) as tape:
        tape.heard(b"100,5\n")
    journal = tape.file.with_suffix(JOURNAL)
    text = journal.read_text(encoding="ascii")
    began = str(read_capture(tape.file).fact("began"))
    journal.write_text(text.replace(began, "9999-12-31T23:59:59-23:59"), encoding="ascii")
    assert read_capture(tape.file).began is None


def test_the_altitude_is_shown_while_telemetry_arrives(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    class Screen(StringIO):
        def isatty(self) -> bool:
            return True

    screen = Screen()
    monkeypatch.setattr(sys, "stderr", screen)
    monkeypatch.setenv("TERM", "xterm")
    with View() as view:
        view.show(PortOpened("/dev/ttyACM0", "teledongle", tmp_path / "a.raw"))
        for height, speed in ((100.0, 80.0), (250.0, 20.0), (240.0, -9.0)):
            view.show(Progress(1000, 10, 2, 0.5, Sample(height, 1.0, speed, "coast")))
        view.received_at -= 60
        view.show(Progress(1234, 10, 2, 0.5, view.last))
        view.show(Instruction("\x1b[31mred [bold]"))
    shown = screen.getvalue()
    assert "every byte goes to" in shown
    assert "1,234 bytes, 10 samples, 2 damaged, 50%" in shown
    assert "altitude 240.0 m   highest 250.0 m" in shown
    assert "-9.0 m/s   coast   received 60 s ago" in shown
    assert "▁█" in shown
    assert "\x1b[31m" not in shown


@terminals
def test_an_impossible_baud_rate_is_refused(tmp_path: Path, run: Run) -> None:
    with played(devices.deaf) as wire:
        for baud in (-300, 0, 10**30):
            assert "--baud" in run("capture", wire.name, f"--baud={baud}", status=2).err
        with pytest.raises(PortTrouble, match="cannot be opened"), begin(tmp_path, {}) as tape:
            open_line(wire.name, "mawd", PortSettings(10**30), tape)
