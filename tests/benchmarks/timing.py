"""Processor time for benchmarks, and their rows: other load on a machine distorts wall-clock time."""

import os
import resource
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

from pytest_benchmark.fixture import BenchmarkFixture

ROOT = Path(__file__).parents[2]
ONLY_IN_TESTS = ("FIELDKIT_CHECK_SHAPES", "PYTHONDONTWRITEBYTECODE")
"""Settings for tests: an installed program is compiled once and not at every start."""
FLYER = {k: v for k, v in os.environ.items() if k not in ONLY_IN_TESTS}
FLYER |= {"PYTHONPATH": str(ROOT), "OMP_NUM_THREADS": "1"}


def of_children() -> float:
    """Processor time of finished child processes, in steps of microseconds. [s]"""
    spent = resource.getrusage(resource.RUSAGE_CHILDREN)
    return spent.ru_utime + spent.ru_stime


def whole_process(code: str) -> str:
    """The output of a separate Python process."""
    return subprocess.run([sys.executable, "-c", code], env=FLYER, check=True, stdout=subprocess.PIPE, text=True).stdout


def measured(benchmark: BenchmarkFixture, work: Callable[..., Any], *given: Any, rounds: int = 5) -> float:
    """The shortest of some rounds, after one to warm up. [s]"""
    benchmark.pedantic(work, given, rounds=rounds, warmup_rounds=1)
    return float(benchmark.stats.stats.min)


def beside(benchmark: BenchmarkFixture, seconds: float, least: float, what: str) -> float:
    """Note and print the ratio to a baseline. [1]"""
    ratio = seconds / least
    benchmark.extra_info |= {"ratio": round(ratio, 3), "beside": what}
    sys.stdout.write(f"\n{benchmark.name}: {seconds:.4g} s, {ratio:.2f} times {what} ({least:.4g} s)\n")
    return ratio
