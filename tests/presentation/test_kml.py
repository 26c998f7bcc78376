"""KML: positions on the ground, complete documents, escaped names."""

from pathlib import Path
from xml.etree import ElementTree

import numpy as np
import pytest

from fieldkit.cli.main import main
from fieldkit.errors import BadValue
from fieldkit.physics.descent import DescentResult
from fieldkit.planning.landing import Landing
from fieldkit.presentation.kml import EARTH_RADIUS, landing_gpx, landing_kml, placed, read_place, track_gpx, track_kml

pytestmark = pytest.mark.fast

CHECK_SHAPES = False
SPACE = "{http://www.opengis.net/kml/2.2}"
LOG = Path(__file__).parents[2] / "sample_logs" / "altos_csv__with_satellites.csv"


def coordinates(content: bytes) -> list[list[tuple[float, ...]]]:
    root = ElementTree.fromstring(content)
    return [
        [tuple(map(float, place.split(","))) for place in (one.text or "").split()]
        for one in root.iter(f"{SPACE}coordinates")
    ]


def test_downwind_of_a_west_wind_is_east_and_to_its_right_is_south() -> None:
    one = placed((45.0, 7.0), 270.0, np.array([[1000.0, 0.0], [0.0, 1000.0]]))
    degree = np.radians(1) * EARTH_RADIUS
    assert one[0] == pytest.approx([7 + 1000 / (degree * np.cos(np.pi / 4)), 45.0])
    assert one[1] == pytest.approx([7.0, 45 - 1000 / degree])


def test_a_landing_has_a_pad_a_center_an_ellipse_and_some_draws() -> None:
    rng = np.random.default_rng(0)
    along, across = 300 + 40 * rng.normal(size=200), 20 * rng.normal(size=200)
    down = DescentResult(*[np.ones(200)] * 7)
    content = landing_kml(
        "<Comet> & \x1b[31m", Landing(along, across, np.ones(200), down, lambda _: down, 4.0), (47.5, 8.7), 270.0
    )
    found = coordinates(content)
    assert found[0] == [(8.7, 47.5)]
    assert len(found[2]) == 72
    assert found[2][0] == pytest.approx(found[2][-1])
    assert len(found) == 3 + 100
    assert b"\x1b" not in content


def test_a_landing_as_gpx_has_the_places_of_the_kml() -> None:
    down = DescentResult(*[np.ones(20)] * 7)
    along = 300 + np.linspace(-9, 9, 20)
    found = Landing(along, np.cos(along), np.ones(20), down, lambda _: down, 4.0)
    landed = coordinates(landing_kml("Comet", found, (47.5, 8.7), 250.0))
    root = ElementTree.fromstring(landing_gpx("<Comet>", found, (47.5, 8.7), 250.0))
    space = "{http://www.topografix.com/GPX/1/1}"
    marks = {one.findtext(f"{space}name"): (one.get("lon"), one.get("lat")) for one in root.iter(f"{space}wpt")}
    assert marks.keys() == {"pad", "center of the landings"}
    assert tuple(map(float, marks["center of the landings"])) == pytest.approx(landed[1][0], abs=1e-6)  # type: ignore[arg-type]
    points = [(float(one.get("lon", "")), float(one.get("lat", ""))) for one in root.iter(f"{space}trkpt")]
    assert points == pytest.approx(landed[2], abs=1e-6)
    assert root.findtext(f"{space}trk/{space}name") == "<Comet>: 90% of landings"


def test_the_map_shows_below_the_ellipse_and_each_style_is_defined() -> None:
    """Without a style an area is opaque white: it hides the field."""
    down = DescentResult(*[np.ones(20)] * 7)
    along = 300 + np.linspace(-9, 9, 20)
    found = Landing(along, np.cos(along), np.ones(20), down, lambda _: down, 4.4704)
    landed = landing_kml("Comet", found, (47.5, 8.7), 270.0, "US")
    assert b"10.0 mph at the pad" in landed
    for content in (landed, track_kml("3", np.array([47.0, 47.1]), np.array([8.0, 8.1]), None)):
        root = ElementTree.fromstring(content)
        styles = {one.get("id"): one for one in root.iter(f"{SPACE}Style")}
        used = {(one.text or "").removeprefix("#") for one in root.iter(f"{SPACE}styleUrl")}
        assert used == set(styles)
        for placemark in root.iter(f"{SPACE}Placemark"):
            if placemark.find(f"{SPACE}Polygon") is not None:
                fill = styles["area"].find(f"{SPACE}PolyStyle/{SPACE}color")
                assert fill is not None
                assert int((fill.text or "ff")[:2], 16) < 128


def test_a_track_has_altitudes_above_sea_level_and_omits_missing_positions() -> None:
    latitude = np.array([47.0, np.nan, 47.001, 0.0, 47.002])
    longitude = np.array([8.0, 8.0, 8.001, 0.0, 8.002])
    content = track_kml("3", latitude, longitude, np.array([400.0, 1, 500, 0, 410]))
    track, first, last = coordinates(content)
    assert (first, last) == ([(8.0, 47.0)], [(8.002, 47.002)])
    assert track == [(8.0, 47.0, 400.0), (8.001, 47.001, 500.0), (8.002, 47.002, 410.0)]
    with pytest.raises(BadValue, match="no GPS positions"):
        track_kml("3", np.full(4, np.nan), np.full(4, np.nan), None)


@pytest.mark.parametrize("text", ["47.5", "95,8", "here,there", "nan,8"])
def test_an_invalid_position_is_named(text: str) -> None:
    assert read_place("47.5, -8.7") == (47.5, -8.7)
    with pytest.raises(BadValue, match=r"such as 47\.5"):
        read_place(text)


def test_a_track_is_written_as_gpx_too() -> None:
    latitude, longitude = np.array([47.0, np.nan, 47.002]), np.array([8.0, 8.1, 8.002])
    root = ElementTree.fromstring(track_gpx("3 & 4", latitude, longitude, np.array([400.0, 1.0, 410.0])))
    space = {"g": "http://www.topografix.com/GPX/1/1"}
    points = root.findall("g:trk/g:trkseg/g:trkpt", space)
    assert [(float(one.attrib["lat"]), float(one.attrib["lon"])) for one in points] == [(47.0, 8.0), (47.002, 8.002)]
    assert [one.findtext("g:ele", namespaces=space) for one in points] == ["400.0", "410.0"]
    assert root.findtext("g:trk/g:name", namespaces=space) == "3 & 4"


def test_the_track_of_a_flight_is_written(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    ledger = ["--ledger", str(tmp_path / "ledger.db")]
    assert main([*ledger, "import", str(LOG)]) == 0
    capsys.readouterr()
    assert main([*ledger, "flights"]) == 0
    id = next(word for word in capsys.readouterr().out.split() if word.startswith("flight-") or word.isdecimal())
    out = tmp_path / "track.kml"
    assert main([*ledger, "track", id, "--out", str(out)]) == 0
    track, *ends = coordinates(out.read_bytes())
    assert [end[0] for end in ends] == [track[0][:2], track[-1][:2]]
    assert len(track) > 2
    assert main([*ledger, "track", id, "--out", str(out)]) == 1  # the file exists
