"""Simulated loggers on pseudo-terminals, byte for byte as in the manufacturers' sources, with the faults that occur in
the field.

A device is a function that talks on a `Wire`; `played` runs it in a thread. Bytes from the host are stored in
`Wire.commands`, so a test can check every byte that reached a device.
"""

import binascii
import errno
import os
import random
import select
import threading
import time
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager, suppress
from pathlib import Path

Device = Callable[["Wire"], None]


class Unplugged(Exception):
    """The device's end of the wire is closed."""


class Wire:
    """The device's end of a pseudo-terminal; `name` is the port that the host opens."""

    def __init__(self) -> None:
        import tty

        self.master, self._slave = os.openpty()
        tty.setraw(self._slave)
        self.name = os.ttyname(self._slave)
        self.opened = threading.Event()
        self.received = bytearray()
        self.commands: list[bytes] = []
        self.left: int | None = None
        """Number of bytes before its cable is pulled; None for no limit."""
        self.flood: tuple[int, bytes] | None = None
        """Garbage that it sends once after a number of bytes; None for a normal device."""
        self._unread = bytearray()
        self._gone = threading.Event()

    def say(self, content: bytes, dribble: random.Random | None = None) -> None:
        """Send bytes, all at once or in pieces of one to nine with pauses."""
        if self.flood is not None:
            after, babble = self.flood
            self.flood = (after - len(content), babble) if after > len(content) else None
            content = content if self.flood else content[:after] + babble + content[after:]
        torn = self.left is not None and len(content) > self.left
        if self.left is not None:
            content = content[: self.left]
            self.left -= len(content)
        place = 0
        while place < len(content):
            size = dribble.randint(1, 9) if dribble else len(content)
            piece = content[place : place + size]
            while piece:
                if self._gone.is_set():
                    raise Unplugged
                if select.select([], [self.master], [], 0.05)[1]:
                    piece = piece[self._write(piece[:1024]) :]
            place += size
            if dribble and dribble.random() < 0.05:
                time.sleep(0.001)
        if torn:
            time.sleep(0.1)
            self.unplug()
            raise Unplugged

    def _write(self, piece: bytes) -> int:
        try:
            return os.write(self.master, piece)
        except OSError as error:
            raise Unplugged from error

    def command(self, ends: bytes) -> bytes:
        """The next command: up to one of these bytes, or of one byte if there are none."""
        while True:
            for place, byte in enumerate(self._unread):
                if not ends or byte in ends:
                    found = bytes(self._unread[: place + 1])
                    del self._unread[: place + 1]
                    self.commands.append(found)
                    return found
            self._unread += self.listen(0.05)

    def listen(self, wait: float) -> bytes:
        """Bytes from the host; empty after a timeout [s]."""
        if self._gone.is_set():
            raise Unplugged
        if not select.select([self.master], [], [], wait)[0]:
            return b""
        try:
            chunk = os.read(self.master, 4096)
        except OSError as error:
            if error.errno == errno.EIO:  # the host closed the port
                time.sleep(0.01)
                return b""
            raise Unplugged from error
        self.received += chunk
        return chunk

    @property
    def baud(self) -> int:
        """The rate at which the host listens. [baud]"""
        import termios

        speed = termios.tcgetattr(self.master)[4]
        return next(int(name[1:]) for name in dir(termios) if name[1:].isdigit() and getattr(termios, name) == speed)

    def unplug(self) -> None:
        """Pull the cable."""
        if not self._gone.is_set():
            self._gone.set()
            time.sleep(0.02)
            os.close(self._slave)
            os.close(self.master)

    def wait_until_opened(self) -> None:
        while not self.opened.wait(0.05):
            if self._gone.is_set():
                raise Unplugged


@contextmanager
def played(device: Device) -> Iterator[Wire]:
    """A device on a separate wire, in a thread that ends with the test."""
    wire = Wire()
    faults: list[BaseException] = []

    def play() -> None:
        try:
            with suppress(Unplugged):
                device(wire)
        except BaseException as error:  # shown by the test
            faults.append(error)

    thread = threading.Thread(target=play, daemon=True)
    thread.start()
    try:
        yield wire
    finally:
        wire.unplug()
        thread.join(10)
    assert not faults, faults


# --- MicroPeak ---------------------------------------------------------------------------------------------------


