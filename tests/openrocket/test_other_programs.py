"""One rocket as three programs save it: designs of RockSim and RASAero have the mass and balance of OpenRocket's."""

import math
import re
from contextlib import suppress
from io import BytesIO
from pathlib import Path
from xml.etree import ElementTree
from zipfile import ZipFile

import pytest

from fieldkit.errors import DamagedLog
from fieldkit.flight import Flight
from fieldkit.motors import catalogue
from fieldkit.openrocket import Design, read_design
from fieldkit.physics.single import field_flight
from fieldkit.units import FOOT, INCH, POUND
from tests.commands import Run
from tests.openrocket.designs import design as simulated
from tests.openrocket.designs import examples

pytestmark = pytest.mark.fast

NOSE_MASS, TUBE_MASS, FINS_MASS, MOUNT_MASS, ALTIMETER = 15.0, 44.0, 19.0, 5.0, 30.0
"""As computed by the programs, and a weight at 150 mm behind the front of the tube. [g]"""
MOUNT_LENGTH, OVERHANG = 75.0, 5.0


def mass(grams: float) -> str:
    return f"<overridemass>{grams / 1e3}</overridemass>"


def openrocket() -> bytes:
    fins = f"""<trapezoidfinset>{mass(FINS_MASS)}<fincount>3</fincount><axialoffset method="bottom">-0.01</axialoffset>
<thickness>0.003</thickness><rootchord>0.08</rootchord><tipchord>0.04</tipchord><sweeplength>0.04</sweeplength>
<height>0.05</height></trapezoidfinset>"""
    mount = f"""<innertube>{mass(MOUNT_MASS)}<axialoffset method="bottom">0</axialoffset><length>0.075</length>
<outerradius>0.0125</outerradius><motormount><overhang>0.005</overhang></motormount></innertube>"""
    weight = f"""<masscomponent><axialoffset method="top">0.15</axialoffset><packedlength>0.02</packedlength>
<mass>{ALTIMETER / 1e3}</mass></masscomponent>"""
    return f"""<openrocket version="1.9"><rocket><name>Lark</name><subcomponents><stage><subcomponents>
<nosecone>{mass(NOSE_MASS)}<length>0.15</length><shape>ogive</shape><aftradius>0.025</aftradius></nosecone>
<bodytube>{mass(TUBE_MASS)}<length>0.4</length><radius>0.025</radius><subcomponents>{fins}{mount}{weight}
</subcomponents></bodytube></subcomponents></stage></subcomponents></rocket></openrocket>""".encode()


FINS = """<FinSet><Name>Fins</Name><KnownMass>0</KnownMass><CalcMass>{mass}</CalcMass><UseKnownCG>0</UseKnownCG>
<Xb>10.</Xb><LocationMode>2</LocationMode><FinCount>3</FinCount><RootChord>80.</RootChord><TipChord>40.</TipChord>
<SemiSpan>50.</SemiSpan><SweepDistance>40.</SweepDistance><Thickness>3.</Thickness><ShapeCode>{code}</ShapeCode>
<TipShapeCode>0</TipShapeCode><PointList>80.,0.|80.,50.|40.,50.|0.,0.|</PointList></FinSet>"""


def rocksim(fins: str = FINS.format(mass=FINS_MASS, code=0), more: str = "", stage: str = "") -> bytes:
    return f"""<?xml version="1.0" encoding="utf-8"?><RockSimDocument><FileVersion>4</FileVersion><DesignInformation>
<RocketDesign><Name>Lark</Name><StageCount>1</StageCount>{stage}<Stage3Parts>
<NoseCone><Name>Nose</Name><KnownMass>0</KnownMass><CalcMass>{NOSE_MASS}</CalcMass><UseKnownCG>0</UseKnownCG>
<Len>150.</Len><BaseDia>50.</BaseDia><ShapeCode>1</ShapeCode><WallThickness>1.</WallThickness><AttachedParts/></NoseCone>
<BodyTube><Name>Body</Name><KnownMass>99</KnownMass><CalcMass>{TUBE_MASS}</CalcMass><UseKnownCG>0</UseKnownCG>
<OD>50.</OD><ID>48.</ID><Len>400.</Len><IsMotorMount>0</IsMotorMount><IsInsideTube>0</IsInsideTube><AttachedParts>
{fins}<BodyTube><Name>Mount</Name><CalcMass>{MOUNT_MASS}</CalcMass><Xb>0.</Xb><LocationMode>2</LocationMode>
<OD>25.</OD><ID>24.</ID><Len>{MOUNT_LENGTH}</Len><IsMotorMount>1</IsMotorMount><EngineOverhang>{OVERHANG}</EngineOverhang>
<IsInsideTube>1</IsInsideTube><AttachedParts/></BodyTube>
<MassObject><Name>Altimeter</Name><KnownMass>{ALTIMETER}</KnownMass><CalcMass>0</CalcMass><Xb>150.</Xb>
<LocationMode>0</LocationMode><Len>20.</Len></MassObject>{more}
</AttachedParts></BodyTube></Stage3Parts><Stage2Parts/><Stage1Parts/></RocketDesign></DesignInformation>
</RockSimDocument>""".encode()


