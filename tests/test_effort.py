"""A run that is not thorough tries a part of the cases: always the same, and never none."""

import pytest

from tests import effort
from tests.effort import examples, left_out, part

pytestmark = pytest.mark.fast


class Case:
    """A case of a test, as pytest collects it."""

    def __init__(self, nodeid: str, sampled: bool = True) -> None:
        self.nodeid, self.sampled = nodeid, sampled

    def get_closest_marker(self, name: str) -> bool:
        return self.sampled and name == "sampled"


@pytest.mark.parametrize(("count", "remaining"), [(1, 1), (3, 1), (4, 1), (5, 2), (40, 10)])
def test_a_quarter_of_the_cases_of_a_sampled_test_is_kept(count: int, remaining: int) -> None:
    cases = [Case(f"tests/test_a.py::test_b[{number}]") for number in range(count)]
    others = [Case(f"tests/test_a.py::test_c[{number}]", sampled=False) for number in range(3)]
    out = left_out([*cases, *others])  # type: ignore[list-item]
    assert len(cases) - len(out) == remaining
    assert not out & {*others}
    assert out == left_out([*reversed(cases)])  # type: ignore[list-item]


def test_the_thorough_run_tries_all_cases(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(effort, "THOROUGH", False)
    assert [part(range(10), start) for start in (0, 1, 5)] == [range(0, 10, 4), range(1, 10, 4), range(1, 10, 4)]
    assert examples(100).max_examples == 25
    monkeypatch.setattr(effort, "THOROUGH", True)
    assert part(range(10), 3) == range(10)
    assert examples(100).max_examples == 100
