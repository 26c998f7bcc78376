"""Bad input: never a traceback, never a hang, never a wrong unit without a note."""

import cProfile
import random
import re
import subprocess
import sys
import time
import tracemalloc
from collections import Counter
from concurrent.futures import ProcessPoolExecutor
from contextlib import suppress
from multiprocessing import get_context
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from fieldkit.errors import FieldkitError
from fieldkit.flight import Series
from fieldkit.importing import Mapped, Reading
from fieldkit.importing.recognize import parsers
from tests.effort import examples
from tests.importing.bad_input import CHANGES, Seed, faults_among, lines_for, must_hold, mutated, patience, seeds
from tests.samples import SAMPLES, owner, samples_of

ROOT = Path(__file__).parents[2]
MANY = 50_000
LARGEST = 200.0
"""Maximum memory for reading a log of 100 MB. [MB]"""


@pytest.mark.sampled
@pytest.mark.parametrize("change", CHANGES, ids=lambda change: change.__name__)
@pytest.mark.parametrize("name", parsers())
def test_a_bad_log_gives_messages_and_no_traceback(name: str, change) -> None:  # type: ignore[no-untyped-def]
    rng = random.Random(f"{name} {change.__name__}")
    seed = rng.choice([seed for seed in seeds() if seed.format == name])
    with patience():
        must_hold(change(seed.log, rng), name)


@examples(30)
@given(number=st.integers(0, 2**32))
def test_any_bad_log_gives_messages_and_no_traceback(number: int) -> None:
    done, name, log = mutated(seeds(), random.Random(number))
    with patience():
        must_hold(log, name)
    assert done


def test_a_table_broken_up_by_quotation_marks_is_read_or_refused() -> None:
    log = next(s for s in SAMPLES if s.name == "openrocket__semicolons_and_german_names.csv").read_bytes()
    must_hold(log.replace(b";", b'"'), "openrocket")


FALLING_AT_BURNOUT = (
    b"~~ MP",
    b"ab800100e27b01006200887f237fc57e",
    b"717e1f7ed67d947d567d9c7de67cb67c",
    b"8c7cc7de67cb67c",
    b"8c7c697c497c2b7c137c047ce" + 48 * b"\xff" + b"f7bea7b",
    b"e67be07be77bf97b157c2e7c467c6a7c",
    b"8e7caf7ccf7ced7c0a7d317d527d747d",
    b"9a7db87dd97dfb7d137e277e3a7e4e7e",
    b"5d7e697e7c7e877e906ea37eaf7eb97e",
    b"c0c7ed77ee47ef47efa7e0a7f%1a7f297f",
    b"347f407f4e7f5e7f6e7f757f817f9'47f",
    b"a17fad7fbf7fcd7fd67fe47ff57fff7f",
    b"0a8018061806c80",
    b"788084809a80a680a680a880ad80a955",
    b"ab80ad80ab80aa80a980ab80a\x00c80",
    b"774d",
    b"",
)
"""Lines of a damaged log that a fuzzer found: its heights fall where they seem to show burnout."""


def test_a_log_that_falls_at_burnout_has_no_boost_and_no_warning() -> None:
    must_hold(b"\r\n".join(FALLING_AT_BURNOUT), "micropeak")


@pytest.mark.slow
def test_fifty_thousand_bad_logs_give_messages_and_no_traceback(capsys: pytest.CaptureFixture[str]) -> None:
    started, tried, faults = time.monotonic(), Counter[str](), dict[str, str]()
    with ProcessPoolExecutor(mp_context=get_context("spawn")) as pool:
        for some, found in pool.map(faults_among, [range(i, i + 500) for i in range(0, MANY, 500)]):
            tried += some
            faults = {**found, **faults}
    with capsys.disabled():
        counts = ", ".join(f"{name} {number}" for name, number in sorted(tried.items()))
        elapsed = time.monotonic() - started
        sys.stdout.write(f"\n{tried.total()} bad logs of {len(seeds())} seeds in {elapsed:.0f} s: {counts}\n")
    assert tried.total() >= MANY
    assert not faults, "\n".join(f"{fault}: {where}" for fault, where in faults.items())