def rasaero(weight: float, cg: float, engine: str = "F24W  (AT)", apogee: float = 0.0) -> bytes:
    """The same outline in inches; the launch weight [kg], the center with the motor [m] and the apogee [m] are of its
    simulation, on a rod of 5 ft in a wind of 5 mph at 1,000 ft."""

    def inches(meters: float) -> str:
        return f"{meters / INCH:.6f}"

    return f"""<RASAeroDocument><FileVersion>2</FileVersion><RocketDesign>
<NoseCone><PartType>NoseCone</PartType><Length>{inches(0.15)}</Length><Diameter>{inches(0.05)}</Diameter>
<Shape>Tangent Ogive</Shape><Location>0</Location></NoseCone>
<BodyTube><PartType>BodyTube</PartType><Length>{inches(0.4)}</Length><Diameter>{inches(0.05)}</Diameter>
<Fin><Count>3</Count><Chord>{inches(0.08)}</Chord><Span>{inches(0.05)}</Span><SweepDistance>{inches(0.04)}</SweepDistance>
<TipChord>{inches(0.04)}</TipChord><Location>{inches(0.09)}</Location></Fin></BodyTube></RocketDesign>
<LaunchSite><Altitude>1000</Altitude><RodLength>5</RodLength><RodAngle>0</RodAngle><WindSpeed>5</WindSpeed></LaunchSite>
<SimulationList><Simulation><MaxAltitude>{apogee / FOOT}</MaxAltitude><SustainerEngine>{engine}</SustainerEngine>
<SustainerLaunchWt>{weight / POUND}</SustainerLaunchWt><SustainerCG>{inches(cg)}</SustainerCG></Simulation>
</SimulationList></RASAeroDocument>""".encode()


def margin(design: Design) -> float:
    found = design.margin(catalogue().resolve("AeroTech F24W").motor)
    assert found is not None
    return found


def test_a_rocksim_design_has_the_mass_and_balance_of_the_same_rocket() -> None:
    own, theirs = read_design(openrocket(), "lark.ork"), read_design(rocksim(), "lark.rkt")
    assert theirs.name == "Lark"
    assert (theirs.dry_mass, theirs.diameter, theirs.length) == pytest.approx((0.113, 0.05, 0.55))
    assert theirs.balance is not None
    assert own.balance is not None
    assert (theirs.balance.cp, theirs.balance.dry_cg) == pytest.approx((own.balance.cp, own.balance.dry_cg))
    assert margin(theirs) == pytest.approx(margin(own))
    assert theirs.cd is None


def test_a_freeform_fin_of_rocksim_may_run_either_way_round() -> None:
    plain = read_design(rocksim(), "a.rkt")
    freeform = read_design(rocksim(FINS.format(mass=FINS_MASS, code=2)), "a.rkt")
    assert margin(freeform) == pytest.approx(margin(plain), abs=0.02)


def test_a_mass_that_was_entered_replaces_the_computed_one() -> None:
    weighed = rocksim().replace(
        b"<KnownMass>99</KnownMass><CalcMass>44.0</CalcMass><UseKnownCG>0",
        b"<KnownMass>99</KnownMass><CalcMass>44.0</CalcMass><UseKnownCG>1",
    )
    assert read_design(weighed, "a.rkt").dry_mass == pytest.approx(0.113 + 0.055)
    whole = rocksim(stage="<UseKnownMass>1</UseKnownMass><Stage3Mass>150</Stage3Mass><Stage3CG>300</Stage3CG>")
    design = read_design(whole, "a.rkt")
    assert design.dry_mass == pytest.approx(0.15)
    assert design.balance is not None
    assert design.balance.dry_cg == pytest.approx(0.3)


def test_parts_that_are_not_read_are_named() -> None:
    notes = read_design(rocksim(more="<FlyingSaucer><Name>x</Name></FlyingSaucer>"), "a.rkt").notes
    assert any("not read: FlyingSaucer" in note for note in notes)
    assert any("motors of a RockSim file are not read" in note for note in notes)
    assert any(note.startswith("no Cd: that of a RockSim file is not read") for note in notes)
    assert read_design(rocksim(more="<ExternalPod/>"), "a.rkt").balance is None


