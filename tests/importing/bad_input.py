"""Logs damaged as by cables, memories, spreadsheets and attackers, and rules that must still hold."""

import random
import signal
import traceback
import unicodedata
import warnings
from collections import Counter
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from functools import cache
from pathlib import Path

import numpy as np

from fieldkit.errors import FieldkitError
from fieldkit.importing import Reading
from fieldkit.importing.read import read
from fieldkit.importing.recognize import claims, parsers
from tests.samples import SAMPLES, any_motor, owner

RECORDED = Path(__file__).parents[3] / "shared" / "logs"
SEED_SIZE = 9_000
"""Only the beginning and end of a longer log are used as a seed, so that many can be tried. [bytes]"""
PATIENCE = 20.0
"""An input that takes more processor time than this counts as hanging. [s]"""

Change = Callable[[bytes, random.Random], bytes]


@dataclass(frozen=True, slots=True)
class Seed:
    """A good log, and the parser that reads it."""

    name: str
    format: str
    log: bytes


@cache
def seeds() -> list[Seed]:
    """Every sample log, and every real recording if there are any."""
    found = [Seed(sample.name, owner(sample), _short(sample.read_bytes())) for sample in SAMPLES]
    for file in sorted(filter(Path.is_file, RECORDED.glob("*"))):
        log = file.read_bytes()
        names = claims(log)
        if len(names) == 1:
            found.append(Seed(file.name, names[0], _short(log)))
    return found


