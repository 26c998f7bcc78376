"""Tracks for maps and gliders are read like the table of a satellite receiver."""

import numpy as np
import pytest

from fieldkit.errors import UnknownFormat
from fieldkit.importing.read import read
from tests.samples import any_motor
from tools.samples.one_parachute import flight

pytestmark = pytest.mark.fast
MADE = flight(thrust=160.0)
TIMES = np.arange(-10.0, MADE.time[-1], 0.5)
HEIGHTS = MADE.pad + MADE.at(TIMES, MADE.height)
CLOCKS = [f"12:{int(t + 10) // 60:02}:{(t + 10) % 60:04.1f}" for t in TIMES]


def gpx() -> str:
    points = (
        f'<trkpt lat="45.1" lon="-7.2"><ele>{height:.1f}</ele><time>2026-05-01T{clock}Z</time></trkpt>'
        for clock, height in zip(CLOCKS, HEIGHTS, strict=True)
    )
    return '<?xml version="1.0"?><gpx version="1.1"><trk><trkseg>\n' + "\n".join(points) + "\n</trkseg></trk></gpx>\n"


def kml() -> str:
    whens = "\n".join(f"<when>2026-05-01T{clock}Z</when>" for clock in CLOCKS)
    places = "\n".join(f"<gx:coord>-7.2 45.1 {height:.1f}</gx:coord>" for height in HEIGHTS)
    return f'<?xml version="1.0"?>\n<kml><gx:Track>\n{whens}\n{places}\n</gx:Track></kml>\n'


def igc() -> str:
    fixes = zip(CLOCKS[::2], HEIGHTS[::2], strict=True)
    rows = (f"B{c.replace(':', '')[:6]}4506000N00712000WA{h - 20:05.0f}{h:05.0f}" for c, h in fixes)
    return "AXXXABC\r\nHFDTE010526\r\n" + "\r\n".join(rows) + "\r\n"


@pytest.mark.parametrize("track", [gpx(), kml(), igc()], ids=["GPX", "KML", "IGC"])
def test_a_track_has_the_apogee_of_its_flight(track: str) -> None:
    imported = read(track.encode(), "track", any_motor)
    assert imported.format == "mapped_table"
    assert imported.flights[0].apogee == pytest.approx(MADE.apogee, abs=5.0)


def test_a_line_of_a_map_without_times_is_not_a_log() -> None:
    rows = "".join(f"7.0,45.0,{height:.1f}\n" for height in HEIGHTS)
    with pytest.raises(UnknownFormat, match="it is XML, such as a track for maps"):
        read(f'<?xml version="1.0"?>\n<kml><coordinates>\n{rows}</coordinates></kml>'.encode(), "t.kml", any_motor)


@pytest.mark.parametrize("wrong", ["1e308", "nan", "4o5", "999999999"])
@pytest.mark.parametrize("track", [gpx(), kml()], ids=["GPX", "KML"])
def test_a_point_with_a_wrong_height_costs_that_point(track: str, wrong: str) -> None:
    """The other points keep their own times; what is no number is refused with its row."""
    height = f"{HEIGHTS[30]:.1f}"
    where = track.rindex(height) if track.count(height) == 1 else track.index(height, track.index(CLOCKS[29]))
    imported = read((track[:where] + wrong + track[where + len(height) :]).encode(), "track", any_motor)
    rejected = [(32, True)] if wrong in ("1e308", "4o5") else []
    assert [(one.row, repr(wrong) in one.error) for one in imported.rejected] == rejected
    assert imported.flights[0].apogee == pytest.approx(MADE.apogee, abs=5.0)
