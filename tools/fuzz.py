"""Fuzzes every parser with atheris: python tools/fuzz.py [--seconds 60] [--format NAME] [--runs N]

It starts with the sample logs, saves new inputs in build/fuzz/corpus, and stops at the first failure, with its input in
build/fuzz. `python tools/fuzz.py --again FILE` runs only that input. The requirements are those of
tests/importing/test_bad_input.py. atheris is not a dependency: install it with pip in the same environment. Without it,
the tool prints a message, and only the test with hypothesis can be run.
"""

import argparse
import sys
import warnings
from pathlib import Path

ROOT = Path(__file__).parent.parent
FOLDER = ROOT / "build" / "fuzz"
sys.path.insert(0, str(ROOT))


def main() -> int:
    """Run according to the command line, and return the exit status."""
    reader = argparse.ArgumentParser(description="Fuzz every parser.")
    reader.add_argument("--seconds", type=int, default=60)
    reader.add_argument("--runs", type=int, default=-1, help="So many inputs, whatever time they take.")
    reader.add_argument("--seed", type=int, default=1, help="The same seed tries the same inputs.")
    reader.add_argument("--format", help="One parser only, by its name.")
    reader.add_argument("--again", type=Path, help="An input to run once more.")
    options = reader.parse_args()
    try:
        import atheris
    except ImportError:
        print("atheris is not installed (pip install it); tests/importing/test_bad_input.py tries bad logs without it")
        return 0
    with atheris.instrument_imports(include=["fieldkit.parsers", "fieldkit.importing.tables"]):
        from fieldkit.importing.recognize import parsers

        names = [options.format] if options.format else list(parsers())
    from tests.importing.bad_input import must_hold, patience
    from tests.samples import SAMPLES, owner

    warnings.simplefilter("error")

    def one_input(data: bytes) -> None:
        if data:
            with patience():
                must_hold(data[1:], names[data[0] % len(names)])

    if options.again:
        one_input(options.again.read_bytes())
        print("nothing wrong with it")
        return 0
    corpus, seeds = FOLDER / "corpus", FOLDER / "seeds"
    corpus.mkdir(parents=True, exist_ok=True)
    seeds.mkdir(exist_ok=True)
    for sample in SAMPLES:
        if owner(sample) in names:
            log = sample.read_bytes()
            (seeds / sample.name).write_bytes(bytes([names.index(owner(sample))]) + log[:6000])
    limits = [f"-max_total_time={options.seconds}"] if options.runs < 0 else [f"-runs={options.runs}"]
    more = [f"-seed={options.seed}", "-max_len=8000", f"-artifact_prefix={FOLDER}/", "-print_final_stats=1"]
    atheris.Setup([sys.argv[0], *limits, *more, str(corpus), str(seeds)], one_input)
    atheris.Fuzz()
    return 0


if __name__ == "__main__":
    sys.exit(main())
