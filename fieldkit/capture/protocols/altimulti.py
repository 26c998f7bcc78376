"""AltiMulti, AltiDuo, TTGO Bear, AltiGPS and related units (bdureau): sentences requested with one-letter commands.

A flight is `$start;`, `$data,...;` and so on, `$end;`. Telemetry may come in between.

Source: RocketFlightLogger.ino, config.cpp, logger_i2c_eeprom.cpp (bdureau/RocketFlightLogger).
"""

import re
import time
from collections.abc import Iterable
from dataclasses import dataclass

from fieldkit.capture.captured import Captured, Log
from fieldkit.capture.events import FlightsListed, Instruction, Sample, Stored
from fieldkit.capture.line import PortSettings
from fieldkit.capture.link import NOISE, Dialogue, Link
from fieldkit.capture.protocol import CaptureOptions, Protocol
from fieldkit.errors import PortTrouble
from fieldkit.importing.tables.checksums import sum_256
from fieldkit.quantities import counted
from fieldkit.safe_text import whole_number

MAX_FLIGHTS = 25
"""Number of flights that a unit stores. [1]"""
GREETINGS, GREETING = 8, 1.5
"""Number of greetings [1], and the time a unit has to answer each [s]: opening the port restarts some boards."""
ANSWER = 5.0
"""Longest pause of a unit within an answer. [s]"""
REFUSALS = ("KO", "K0", "UNKNOWN")
"""Names of sentences with which a unit refuses a command."""
TRIES = 3
"""Number of times that a command is sent until the answer is complete. [1]"""
STREAM = 60.0
"""Longest pause in telemetry. [s]"""


@dataclass(frozen=True, slots=True)
class Sentence:
    """A sentence; `sound` if its checksum is valid, or if its kind has none."""

    name: str
    fields: tuple[str, ...]
    sound: bool


def sentence(piece: bytes) -> Sentence | None:
    """The sentence at the end of the text before a semicolon, None if there is none."""
    start = piece.rfind(b"$")
    if start < 0:
        return None
    body = piece[start + 1 :]
    name, *fields = body.decode("latin-1").split(",")
    if not fields:
        return Sentence(name.strip(), (), name.strip().isalnum())
    right = str(sum_256(body[: body.rfind(b",") + 1])) == fields[-1].strip()
    return Sentence(name, tuple(fields[:-1]), right)


def sentences(content: bytes) -> Iterable[Sentence]:
    """All sentences `$name,field,...,checksum;` in a sequence of bytes. The checksum is the sum of the characters from
    the name up to and including the comma before the checksum, modulo 256."""
    for piece in content.split(b";")[:-1]:
        if (one := sentence(piece)) is not None:
            yield one


def recognizes_stream(heard: bytes) -> bool:
    """Whether there is a telemetry or data sentence with a valid checksum."""
    return any(one.sound and one.name in ("telemetry", "data") and one.fields for one in sentences(heard))


@dataclass(frozen=True, slots=True)
class AnswerFrame:
    """An answer to one command, starting at its `$start;`: its valid samples, and its sentences that are not valid."""

    content: bytes
    good: int
    bad: int
    ended: bool

    @property
    def whole(self) -> bool:
        """Whether the answer ended and every sentence has a valid checksum."""
        return self.ended and not self.bad


def frames(captured: Captured) -> dict[int, AnswerFrame]:
    """The best available answer for each requested flight."""
    best: dict[int, AnswerFrame] = {}
    for answer in captured.answers():
        asked = re.fullmatch(rb"r(\d+);", answer.command)
        if asked:
            frame, number = _frame(answer.content), int(asked[1])
            if number not in best or _worth(frame) > _worth(best[number]):
                best[number] = frame
    return best


def _worth(frame: AnswerFrame) -> tuple[bool, int, bool]:
    """Rank of an answer, best highest: a whole one, then one with more samples, then one that ended."""
    return frame.whole, frame.good, frame.ended


def _frame(content: bytes) -> AnswerFrame:
    """The answer in some bytes, from its `$start;` to its `$end;` or as far as it arrived."""
    start = max(content.find(b"$start;"), 0)
    end = content.find(b"$end;", start)
    content = content[start : end + len(b"$end;") if end >= 0 else None]
    data = [one for one in sentences(content) if one.fields and one.name != "telemetry"]
    good = sum(one.sound and one.name == "data" for one in data)
    return AnswerFrame(content, good, len(data) - good, end >= 0)


def dialogue(link: Link, wishes: CaptureOptions, captured: Captured) -> Dialogue[bool]:
    """Download the chosen flights, or follow telemetry; returns whether all arrived. Raises PortTrouble."""
    yield from _greeted(link)
    yield from _identified(link)
    return (yield from (_followed if wishes.live else _downloaded)(link, wishes, captured))


def _greeted(link: Link) -> Dialogue[None]:
    for _ in range(GREETINGS):
        link.send(b"h;")
        while (one := (yield from _next(link, GREETING))) is not None:
            if one.name == "OK":
                return
    raise PortTrouble(
        f"{link.line.name}: no $OK; in answer to h; from an AltiMulti; is it on, and does --baud match its setting?"
    )


def _next(link: Link, silence: float) -> Dialogue[Sentence | None]:
    """The next sentence that is not telemetry, None after `silence` [s], or after a while with only telemetry."""
    ends = time.monotonic() + NOISE * silence
    while time.monotonic() < ends and (piece := (yield from link.piece(b";", silence))) is not None:
        one = sentence(piece)
        if one is None:
            continue
        if one.name == "telemetry" and one.fields:
            _telemetry(link, one)
        else:
            return one
    return None


