"""Masses of parts that a design contains several times, and of parts that taper toward the tail."""

import math

import pytest

from fieldkit.openrocket import Design, read_design

pytestmark = pytest.mark.fast

PAPER = '<material type="bulk" density="700">Paper</material>'
FINS = f"""<trapezoidfinset>{{counts}}{PAPER}<thickness>0.003</thickness><rootchord>0.1</rootchord>
<tipchord>0.06</tipchord><height>0.08</height></trapezoidfinset>"""
TUBE = f"<bodytube>{PAPER}<length>0.5</length><thickness>0.001</thickness><radius>0.03</radius>{{inside}}</bodytube>"
BODY = 700 * math.pi * (0.03**2 - 0.029**2) * 0.5
WEIGHT = "<masscomponent><mass>0.02</mass></masscomponent>"


def _read(inside: str, after: str = "") -> Design:
    tube = TUBE.format(inside=f"<subcomponents>{inside}</subcomponents>")
    stage = f"<stage><subcomponents>{tube}{after}</subcomponents></stage>"
    rocket = f"<rocket><name>A</name><subcomponents>{stage}</subcomponents></rocket>"
    return read_design(f'<openrocket version="1.9">{rocket}</openrocket>'.encode(), "a.ork")


def _mass(inside: str, after: str = "") -> float:
    """Mass beyond that of the body. [kg]"""
    found = _read(inside, after).dry_mass
    assert found is not None
    return found - BODY


@pytest.mark.parametrize("counts", ["<fincount>3</fincount>", "<instancecount>3</instancecount>"])
def test_fins_are_counted_once(counts: str) -> None:
    both = "<instancecount>3</instancecount><fincount>3</fincount>"
    three = 700 * 3 * (0.1 + 0.06) / 2 * 0.08 * 0.003
    assert _mass(FINS.format(counts=counts)) == pytest.approx(three)
    assert _mass(FINS.format(counts=both)) == pytest.approx(three)


@pytest.mark.parametrize("kind", ["podset", "parallelstage"])
def test_pods_and_boosters_weigh_according_to_their_number(kind: str) -> None:
    one = TUBE.format(inside=f"<subcomponents>{WEIGHT}</subcomponents>")
    pods = f"<{kind}><instancecount>2</instancecount><subcomponents>{one}</subcomponents></{kind}>"
    assert _mass(pods) == pytest.approx(2 * (BODY + 0.02))


def test_every_tube_of_a_cluster_and_its_contents_have_mass() -> None:
    mount = f"""<innertube>{PAPER}<length>0.1</length><outerradius>0.01</outerradius><thickness>0.001</thickness>
<clusterconfiguration>3-ring</clusterconfiguration><subcomponents>{WEIGHT}</subcomponents></innertube>"""
    assert _mass(mount) == pytest.approx(3 * (700 * math.pi * (0.01**2 - 0.009**2) * 0.1 + 0.02))


@pytest.mark.parametrize("inner", ["0.01", "auto"])
def test_an_automatic_radius_of_a_ring_that_is_not_stored_is_that_of_the_tubes_it_joins(inner: str) -> None:
    """Versions before 15 of OpenRocket write `auto` alone."""
    ring = f"""<centeringring><name>Ring</name>{PAPER}<length>0.005</length><outerradius>auto</outerradius>
<innerradius>{inner}</innerradius></centeringring>"""
    tube = (
        f"<innertube>{PAPER}<length>0.1</length><thickness>0.001</thickness><outerradius>0.01</outerradius></innertube>"
    )
    inside = 700 * math.pi * ((0.029**2 - 0.01**2) * 0.005 + (0.01**2 - 0.009**2) * 0.1)
    assert _mass(tube + ring) == pytest.approx(inside)
    assert not any("unknown" in note for note in _read(tube + ring).notes)


def test_an_automatic_radius_of_a_nose_that_is_not_stored_is_that_of_the_tube_behind_it() -> None:
    nose = f"""<nosecone>{PAPER}<length>0.1</length><thickness>0.002</thickness><shape>ogive</shape>
<aftradius>{{}}</aftradius></nosecone>"""
    masses = []
    for radius in ("auto", "0.03"):
        parts = nose.format(radius) + TUBE.format(inside="")
        stage = f"<stage><subcomponents>{parts}</subcomponents></stage>"
        rocket = f"<rocket><name>A</name><subcomponents>{stage}</subcomponents></rocket>"
        masses.append(read_design(f'<openrocket version="1.4">{rocket}</openrocket>'.encode(), "a.ork").dry_mass)
    assert masses[0] == pytest.approx(masses[1])
    assert masses[1] is not None
    assert masses[1] > BODY


