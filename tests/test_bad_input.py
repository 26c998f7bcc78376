"""Bad input: never a traceback, never a hang, never a number in a wrong unit without a word."""

import random
import subprocess
import sys
import time
from collections import Counter
from pathlib import Path

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from fieldkit.parsing import parsers
from tests.badinput import CHANGES, Seed, must_hold, mutated, patience, seeds
from tests.samples import SAMPLES, owner

ROOT = Path(__file__).parent.parent
SEEDS = seeds()
MANY = 50_000
LARGEST = 200.0
"""What reading a log of 100 MB may take. [MB]"""


@pytest.mark.parametrize("change", CHANGES, ids=lambda change: change.__name__)
@pytest.mark.parametrize("name", parsers())
def test_a_bad_log_brings_lines_and_no_traceback(name: str, change) -> None:  # type: ignore[no-untyped-def]
    rng = random.Random(f"{name} {change.__name__}")
    for seed in [seed for seed in SEEDS if seed.format == name][:2]:
        for _ in range(3):
            with patience():
                must_hold(change(seed.log, rng), name)


@settings(max_examples=60, deadline=None)
@given(number=st.integers(0, 2**32))
def test_any_bad_log_brings_lines_and_no_traceback(number: int) -> None:
    done, name, log = mutated(SEEDS, random.Random(number))
    with patience():
        must_hold(log, name)
    assert done


@pytest.mark.slow
def test_fifty_thousand_bad_logs_bring_lines_and_no_traceback(capsys: pytest.CaptureFixture[str]) -> None:
    begun, count, by_format = time.monotonic(), 0, Counter[str]()
    faults: dict[str, str] = {}
    while count < MANY:
        done, name, log = mutated(SEEDS, random.Random(count))
        try:
            with patience():
                must_hold(log, name)
        except Exception as error:  # every kind of fault is told of once, with what brings it back
            faults.setdefault(f"{name}: {type(error).__name__}: {str(error)[:150]}", f"seed {count}, {done}")
        count += 1
        by_format[name] += 1
    with capsys.disabled():
        took = time.monotonic() - begun
        sys.stdout.write(
            f"\n{count} bad logs of {len(SEEDS)} seeds in {took:.0f} s; {dict(sorted(by_format.items()))}\n"
        )
    assert not faults, "\n".join(f"{fault} ({where})" for fault, where in faults.items())


def test_a_unit_in_a_damaged_header_is_another_only_if_it_says_so() -> None:
    """Only the header of a table is hurt: heights stay, or their new unit is told, or the log is refused."""
    log = next(s for s in SAMPLES if s.name.startswith("mapped_table__time_three_axes")).read_bytes()
    header, rows = log.split(b"\n", 1)
    (before,) = (series.altitude.max() for item in _read(log) for series in getattr(item, "clocks", ()))
    rng = random.Random(4)
    for _ in range(300):
        hurt = bytearray(header)
        hurt[rng.randrange(len(hurt))] = rng.randrange(32, 127)
        for item in _read(bytes(hurt) + b"\n" + rows):
            for series in getattr(item, "clocks", ()):
                if series.altitude is not None:
                    assert series.altitude.max() == before or b"(ft)" not in hurt


def _read(log: bytes):  # type: ignore[no-untyped-def]
    from fieldkit.errors import FieldkitError

    try:
        return parsers()["mapped_table"].read(log)
    except FieldkitError:
        return []


BIG = """
import resource, sys, time
from pathlib import Path
from fieldkit.errors import FieldkitError
from fieldkit.parsing import read
log = Path(sys.argv[1]).read_bytes()
begun = time.monotonic()
try:
    intake = read(log, "big.log", lambda name: None, sys.argv[2])
    said = f"{len(intake.flights)} flights, {len(intake.rejected)} rejected, {len(intake.notes)} notes"
except FieldkitError as error:
    said = str(error)[:100]
used = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024
print(f"{used:.0f} MB, {time.monotonic() - begun:.1f} s, {said}")
"""


def repeated(log: bytes, size: int) -> bytes:
    """A log of a size: its rows over and over, below one header."""
    start = min(len(log) // 2, 2000)
    start = log.find(b"\n", start) + 1
    rows = log[start:] or log
    rows = rows if rows.endswith(b"\n") else rows + b"\n"
    return (log[:start] + rows * (size // len(rows) + 1))[:size]


def waited(size: int) -> bytes:
    """A logger that waited on the pad for hours: one table that goes on."""
    lines = [b"time_ms,alt_m,pressure_pa,temp_c\n"]
    lines += [b"%d,%.2f,%d,21.5\n" % (i * 5, i % 7 / 10, 99500 + i % 5) for i in range(size // 26)]
    return b"".join(lines)


@pytest.mark.slow
@pytest.mark.parametrize("name", [*parsers(), "mapped_table that goes on"])
def test_a_log_of_a_hundred_megabytes_is_read_in_little_memory(
    name: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    size = 100 * 1024 * 1024
    if name in parsers():
        sample = max((s for s in SAMPLES if owner(s) == name), key=lambda s: s.stat().st_size)
        log = repeated(sample.read_bytes(), size)
    else:
        log = waited(size)
    file = tmp_path / "big.log"
    file.write_bytes(log)
    del log
    ran = subprocess.run(
        [sys.executable, "-c", BIG, str(file), name.split()[0]],
        cwd=ROOT,
        capture_output=True,
        text=True,
        timeout=600,
        env={"PYTHONPATH": str(ROOT), "PATH": "", "HOME": str(tmp_path)},
    )
    file.unlink()
    assert ran.returncode == 0, ran.stderr[-2000:]
    with capsys.disabled():
        sys.stdout.write(f"\n{name}: {ran.stdout.strip()}\n")
    assert float(ran.stdout.split()[0]) < LARGEST


def test_seeds_are_logs_that_are_read() -> None:
    assert {seed.format for seed in SEEDS} == set(parsers())
    assert all(isinstance(seed, Seed) for seed in SEEDS)
