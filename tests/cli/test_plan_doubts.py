"""A plan far from what its rocket flew with is forecast, with a note; a diameter that nobody gave is named."""

from tests.commands import Run

FLOWN = ("--rocket", "Lark", "--motor", "F24-4W", "--dry-mass", "320g", "--diameter", "66mm", "--apogee", "250m")


def test_a_mass_and_a_tube_far_from_those_flown_are_named(run: Run) -> None:
    run("add", *FLOWN)
    err = run("predict", "--motor", "F24-4W", "--dry-mass", "32g", "--diameter", "54mm").err
    assert "note: dry mass 32 g, but 320 g in the last flight\n" in err
    assert "note: diameter 54 mm, but 66 mm in the last flight; with another tube it is another configuration\n" in err
    assert "in the last flight" not in run("predict", "--motor", "F24-4W", "--dry-mass", "340g").err


def test_the_assumed_diameter_of_a_drag_coefficient_is_named(run: Run) -> None:
    plan = ("predict", "--rocket", "Wren", "--motor", "F24-4W", "--dry-mass", "320g")
    assert "for a diameter usual at its mass: its own is not given" in run(*plan).out
    assert "usual at its mass" not in run(*plan, "--diameter", "66mm").out


def test_the_motor_guide_names_its_target(run: Run) -> None:
    run("add", *FLOWN)
    guide = ("motors", "--fit", "Lark", "--mount", "24mm", "--quick")
    assert "\ntarget  244 m\n" in run(*guide, "--target", "800ft").out
    assert "target" not in run(*guide).out
