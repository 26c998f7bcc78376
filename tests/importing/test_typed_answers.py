"""Typed answers: what the message about an impossible one suggests."""

import re

import pytest

from fieldkit.errors import BadValue
from fieldkit.flight.columns import COLUMNS, Column
from fieldkit.importing.manual_entry import read_answer
from fieldkit.units import UNITS


@pytest.mark.parametrize("column", COLUMNS, ids=lambda column: column.name)
def test_the_example_of_an_answer_is_a_round_number_that_is_accepted(column: Column) -> None:
    for unit in UNITS[column.quantity]:
        with pytest.raises(BadValue, match="such as ") as refused:
            read_answer(column.name, f"1e30{unit}")
        example = str(refused.value).rpartition("such as ")[2]
        assert read_answer(column.name, example) is not None
        assert re.fullmatch(r"-?(\d0*|0\.0*\d)(\D.*)?", example), example
