"""OpenRocket designs: facts from their XML as a starting configuration, and damaged or hostile files.

Every design here is written for these tests from the known format.
"""

import gzip
import io
import math
import zipfile
from collections.abc import Mapping
from pathlib import Path

import numpy as np
import pytest

from fieldkit.errors import DamagedLog
from fieldkit.flight import Flight
from fieldkit.flight.site import Site
from fieldkit.ledger import Ledger
from fieldkit.motors import catalogue
from fieldkit.openrocket import Design, archive, read_design
from fieldkit.planning.forecasts import forecasts
from fieldkit.planning.limits import limits
from fieldkit.planning.motor_guide import guide
from fieldkit.rocket import Configuration
from fieldkit.services.forecasts import predict_plans, rocket_of
from fieldkit.services.plans import completed_plan
from fieldkit.services.saved_forecasts import list_forecasts
from fieldkit.settings import Settings
from tests.commands import Run

pytestmark = pytest.mark.fast

NOSE = """<nosecone><name>Nose</name><material type="bulk" density="1000.0">Plastic</material><length>0.2</length>
<thickness>0.002</thickness><shape>conical</shape><aftradius>0.033</aftradius></nosecone>"""
FINS = """<trapezoidfinset><name>Fins</name><fincount>3</fincount><material type="bulk" density="600">Ply</material>
<thickness>0.003</thickness><rootchord>0.1</rootchord><tipchord>0.06</tipchord><height>0.08</height></trapezoidfinset>"""
WEIGHT = "<masscomponent><name>Altimeter</name><mass>0.1</mass></masscomponent>"
MOTOR = """<innertube><name>Mount</name><material type="bulk" density="700">Paper</material><length>0.07</length>
<outerradius>0.0125</outerradius><thickness>0.0005</thickness><motormount>
<motor configid="a"><manufacturer>AeroTech</manufacturer><designation>F24W</designation><delay>4.0</delay></motor>
<motor configid="b"><manufacturer>AeroTech</manufacturer><designation>E30T</designation><delay>7.0</delay></motor>
</motormount></innertube>"""
TUBE = """<bodytube><name>Body</name>{override}<material type="bulk" density="700.0">Paper</material>
<length>0.6</length><thickness>0.001</thickness><radius>{radius}</radius>
<subcomponents>{inside}</subcomponents></bodytube>"""
SIMULATION = """<simulations><simulation status="{status}"><name>Sim 1</name><flightdata maxaltitude="240">
<databranch name="Stage" types="Time,Altitude,Total velocity,Mass,Motor mass,Drag coefficient,Reference area">
<event time="1.0" type="burnout"/><event time="5.0" type="apogee"/>
<datapoint>0,0,0,0.5,0.1,0.9,0.00342119</datapoint><datapoint>1,40,80,0.46,0.06,0.7,0.00342119</datapoint>
<datapoint>2,110,60,0.46,0.06,0.5,0.00342119</datapoint><datapoint>3,160,30,0.46,0.06,0.6,0.00342119</datapoint>
<datapoint>4,190,NaN,0.46,0.06,0.6,0.00342119</datapoint><datapoint>5,200,0,0.46,0.06,3.0,0.00342119</datapoint>
</databranch></flightdata></simulation></simulations>"""


def design(inside: str = FINS + WEIGHT + MOTOR, override: str = "", rest: str = "", radius: str = "auto 0.033") -> str:
    tube = TUBE.format(inside=inside, override=override, radius=radius)
    return (
        '<?xml version="1.0" encoding="utf-8"?><openrocket version="1.8" creator="OpenRocket 22.02"><rocket>'
        '<name>Skylark</name><motorconfiguration configid="a" default="true"><name>Field</name></motorconfiguration>'
        f"<subcomponents><stage><name>Sustainer</name><subcomponents>{NOSE}{tube}</subcomponents></stage>"
        f"</subcomponents></rocket>{rest}</openrocket>"
    )


def packed(xml: str, kind: str) -> bytes:
    if kind == "gzip":
        return gzip.compress(xml.encode())
    if kind == "plain":
        return xml.encode()
    out = io.BytesIO()
    with zipfile.ZipFile(out, "w", zipfile.ZIP_DEFLATED) as archive:
        archive.writestr("decals/red.png", b"\x89PNG")
        archive.writestr("rocket.ork", xml)
    return out.getvalue()


