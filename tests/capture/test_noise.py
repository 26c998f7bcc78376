"""Noise within an answer that lasts longer than the wait for silence, as on a slow line or a busy computer."""

import random
import sys
import time
from dataclasses import replace
from pathlib import Path
from unittest.mock import patch

import pytest

from fieldkit.capture import CaptureOptions, Port, capture, logs_in
from fieldkit.capture.events import CaptureEvent, Ended
from fieldkit.capture.protocols import mawd
from tests.capture import devices
from tests.capture.devices import Wire, played

CHECK_SHAPES = False
pytestmark = pytest.mark.skipif(sys.platform == "win32", reason="pseudo-terminals")
QUICK = CaptureOptions(wait=30, silence=30, reconnect=30)
HEIGHTS = [0, *range(100, 300), 0]
LOW = [devices.raven_frame("LOG_LOW", 600 + n * 0.02, f"Bo: 7712 {49_000 - n} Vel: {n} 0 0") for n in range(40)]
HIGH = [devices.raven_frame("LOG_HIR", 600 + n * 0.002, "gyro: 1 2 3 accel: 10 20 1000") for n in range(60)]
BABBLE = b"\x8f????\r\n"


def interrupted(device: devices.Device, word: bytes, before: bytes, tail: int, pause: float) -> devices.Device:
    """A unit whose first answer containing a word has noise before its last `tail` lines, which arrive slowly. [s]"""

    def noisy(wire: Wire) -> None:
        send, left = wire.say, [True]

        def say(content: bytes, dribble: random.Random | None = None) -> None:
            if not (left and word in content):
                send(content, dribble)
                return
            left.clear()
            lines = content.splitlines(keepends=True)
            send(b"".join(lines[:-tail]))
            for piece in [*before.splitlines(keepends=True), *lines[-tail:]]:
                send(piece)
                time.sleep(pause)

        with patch.object(wire, "say", say):
            device(wire)

    return noisy


def heard(device: devices.Device, name: str, folder: Path, options: CaptureOptions) -> Ended:
    """The end of a capture of a unit."""
    seen: list[CaptureEvent] = []
    with played(device) as wire:
        wire.opened.set()
        seen += capture(Port(wire.name), name, folder=folder, wishes=options)
    assert isinstance(seen[-1], Ended)
    return seen[-1]


def test_each_sample_is_read_once_if_a_mawd_is_asked_again_during_its_answer(tmp_path: Path) -> None:
    device = interrupted(devices.mawd(HEIGHTS), b"Sample interval", BABBLE * 40, 40, 0.03)
    end = heard(device, "mawd", tmp_path, QUICK)
    assert end.whole
    (log,) = logs_in(end.file)
    assert [int(row) for row in mawd._ROW.findall(log.content)] == HEIGHTS


def test_each_sample_is_read_once_if_a_mawd_was_asked_again_too_early(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(mawd, "NOISE_WAIT", 0.1)
    device = interrupted(devices.mawd(HEIGHTS), b"Sample interval", BABBLE * 40, 40, 0.03)
    (log,) = logs_in(heard(device, "mawd", tmp_path, QUICK).file)
    assert [int(row) for row in mawd._ROW.findall(log.content)] == HEIGHTS
    assert b"Sample interval is  50 ms" in log.content


def test_noise_longer_than_the_silence_does_not_end_a_download_of_a_blue_raven(tmp_path: Path) -> None:
    device = interrupted(devices.blue_raven(LOW, HIGH), LOW[0], BABBLE * 70, 20, 0.015)
    end = heard(device, "blue_raven", tmp_path, replace(QUICK, silence=1.0))
    assert (end.whole, end.samples) == (True, len(LOW) + len(HIGH))
    (log,) = logs_in(end.file)
    assert [line for line in log.content.splitlines() if b"LOG_LOW" in line] == [line.strip() for line in LOW]


def test_the_model_of_a_mawd_is_read_through_noise(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(mawd, "ANSWER", 0.2)
    device = interrupted(devices.mawd(HEIGHTS), b"PerfectFlite", BABBLE * 100, 2, 0.02)
    (log,) = logs_in(heard(device, "mawd", tmp_path, QUICK).file)
    for line in (b"PerfectFlite", b"miniAlt/WD", b"Version 1.4", b"Sample interval is  50 ms"):
        assert line in log.content
    assert [int(row) for row in mawd._ROW.findall(log.content)] == HEIGHTS