def micropeak_payload(ground: int, lowest: int, samples: Sequence[int], model: int = 0) -> bytes:
    """Header and samples of a record. [Pa]"""
    count = len(samples)
    header = ground.to_bytes(4, "little") + lowest.to_bytes(4, "little")
    header += ((count & 0xFFF) | model << 12).to_bytes(2, "little")
    if model == 2:
        header += (count >> 12).to_bytes(2, "little")
    return header + b"".join((sample & 0xFFFF).to_bytes(2, "little") for sample in samples)


def x25(data: bytes) -> int:
    """CRC-16/X-25, bit by bit."""
    crc = 0xFFFF
    for byte in data:
        crc ^= byte
        for _ in range(8):
            crc = crc >> 1 ^ 0x8408 if crc & 1 else crc >> 1
    return crc ^ 0xFFFF


def micropeak_stream(payload: bytes, crc: int | None = None, chip: str = "") -> bytes:
    """The LED's transmission: `MP`, sixteen bytes per line, the checksum, and for a MicroPeak 2 its chip."""
    text = b"MP"
    for place in range(0, len(payload), 16):
        text += b"\r\n" + payload[place : place + 16].hex().encode()
    text += b"\r\n%04x\r\n" % (x25(payload) if crc is None else crc)
    return text + chip.encode() + b"\r\n" * bool(chip)


# --- AltiMulti ---------------------------------------------------------------------------------------------------


def sentence(*fields: object) -> bytes:
    """`$name,field,...,checksum;` and a newline."""
    body = ",".join(map(str, fields)).encode() + b","
    return b"$%s%d;\n" % (body, sum(body) % 256)


def altimulti_data(flight: int, count: int, step: int = 50) -> list[bytes]:
    """A flight's samples as an 8-bit board prints them: time and pressure through 16 bits."""
    rows = []
    for n in range(count):
        height = round(300 * (1 - (2 * n / count - 1) ** 2))
        pressure = round(100_873 * (1 - height / 44_330) ** 5.256)
        rows.append(sentence("data", flight, n * step % 65_536, height, 21, pressure % 65_536))
    return rows


TELEMETRY = sentence("telemetry", 123, 1, 0, 0, 0, 0, 0, 4200, 1, 1, -1, -1, 7.4, 21, 12, 3, 0)
CONFIG = sentence("alticonfig", 0, 1, 1, 2, 0, 0, 150, "AltiMulti", 1, 28, 0, 0, 0, 440, 5, 10, 0, 0, 38400, 0, 3)