def by_hand() -> float:
    """The parts' masses by the formulas of a cone, a tube and three fins. [kg]"""
    wall = 0.002 * math.hypot(0.2, 0.033) / 0.2
    cone = math.pi * 0.2 / 3 * (0.033**2 - (0.033 - wall) ** 2 * (1 - wall / 0.033))
    tube = math.pi * (0.033**2 - 0.032**2) * 0.6
    fins = 3 * (0.1 + 0.06) / 2 * 0.08 * 0.003
    mount = math.pi * (0.0125**2 - 0.012**2) * 0.07
    return 1000 * cone + 700 * tube + 600 * fins + 700 * mount + 0.1


@pytest.mark.parametrize("kind", ["zip", "gzip", "plain"])
def test_a_design_is_read_however_it_is_packed(kind: str) -> None:
    found = read_design(packed(design(), kind), "skylark.ork")
    assert found.name == "Skylark"
    assert found.diameter == pytest.approx(0.066)
    assert found.length == pytest.approx(0.8)
    assert found.dry_mass == pytest.approx(by_hand(), rel=0.002)
    assert found.mass_by == "the sum of its parts"
    assert found.cd is None
    assert "no Cd" in found.notes[0]
    assert [(one.configuration, one.designation) for one in found.motors] == [("Field", "F24W"), ("", "E30T")]


def test_a_simulation_in_the_file_gives_mass_and_drag() -> None:
    found = read_design(design(rest=SIMULATION.format(status="uptodate")).encode(), "skylark.ork")
    assert found.dry_mass == pytest.approx(0.4)
    assert found.cd == pytest.approx((0.5 + 0.6) / 2)
    assert "Sim 1" in found.mass_by
    old = read_design(design(rest=SIMULATION.format(status="outdated")).encode(), "skylark.ork")
    assert old.dry_mass == pytest.approx(by_hand(), rel=0.002)
    assert any("older than the design" in note for note in old.notes)


def _zip(names: Mapping[str, bytes]) -> bytes:
    packed = io.BytesIO()
    with zipfile.ZipFile(packed, "w") as archive:
        for name, content in names.items():
            archive.writestr(name, content)
    return packed.getvalue()


def test_a_design_that_was_sent_in_a_zip_or_saved_by_an_editor_is_read() -> None:
    xml = design().encode()
    forms = {
        "blank line": b"\r\n" + xml,
        "padding": xml + b"\n\0\0",
        "wide": design().replace("utf-8", "UTF-16").encode("utf-16"),
        "zip in a zip": _zip({"__MACOSX/._my.ork": b"\0\5\x16", "my.ork": _zip({"rocket.ork": xml})}),
    }
    for name, content in forms.items():
        assert read_design(content, "a.ork").dry_mass == pytest.approx(by_hand(), rel=0.002), name
    with pytest.raises(DamagedLog):
        read_design(_zip({"a.ork": _zip({"b.ork": _zip({"rocket.ork": xml})})}), "a.ork")


@pytest.mark.parametrize("event", ["tumble", "simabort"])
def test_the_flight_of_a_simulation_that_tumbles_or_is_aborted_is_left_out(event: str) -> None:
    def read(moment: float) -> Design:
        upset = SIMULATION.format(status="uptodate").replace(
            "<event", f'<event time="{moment}" type="{event}"/><event', 1
        )
        return read_design(design(rest=upset).encode(), "skylark.ork")

    assert (read(2.5).cd, read(2.5).simulations[0].apogee) == (None, None)
    assert read(2.5).dry_mass == pytest.approx(0.4)
    assert any("Sim 1 tumbles or ends before apogee" in note for note in read(2.5).notes)
    assert (read(6.0).cd, read(6.0).simulations[0].apogee) == (pytest.approx(0.55), 240)


def test_a_simulation_in_another_language_is_named_as_such() -> None:
    german = SIMULATION.format(status="uptodate").replace(
        "Time,Altitude,Total velocity,Mass,Motor mass,Drag coefficient,Reference area",
        "Zeit,Höhe,Gesamtgeschwindigkeit,Masse,Motormasse,Luftwiderstandsbeiwert,Referenzfläche",
    )
    found = read_design(design(rest=german).encode(), "skylark.ork")
    assert any("not in English" in note for note in found.notes)


