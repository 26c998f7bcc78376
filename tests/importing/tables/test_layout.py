"""The layout of tables: which look like the samples of a log."""

import pytest

from fieldkit.importing.tables.layout import runs_like_a_log

pytestmark = pytest.mark.fast


@pytest.mark.parametrize("space", [" ", "\x1f", "\x85", "\N{NO-BREAK SPACE}"])
def test_a_clock_with_any_space_around_its_numbers_runs(space: str) -> None:
    """Fuzzing found a separator of units, which is a space to a pattern and none to a number."""
    rows = "".join(f"{number / 10:.1f}{space},{100 + number}\n" for number in range(40))
    assert runs_like_a_log(f"time,altitude\n{rows}".encode())


def test_a_clock_that_stands_does_not_run() -> None:
    rows = "".join(f"1.0,{100 + number}\n" for number in range(40))
    assert not runs_like_a_log(f"time,altitude\n{rows}".encode())
