"""A number without a unit, typed by a flyer who reads feet: the command says how it was read."""

import pytest

from tests.commands import Run

ADD = ("add", "--rocket", "Lark", "--motor", "F39-6T", "--diameter", "66mm")


@pytest.mark.parametrize(
    ("option", "read"),
    [
        (("--apogee", "812"), "note: read --apogee 812 as 812 m (2664 ft); type --apogee 812ft for ft"),
        (("--wind=8",), "note: read --wind 8 as 8 m/s (17.9 mph); type --wind 8mph for mph"),
        (("--temperature", "50"), "note: read --temperature 50 as 50 °C (122 °F); type --temperature 50F for F"),
        (("--dry-mass", "450"), "note: read --dry-mass 450 as 450 g (15.87 oz); type --dry-mass 450oz for oz"),
    ],
)
def test_a_bare_number_is_named_with_the_unit_it_was_read_in(run: Run, option: tuple[str, ...], read: str) -> None:
    run("units", "US")
    assert read in run(*ADD, *option, status=None).err.splitlines()


def test_a_bare_ceiling_of_a_plan_is_named(run: Run) -> None:
    run("units", "mixed")
    err = run("motors", "--fit", "Lark", "--waiver", "900", "--quick", status=None).err
    assert "note: read --waiver 900 as 900 m (2953 ft); type --waiver 900ft for ft" in err


def test_a_bare_number_of_a_changed_column_is_named(run: Run) -> None:
    run("units", "US")
    run(*ADD, "--apogee", "812ft")
    err = run("edit", 1, "diameter=2.6", "notes=3").err
    assert "note: read diameter=2.6 as 2.6 mm (0.10 in); type diameter=2.6in for in" in err
    assert "notes" not in err


@pytest.mark.parametrize(
    ("system", "option"),
    [
        ("SI", ("--apogee", "812")),
        ("mixed", ("--dry-mass", "450")),
        ("US", ("--apogee", "812ft")),
        ("US", ("--apogee-m", "248")),
        ("US", ("--wind", "0")),
        ("US", ("--duration", "40")),
    ],
)
def test_a_number_that_says_its_unit_or_is_read_in_the_shown_one_is_not(
    run: Run, system: str, option: tuple[str, ...]
) -> None:
    run("units", system)
    assert "note: read" not in run(*ADD, *option, status=None).err