def test_weighed_masses_take_precedence_over_computed_ones() -> None:
    whole = "<overridemass>0.2</overridemass><overridesubcomponentsmass>true</overridesubcomponentsmass>"
    alone = "<overridemass>0.2</overridemass>"
    nose = read_design(design(inside="", override=whole).encode(), "a.ork").dry_mass
    assert nose is not None
    assert read_design(design(override=whole).encode(), "a.ork").dry_mass == nose
    inside = read_design(design(inside=WEIGHT, override=alone).encode(), "a.ork").dry_mass
    assert inside == pytest.approx(nose + 0.1)
    older = whole.replace("subcomponentsmass", "subcomponents")
    assert read_design(design(override=older).encode(), "a.ork").dry_mass == nose


def test_an_entered_mass_that_is_no_number_is_not_an_entered_mass() -> None:
    plain, damaged = (
        read_design(design(override=text).encode(), "a.ork").dry_mass
        for text in ("", "<overridemass>heavy</overridemass>")
    )
    assert damaged == plain


def test_an_automatic_radius_is_that_of_the_adjacent_part() -> None:
    assert read_design(design(radius="auto").encode(), "a.ork").diameter == pytest.approx(0.066)


def test_unknown_parts_are_named_and_left_out() -> None:
    unknown_part = read_design(design(inside="<warpdrive><name>Flux\u202e</name></warpdrive>").encode(), "a.ork")
    assert any("Flux<U+202E>" in note for note in unknown_part.notes)


BOMB = '<!DOCTYPE x [<!ENTITY a "aaaa"><!ENTITY b "&a;&a;">]><openrocket><rocket>&b;</rocket></openrocket>'
DAMAGED = {
    "empty": (b"", "broken XML"),
    "cut off": (design()[:900].encode(), "row"),
    "a cut zip": (packed(design(), "zip")[:300], "zip that cannot be unpacked"),
    "a cut gzip": (packed(design(), "gzip")[:200], "gzip that ends early"),
    "an empty zip": (b"PK\x05\x06" + bytes(18), "without a design"),
    "entities": (BOMB.encode(), "document type"),
    "another XML": (b"<svg/>", "expected a design of OpenRocket"),
    "no parts": (b"<openrocket><rocket><name>x</name></rocket></openrocket>", "no nose cone"),
    "an encoding": (b'<?xml version="1.0" encoding="martian"?><openrocket/>', "skylark.ork"),
    "no end of parts": (
        design("<bulkhead><subcomponents>" * 3000 + "</subcomponents></bulkhead>" * 3000).encode(),
        "nested more than",
    ),
}


