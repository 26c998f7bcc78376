"""Center of pressure and of gravity of a design from its parts: Barrowman's formulas by hand, and laws."""

import math
from dataclasses import replace
from pathlib import Path

import pytest

from fieldkit.motors import catalogue
from fieldkit.openrocket import Design, read_design
from tests.commands import Run

CHECK_SHAPES = False

pytestmark = pytest.mark.fast

PAPER = '<material type="bulk" density="700">Paper</material>'
NOSE = f"""<nosecone>{PAPER}<length>0.1</length><thickness>0.001</thickness><shape>{{}}</shape>
<aftradius>0.025</aftradius></nosecone>"""
TRAPEZOID = f"""<trapezoidfinset><fincount>{{}}</fincount>{PAPER}<axialoffset method="bottom">0</axialoffset>
<thickness>0.003</thickness><rootchord>0.08</rootchord><tipchord>0.04</tipchord><sweeplength>0.04</sweeplength>
<height>0.05</height></trapezoidfinset>"""
POINTS = ((0.0, 0.0), (0.04, 0.05), (0.08, 0.05), (0.08, 0.0))
FREEFORM = f"""<freeformfinset><fincount>3</fincount>{PAPER}<axialoffset method="bottom">0</axialoffset>
<thickness>0.003</thickness><finpoints>{"".join(f'<point x="{x}" y="{y}"/>' for x, y in POINTS)}</finpoints>
</freeformfinset>"""
ELLIPSE = f"""<ellipticalfinset><fincount>3</fincount>{PAPER}<axialoffset method="bottom">0</axialoffset>
<thickness>0.003</thickness><rootchord>0.08</rootchord><height>0.05</height></ellipticalfinset>"""
MOUNT = f"""<innertube>{PAPER}<axialoffset method="bottom">0</axialoffset><length>0.075</length>
<outerradius>0.0125</outerradius><thickness>0.0005</thickness><motormount><overhang>0.005</overhang>
<motor configid="a"><manufacturer>AeroTech</manufacturer><designation>F24W</designation><delay>4</delay></motor>
</motormount></innertube>"""


def read(fins: str = TRAPEZOID.format(3), shape: str = "conical", entered: str = "") -> Design:
    return read_design(content(fins, shape, entered), "a.ork")


def content(fins: str = TRAPEZOID.format(3), shape: str = "conical", entered: str = "") -> bytes:
    """A rocket of 50 mm with a nose of 0.1 m and a tube of 0.4 m."""
    tube = f"""<bodytube>{PAPER}<length>0.4</length><thickness>0.001</thickness><radius>0.025</radius>
<subcomponents>{fins}{MOUNT}</subcomponents></bodytube>"""
    stage = f"<stage>{entered}<subcomponents>{NOSE.format(shape)}{tube}</subcomponents></stage>"
    rocket = f"<rocket><name>A</name><subcomponents>{stage}</subcomponents></rocket>"
    return f'<openrocket version="1.9">{rocket}</openrocket>'.encode()


def cp(design: Design) -> float:
    assert design.balance is not None
    return design.balance.cp


def test_the_center_of_pressure_is_barrowmans() -> None:
    """Nose: 2 per radian at two thirds of a cone. Fins: 4 N (s / d)^2 / (1 + sqrt(1 + (2 l / (a + b))^2)) times 1 + r /
    (s + r), at x / 3 (a + 2 b) / (a + b) + (a + b - a b / (a + b)) / 6 (Barrowman, as in Centuri's report TIR-33)."""
    middle = math.hypot(0.05, 0.04 + 0.02 - 0.04)
    fins = 12 / (1 + math.sqrt(1 + (2 * middle / 0.12) ** 2)) * (1 + 0.025 / 0.075)
    place = 0.42 + 0.04 / 3 * 0.16 / 0.12 + (0.12 - 0.08 * 0.04 / 0.12) / 6
    assert cp(read()) == pytest.approx((2 * 0.1 * 2 / 3 + fins * place) / (2 + fins), abs=2e-4)


def test_a_freeform_fin_of_the_same_outline_has_the_same_center() -> None:
    swept = TRAPEZOID.format(3)
    assert cp(read(FREEFORM)) == pytest.approx(cp(read(swept)), abs=3e-4)


def test_an_ogive_has_its_center_of_pressure_at_466_thousandths_and_an_elliptical_fin_at_288() -> None:
    """Barrowman's figures for slender ones; fins without span leave the force of the nose alone."""
    none = TRAPEZOID.format(3).replace("<height>0.05</height>", "<height>0</height>")
    assert cp(read(none, "ogive")) == pytest.approx(0.0466, abs=1e-3)
    assert cp(read(none)) == pytest.approx(0.1 * 2 / 3, abs=2e-4)
    both, nose = cp(read(ELLIPSE)), 0.1 * 2 / 3
    area = math.pi / 4 * 0.08 * 0.05
    fins = 12 / (1 + math.sqrt(1 + (0.05**2 / area) ** 2)) * (1 + 0.025 / 0.075)
    assert both == pytest.approx((2 * nose + fins * (0.42 + 0.288 * 0.08)) / (2 + fins), abs=4e-4)