def test_a_damaged_header_is_refused_or_its_unit_is_right() -> None:
    """One letter of the header is wrong and the rows are complete: heights do not change, or a height in ft is not
    used."""
    log = next(s for s in SAMPLES if s.name.startswith("mapped_table__time_three_axes")).read_bytes()
    header, rows = log.split(b"\n", 1)
    rng = random.Random(4)
    whole = 0
    for _ in range(300):
        hurt = bytearray(header)
        hurt[rng.randrange(len(hurt))] = rng.choice(b"abmfs([ )#")
        if hurt.count(b",") != header.count(b","):
            continue  # a row of names that is one cell short is another table
        for series, line in _read(bytes(hurt) + b"\n" + rows):
            whole += 1
            if series.altitude is not None:
                top = 250.9 if "in ft" in line.split("altitude = ")[1] else 250.9 / 0.3048
                assert series.altitude.max() == pytest.approx(top, rel=0.01), line
    assert whole > 150


def _read(log: bytes) -> list[tuple[Series, str]]:
    """The series of a table, each with the note on how it was read; empty if the table is refused."""
    try:
        items = parsers()["mapped_table"].read(log)
    except FieldkitError:
        return []
    (line,) = (item.text for item in items if isinstance(item, Mapped))
    return [(series, line) for item in items if isinstance(item, Reading) for series in item.clocks]


BIG = """
import resource, sys, time
from pathlib import Path
from fieldkit.errors import FieldkitError
from fieldkit.services.imports import ReadAs, gather
start = time.monotonic()
try:
    got = gather([Path(sys.argv[1])], lambda name: None, ReadAs(sys.argv[2]))
    said = f"{len(got.incoming_flights)} flights, {len(got.rejected)} rejected, {len(got.notes)} notes"
except FieldkitError as error:
    said = str(error)[:100]
used = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024
print(f"{used:.0f} MB, {time.monotonic() - start:.1f} s, {said}")
"""
"""Reads a file as `fieldkit import` does, before a ledger is opened."""


in_kilobytes = pytest.mark.skipif(
    sys.platform != "linux", reason="other systems report peaks differently, or not at all"
)


CLEAN = "import subprocess, sys; sys.exit(subprocess.call(sys.argv[1:]))"
"""Starts a process that does not inherit the peak memory of the test process."""


def run_clean(home: Path, code: str, *arguments: str) -> subprocess.CompletedProcess[str]:
    """Run a program in a separate process, which must succeed."""
    ran = subprocess.run(
        [sys.executable, "-c", CLEAN, sys.executable, "-c", code, *arguments],
        cwd=ROOT,
        capture_output=True,
        text=True,
        timeout=600,
        env={"PYTHONPATH": str(ROOT), "PATH": "", "HOME": str(home)},
    )
    assert ran.returncode == 0, ran.stderr[-2000:]
    return ran