@pytest.mark.parametrize("what", DAMAGED)
def test_a_damaged_file_is_named_in_one_line(what: str) -> None:
    content, why = DAMAGED[what]
    with pytest.raises(DamagedLog, match=why) as caught:
        read_design(content, "skylark.ork")
    assert str(caught.value).startswith("skylark.ork")
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize("kind", ["zip", "gzip", "plain"])
def test_an_archive_that_expands_too_much_is_refused(kind: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(archive, "MAX_UNPACKED_SIZE", 2**20)
    content = packed(" " * (2**20 + 1), kind)
    with pytest.raises(DamagedLog, match="unpacks to more than 1 MiB"):
        read_design(content, "bomb.ork")


def test_impossible_figures_are_left_out() -> None:
    found = read_design(design(radius="33").encode(), "a.ork")
    assert found.diameter is None
    assert any(note.startswith("diameter: found 66") for note in found.notes)


BALANCED = """<simulations><simulation status="{status}"><name>Sim 1</name><flightdata maxaltitude="240">
<databranch name="Stage" types="Time,Total velocity,CG location,CP location,Mass">
<event time="0.2" type="launchrod"/><datapoint>0,0,0.45,NaN,0.5</datapoint>
<datapoint>0.1,3,0.45,0.40,0.5</datapoint><datapoint>0.2,9,0.449,NaN,0.5</datapoint>
<datapoint>0.3,14,0.448,{cp},0.5</datapoint><datapoint>1,40,0.44,{cp},0.5</datapoint>
</databranch></flightdata></simulation></simulations>"""


def test_a_nose_of_automatic_radius_has_that_of_its_tube() -> None:
    """Version 15.03 and older store `auto` without a value; the tip of the nose is no neighbor of its base."""
    stated, automatic = (
        read_design(design().replace("<aftradius>0.033<", f"<aftradius>{text}<").encode(), "a.ork")
        for text in ("0.033", "auto")
    )
    assert automatic.dry_mass == pytest.approx(stated.dry_mass)


def test_the_margin_is_that_of_the_center_of_pressure_at_small_angles() -> None:
    """As the rocket leaves the rod in wind, its center of pressure is far ahead of that at small angles."""
    rows = "0.3,14,0.448,0.47,0.5,0.3", "0.6,40,0.446,0.56,0.5,0.04", "1.0,60,0.440,0.58,0.5,0.01", "2,5,0.43,0.3,0.5,0"
    points = "".join(f"<datapoint>{row}</datapoint>" for row in ("0,0,0.45,NaN,0.5,NaN", *rows))
    types = "Time,Total velocity,CG location,CP location,Mass,Angle of attack"
    stored = f"""<simulations><simulation status="uptodate"><name>Sim 1</name><flightdata maxaltitude="240">
<databranch name="Stage" types="{types}"><event time="0.2" type="launchrod"/>{points}</databranch></flightdata>
</simulation></simulations>"""
    found = read_design(design(rest=stored).encode(), "skylark.ork").start("Skylark", "A", "skylark.ork")
    assert (found.cg, found.cp) == (0.448, 0.58)
    assert found.margin == pytest.approx(2.0)


def test_a_stored_margin_below_one_caliber_is_a_caution_of_every_plan(tmp_path: Path, run: Run) -> None:
    file = tmp_path / "skylark.ork"
    file.write_text(design(rest=BALANCED.format(status="uptodate", cp=0.50)))
    run("ork", file)
    (made,) = run("predict", "--rocket", "Skylark", "--motor", "F24-4W", "--json").document["predictions"]
    (line,) = [one for one in made["safety"] if one["check"] == "stability"]
    assert line["verdict"] == "caution"
    assert line["text"].startswith("0.79 calibers") or line["text"].startswith("0.8 calibers")


def test_the_centers_of_gravity_and_pressure_are_those_at_rod_exit() -> None:
    def start(status: str, cp: float) -> Configuration:
        found = read_design(design(rest=BALANCED.format(status=status, cp=cp)).encode(), "skylark.ork")
        return found.start("Skylark", "A", "skylark.ork")

    assert (start("uptodate", 0.58).cg, start("uptodate", 0.58).cp) == (0.448, 0.58)
    assert start("uptodate", 0.58).margin == pytest.approx((0.58 - 0.448) / 0.066)
    of_its_parts = start("outdated", 0.58)  # of another design
    assert of_its_parts.cp not in (None, 0.58)
    assert start("uptodate", 1.2) == of_its_parts, "beyond the rocket, whose length is 0.8 m"


def test_a_rocket_starts_from_its_design_until_it_has_flown(tmp_path: Path) -> None:
    start = Configuration("Skylark", "A", 0.4, 0.066, 0.8, 1.0, "skylark.ork")
    plan = Flight(rocket="Skylark", config="A", motor="F24-4W")
    with Ledger.open(tmp_path / "ledger.db") as ledger:
        assert ledger.keep_design(start)
        assert not ledger.keep_design(start)
        (from_design,) = predict_plans(ledger, catalogue(), [plan])
        ledger.undo()
        assert ledger.rocket("Skylark").configurations == ()
        (anyone,) = predict_plans(ledger, catalogue(), [plan.with_changes(dry_mass=0.4, diameter=0.066)])
    assert (from_design.plan.dry_mass, from_design.plan.diameter) == (0.4, 0.066)
    assert from_design.cd.mean() == pytest.approx(1.0, rel=0.1)
    assert from_design.cd.std() < anyone.cd.std()


def test_every_plan_starts_from_the_design_and_a_changed_one_makes_a_prediction_stale(tmp_path: Path) -> None:
    plan, motors = Flight(rocket="Skylark", config="A", motor="F24-4W"), catalogue()
    with Ledger.open(tmp_path / "ledger.db") as ledger:
        ledger.keep_design(Configuration("Skylark", "A", 0.4, 0.066, 0.8, 1.0, "skylark.ork"))
        (predicted,) = predict_plans(ledger, motors, [plan])
        rocket, begins = rocket_of(ledger, motors, "Skylark"), completed_plan(ledger, motors, plan, Settings())
        assert (begins.dry_mass, begins.diameter) == (0.4, 0.066)
        planned = [(begins, motors.resolve("F24-4W"))]
        (printed,) = forecasts(rocket, planned, draws=400)
        (choice,) = guide(rocket, begins, [planned[0][1].motor], limits(), Site(), draws=400)
        for one in (printed, choice.prediction):
            assert np.median(one.apogee) == pytest.approx(np.median(predicted.apogee), rel=0.03)
        (open_one,) = list_forecasts(ledger, motors)
        assert not open_one.stale
        ledger.keep_design(Configuration("Skylark", "A", 0.42, 0.066, 0.8, 0.6, "skylark.ork"))
        (stale,) = list_forecasts(ledger, motors)
    changes = [change.words() for change in stale.changes]
    assert changes == ["the design's Cd was 1, now 0.6", "the design's dry mass was 400 g, now 420 g"]


def test_every_configuration_starts_from_its_own_design(tmp_path: Path) -> None:
    plans = [Flight(rocket="Skylark", config=config, motor="F24-4W") for config in "AB"]
    with Ledger.open(tmp_path / "ledger.db") as ledger:
        ledger.keep_design(Configuration("Skylark", "A", 0.4, 0.066, 0.8, 0.5, "slim.ork"))
        ledger.keep_design(Configuration("Skylark", "B", 0.4, 0.066, 0.8, 1.0, "wide.ork"))
        slim, wide = predict_plans(ledger, catalogue(), plans, save="nothing")
        alone = [predict_plans(ledger, catalogue(), [plan], save="nothing")[0] for plan in plans]
        turned = predict_plans(ledger, catalogue(), plans[::-1], save="nothing")[::-1]
        draggy = [
            Flight(f"{n}", rocket="Skylark", config="A", motor="F24-4W", dry_mass=0.4, diameter=0.066, apogee=height)
            for n, height in enumerate([150.0, 152.0, 149.0])  # far more drag than 0.5
        ]
        ledger.add(draggy)
        _, after_flights = predict_plans(ledger, catalogue(), plans, save="nothing")
    assert np.median(wide.cd) / np.median(slim.cd) == pytest.approx(2.0, rel=0.05)
    for one, by_itself, backwards in zip((slim, wide), alone, turned, strict=True):
        assert np.median(by_itself.cd) == pytest.approx(np.median(one.cd), rel=0.05)
        assert np.median(backwards.cd) == pytest.approx(np.median(one.cd), rel=0.05)
    assert np.median(after_flights.cd) > np.median(wide.cd)


def test_a_rocket_that_only_has_a_design_can_be_planned(tmp_path: Path, run: Run) -> None:
    file = tmp_path / "skylark.ork"
    file.write_bytes(packed(design(rest=SIMULATION.format(status="uptodate")), "zip"))
    run("ork", file)
    assert "expected --motor" in run("delay", "--rocket", "Skylark", status=1).err
    guided = ["motors", "--fit", "Skylark", "--mount", "24mm", "--class", "E"]
    for command in (guided, ["delay", "--rocket", "Skylark", "--motor", "E20W"]):
        printed = run(*command).out
        assert "no flights of this rocket" in printed
        assert "initial Cd 0.55 from skylark.ork" in printed


def test_the_command_saves_the_design_and_reports_what_it_found(tmp_path: Path, run: Run) -> None:
    file = tmp_path / "skylark.ork"
    file.write_bytes(packed(design(rest=SIMULATION.format(status="uptodate")), "zip"))
    printed = run("ork", file, "--config", "A")
    assert "dry mass  400 g" in printed.out
    assert "Cd        0.55" in printed.out
    assert "Saved" in printed.err
    document = run("ork", file, "--look", "--rocket", "Lark", "--json").document
    assert (document["rocket"], document["saved"], document["diameter_mm"]) == ("Lark", False, pytest.approx(66.0))
    with Ledger.open(tmp_path / "ledger.db") as opened:
        assert opened.flights() == []
        assert [one.config for one in opened.rocket("Skylark").configurations] == ["A"]
    assert "none.ork" in run("ork", tmp_path / "none.ork", status=1).err
