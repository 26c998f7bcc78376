"""PerfectFlite MAWD: model, firmware, statistics and the last flight, each requested with one letter.

No mark ends a flight; the statistics state its number of samples. The letter F fires an output if D or M follows: it is
not in the command table, and no allowed command contains it.

Source: readme.md, cmd/dump.go, cmd/stats.go (ukhpr/mawd), which its author calls untested.
"""

import re
import time

from fieldkit.capture.captured import Captured, Log
from fieldkit.capture.events import Instruction
from fieldkit.capture.line import PortSettings
from fieldkit.capture.link import NOISE, Dialogue, Link
from fieldkit.capture.protocol import CaptureOptions, Protocol
from fieldkit.errors import PortTrouble
from fieldkit.quantities import counted

ANSWER = 3.0
"""Longest pause of the unit within an answer. [s]"""
QUIET_TIME = 0.2
"""Silence before a command. [s]"""
NOISE_WAIT = 60.0
"""Longest wait for the end of an answer with noise in it, before its command is sent again. [s]"""
TRIES = 3
"""Number of times that a command is sent until the answer is complete. [1]"""
STATISTICS = 5
"""Number of lines in the answer to S: ground, apogee, number of samples, Mach delay, main altitude."""

_SAMPLE = re.compile(r".\d{4}")
_ROW = re.compile(rb"^.\d{4}\r$", re.MULTILINE)
_COUNT = re.compile(rb"^N(\d{5})\r?$", re.MULTILINE)


def dialogue(link: Link, wishes: CaptureOptions, captured: Captured) -> Dialogue[bool]:
    """Download the flight, again if samples are missing; returns whether all arrived. Raises PortTrouble."""
    model = yield from _lines(link, b"I", 2)
    if not model:
        raise PortTrouble(
            f"{link.line.name}: no model in answer to I from a MAWD; is it on, and is this its own cable?"
        )
    link.about["model"] = " ".join(model)
    firmware = yield from _lines(link, b"V", 1)
    link.about["firmware"] = " ".join(firmware)
    count = yield from _count(link)
    if not count:
        yield Instruction("the unit holds no flight")
        return True
    return (yield from _flight(link, count))


def _lines(link: Link, command: bytes, wanted: int) -> Dialogue[list[str]]:
    """Up to `wanted` non-blank lines in answer to a command; fewer, or none, if the unit does not answer."""
    found: list[str] = []
    for attempt in range(1, TRIES + 1):
        yield from _quiet(link, attempt)
        link.send(command)
        found = []
        ends = time.monotonic() + NOISE * ANSWER
        while (
            len(found) < wanted
            and time.monotonic() < ends
            and (line := (yield from link.text_line(ANSWER))) is not None
        ):
            if line.strip() and line.strip().isprintable():
                found.append(line.strip())
        if len(found) == wanted:
            break
    return found


def _quiet(link: Link, attempt: int) -> Dialogue[None]:
    """Wait for silence before a command: the answer to an earlier attempt may still be coming, among noise."""
    yield from link.drain(QUIET_TIME, NOISE if attempt == 1 else NOISE_WAIT / QUIET_TIME)


def _count(link: Link) -> Dialogue[int]:
    """The number of samples in memory. Raises PortTrouble if the statistics cannot be read."""
    for _ in range(TRIES):
        lines = yield from _lines(link, b"S", STATISTICS)
        found = {line[0]: int(line[1:]) for line in lines if re.fullmatch(r"[GANDM]\d{5}", line)}
        if "N" in found:
            return found["N"]
    raise PortTrouble(f"{link.line.name}: no number of samples in answer to S, expected a line such as N00512")


def _flight(link: Link, count: int) -> Dialogue[bool]:
    """Read the interval and the samples; request them again if they are incomplete."""
    for attempt in range(1, TRIES + 1):
        yield from _quiet(link, attempt)
        link.send(b"D")
        good = seen = 0
        while seen < count + 1 and (line := (yield from link.text_line(ANSWER))) is not None:
            if not line.strip():
                continue
            seen += 1
            if seen > 1:
                good += _SAMPLE.fullmatch(line) is not None
                link.samples += _SAMPLE.fullmatch(line) is not None
                link.damaged += _SAMPLE.fullmatch(line) is None
                link.fraction = good / count
        if good == count:
            return True
        again = "; reading it again" if attempt < TRIES else ""
        yield Instruction(f"{good} of {counted(count, 'sample')} arrived{again}")
    return False


def logs(captured: Captured) -> list[Log]:
    """The last answer to each letter, and of those to D the one with the most samples; all bytes if there are none."""
    answers = captured.answers()
    kept = [[answer.content for answer in answers if answer.command == command][-1:] for command in (b"I", b"V", b"S")]
    flights = [answer.content for answer in answers if answer.command == b"D"]
    best = max(flights, key=lambda content: len(_ROW.findall(content)), default=b"")
    content = b"".join(b"".join(one) for one in kept) + _last_answer(best, _samples(b"".join(kept[-1])))
    return [Log(captured.file.name, content or captured.raw)] if captured.raw else []


def _samples(statistics: bytes) -> int:
    """The number of samples in an answer to S, 0 if it has none."""
    found = _COUNT.findall(statistics)
    return int(found[-1]) if found else 0


def _last_answer(content: bytes, count: int) -> bytes:
    """An answer to D without the end of the one before, which a noisy unit was still sending when it was asked again.

    It is the line with the interval and the last `count` samples.
    """
    rows = [row.start() for row in _ROW.finditer(content)]
    if not count or len(rows) <= count:
        return content
    return content[content[: rows[-count]].rstrip().rfind(b"\n") + 1 :]


PROTOCOL = Protocol("PerfectFlite MAWD", PortSettings(38_400, xonxoff=True), dialogue, logs)
