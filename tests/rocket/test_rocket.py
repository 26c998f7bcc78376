"""A rocket knows what was weighed and measured once."""

import pytest

from fieldkit.rocket import Configuration, Rocket

pytestmark = pytest.mark.fast


def test_what_the_flyer_weighed_replaces_the_design() -> None:
    designed = Configuration("Bertha", "A", dry_mass=0.08, diameter=0.0416, source="bertha.ork", weighed_mass=0.086)
    assert Rocket("Bertha", (designed,)).body("A") == {"dry_mass": 0.086, "diameter": 0.0416}


def test_a_figure_without_a_configuration_applies_to_all() -> None:
    rocket = Rocket("Bertha", (Configuration("Bertha", "", measured_diameter=0.0416), Configuration("Bertha", "A")))
    assert rocket.body("B")["diameter"] == 0.0416


def test_the_margin_is_in_diameters() -> None:
    one = Configuration("Bertha", "A", diameter=0.04, cg=0.30, cp=0.38)
    assert one.margin == pytest.approx(2.0)
    assert Configuration("Bertha", "A", cg=0.30, cp=0.38).margin is None
