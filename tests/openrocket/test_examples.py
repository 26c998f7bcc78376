"""The designs that OpenRocket comes with, by their figures: every Cd on the area of the design.

The stored reference area of these files has one digit for most, so that a Cd scaled by it is off by up to 20%.
"""

import math

import pytest

from fieldkit.openrocket import Design, read_design
from tests.openrocket.designs import Example, decimals, design, examples

CHECK_SHAPES = False
EXAMPLES = examples()
SIMULATIONS = [(name, place, row) for name, rows in EXAMPLES for place, row in enumerate(rows)]
GATE = 0.02


def _read(name: str, **changes: str) -> Design:
    rows = dict(EXAMPLES)[name]
    return read_design(design(name, rows, dry_mass=0.1234, **changes), "example.ork")


def test_the_table_has_every_design_and_simulation() -> None:
    assert (len(EXAMPLES), len(SIMULATIONS)) == (17, 60)


@pytest.mark.parametrize("name", [name for name, _ in EXAMPLES])
def test_a_design_gives_mass_diameter_and_cd_on_its_own_area(name: str) -> None:
    rows = dict(EXAMPLES)[name]
    found = _read(name)
    assert found.diameter == pytest.approx(float(rows[0]["diameter_mm"]) / 1e3, rel=1e-6)
    assert found.cd == pytest.approx(float(rows[0]["cd_coast"]), rel=GATE)
    assert found.dry_mass == pytest.approx(0.1234, rel=1e-6)
    assert found.mass_by == "the mass entered for it"
    assert not any("does not fit" in note for note in found.notes)
    noted = any("simulations have a Cd" in note for note in found.notes)
    cds = [float(row["cd_coast"]) for row in rows]
    assert noted == (max(cds) > 1.05 * min(cds))


@pytest.mark.parametrize(("name", "place", "row"), SIMULATIONS)
def test_every_stored_simulation_is_reproduced(name: str, place: int, row: Example) -> None:
    found = _read(name).simulations[place]
    diameter = float(row["diameter_mm"]) / 1e3
    assert found.cd == pytest.approx(float(row["cd_coast"]), rel=GATE)
    assert math.pi / 4 * found.reference**2 == pytest.approx(math.pi / 4 * diameter**2, rel=1e-6)
    assert found.apogee == float(row["apogee_m"])
    assert found.top_speed == float(row["top_speed_mps"])
    assert found.consistent


def test_the_stored_area_would_have_been_wrong() -> None:
    """So the test can fail: 8 of the 17 designs fail it if Cd is scaled by the stored area."""
    off = [
        abs(float(rows[0]["stored_area_m2"]) / (math.pi / 4 * (float(rows[0]["diameter_mm"]) / 1e3) ** 2) - 1)
        for _, rows in EXAMPLES
    ]
    assert sum(one > GATE for one in off) == 8
    assert max(off) > 0.19


def test_numbers_are_stored_as_openrocket_stores_them() -> None:
    """Source: `TextUtil.doubleToString` of version 24.12."""
    assert [decimals(value) for value in (0.002491, 0.05631, 0.0004909, 12345.6, 3.0, 0.0)] == [
        "0.002",
        "0.056",
        "4.909E-4",
        "1.235E4",
        "3",
        "0",
    ]


def test_a_cd_on_another_reference_area_is_rescaled_to_the_body() -> None:
    name = "ARC payload rocket"
    body = _read(name).cd
    assert body is not None
    assert _read(name, reference="nosecone").cd == pytest.approx(body)
    custom = "custom</referencetype><customreference>0.0400</customreference><referencetype>"
    content = design(name, dict(EXAMPLES)[name], dry_mass=0.1234, reference=custom)
    found = read_design(content.replace(b"<referencetype></referencetype>", b""), "a.ork")
    assert found.cd == pytest.approx(body * (0.04 / 0.05631) ** 2, rel=1e-6)
    assert any("does not match its Cd" in note for note in found.notes)


def test_the_default_configuration_and_its_stages_determine_the_reference_area() -> None:
    rows = dict(EXAMPLES)["Tube fin rocket"]
    stages = '<stage number="0" active="true"/><stage number="1" active="false"/>'
    booster = """<stage><name>Booster</name><subcomponents><bodytube><name>Wide</name><length>0.1</length>
<thickness>0.001</thickness><radius>0.02479</radius></bodytube></subcomponents></stage>"""
    content = design("x", rows, dry_mass=0.1).decode()
    content = content.replace("</stage></subcomponents></rocket>", f"</stage>{booster}</subcomponents></rocket>")
    both = read_design(content.encode(), "a.ork")
    configuration = f'<motorconfiguration configid="x" default="true">{stages}</motorconfiguration><subcomponents>'
    alone = read_design(content.replace("<subcomponents>", configuration, 1).encode(), "a.ork")
    assert both.simulations[0].reference == pytest.approx(2 * 0.02479)
    assert alone.simulations[0].reference == pytest.approx(0.02479)
    assert alone.simulations[0].default
    assert both.cd is not None
    assert alone.cd == pytest.approx(both.cd / 4)


def test_motors_of_clusters_and_pods_are_counted() -> None:
    mount = """<innertube><name>Mount</name><clusterconfiguration>{cluster}</clusterconfiguration><motormount>
<motor configid="x"><manufacturer>Estes</manufacturer><designation>C6</designation><delay>5</delay></motor>
</motormount></innertube>"""
    rows = dict(EXAMPLES)["Clustered motors"]
    content = design("x", rows, dry_mass=0.1).decode()
    for cluster, pods, count in (
        ("4-ring", 1, 4),
        ("double", 1, 2),
        ("single", 2, 2),
        ("3-row", 2, 6),
        ("4-star", 1, 5),
        ("9-star", 1, 9),
    ):
        inside = f"<podset><instancecount>{pods}</instancecount><subcomponents>{mount.format(cluster=cluster)}"
        tube = f"<subcomponents>{inside}</subcomponents></podset></subcomponents></bodytube>"
        found = read_design(content.replace("</bodytube>", tube, 1).encode(), "a.ork")
        assert [one.count for one in found.motors] == [count]