def test_more_fins_move_the_center_of_pressure_back_and_a_heavier_motor_the_margin_down() -> None:
    assert cp(read(TRAPEZOID.format(3))) < cp(read(TRAPEZOID.format(4)))
    light = catalogue().resolve("AeroTech F24W").motor
    margins = [read().margin(replace(light, casing_mass=mass)) or 0.0 for mass in (0.01, 0.04, 0.1)]
    assert margins == sorted(margins, reverse=True)


def test_the_center_of_gravity_balances_the_parts_and_the_motor() -> None:
    design = read(entered="<overridemass>0.2</overridemass><overridesubcomponentsmass>true</overridesubcomponentsmass>")
    balance, motor = design.balance, catalogue().resolve("AeroTech F24W").motor
    assert balance is not None
    assert (balance.dry_mass, balance.mount_end) == pytest.approx((0.2, 0.505))
    cg = balance.cg(motor.loaded_mass, motor.length)
    assert cg is not None
    at = 0.505 - motor.length / 2
    assert 0.2 * (cg - balance.dry_cg) == pytest.approx(motor.loaded_mass * (at - cg))
    stated = read(entered="<overridecg>0.3</overridecg>")
    assert stated.balance is not None
    assert stated.balance.dry_cg == 0.3


@pytest.mark.parametrize("kind", ["podset", "parallelstage", "tubefinset"])
def test_a_design_with_parts_that_are_not_modeled_has_no_margin(kind: str) -> None:
    assert read(TRAPEZOID.format(3) + f"<{kind}><instancecount>2</instancecount></{kind}>").balance is None


def test_a_design_without_a_simulation_has_the_margin_of_its_parts() -> None:
    design = read()
    start = design.start("A", "", "a.ork")
    motor = catalogue().resolve("AeroTech F24W").motor
    assert start.margin == pytest.approx(design.margin(motor))


WEIGHED = """<overridemass>0.3</overridemass><overridesubcomponentsmass>true</overridesubcomponentsmass>
<overridecg>0.28</overridecg>"""


def stability(run: Run, *more: str) -> tuple[str, str]:
    """The verdict and the text of the stability of a plan."""
    (made,) = run("predict", "--rocket", "A", *more, "--json").document["predictions"]
    (line,) = [one for one in made["safety"] if one["check"] == "stability"]
    return line["verdict"], line["text"]


def test_a_plan_has_the_margin_with_its_own_motor(run: Run, tmp_path: Path) -> None:
    (tmp_path / "a.ork").write_bytes(content(entered=WEIGHED))
    run("ork", tmp_path / "a.ork")
    margins = [read(entered=WEIGHED).margin(catalogue().resolve(f"AeroTech {name}").motor) for name in ("F24W", "G74W")]
    for name, margin in zip(("F24W", "G74W"), margins, strict=True):
        assert f"{margin:.1f} caliber" in stability(run, "--motor", f"AeroTech {name}")[1]
    assert margins[0] != margins[1]
    assert "2.2 caliber" in stability(run, "--motor", "AeroTech G74W", "--stability-cal", "2.2")[1]


def test_a_motor_that_makes_a_rocket_unstable_is_unsafe(run: Run, tmp_path: Path) -> None:
    (tmp_path / "a.ork").write_bytes(content())
    run("ork", tmp_path / "a.ork")
    assert (read().margin(catalogue().resolve("AeroTech F24W").motor) or 0) < 0
    verdict, text = stability(run, "--motor", "AeroTech F24W")
    assert (verdict, "it is unstable" in text) == ("unsafe", True)


def test_the_guide_judges_every_motor_by_its_own_margin(run: Run, tmp_path: Path) -> None:
    (tmp_path / "a.ork").write_bytes(content(entered=WEIGHED))
    run("ork", tmp_path / "a.ork")
    every = run("motors", "--fit", "A", "--json").document["motors"]
    texts = [next(line["text"] for line in one["safety"] if line["check"] == "stability") for one in every]
    assert len(set(texts)) > 3


def test_an_entered_center_of_gravity_of_a_part_counts() -> None:
    """That of fins alone, and that of the tube with or without everything inside."""
    plain = content()
    weighed = "<overridemass>0.02</overridemass><overridesubcomponentsmass>false</overridesubcomponentsmass>"
    fins = TRAPEZOID.format(3).replace("<fincount>", f"{weighed}<overridecg>{{}}</overridecg><fincount>")
    ahead, behind = (read(fins.format(place)).balance for place in (0.01, 0.06))
    assert ahead is not None
    assert behind is not None
    assert behind.dry_cg - ahead.dry_cg == pytest.approx(0.02 * 0.05 / ahead.dry_mass)
    together = "<bodytube><overridecg>0.3</overridecg><overridesubcomponentscg>true</overridesubcomponentscg>"
    found = read_design(plain.replace(b"<bodytube>", together.encode()), "a.ork").balance
    nose = read_design(plain.replace(b"<bodytube>", b"<bodytube><overridecg>0.3</overridecg>"), "a.ork").balance
    assert found is not None
    assert nose is not None
    assert found.dry_cg == pytest.approx(0.4, abs=0.05)
    assert found.dry_cg != pytest.approx(nose.dry_cg, abs=1e-6)
