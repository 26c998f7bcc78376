"""Prints the versions of everything that an install consists of, as tested: `python -m tools.constraints`.

Written to `constraints.txt`, they make `pip install -c constraints.txt .` resolve the same in a year as today. The
extras for the field and for training are included; those for the manual and development are not.
"""

import tomllib
from collections.abc import Iterable
from importlib.metadata import distribution
from pathlib import Path

from packaging.requirements import Requirement
from packaging.utils import canonicalize_name
from packaging.version import Version

ROOT = Path(__file__).parent.parent
EXTRAS = ("serve", "postgres", "train")
"""Extras with fixed versions: those that a flyer installs, and the one whose results the program ships."""


def declared() -> list[str]:
    """The requirements of the program and of these extras, as `pyproject.toml` declares them."""
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    return [*project["dependencies"], *(one for name in EXTRAS for one in project["optional-dependencies"][name])]


def installed(requirements: Iterable[str]) -> dict[str, str]:
    """The installed versions of requirements and of everything that they require, by name. Raises
    PackageNotFoundError for one that is not installed."""
    found: dict[str, str] = {}
    waiting = [Requirement(one) for one in requirements]
    done: set[tuple[str, frozenset[str]]] = set()
    while waiting:
        one = waiting.pop()
        key = canonicalize_name(one.name), frozenset(one.extras)
        if key in done:
            continue
        done.add(key)
        found[canonicalize_name(one.name)] = Version(distribution(one.name).version).public  # without a build: +cpu
        waiting += required(one.name, one.extras)
    return found


def required(name: str, extras: Iterable[str] = ()) -> list[Requirement]:
    """What an installed package with these extras requires here. Raises PackageNotFoundError."""
    every = map(Requirement, distribution(name).requires or ())
    return [
        one
        for one in every
        if one.marker is None or any(one.marker.evaluate({"extra": extra}) for extra in ("", *extras))
    ]


if __name__ == "__main__":
    for name, version in sorted(installed(declared()).items()):
        print(f"{name}=={version}")