def write_repeated(file: Path, log: bytes, size: int) -> None:
    """A log of a given size: its rows repeated below one header."""
    start = log.find(b"\n", min(len(log) // 2, 2000)) + 1
    rows = log[start:] or log
    rows = rows if rows.endswith(b"\n") else rows + b"\n"
    with file.open("wb") as stream:
        stream.write(log[:start])
        while stream.tell() < size:
            stream.write(rows)
        stream.truncate(size)


def write_going_on(file: Path, log: bytes, size: int) -> None:
    """A log of a given size whose rows repeat, while its clocks, the columns that always grow, continue."""
    separator, rows, clocks = clocks_of(log)
    head = log[: log.index(separator.join(rows[0]))]
    span = [float(rows[-1][c]) - float(rows[0][c]) + float(rows[1][c]) - float(rows[0][c]) for c in clocks]
    with file.open("wb") as stream:
        stream.write(head)
        for turn in range(size):
            for cells in rows:
                for clock, more in zip(clocks, span, strict=True):
                    cells[clock] = b"%.4f" % (float(cells[clock]) + more * (turn > 0))
                stream.write(separator.join(cells) + b"\n")
            if stream.tell() > size:
                break
        stream.truncate(size)


def clocks_of(log: bytes) -> tuple[bytes, list[list[bytes]], list[int]]:
    """The separator of a table, its longest run of rows in which a column increases, and all columns that increase
    there."""
    lines = log.replace(b"\r", b"").split(b"\n")[1:-1]
    for separator in (b",", b"\t", b";"):
        widths = Counter(line.count(separator) for line in lines)
        width = max(widths, key=widths.__getitem__, default=0)
        rows = [line.split(separator) for line in lines if line.count(separator) == width]
        columns = [np.array([number(cells[place]) for cells in rows]) for place in range(width + 1)]
        start, stop = max((longest_growth(one) for one in columns), key=lambda run: run[1] - run[0], default=(0, 0))
        if width and stop - start > 50:
            grows = [i for i, one in enumerate(columns) if (np.diff(one[start:stop]) > 0).all()]
            return separator, rows[start:stop], grows
    return b"", [], []


def longest_growth(values: np.ndarray) -> tuple[int, int]:
    """Start and end of the longest run of increasing numbers."""
    ends = np.flatnonzero(~(np.diff(values) > 0))
    bounds = np.concatenate([[-1], ends, [len(values) - 1]])
    run = int(np.argmax(np.diff(bounds)))
    return int(bounds[run]) + 1, int(bounds[run + 1]) + 1


def number(cell: bytes) -> float:
    try:
        return float(cell)
    except ValueError:
        return float("nan")


def biggest(name: str) -> bytes:
    """The largest sample log of a parser."""
    return max(samples_of(name), key=lambda sample: sample.stat().st_size).read_bytes()


SAMPLED = sorted({owner(sample) for sample in SAMPLES} & parsers().keys())
WHOLE = [*parsers(), *(f"{name} without an end" for name in SAMPLED if clocks_of(biggest(name))[2])]
"""Every parser, and again those of logs with a clock in their rows, for one that does not end."""


def write_waiting(file: Path, size: int, flown: bool = False) -> None:
    """A logger that waited on the pad for hours, and may have flown at the end: one very long table."""
    with file.open("wb") as stream:
        stream.write(b"time_ms,alt_m,pressure_pa,temp_c\n")
        waited = size // 26
        for i in range(waited + 12_000 * flown):
            height = flown_height((i - waited) * 0.005)
            stream.write(b"%d,%.2f,%d,21.5\n" % (i * 5, height + i % 7 / 10, 99500 + i % 5 - height * 11.8))


def flown_height(time: float) -> float:
    """Height of a flight: a second under thrust to 80 m/s, up to 366 m and down at 8 m/s. [m]"""
    if time < 1:
        return 40 * max(time, 0.0) ** 2
    coast = time - 1
    return 40 + 80 * coast - 4.9 * coast**2 if coast < 8.16 else max(0.0, 366.5 - 8 * (coast - 8.16))


def write_torn(file: Path, log: bytes, size: int) -> None:
    """The beginning of a log, followed only by truncated lines."""
    lines = log.splitlines(keepends=True)
    halves = b"".join(line[: len(line) // 2] + b"\n" for line in lines[len(lines) // 2 :])
    with file.open("wb") as stream:
        stream.write(b"".join(lines[: len(lines) // 2]))
        while stream.tell() < size:
            stream.write(halves)


def write_remarks(file: Path, log: bytes, size: int) -> None:
    """A log, followed only by comments."""
    with file.open("wb") as stream:
        stream.write(log)
        while stream.tell() < size:
            stream.write(b"# Event APOGEE occurred at t=3.2 seconds\n" * 1000)


CAPPED = {"altos_eeprom": 31 << 20, "altos_telem": 31 << 20}
"""Longest log that parsers with a limit accept. [bytes]"""
REMARKED = ("altos_csv", "arts2", "openrocket")
"""Parsers that keep comments apart."""
HURT = [*(f"{name} that is torn" for name in parsers()), *(f"{name} of remarks" for name in REMARKED)]


@in_kilobytes
@pytest.mark.slow
@pytest.mark.parametrize("name", [*WHOLE, *HURT, "mapped_table that waits"])
def test_a_log_of_a_hundred_megabytes_is_read_in_little_memory(
    name: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    size = 100 * 1024 * 1024
    file = tmp_path / "big.log"
    if name in parsers():
        write_repeated(file, biggest(name), size)
    elif name.endswith("without an end"):
        write_going_on(file, biggest(name.split()[0]), size)
    elif name.endswith("is torn"):
        write_torn(file, biggest(name.split()[0]), CAPPED.get(name.split()[0], size))
    elif name.endswith("remarks"):
        write_remarks(file, biggest(name.split()[0]), size)
    else:
        write_waiting(file, size)
    ran = run_clean(tmp_path, BIG, str(file), name.split()[0])
    file.unlink()
    with capsys.disabled():
        sys.stdout.write(f"\n{name}: {ran.stdout.strip()}\n")
    assert float(ran.stdout.split()[0]) < LARGEST


TORN = 8_000, 16_000, 24_000
"""Lengths of truncated logs. [bytes]"""


def read_in_vain(name: str, log: bytes) -> None:
    with suppress(FieldkitError):
        parsers()[name].read(log)


def calls(name: str, log: bytes) -> int:
    """Number of calls for reading a log, the same on any machine. [1]"""
    profile = cProfile.Profile()
    profile.runcall(read_in_vain, name, log)
    return sum(entry.callcount for entry in profile.getstats())


def peak(name: str, log: bytes) -> int:
    """Peak memory for reading a log. [bytes]"""
    tracemalloc.start()
    try:
        read_in_vain(name, log)
        return tracemalloc.get_traced_memory()[1]
    finally:
        tracemalloc.stop()


@pytest.mark.sampled
@pytest.mark.parametrize("name", parsers())
def test_work_and_memory_grow_no_faster_than_a_log(name: str, tmp_path: Path) -> None:
    logs = []
    for size in TORN:
        write_torn(tmp_path / "torn.log", biggest(name)[: TORN[0]], size)
        logs.append((tmp_path / "torn.log").read_bytes()[:size])
        read_in_vain(name, logs[-1])  # warm up: some things are read only once
    small, medium, large = (calls(name, log) for log in logs)
    assert large - medium < 1.35 * (medium - small) + 1_000
    assert peak(name, logs[-1]) < 64 * len(logs[-1])


IMPORT = """
import resource, sys
from fieldkit.cli.main import main
try:
    main()
finally:
    print(f"{resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024:.0f} MB", file=sys.stderr)
"""


@in_kilobytes
@pytest.mark.slow
def test_a_hundred_megabytes_with_a_flight_at_their_end_are_imported_in_little_memory(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    file = tmp_path / "big.csv"
    write_waiting(file, 100 * 1024 * 1024, flown=True)
    ran = run_clean(tmp_path, IMPORT, "--ledger", str(tmp_path / "ledger.db"), "import", str(file))
    file.unlink()
    assert "Imported 1," in ran.stdout
    assert "no figure" not in ran.stderr
    used = ran.stderr.split("\n")[-2]
    with capsys.disabled():
        sys.stdout.write(f"\nfieldkit import: {used}\n")
    assert float(used.split()[0]) < LARGEST


def test_seeds_are_readable_logs() -> None:
    assert {seed.format for seed in seeds()} == set(parsers())
    assert all(isinstance(seed, Seed) for seed in seeds())


def test_a_log_whose_column_of_time_has_another_name_is_refused_in_a_line() -> None:
    log = next(s for s in SAMPLES if s.name.startswith("perfectflite__")).read_bytes()
    renamed = log.replace(b"(Time,", b"(Timely,")
    assert renamed != log
    assert any("found no column of time" in line for line in lines_for(renamed, "perfectflite"))


@pytest.mark.parametrize("sample", SAMPLES, ids=lambda sample: sample.stem)
def test_numbers_that_overflow_when_squared_are_refused(sample: Path) -> None:
    """In every cell of every seventh row of the second half; warnings are errors."""
    rows = sample.read_bytes().split(b"\n")
    for place in range(len(rows) // 2, len(rows), 7):
        rows[place] = re.sub(rb"(?<![\w.])\d+\.\d+", b"1e308", rows[place])
    must_hold(b"\n".join(rows), owner(sample))
