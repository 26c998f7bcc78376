"""The versions in `constraints.txt` are ones that the program and its packages allow, of everything in an install."""

import sys
from collections.abc import Iterator
from importlib.metadata import PackageNotFoundError, distribution
from pathlib import Path

import pytest
from packaging.requirements import Requirement
from packaging.utils import canonicalize_name

from tools.constraints import declared, installed, required

FILE = Path(__file__).parent.parent / "constraints.txt"
LINES = FILE.read_text(encoding="utf-8").splitlines()
PINNED = dict(line.split("==") for line in LINES)


@pytest.mark.parametrize("requirement", declared())
def test_every_requirement_allows_the_version_in_the_file(requirement: str) -> None:
    one = Requirement(requirement)
    assert one.specifier.contains(PINNED[canonicalize_name(one.name)])


def test_lines_are_sorted_and_exact() -> None:
    assert sorted(PINNED) == [line.split("==")[0] for line in LINES]


def test_the_extra_for_training_has_the_version_that_the_graphs_were_made_with() -> None:
    assert PINNED["torch"] == "2.13.0"


@pytest.mark.skipif(sys.platform != "linux", reason="other systems need a few packages more, and the file is of Linux")
def test_everything_that_an_install_consists_of_is_in_the_file() -> None:
    of_flyers = [one for one in declared() if Requirement(one).name not in ("torch", "onnx")]
    assert installed(of_flyers).keys() <= PINNED.keys()


def in_the_file_and_installed() -> Iterator[str]:
    """The packages that are installed in the version of the file, so that their requirements are known."""
    for name, version in PINNED.items():
        try:
            if distribution(name).version.partition("+")[0] == version:
                yield name
        except PackageNotFoundError:
            continue


def test_the_versions_allow_one_another() -> None:
    """Otherwise pip finds no install that the file allows."""
    known = list(in_the_file_and_installed())
    one_of_each = [(name, one, PINNED.get(canonicalize_name(one.name))) for name in known for one in required(name)]
    assert not [found for found in one_of_each if found[2] and not found[1].specifier.contains(found[2])]
