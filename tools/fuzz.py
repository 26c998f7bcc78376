"""Fuzzes every reader of files of unknown origin with atheris: python tools/fuzz.py [--seconds 60] [--reader NAME]

The readers are every parser of logs, and those of saved weather, designs and motor files; each is fuzzed for that long
in a process of its own. Its line has the number of inputs, how many of them reached new code, and the coverage (edges
between blocks of code) at half time and at the end: if both are equal, a longer run is unlikely to find more. A reader
starts with good files, saves new inputs in build/fuzz/NAME, from which the next run continues, and stops at its first
failure, with the input in build/fuzz. `python tools/fuzz.py --reader NAME --again FILE` runs only that input. A log is
read by its parser, and one in eight also as a flyer's import reads it, with the requirements of
tests/importing/test_bad_input.py. atheris is not a dependency: install it with pip in the same environment. Without it,
the tool prints a message, and only the test with hypothesis can be run.
"""

import argparse
import json
import re
import subprocess
import sys
import time
import warnings
import zlib
from collections import deque
from collections.abc import Callable, Mapping
from contextlib import suppress
from functools import partial
from pathlib import Path

ROOT = Path(__file__).parent.parent
FOLDER = ROOT / "build" / "fuzz"
WHOLE = 8
"""One in so many logs is also imported. [1]"""
FILES = {
    "weather": "tests/importing/weather_files/*",
    "design": "bench/faults/samples/*.ork",
    "motor file": "bench/faults/samples/*.eng",
}
"""Readers of other files than logs, and good files for each."""
sys.path.insert(0, str(ROOT))


def main() -> int:
    """Run according to the command line, and return the exit status."""
    parser = argparse.ArgumentParser(description="Fuzz every reader of files of unknown origin.")
    parser.add_argument("--seconds", type=int, default=60, help="How long each reader is fuzzed.")
    parser.add_argument("--runs", type=int, default=-1, help="So many inputs, whatever time they take.")
    parser.add_argument("--seed", type=int, default=1, help="The same seed tries the same inputs.")
    parser.add_argument("--reader", help="One reader only, by its name.")
    parser.add_argument("--again", type=Path, help="An input to run once more.")
    parser.add_argument("--list", action="store_true", help="Print the names of the readers as JSON.")
    parser.add_argument("--in-process", action="store_true", help=argparse.SUPPRESS)
    options = parser.parse_args()
    if options.list:
        print(json.dumps(list(_readers())))
        return 0
    try:
        import atheris
    except ImportError:
        print("atheris is not installed (pip install it); tests/importing/test_bad_input.py tries bad logs without it")
        return 0
    if not (options.in_process or options.again):
        names = [options.reader] if options.reader else list(_readers())
        statuses = [_in_own_process(name, sys.argv[1:], options.seconds / 2) for name in names]
        return int(any(statuses))
    read = ["parsers", "importing.tables", "importing.weather", "openrocket", "motors.rasp", "motors.rocksim"]
    with atheris.instrument_imports(include=[f"fieldkit.{name}" for name in read]):
        readers = _readers()
    warnings.simplefilter("error")
    one_input = readers[options.reader]
    if options.again:
        one_input(options.again.read_bytes())
        print("nothing wrong with it")
        return 0
    corpus, seeds = FOLDER / options.reader, FOLDER / f"{options.reader} samples"
    for folder in (corpus, seeds):
        folder.mkdir(parents=True, exist_ok=True)
    for sample in _samples(options.reader):
        (seeds / sample.name).write_bytes(sample.read_bytes()[:6000])
    limits = [f"-max_total_time={options.seconds}"] if options.runs < 0 else [f"-runs={options.runs}"]
    more = [f"-seed={options.seed}", "-max_len=8000", f"-artifact_prefix={FOLDER}/", "-print_final_stats=1"]
    atheris.Setup([sys.argv[0], *limits, *more, str(corpus), str(seeds)], one_input)
    atheris.Fuzz()
    return 0


def _in_own_process(name: str, arguments: list[str], half_time: float) -> int:
    """Fuzz one reader in a process of its own, print the result in a line, and return its exit status."""
    command = [sys.executable, __file__, *arguments, "--reader", name, "--in-process"]
    found = {"number_of_executed_units": "?", "new_units_added": "?", "half": "?", "cov": "?"}
    tail, start = deque[str](maxlen=40), time.monotonic()
    both = {"stdout": subprocess.PIPE, "stderr": subprocess.STDOUT}
    with subprocess.Popen(command, text=True, errors="replace", **both) as run:
        assert run.stdout
        for line in run.stdout:
            tail.append(line)
            if "INITED" in line:
                start = time.monotonic()
            found |= re.findall(r"\b(cov|number_of_executed_units|new_units_added): +(\d+)", line)
            if time.monotonic() - start < half_time:
                found["half"] = found["cov"]
    print(
        f"{name}: {found['number_of_executed_units']} inputs, {found['new_units_added']} of them new; coverage "
        f"{found['half']} at half time, {found['cov']} at the end; {'a failure' if run.returncode else 'no failure'}",
        flush=True,
    )
    if run.returncode:
        print("".join(tail))
    return run.returncode


def _readers() -> Mapping[str, Callable[[bytes], None]]:
    """What is called with every input, by the name of the reader."""
    from fieldkit.errors import FieldkitError
    from fieldkit.importing.recognize import parsers
    from fieldkit.importing.weather import read_weather
    from fieldkit.motors.own import sound_motors
    from fieldkit.openrocket.design import read_design
    from tests.importing.bad_input import must_hold, patience, series_must_hold

    def a_log(name: str, data: bytes) -> None:
        with patience():
            (series_must_hold if zlib.crc32(data) % WHOLE else must_hold)(data, name)

    def a_file(read: Callable[[bytes, str], object], data: bytes) -> None:
        with patience(), suppress(FieldkitError):
            read(data, "bad")

    others = {"weather": read_weather, "design": read_design, "motor file": sound_motors}
    return {name: partial(a_log, name) for name in parsers()} | {
        name: partial(a_file, read) for name, read in others.items()
    }


def _samples(reader: str) -> list[Path]:
    """Good files for a reader."""
    from tests.samples import SAMPLES, owner

    if reader in FILES:
        return sorted(ROOT.glob(FILES[reader]))
    return [sample for sample in SAMPLES if owner(sample) == reader]


if __name__ == "__main__":
    sys.exit(main())