@pytest.mark.parametrize("shape", ["ogive", "ellipsoid", "conical"])
def test_a_tail_weighs_as_much_as_the_same_nose(shape: str) -> None:
    part = f"""<transition>{PAPER}<length>0.1</length><thickness>0.001</thickness><shape>{shape}</shape>
<foreradius>{{}}</foreradius><aftradius>{{}}</aftradius></transition>"""
    assert _mass("", part.format(0.03, 0.01)) == pytest.approx(_mass("", part.format(0.01, 0.03)))


def test_a_filled_ellipsoid_tail_has_the_volume_of_half_an_ellipsoid() -> None:
    tail = f"""<transition>{PAPER}<length>0.1</length><thickness>filled</thickness><shape>ellipsoid</shape>
<foreradius>0.03</foreradius><aftradius>0</aftradius></transition>"""
    assert _mass("", tail) == pytest.approx(700 * 2 / 3 * math.pi * 0.03**2 * 0.1, rel=1e-3)


@pytest.mark.parametrize(("section", "fraction"), [("square", 1.0), ("rounded", 0.99), ("airfoil", 0.85)])
def test_the_mass_of_a_fin_includes_its_tab_and_depends_on_its_cross_section(section: str, fraction: float) -> None:
    """Source: OpenRocket's `FinSet`, whose tabs go through the wall of the tube."""
    more = f"<crosssection>{section}</crosssection><tabheight>0.012</tabheight><tablength>0.07</tablength>"
    fins = FINS.format(counts=f"<fincount>4</fincount>{more}")
    assert _mass(fins) == pytest.approx(700 * 4 * (fraction * 0.08 * 0.08 + 0.012 * 0.07) * 0.003)


def test_a_fin_with_an_invalid_point_causes_no_crash() -> None:
    points = '<point x="0.0" y="0.0"/><point x="abc" y="0.05"/><point x="nan" y="0.05"/><point x="0.1" y="0.0"/>'
    fins = f"<freeformfinset>{PAPER}<thickness>0.003</thickness><finpoints>{points}</finpoints></freeformfinset>"
    assert math.isfinite(_mass(fins))


NOSE = f"""<nosecone>{PAPER}<length>0.1</length><thickness>filled</thickness><aftradius>0.03</aftradius>
<shape>{{}}</shape>{{}}</nosecone>"""


@pytest.mark.parametrize(("shape", "usual"), [("ogive", 1), ("power", 0.5), ("parabolic", 1), ("haack", 0)])
def test_a_nose_without_a_shape_parameter_has_openrockets_default(shape: str, usual: float) -> None:
    given = NOSE.format(shape, f"<shapeparameter>{usual}</shapeparameter>")
    assert _mass("", NOSE.format(shape, "")) == pytest.approx(_mass("", given))


@pytest.mark.parametrize(("shape", "most"), [("parabolic", 1), ("haack", 1 / 3), ("ogive", 1), ("power", 1)])
def test_a_shape_parameter_out_of_range_is_the_nearest_possible_one(shape: str, most: float) -> None:
    last, beyond = (NOSE.format(shape, f"<shapeparameter>{one}</shapeparameter>") for one in (most, 2 + most))
    assert _mass("", beyond) == pytest.approx(_mass("", last))


def test_an_ogive_becomes_a_cone_as_its_parameter_falls() -> None:
    """A solid cone has a third of the volume of its cylinder; a tangent ogive is a solid of revolution of an arc.

    Source: Crowell, The Descriptive Geometry of Nose Cones, 1996.
    """
    ogive = [_mass("", NOSE.format("ogive", f"<shapeparameter>{one}</shapeparameter>")) for one in (0, 0.01, 0.5, 1)]
    cylinder = 700 * math.pi * 0.03**2 * 0.1
    assert ogive[0] == pytest.approx(cylinder / 3, rel=1e-3)
    assert ogive[1] == pytest.approx(ogive[0], rel=1e-2)
    assert ogive[0] < ogive[2] < ogive[3]
    arc = (0.03**2 + 0.1**2) / (2 * 0.03)
    volume = math.pi * (0.1 * arc**2 - 0.1**3 / 3 - (arc - 0.03) * arc**2 * math.asin(0.1 / arc))
    assert ogive[3] == pytest.approx(700 * volume, rel=1e-3)


@pytest.mark.parametrize(("includes", "cd"), [("true", 0.52), ("false", None)])
def test_an_entered_cd_is_used_if_it_includes_the_parts_inside(includes: str, cd: float | None) -> None:
    entered = f"<overridecd>0.52</overridecd><overridesubcomponentscd>{includes}</overridesubcomponentscd>"
    stage = f"<stage>{entered}<subcomponents>{TUBE.format(inside='')}</subcomponents></stage>"
    rocket = f"<rocket><name>A</name><subcomponents>{stage}</subcomponents></rocket>"
    found = read_design(f'<openrocket version="1.9">{rocket}</openrocket>'.encode(), "a.ork")
    assert found.cd == cd
    assert found.cd_by == ("its override" if cd else "")