def altimulti(
    flights: Sequence[Sequence[bytes]],
    *,
    dribble: random.Random | None = None,
    between: bytes = b"",
    spoil: int = 0,
    unplug_after: int | None = None,
    deaf: int = 0,
) -> Device:
    """A unit; the first `spoil` answers have a wrong checksum, and it ignores greetings up to `deaf`."""

    def device(wire: Wire) -> None:
        left, budget = spoil, unplug_after
        missed = deaf
        while True:
            command = wire.command(b";").strip()
            if command == b"h;" and missed:
                missed -= 1
            elif command in (b"h;", b"f;", b"g;"):
                wire.say(b"$OK;\n", dribble)
            elif command == b"b;":
                wire.say(b"$start;\n" + CONFIG + b"$end;\n", dribble)
            elif command == b"n;":
                wire.say(b"$start;\n" + sentence("nbrOfFlight", len(flights)) + b"$end;\n", dribble)
            elif command[:1] == b"r":
                rows = list(flights[int(command[1:-1])])
                if left:
                    left -= 1
                    rows[len(rows) // 2] = rows[len(rows) // 2].replace(b"data,", b"dota,")
                body = b"$start;\n" + b"".join(row + between for row in rows) + b"$end;\n"
                if budget is not None and len(body) > budget:
                    wire.say(body[:budget], dribble)
                    time.sleep(0.1)
                    wire.unplug()
                budget = None if budget is None else budget - len(body)
                wire.say(body, dribble)
            elif command == b"y1;":
                while not wire.listen(0.01):
                    wire.say(TELEMETRY)
            else:
                wire.say(b"$UNKNOWN;" + command)

    return device


# --- Altus Metrum ------------------------------------------------------------------------------------------------

BLOCK = 256


def altos_record(kind: bytes, tick: int, payload: bytes) -> bytes:
    """A record of flash memory; all its bytes and 0x5a sum to zero."""
    body = kind + b"\0" + (tick & 0xFFFF).to_bytes(2, "little") + payload
    return kind + bytes([-(sum(body) + 0x5A) & 0xFF]) + body[2:]


def altos_lines(block: bytes) -> list[bytes]:
    """The answer to `e`: offset and eight bytes a line."""
    rows = [block[place : place + 8] for place in range(0, BLOCK, 8)]
    return [b"%x %s\n" % (place * 8, b" ".join(b"%x" % byte for byte in row)) for place, row in enumerate(rows)]


IDENTITY = (
    b"manufacturer     altusmetrum.org\nproduct          TeleMetrum-v2.0\nserial-number    2094\n"
    b"log-format       7\naltitude-32      1\nsoftware-version 1.9.14\n"
)
SETTINGS = (
    b"Config version: 1.24\nMain deploy: 250 meters\nAPRS interval: 0\nFrequency: 434550\n"
    b'Accel cal +1g: 1991 -1g: 4133\nCallsign: "N0CALL"\n'
)


def altos(
    memory: Mapping[int, bytes],
    extents: Sequence[tuple[int, int, int]],
    *,
    dribble: random.Random | None = None,
    spoil: Iterable[int] = (),
    unplug_at: int | None = None,
    identity: bytes = IDENTITY,
) -> Device:
    """A flight computer; each block of `spoil` is damaged once, at block `unplug_at` the cable is pulled."""
    spoiled = set(spoil)

    def device(wire: Wire) -> None:
        while True:
            command = wire.command(b"\n")
            if command == b"c s\n":
                wire.say(SETTINGS, dribble)
            elif command == b"f\n":
                wire.say(b"Storage size: 8388608\nStorage erase unit: 65536\n", dribble)
            elif command == b"v\n":
                wire.say(identity, dribble)
            elif command == b"l\n":
                wire.say(b"".join(b"flight %d start %x end %x\n" % one for one in extents) + b"done\n", dribble)
            elif command[:2] == b"e ":
                number = int(command[2:], 16)
                lines = altos_lines(memory.get(number, b"\xff" * BLOCK))
                if number in spoiled:
                    spoiled.discard(number)
                    lines[7] = b"38 zz 0\x00\x8f\n"
                    lines[9] = b"0" + lines[9]
                if number == unplug_at:
                    wire.say(b"".join(lines[:13]) + b"68 1f 2")
                    time.sleep(0.1)
                    wire.unplug()
                wire.say(b"".join(lines), dribble)

    return device


def telem(packet: bytes, status: int = 0x80 | 0x2F) -> bytes:
    """A packet as a TeleDongle prints it."""
    body = packet + b"\x20" + bytes([status])
    content = bytes([len(packet) + 2]) + body
    return b"TELEM " + (content + bytes([(0x5A + sum(body)) & 0xFF])).hex().encode() + b"\n"


def telem_sensor(tick: int, height: int, speed: float, state: int = 3) -> bytes:
    """A sensor packet of a TeleMetrum v1. [m], [m/s]"""
    content = (319).to_bytes(2, "little") + (tick & 0xFFFF).to_bytes(2, "little") + bytes([1, state]) + bytes(14)
    content += round(speed * 16).to_bytes(2, "little", signed=True) + height.to_bytes(2, "little", signed=True)
    return content + bytes(32 - len(content))


def teledongle(packets: Sequence[bytes], noise: bytes = b"") -> Device:
    """A radio that forwards packets, each followed by noise, once it is asked to."""

    def device(wire: Wire) -> None:
        while True:
            command = wire.command(b"\n")
            if command == b"v\n":
                wire.say(IDENTITY.replace(b"TeleMetrum-v2.0", b"TeleDongle-v3.0"))
            elif command == b"m 20\n":
                for packet in packets:
                    wire.say(packet + noise)

    return device


# --- Blue Raven --------------------------------------------------------------------------------------------------


def buypass(data: bytes) -> int:
    """CRC-16/BUYPASS, bit by bit."""
    crc = 0
    for byte in data:
        crc ^= byte << 8
        for _ in range(8):
            crc = (crc << 1 ^ 0x8005 if crc & 0x8000 else crc << 1) & 0xFFFF
    return crc


def raven_frame(kind: str, moment: float, fields: str) -> bytes:
    """A frame of a flight on 11 May 2024; its length counts the line end. [s]"""
    clock = f"14:{int(moment // 60):02d}:{int(moment % 60):02d}.{round(moment % 1 * 1000) % 1000:03d}"
    rest = f" 2024 5 11 {clock} {round(moment * 1000) % 250} {fields}"
    body = f"@ {kind} {0:>4}{rest}".encode()
    body = body.replace(b"   0", b"%4d" % (len(body) + len(" CRC: XXXX\r\n")), 1)
    return body + b" CRC: %04X\r\n" % buypass(body)


def blue_raven(low: Sequence[bytes], high: Sequence[bytes], live: bytes = b"") -> Device:
    """A unit that sends its status `live` all the time, and its memory when asked."""

    def device(wire: Wire) -> None:
        last_sent = time.monotonic()
        unread = b""
        while True:
            unread += wire.listen(0.02)
            while b"\n" in unread:
                command, _, unread = unread.partition(b"\n")
                wire.commands.append(command + b"\n")
                wire.say({b"download l": b"".join(low), b"download h": b"".join(high)}.get(command.strip(), b"?\r\n"))
            if live and time.monotonic() - last_sent > 0.1:
                last_sent = time.monotonic()
                wire.say(live)

    return device


# --- PerfectFlite, Eggtimer --------------------------------------------------------------------------------------


def mawd(heights: Sequence[int], *, dribble: random.Random | None = None, cut: int = 0) -> Device:
    """A MAWD with one flight; its first `cut` answers to D end in the middle. [ft]"""

    def device(wire: Wire) -> None:
        left = cut
        while True:
            command = wire.command(b"")
            if command == b"I":
                wire.say(b"\r\nPerfectFlite\r\nminiAlt/WD\r\n", dribble)
            elif command == b"V":
                wire.say(b"\r\nVersion 1.4\r\n", dribble)
            elif command == b"S":
                figures = (("G", 812), ("A", max(heights, default=0)), ("N", len(heights)), ("D", 0), ("M", 700))
                wire.say(
                    b"\r\n" + b"".join(f"{letter}{number:05d}\r\n".encode() for letter, number in figures), dribble
                )
            elif command == b"D":
                rows = [f"{'-' if height < 0 else ' '}{abs(height):04d}\r\n".encode() for height in heights]
                if left:
                    left -= 1
                    rows = rows[: len(rows) // 2]
                wire.say(b"\r\n" + b"Sample interval is  50 ms\r\n" + b"\r\n" + b"".join(rows), dribble)

    return device


def talking(content: bytes, dribble: random.Random | None = None, pause: float = 0.0) -> Device:
    """A unit that sends lines without being asked, with pauses [s], and then stops."""

    def device(wire: Wire) -> None:
        wire.wait_until_opened()
        for line in content.splitlines(keepends=True) if pause else [content]:
            wire.say(line, dribble)
            time.sleep(pause)
        while True:
            wire.listen(0.05)

    return device


def at_rate(baud: int, content: bytes) -> Device:
    """A unit that sends at one rate, which is noise at every other, until its cable is pulled."""

    def device(wire: Wire) -> None:
        wire.wait_until_opened()
        while wire.baud != baud:
            wire.say(b"\xfe\x80" * 16)
            time.sleep(0.02)
        wire.say(content)
        time.sleep(0.3)
        wire.unplug()

    return device


def pulled(device: Device, after: int) -> Device:
    """A unit whose cable is pulled after a number of bytes."""

    def broken(wire: Wire) -> None:
        wire.left = after
        device(wire)

    return broken


def flooded(device: Device, after: int, flood: bytes) -> Device:
    """A unit that sends garbage once after a number of bytes."""

    def babbling(wire: Wire) -> None:
        wire.flood = (after, flood)
        device(wire)

    return babbling


def deaf(wire: Wire) -> None:
    """A unit that never sends anything."""
    while True:
        wire.listen(0.05)


def arrived(folder: Path, content: bytes) -> Callable[[], bool]:
    """Whether this many bytes are on the disk, to stop an endless stream."""
    return lambda: sum(file.stat().st_size for file in folder.glob("*.raw")) >= len(content)


def noise(size: int, seed: int = 1) -> bytes:
    """Random bytes without the letters that start a record."""
    return random.Random(seed).randbytes(size).replace(b"M", b"m").replace(b"$", b"s").replace(b"@", b"a")


assert x25(b"123456789") == 0x906E
assert buypass(b"123456789") == 0xFEE8
assert binascii.hexlify(micropeak_payload(100000, 99000, [99990, 99900, 99000])) == b"a0860100b8820100030096863c86b882"
