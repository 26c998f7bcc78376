"""Write the sample logs into sample_logs/: `python -m tools.samples [MODULE ...]`, all of them by default."""

import sys
from collections.abc import Sequence
from importlib import import_module
from pathlib import Path
from pkgutil import iter_modules

FOLDER = Path(__file__).parents[2] / "sample_logs"


def main(names: Sequence[str]) -> None:
    for found in iter_modules([str(Path(__file__).parent)]):
        if found.name == "__main__" or (names and found.name not in names):
            continue
        for make in getattr(import_module(f"tools.samples.{found.name}"), "MAKERS", ()):
            for name, content in dict(make()).items():
                (FOLDER / name).write_bytes(content)
                print(f"{len(content):7} {name}")


if __name__ == "__main__":
    main(sys.argv[1:])