def test_a_rasaero_design_has_the_mass_and_balance_of_its_simulation() -> None:
    own, motor = read_design(openrocket(), "lark.ork"), catalogue().resolve("AeroTech F24W").motor
    assert own.balance is not None
    weight = 0.113 + motor.loaded_mass
    center = (0.113 * own.balance.dry_cg + motor.loaded_mass * (0.55 - motor.length / 2)) / weight
    theirs = read_design(rasaero(weight, center), "Lark.CDX1")
    assert (theirs.name, theirs.dry_mass) == ("Lark", pytest.approx(0.113))
    assert (theirs.diameter, theirs.length) == pytest.approx((0.05, 0.55))
    assert theirs.balance is not None
    assert (theirs.balance.cp, theirs.balance.dry_cg) == pytest.approx((own.balance.cp, own.balance.dry_cg), abs=1e-5)
    assert [(one.maker, one.designation) for one in theirs.motors] == [("AeroTech", "F24W")]
    assert theirs.start("Lark", "", "Lark.CDX1").margin == pytest.approx((own.balance.cp - center) / 0.05, abs=1e-3)


def test_the_apogees_of_a_rasaero_design_imply_its_cd() -> None:
    found, level = catalogue().resolve("AeroTech F24W"), {"wind_aloft_mps": "2.2352", "wind_aloft_height_m": "1000"}
    site = {"rail_length": 5 * FOOT, "site_elevation": 1000 * FOOT, "wind": 2.2352}
    plan = Flight(dry_mass=0.113, diameter=0.05, extra=level).with_changes(**site)
    apogee = field_flight(plan, found, 0.62, 1.0)["true_apogee_m"]
    design = read_design(rasaero(0.113 + found.motor.loaded_mass, 0.3, apogee=apogee), "Lark.CDX1")
    assert design.cd == pytest.approx(0.62, rel=0.003)
    assert design.cd_by == "the apogees of 1 simulation"
    assert not any(note.startswith("no Cd") for note in design.notes)
    (again,) = design.flown_again
    assert again.difference == pytest.approx(0.0, abs=0.005)
    assert read_design(rasaero(0.2, 0.3), "Lark.CDX1").cd is None, "no apogee is stored"


def test_a_rasaero_design_on_an_unknown_motor_asks_for_the_mass() -> None:
    design = read_design(rasaero(0.2, 0.3, "Z9 (ZZ)"), "Lark.CDX1")
    assert design.dry_mass is None
    assert any("weigh the rocket" in note for note in design.notes)


def test_both_are_saved_as_a_start_and_forecast(run: Run, tmp_path: Path) -> None:
    (tmp_path / "lark.rkt").write_bytes(rocksim())
    shown = run("ork", tmp_path / "lark.rkt").out
    assert "113 g" in shown
    (made,) = run("predict", "--rocket", "Lark", "--motor", "E12-6", "--json").document["predictions"]
    assert made["apogee_m"]["p50"] > 50


@pytest.mark.parametrize("name", ["a.rkt", "a.CDX1"])
@pytest.mark.parametrize("at", [40, 300, 700])
def test_a_torn_design_is_damaged_not_a_crash(name: str, at: int) -> None:
    content = rocksim() if name == "a.rkt" else rasaero(0.2, 0.3)
    with pytest.raises(DamagedLog, match=name):
        read_design(content[:at], name)


def test_texts_in_place_of_numbers_do_not_crash() -> None:
    for content in (rocksim(), rasaero(0.2, 0.3)):
        spoiled = content
        for number in (b"80.", b"50.", b"400.", b"150.", b"2", b"3"):
            spoiled = spoiled.replace(b">" + number + b"<", b">nan<")
        with suppress(DamagedLog):
            read_design(spoiled, "a")


def zipped(name: str, content: bytes) -> bytes:
    with BytesIO() as buffer:
        with ZipFile(buffer, "w") as archive:
            archive.writestr(name, content)
        return buffer.getvalue()


def test_an_entered_center_of_gravity_is_used_with_its_mass() -> None:
    """RockSim uses the known mass and the known center of a part together."""
    entered = rocksim().replace(
        b"<KnownMass>99</KnownMass><CalcMass>44.0</CalcMass><UseKnownCG>0",
        b"<KnownMass>44</KnownMass><KnownCG>100.</KnownCG><CalcMass>9.0</CalcMass><UseKnownCG>1",
    )
    plain, moved = read_design(rocksim(), "a.rkt").balance, read_design(entered, "a.rkt").balance
    assert plain is not None
    assert moved is not None
    assert moved.dry_cg == pytest.approx((plain.dry_cg or 0.0) - 0.044 * (0.2 - 0.1) / 0.113)


def test_parts_of_a_subassembly_and_a_cord_with_a_computed_mass_are_read() -> None:
    cord = (
        "<MassObject><Name>Cord</Name><KnownMass>0</KnownMass><CalcMass>7</CalcMass><TypeCode>1</TypeCode></MassObject>"
    )
    grouped = rocksim(more=f"<SubAssembly><Name>Bay</Name><AttachedParts>{cord}</AttachedParts></SubAssembly>")
    design = read_design(grouped, "a.rkt")
    assert design.dry_mass == pytest.approx(0.113 + 0.007)
    assert not any(note.startswith("not read") for note in design.notes)