def _short(log: bytes) -> bytes:
    if len(log) <= SEED_SIZE:
        return log
    end = log[-SEED_SIZE // 4 :]
    return log[: SEED_SIZE * 3 // 4] + b"\n" + end[end.find(b"\n") + 1 :]


def _place(log: bytes, rng: random.Random) -> int:
    """A random position in a log; in its head, which has the header, every second time."""
    return rng.randrange(min(len(log), 400) + 1 if rng.random() < 0.5 else len(log) + 1)


def cut(log: bytes, rng: random.Random) -> bytes:
    """Cut off at the end, at the beginning, or in the middle."""
    a, b = sorted((_place(log, rng), _place(log, rng)))
    return rng.choice((log[:a], log[a:], log[:a] + log[b:]))


def doubled(log: bytes, rng: random.Random) -> bytes:
    """A part, a line or the whole is repeated."""
    a, b = sorted((_place(log, rng), _place(log, rng)))
    return rng.choice((log + log, log[:b] + log[a:], log[:a] + log))


def flipped(log: bytes, rng: random.Random) -> bytes:
    """Some bits are wrong."""
    mangled = bytearray(log)
    for _ in range(rng.choice((1, 1, 2, 5, 40))):
        if mangled:
            mangled[min(_place(log, rng), len(mangled) - 1)] ^= 1 << rng.randrange(8)
    return bytes(mangled)


def encodings_mixed(log: bytes, rng: random.Random) -> bytes:
    """A part, or the whole, in another encoding, or a byte order mark if none belongs."""
    a, b = sorted((_place(log, rng), _place(log, rng)))
    text = log[a:b].decode("latin-1")
    other = text.encode(rng.choice(("utf-16-le", "utf-16-be", "utf-16", "utf-8-sig", "utf-32")))
    bad = rng.choice((b"\xff\xfe", b"\xfe\xff", b"\xef\xbb\xbf", b"\xb2\xbd\xb5", b"\xe2\x80", b"\xed\xa0\x80"))
    whole = log.decode("latin-1").encode(rng.choice(("utf-16", "utf-16-le", "utf-16-be")))
    return rng.choice((log[:a] + other + log[b:], log[:a] + bad + log[a:], whole))


def padded(log: bytes, rng: random.Random) -> bytes:
    """Memory that was never written: NUL or 0xff, at the end, at the beginning or within."""
    filling = rng.choice((b"\0", b"\xff", b"\0\xff")) * rng.choice((1, 16, 512, 70_000))
    place = rng.choice((0, len(log), _place(log, rng)))
    return log[:place] + filling + log[place:]


def escaped(log: bytes, rng: random.Random) -> bytes:
    """Characters that would move a cursor, set a title, clear a screen or reverse a line."""
    escapes = (
        "\x1b[2J",
        "\x1b]0;x\x07",
        "\x9b31m",
        "\u202e",
        "\u2028",
        "\r\x1b[A",
        "\x08" * 9,
        "[red]",
        "\x00",
        "%s{}",
    )
    place = _place(log, rng)
    return log[:place] + rng.choice(escapes).encode() + log[place:]


NUMBERS = (
    *(
        "1e308",
        "-1e308",
        "1e999",
        "nan",
        "NaN",
        "inf",
        "-0",
        "",
        "1_000",
        "\u0661\u0662",
        "0x1F",
        "1e-320",
        "--5",
        "1,5",
    ),
    *("1_000", "2147483647", "4294967296", "99999999999999999999", "-9223372036854775808", "1" * 5000),
)


def numbers_replaced(log: bytes, rng: random.Random) -> bytes:
    """Cells with values that no sensor reports."""
    lines = log.split(b"\n")
    for _ in range(rng.choice((1, 3, 30))):
        at = rng.randrange(len(lines))
        separator = rng.choice((b",", b";", b"\t", b" "))
        cells = lines[at].split(separator)
        cells[rng.randrange(len(cells))] = rng.choice(NUMBERS).encode()
        lines[at] = separator.join(cells)
    return b"\n".join(lines)


def a_column_replaced(log: bytes, rng: random.Random) -> bytes:
    """The same cell of every row is equal or empty."""
    separator = rng.choice((b",", b";", b"\t"))
    place, filling = rng.randrange(9), rng.choice((*NUMBERS, "0", "1")).encode()
    lines = [line.split(separator) for line in log.split(b"\n")]
    start = rng.choice((0, 1, 9))
    for cells in lines[start:]:
        if len(cells) > place:
            cells[place] = filling
    return b"\n".join(separator.join(cells) for cells in lines)


def lines_moved(log: bytes, rng: random.Random) -> bytes:
    """Lines in another order, lost, or joined."""
    lines = log.split(b"\n")
    a, b = sorted((rng.randrange(len(lines)), rng.randrange(len(lines))))
    part = lines[a : b + 1]
    kind = rng.randrange(4)
    if kind == 0:
        rng.shuffle(part)
    elif kind == 1:
        part.reverse()
    elif kind == 2:
        part = [line for line in part if rng.random() < 0.5]
    else:
        part = [b"".join(part)]
    return b"\n".join(lines[:a] + part + lines[b + 1 :])


def ends_of_lines_changed(log: bytes, rng: random.Random) -> bytes:
    """Other line endings, or spaces and quotation marks if there were none."""
    new = rng.choice((b"\r\n", b"\r", b"\n\n", b"\x0b", b"\xc2\x85", b' "\n', b'"\n', b" \n", b",\n", b""))
    if rng.random() < 0.5:
        return log.replace(b"\n", new)
    place = _place(log, rng)
    return log[:place] + log[place:].replace(b"\n", new)


def separators_changed(log: bytes, rng: random.Random) -> bytes:
    """Another separator or decimal mark."""
    old = rng.choice((b",", b".", b";", b"\t", b" ", b":", b"$", b"@", b"{"))
    return log.replace(old, rng.choice((b",", b".", b";", b"\t", b" ", b"", b'"', b",,")), rng.choice((1, 20, -1)))


def header_changed(log: bytes, rng: random.Random) -> bytes:
    """A name, a unit or a number in the first lines comes from another log."""
    words = (b"(ft)", b"(m)", b"ft", b"m", b"(s)", b"ms", b"time", b"Altitude", b"Pressure", b"F)", b"C)", b"g", b"#")
    return log.replace(rng.choice(words), rng.choice(words), rng.choice((1, 2, -1)))


CHANGES: Sequence[Change] = (
    cut,
    doubled,
    flipped,
    encodings_mixed,
    padded,
    escaped,
    numbers_replaced,
    a_column_replaced,
    lines_moved,
    ends_of_lines_changed,
    separators_changed,
    header_changed,
)


def mutated(all_seeds: Sequence[Seed], rng: random.Random) -> tuple[str, str, bytes]:
    """A bad log: its seed, the damage, its format, its bytes; one in ten is combined with another seed."""
    seed = rng.choice(all_seeds)
    log, done = seed.log, []
    if rng.random() < 0.1:
        other = rng.choice(all_seeds)
        log = log[: _place(log, rng)] + other.log[_place(other.log, rng) :]
        done.append(f"graft of {other.name}")
    for _ in range(rng.choice((1, 1, 1, 2, 3))):
        change = rng.choice(CHANGES)
        log = change(log, rng)[:120_000]
        done.append(change.__name__)
    return f"{seed.name}: {', '.join(done)}", seed.format, log


def faults_among(numbers: range) -> tuple[Counter[str], dict[str, str]]:
    """The number of bad logs checked of each format, and every kind of fault with an example."""
    all_seeds, tried, faults = seeds(), Counter[str](), dict[str, str]()
    for number in numbers:
        done, name, log = mutated(all_seeds, random.Random(number))
        tried[name] += 1
        try:
            with patience(), warnings.catch_warnings():
                warnings.simplefilter("error")
                must_hold(log, name)
        except Exception as error:  # every kind of fault is one
            where = [f"{Path(step.filename).name}:{step.lineno}" for step in traceback.extract_tb(error.__traceback__)]
            kind = f"{name}: {type(error).__name__} {str(error)[:150]} ({where[-1]})"
            faults.setdefault(kind, f"random.Random({number}), {done}")
    return tried, faults


@contextmanager
def patience(seconds: float = PATIENCE) -> Iterator[None]:
    """Raises TimeoutError if the block takes too long."""

    def on_progress(signal_number: int, frame: object) -> None:
        raise TimeoutError(f"took more than {seconds} s")

    before = signal.signal(signal.SIGPROF, on_progress)
    signal.setitimer(signal.ITIMER_PROF, seconds)
    try:
        yield
    finally:
        signal.setitimer(signal.ITIMER_PROF, 0)
        signal.signal(signal.SIGPROF, before)


def lines_for(log: bytes, format: str | None) -> list[str]:
    """Every line that a flyer would see for a log; anything but a FieldkitError is a bug and is raised."""
    try:
        imported = read(log, "bad.log", any_motor, format)
    except FieldkitError as error:
        return [str(error)]
    return [*(f"{r.file}, row {r.row}, {r.column}: {r.error}" for r in imported.rejected), *imported.notes]


def must_hold(log: bytes, format: str | None) -> int:
    """Check one bad log, read by the parser it was made for or by the one that recognizes it; the number of lines
    shown.

    Messages are single lines without control characters; series have whole clocks that never run backwards, and
    channels of one length without infinities.
    """
    lines = lines_for(log, format)
    if format is None or claims(log) != [format]:
        lines += lines_for(log, None)
    for line in lines:
        assert len(line) < 4000, f"a message of {len(line)} characters"
        bad = [char for char in line if unicodedata.category(char) in ("Cc", "Cs", "Zl", "Zp")]
        assert not bad, f"{bad[:5]!r} in a message: {line[:300]!r}"
    if format is not None:
        series_must_hold(log, format)
    return len(lines)


def series_must_hold(log: bytes, format: str) -> None:
    """Check the series that a parser reads in a bad log."""
    try:
        found = parsers()[format].read(log)
    except FieldkitError:
        return
    for item in found:
        for series in item.clocks if isinstance(item, Reading) else ():
            assert np.isfinite(series.time).all(), "a clock that is no number"
            assert (np.diff(series.time) >= 0).all(), "a clock that runs backwards"
            for channel in series.__slots__:
                values = getattr(series, channel)
                assert values is None or values.shape == series.time.shape, f"{channel} has a length of its own"
                assert values is None or not np.isinf(values).any(), f"{channel} is infinite"
        if isinstance(item, Reading):
            assert all(abs(time) < 1e30 for time in item.events.values()), "an event at no time"
