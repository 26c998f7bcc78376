"""The versions in `constraints.txt` are ones that the program allows."""

from pathlib import Path

import pytest
from packaging.requirements import Requirement
from packaging.utils import canonicalize_name

from tools.constraints import declared

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