def _telemetry(link: Link, one: Sentence) -> None:
    """Report a telemetry sentence; always meters, whatever unit the device displays."""
    if not one.sound:
        link.damaged += 1
        return
    try:
        altitude, lifted, apogee, _, main, _, landed, clock = (float(text) for text in one.fields[:8])
    except ValueError:
        return
    flags = (("landed", landed), ("main", main), ("drogue", apogee), ("flying", lifted))
    state = next((name for name, flag in flags if flag > 0), "pad")
    link.sample = Sample(altitude, clock / 1000, state=state)


def _identified(link: Link) -> Dialogue[None]:
    """Record the settings, whose eighth field is the name of the board."""
    link.send(b"b;")
    while (one := (yield from _next(link, ANSWER))) is not None and one.name not in ("end", *REFUSALS):
        if one.name == "alticonfig" and one.sound and len(one.fields) > 9:
            link.about["model"] = one.fields[7]
            link.about["firmware"] = f"{one.fields[8]}.{one.fields[9]}"
            link.about["settings"] = ",".join(one.fields)


def _downloaded(link: Link, wishes: CaptureOptions, captured: Captured) -> Dialogue[bool]:
    count = yield from _counted(link)
    _same_unit(link, count, captured)
    flights = [Stored(number, f"flight {number}") for number in range(min(count, MAX_FLIGHTS))]
    wanted = set(wishes.choose(flights)) if flights else set()
    chosen = [flight.number for flight in flights if flight.number in wanted]
    yield FlightsListed(tuple(flights), tuple(chosen))
    have = {number for number, frame in frames(captured).items() if frame.whole}
    link.send(b"f;")
    try:
        yield from link.drain(0.1)
        whole = True
        for place, number in enumerate(chosen):
            link.fraction = place / len(chosen)
            if number not in have:
                whole = (yield from _flight(link, number)) and whole
        link.fraction = 1.0
    finally:
        link.last_command(b"g;")
    yield from link.drain(0.1)
    return whole


def _counted(link: Link) -> Dialogue[int]:
    for _ in range(TRIES):
        link.send(b"n;")
        while (one := (yield from _next(link, ANSWER))) is not None and one.name != "end":
            known = one.fields[0].strip() if one.name == "nbrOfFlight" and one.sound and one.fields else ""
            if (count := whole_number(known)) is not None:
                return count
    raise PortTrouble(f"{link.line.name}: no number of flights in answer to n;, expected $nbrOfFlight,N,checksum;")


def _same_unit(link: Link, count: int, captured: Captured) -> None:
    """Raise PortTrouble if a resumed capture is from another unit."""
    intact = [one for one in sentences(captured.raw) if one.sound]
    counts = {one.fields[0] for one in intact if one.name == "nbrOfFlight" and one.fields}
    settings = {",".join(one.fields) for one in intact if one.name == "alticonfig"}
    mine = link.about.get("settings")
    if (counts and str(count) not in counts) or (mine and settings and mine not in settings):
        raise PortTrouble(f"{link.line.name}: this is not the unit that was being captured; start a new capture")


def _flight(link: Link, number: int) -> Dialogue[bool]:
    """Read one flight, and read it again if it arrived damaged."""
    for attempt in range(1, TRIES + 1):
        good, bad, ended = yield from _answer(link, number)
        if ended and not bad:
            return True
        fault = f"{counted(bad, 'sentence')} with a wrong checksum" if ended else "it stopped in the middle"
        again = "; reading it again" if attempt < TRIES else f"; {counted(good, 'sample')} of it are saved"
        yield Instruction(f"flight {number}: {fault}{again}")
        yield from link.drain(0.3)
    return False


def _answer(link: Link, number: int) -> Dialogue[tuple[int, int, bool]]:
    """Request one flight; returns the numbers of good and bad sentences, and whether the answer ended."""
    good = bad = 0
    link.send(b"r%d;" % number)
    while (one := (yield from _next(link, ANSWER))) is not None:
        if one.name == "end":
            return good, bad, True
        if one.name in REFUSALS:
            break
        if one.fields and one.sound and one.name == "data":
            good += 1
            link.samples += 1
        elif one.fields:
            bad += 1
            link.damaged += 1
    return good, bad, False


def _followed(link: Link, wishes: CaptureOptions, captured: Captured) -> Dialogue[bool]:
    """Record telemetry until it pauses or the user stops it."""
    silence = STREAM if wishes.silence is None else wishes.silence
    link.open_ended = True
    link.send(b"y1;")
    try:
        while (piece := (yield from link.piece(b";", silence))) is not None:
            one = sentence(piece)
            if one is not None and one.name == "telemetry":
                link.samples += one.sound
                _telemetry(link, one)
    finally:
        link.last_command(b"y0;")
    return True


def logs(captured: Captured) -> list[Log]:
    """The last settings and the best answer for each flight, in one log; if no answer has samples, all bytes
    unchanged; nothing if there is no sentence."""
    best = frames(captured)
    flown = [best[number].content for number in sorted(best) if best[number].good]
    if not flown:
        return [Log(captured.file.name, captured.raw)] if any(True for _ in sentences(captured.raw)) else []
    settings = [answer.content for answer in captured.answers() if answer.command == b"b;"]
    head = [_frame(content).content for content in settings[-1:] if b"$alticonfig" in content]
    return [Log(captured.file.name, b"\n".join([*head, *flown]) + b"\n")]


PROTOCOL = Protocol(
    "bdureau AltiMulti, AltiDuo, TTGO Bear, AltiGPS", PortSettings(38_400), dialogue, logs, recognizes_stream
)
