"""The Cd that stored apogees imply, for files that store no drag coefficient."""

import math
from collections.abc import Sequence

import pytest

from fieldkit.flight import Flight
from fieldkit.motors import Found, catalogue
from fieldkit.openrocket import Design, read_design
from fieldkit.physics.single import field_flight

pytestmark = pytest.mark.fast

Row = tuple[str, str, float]
"""A motor, its delay, and the stored apogee. [m]"""


def read(
    rows: Sequence[Row],
    dry_mass: float,
    wind: float = 2.0,
    status: str = "uptodate",
    more: str = "",
    *,
    levels: bool = False,
) -> Design:
    """A design of 25 mm without drag columns, with one configuration and one stored summary for each motor; `more` are
    further conditions."""
    motors = "".join(
        f'<motor configid="{n}"><manufacturer>Estes</manufacturer><designation>{name}</designation>'
        f"<delay>{delay}</delay></motor>"
        for n, (name, delay, _) in enumerate(rows)
    )
    model = "<windmodeltype>MultiLevel</windmodeltype>" if levels else ""
    simulations = "".join(
        f'<simulation status="{status}"><name>{n}</name><conditions><configid>{n}</configid><launchrodlength>1.0'
        f"</launchrodlength><windaverage>{wind}</windaverage>{model}{more}</conditions>"
        f'<flightdata maxaltitude="{apogee}" maxvelocity="90"/></simulation>'
        for n, (_, _, apogee) in enumerate(rows)
    )
    tube = f"""<bodytube><length>0.4</length><thickness>0.001</thickness><radius>0.0125</radius><subcomponents>
<innertube><length>0.07</length><outerradius>0.0095</outerradius><thickness>0.0005</thickness><motormount>{motors}
</motormount></innertube></subcomponents></bodytube>"""
    stage = f"""<stage><overridemass>{dry_mass}</overridemass>
<overridesubcomponentsmass>true</overridesubcomponentsmass><subcomponents>{tube}</subcomponents></stage>"""
    return read_design(
        f'<openrocket version="1.9"><rocket><name>A</name><subcomponents>{stage}</subcomponents></rocket>'
        f"<simulations>{simulations}</simulations></openrocket>".encode(),
        "a.ork",
    )


def test_the_cd_of_a_flight_of_our_own_is_found_again_from_its_apogee() -> None:
    motor = catalogue().resolve("Estes C6").motor
    plan = Flight(
        dry_mass=0.047,
        diameter=0.025,
        rail_length=1.0,
        wind=2.0,
        extra={"wind_aloft_mps": "2", "wind_aloft_height_m": "1000"},
    )
    apogee = field_flight(plan, Found(motor, 7.0), 0.82, 1.0)["true_apogee_m"]
    found = read([("C6", "7", apogee)], 0.047)
    assert found.cd == pytest.approx(0.82, rel=0.005)
    assert found.cd_by == "the apogees of 1 simulation"


def test_the_apogees_of_openrockets_own_example_imply_its_cd() -> None:
    """A simple model rocket of OpenRocket's examples: 71 g with a C6, 67 g with a B4, Cd 0.618 to 0.621."""
    motor = catalogue().resolve("Estes C6").motor
    found = read([("B4", "4", 135.07), ("C6", "5", 316.58), ("C6", "7", 319.75)], 0.071 - motor.loaded_mass)
    assert found.cd == pytest.approx(0.62, rel=0.05)
    (note,) = [note for note in found.notes if "imply" in note]
    assert note.count("Estes C6") == 2


@pytest.mark.parametrize(
    ("rows", "status"),
    [
        ([("C6", "7", 5000.0)], "uptodate"),
        ([("ZZ9", "7", 300.0)], "uptodate"),
        ([("C6", "x", 300.0)], "uptodate"),
        ([("C6", "7", 300.0)], "outdated"),
    ],
)
def test_an_apogee_of_another_design_implies_no_cd(rows: list[Row], status: str) -> None:
    found = read(rows, 0.047, status=status)
    assert found.cd is None
    assert any(note.startswith("no Cd:") for note in found.notes)


def test_a_simulation_in_winds_of_several_heights_gives_a_note_and_no_cd() -> None:
    motor = catalogue().resolve("Estes C6").motor
    rows = [("C6", "7", 319.75)]
    found = read(rows, 0.071 - motor.loaded_mass, levels=True)
    assert (found.cd, found.flown_again) == (None, ())
    assert "1 simulation in winds stated for several heights: not flown again here" in found.notes


def cd_in(more: str, **weather: float | str) -> float:
    """The Cd from the apogee of our own flight with a Cd of 0.82 in these conditions, stored with `more`."""
    extra = {"wind_aloft_mps": "2", "wind_aloft_height_m": "1000"}
    extra |= {name: value for name, value in weather.items() if isinstance(value, str)}
    numbers = {name: value for name, value in weather.items() if not isinstance(value, str)}
    plan = Flight(dry_mass=0.047, diameter=0.025, rail_length=1.0, wind=2.0, extra=extra).with_changes(**numbers)
    apogee = field_flight(plan, Found(catalogue().resolve("Estes C6").motor, 7.0), 0.82, 1.0)["true_apogee_m"]
    found = read([("C6", "7", apogee)], 0.047, more=more).cd
    assert found is not None
    return found


def test_the_air_of_a_simulation_counts() -> None:
    air = "<basetemperature>308.15</basetemperature><basepressure>84000</basepressure>"
    site = "<launchaltitude>1500</launchaltitude>"
    hot = {"temperature": 308.15, "pressure": 84000.0, "site_elevation": 1500.0}
    assert cd_in(f'{site}<atmosphere model="extendedisa">{air}</atmosphere>', **hot) == pytest.approx(0.82, rel=0.005)
    standard = cd_in(f'{site}<atmosphere model="isa">{air}</atmosphere>', **hot)
    assert standard < 0.78, "the figures of another model are not used"


@pytest.mark.parametrize(
    ("into", "rod", "wind", "degrees"),
    [
        ("true", 0.0, 0.0, "0"),
        ("false", 0.0, 3.14159265, "180"),
        ("false", 90.0, 1.57079633, "0"),
        ("false", 0.0, 4.71238898, "90"),
    ],
)
def test_a_rod_is_slanted_where_the_simulation_says(into: str, rod: float, wind: float, degrees: str) -> None:
    """OpenRocket stores the direction of the rod in degrees and that from which the wind blows in radians."""
    more = f"<launchrodangle>10</launchrodangle><launchintowind>{into}</launchintowind>"
    more += f"<launchroddirection>{rod}</launchroddirection>"
    more += f'<wind model="average"><speed>2</speed><direction>{wind}</direction></wind>'
    assert cd_in(more, rail_angle=math.radians(10), rail_direction=degrees) == pytest.approx(0.82, rel=0.005)
    assert cd_in(more, rail_angle=math.radians(10), rail_direction="45") != pytest.approx(0.82, rel=0.005)
