"""Rockets that are renamed, merged, and removed, by the name that stands for all their flights."""

import pytest

from tests.commands import Run

LARK = ("add", "--rocket", "Lark", "--motor", "F24-4W", "--dry-mass", "320g", "--diameter", "66mm")


@pytest.fixture
def three(run: Run) -> Run:
    """A ledger of two flights of Lark and one of Wren."""
    run(*LARK, "--apogee", "280m")
    run(*LARK, "--apogee", "284m")
    run("add", "--rocket", "Wren", "--motor", "F24-4W", "--dry-mass", "300g", "--diameter", "66mm", "--apogee", "290m")
    return run


def listed(run: Run) -> list[tuple[str, str]]:
    return [(one["rocket"], one["flight_id"]) for one in run("flights", "--json").document["flights"]]


def test_a_rocket_is_renamed_by_its_name(three: Run) -> None:
    assert three("edit", "Lark", "rocket=Robin").out == "Changed 2 flights. `fieldkit undo` to undo.\n"
    assert listed(three) == [("Robin", "1"), ("Robin", "2"), ("Wren", "1")]
    assert three("undo").out == "Undone: edit Lark/1, 2 (rocket)\n"
    assert listed(three) == [("Lark", "1"), ("Lark", "2"), ("Wren", "1")]


def test_a_merged_rocket_gets_free_numbers_and_the_known_spelling(three: Run) -> None:
    err = three("edit", "Lark", "rocket=wren").err
    assert "note: flight 1 of Lark is now 3\n" in err
    assert sorted(listed(three)) == [("Wren", "1"), ("Wren", "2"), ("Wren", "3")]


def test_the_case_of_a_name_can_be_changed(three: Run) -> None:
    three("edit", "Lark", "rocket=LARK")
    assert listed(three)[0] == ("LARK", "1")


def test_several_flights_are_changed_at_once(three: Run) -> None:
    assert three("edit", "Lark/1", "2", "site=Moor", "dry_mass=310g").out.startswith("Changed 2 flights.")
    flights = three("flights", "--json").document["flights"]
    assert [(one["site"], one["dry_mass_g"]) for one in flights] == [("Moor", 310), ("Moor", 310), ("", 300)]


def test_a_rocket_is_removed_by_its_name_and_a_single_flight_is_named(three: Run) -> None:
    assert three("remove", "Lark").out == "Removed 2 flights. `fieldkit undo` to undo.\n"
    assert listed(three) == [("Wren", "1")]
    three("undo")
    assert three("remove", "2").out == "Removed flight 2. `fieldkit undo` to undo.\n"


def test_the_name_of_a_rocket_with_several_flights_is_no_flight(three: Run) -> None:
    err = three("show", "Lark", status=1).err
    assert err == "Lark is a rocket with 2 flights, expected one of them: Lark/1 or 2\n"
    assert "Rocket     Wren" in three("show", "Wren").out


def test_a_changed_figure_is_questioned_as_a_typed_one_is(three: Run) -> None:
    err = three("edit", "2", "apogee=12000m").err
    assert "note: flight 2 of Lark is excluded from every fit: apogee of 12000 m is more than" in err
    assert "note:" not in three("edit", "2", "notes=calm").err.replace("note: flight 2 of Lark is excluded", "")


def test_a_rocket_that_is_typed_in_another_case_is_the_known_one(three: Run) -> None:
    assert "Rocket     Lark" in three("add", "--rocket", "lark", "--motor", "F24-4W", "--apogee", "281m").out
    assert listed(three)[-1] == ("Lark", "3")
