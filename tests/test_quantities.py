"""Figures in the units that a flyer chose."""

import pytest

from fieldkit.quantities import in_system

pytestmark = pytest.mark.fast


@pytest.mark.parametrize(
    ("note", "shown"),
    [
        ("a gap between 30 m, as recorded, and 61 m", "a gap between 98 ft, as recorded, and 200 ft"),
        ("off the rail at 10 m/s", "off the rail at 22 mph"),
        ("the missing 25 m/s² are filled in", "the missing 25 m/s² are filled in"),
        ("row 7 m2 has 3 mm and version 1.5 meters", "row 7 m2 has 3 mm and version 1.5 meters"),
    ],
)
def test_a_note_states_lengths_and_speeds_in_the_units_of_the_system(note: str, shown: str) -> None:
    assert in_system(note, "US") == shown
    assert in_system(note, "SI") == note