@pytest.mark.parametrize(
    ("old", "new"),
    [
        (b"FileVersion>4", b"FileVersion>2"),
        (b"<FileVersion>4</FileVersion>", b""),
        (b"50.<", b"50,<"),
        (b"80.<", b"8.0E1<"),
    ],
    ids=["an older version", "no version", "decimal commas", "exponents"],
)
def test_other_ways_to_write_the_same_design_are_read_the_same(old: bytes, new: bytes) -> None:
    plain, other = read_design(rocksim(), "a.rkt"), read_design(rocksim().replace(old, new), "a.rkt")
    assert (other.dry_mass, other.diameter, other.length) == (plain.dry_mass, plain.diameter, plain.length)
    assert other.balance == plain.balance


@pytest.mark.parametrize("encoding", ["utf-8-sig", "utf-16"])
def test_a_design_may_be_zipped_and_in_another_encoding(encoding: str) -> None:
    text = rocksim().decode().replace('encoding="utf-8"', "" if encoding == "utf-8-sig" else 'encoding="utf-16"')
    assert read_design(text.encode(encoding), "a.rkt").dry_mass == pytest.approx(0.113)
    assert read_design(zipped("Lark.RKT", rocksim()), "mail.zip").dry_mass == pytest.approx(0.113)


def test_a_missing_size_is_named() -> None:
    notes = read_design(rocksim().replace(b"<Len>400.</Len>", b"<Len>long</Len>"), "a.rkt").notes
    assert any("no size, taken as zero: Body (length)" in note for note in notes)
    notes = read_design(
        rasaero(0.2, 0.3).replace(b"<Span>", b"<Width>").replace(b"</Span>", b"</Width>"), "a.CDX1"
    ).notes
    assert any("no size, taken as zero" in note and "(height)" in note for note in notes)


def test_a_design_of_a_version_without_xml_is_refused_in_a_line() -> None:
    for content in (b"[RockSim]\r\nVersion=4\r\n", b"\x00\x01\x02\x03" * 200):
        with pytest.raises(DamagedLog, match="save it again with a newer version"):
            read_design(content, "old.rkt")


@pytest.mark.parametrize("content", [rocksim(), rasaero(0.2, 0.3, apogee=150.0)], ids=["RockSim", "RASAero"])
def test_no_element_of_a_design_is_needed_for_an_answer_or_a_clear_line(content: bytes) -> None:
    """Without any one of its elements a design is read or refused in a line, and its figures are finite."""
    for place in range(1, sum(1 for _ in ElementTree.fromstring(content).iter())):
        root = ElementTree.fromstring(content)
        gone = list(root.iter())[place]
        next(parent for parent in root.iter() if gone in list(parent)).remove(gone)
        with suppress(DamagedLog):
            design = read_design(ElementTree.tostring(root), "a")
            figures = (design.dry_mass, design.diameter, design.length, design.cd)
            assert all(one is None or (math.isfinite(one) and one > 0) for one in figures), gone.tag


NUMBER = re.compile(rb"(?<=[>\",|])-?\d+\.?\d*(?=[<\",|])")
"""A number in a design: an element, an attribute, or one of several."""
EXTREMES = [b"1e308", b"-1e308", b"1e-300", b"-1e-300", b"1e154", b"-1", b"0"]


@pytest.mark.sampled
@pytest.mark.parametrize("number", EXTREMES)
@pytest.mark.parametrize("program", ["OpenRocket", "RockSim", "RASAero", "a stored simulation"])
def test_whatever_a_number_of_a_design_is_its_figures_are_finite(program: str, number: bytes) -> None:
    """Any one number, and all of them, as in a damaged file; warnings are errors."""
    content = {
        "OpenRocket": openrocket(),
        "RockSim": rocksim(),
        "RASAero": rasaero(0.2, 0.3, apogee=150.0),
        "a stored simulation": simulated(*examples()[0], dry_mass=0.1),
    }[program]
    places = list(NUMBER.finditer(content))
    for place in [None, *places[:: 1 + len(places) // 100]]:
        changed = NUMBER.sub(number, content)
        if place is not None:
            changed = content[: place.start()] + number + content[place.end() :]
        with suppress(DamagedLog):
            design = read_design(changed, "a")
            motor = catalogue().resolve("AeroTech F24W").motor
            figures = (design.dry_mass, design.diameter, design.length, design.cd, design.margin(motor))
            assert all(one is None or math.isfinite(one) for one in figures), place
            assert not any(word in note for note in design.notes for word in ("nan", "inf ")), design.notes
