"""KML and GPX of a predicted landing and of a flown track, for maps and hand-held receivers.

Source: OGC KML 2.3 (12-007r2): coordinates are longitude, latitude and altitude, in degrees and meters. GPX 1.1: the
schema of Topografix, http://www.topografix.com/GPX/1/1.
"""

from collections.abc import Sequence
from pathlib import Path
from typing import Any
from xml.sax.saxutils import escape

import numpy as np

from fieldkit.errors import BadValue
from fieldkit.flight import Series
from fieldkit.planning.landing import Landing
from fieldkit.quantities import ShownUnits
from fieldkit.safe_text import printable
from fieldkit.shapes import Array, Float

EARTH_RADIUS = 6371008.8
"""Mean radius of the Earth (IUGG). [m]"""
MAX_POINTS = 2000
"""Maximum number of points of a track, evenly selected. [1]"""
TRACK_SUFFIXES = (".kml", ".gpx")

RED = "0000ff"
"""Color of what is drawn, as KML writes it after the opacity: blue, green, red."""
STYLES = {
    "area": f"<LineStyle><color>ff{RED}</color><width>2</width></LineStyle>"
    f"<PolyStyle><color>33{RED}</color></PolyStyle>",
    "draw": "<IconStyle><scale>0.4</scale></IconStyle>",
    "track": f"<LineStyle><color>ff{RED}</color><width>3</width></LineStyle>",
}
"""Styles by id: without one, a map viewer fills an area with opaque white, and marks every point with a large pin."""


def read_place(text: str) -> tuple[float, float]:
    """A pad typed as `47.5,8.7`: latitude and longitude. [deg] Raises BadValue for anything else."""
    wanted = BadValue(f"found {text[:40]!r}, expected latitude and longitude in degrees, such as 47.5,8.7")
    try:
        latitude, longitude = (float(part) for part in text.split(","))
    except ValueError:
        raise wanted from None
    if not (-89 <= latitude <= 89 and -180 <= longitude <= 180):
        raise wanted
    return latitude, longitude


def placed(pad: tuple[float, float], wind_from: float, points: Float[Array, "point 2"]) -> Float[Array, "point 2"]:
    """Longitude and latitude [deg] of points given by their distances downwind of a pad and to the right of that [m];
    the wind is from `wind_from`, clockwise from north. [deg]"""
    toward = np.radians(wind_from) + np.pi
    along, right = points[:, 0], points[:, 1]
    north = along * np.cos(toward) - right * np.sin(toward)
    east = along * np.sin(toward) + right * np.cos(toward)
    latitude = pad[0] + np.degrees(north / EARTH_RADIUS)
    longitude = pad[1] + np.degrees(east / (EARTH_RADIUS * np.cos(np.radians(pad[0]))))
    return np.stack([longitude, latitude], axis=-1)


def landing_kml(name: str, found: Landing, pad: tuple[float, float], wind_from: float, system: str = "SI") -> bytes:
    """The pad, the most likely landing, the ellipse around it, and some of the landing draws; `pad` is latitude and
    longitude [deg], `wind_from` an angle from north [deg], and the wind is described in the units of a system."""
    ellipse = found.ellipse()
    outline = placed(pad, wind_from, ellipse.outline())
    centre = placed(pad, wind_from, np.array([[ellipse.along, ellipse.across]]))
    drawn = placed(pad, wind_from, np.stack([found.along, found.across], axis=-1)[:100])
    marks = "".join(f"<Point><coordinates>{_places(point[None])}</coordinates></Point>" for point in drawn)
    wind = f"wind from {wind_from:g} degrees, {ShownUnits(system).speed(found.wind or 0.0)} at the pad"
    parts = [
        f"<description>{escape(wind)}</description>",
        _style("area"),
        _style("draw"),
        _placemark("pad", f"<Point><coordinates>{pad[1]:.7f},{pad[0]:.7f}</coordinates></Point>"),
        _placemark("center of the landings", f"<Point><coordinates>{_places(centre)}</coordinates></Point>"),
        _placemark(
            f"{ellipse.level:.0%} of landings",
            "<Polygon><outerBoundaryIs><LinearRing><coordinates>"
            f"{_places(outline)}</coordinates></LinearRing></outerBoundaryIs></Polygon>",
            "area",
        ),
        _placemark("simulated landings", f"<MultiGeometry>{marks}</MultiGeometry>", "draw"),
    ]
    return _document(name, parts)


def landing_gpx(name: str, found: Landing, pad: tuple[float, float], wind_from: float) -> bytes:
    """The pad and the most likely landing as waypoints, and the ellipse around it as a track; `pad` and `wind_from` are
    as in `landing_kml` [deg]."""
    ellipse = found.ellipse()
    outline = placed(pad, wind_from, ellipse.outline())
    ((longitude, latitude),) = placed(pad, wind_from, np.array([[ellipse.along, ellipse.across]]))
    marks = (("pad", pad[0], pad[1]), ("center of the landings", latitude, longitude))
    waypoints = "".join(f'<wpt lat="{lat:.7f}" lon="{lon:.7f}"><name>{mark}</name></wpt>' for mark, lat, lon in marks)
    title = f"{name}: {ellipse.level:.0%} of landings"
    return _gpx(waypoints, title, [f'<trkpt lat="{lat:.7f}" lon="{lon:.7f}"/>' for lon, lat in outline])


def check_track(file: Path) -> None:
    """Raise BadValue for a file name that is neither KML nor GPX."""
    if file.suffix.lower() not in TRACK_SUFFIXES:
        raise BadValue(f"{file.name}: found {file.suffix or 'no suffix'!r}, expected .kml or .gpx")


def track_file(name: str, positions: Series, suffix: str) -> bytes:
    """The satellite track in some samples as KML, or as GPX with that suffix. Raises BadValue for fewer than two
    positions."""
    write = track_gpx if suffix == ".gpx" else track_kml
    if positions.latitude is None or positions.longitude is None:
        raise BadValue(f"{printable(name)}: found no GPS positions, expected a log of a tracker")
    return write(name, positions.latitude, positions.longitude, positions.gps_altitude_msl)


def track_kml(
    name: str, latitude: Float[Array, "time"], longitude: Float[Array, "time"], altitude: Float[Array, "time"] | None
) -> bytes:
    """A satellite track, with its altitude above sea level [m] if recorded, and its ends on the ground. Raises BadValue
    for fewer than two positions."""
    rows = _positions(name, latitude, longitude, altitude)
    columns = [longitude[rows], latitude[rows], *([altitude[rows]] if altitude is not None else [])]
    mode = "<altitudeMode>absolute</altitudeMode>" if altitude is not None else "<tessellate>1</tessellate>"
    path = f"<LineString>{mode}<coordinates>{_places(np.stack(columns, axis=-1))}</coordinates></LineString>"
    ends = [
        _placemark(end, f"<Point><coordinates>{longitude[row]:.7f},{latitude[row]:.7f}</coordinates></Point>")
        for end, row in (("first position", rows[0]), ("last position", rows[-1]))
    ]
    return _document(name, [_style("track"), _placemark("track", path, "track"), *ends])


def track_gpx(
    name: str, latitude: Float[Array, "time"], longitude: Float[Array, "time"], altitude: Float[Array, "time"] | None
) -> bytes:
    """The same track as GPX, which map programs and hand-held receivers read. Raises BadValue as `track_kml`. [degrees,
    m]"""
    rows = _positions(name, latitude, longitude, altitude)
    heights = [""] * len(rows) if altitude is None else [f"<ele>{altitude[row]:.1f}</ele>" for row in rows]
    points = [
        f'<trkpt lat="{latitude[row]:.7f}" lon="{longitude[row]:.7f}">{height}</trkpt>'
        for row, height in zip(rows, heights, strict=True)
    ]
    return _gpx("", name, points)


def _gpx(waypoints: str, name: str, points: Sequence[str]) -> bytes:
    """A document with waypoints and a track of points."""
    title = f"<name>{escape(printable(name))}</name>"
    return (
        '<?xml version="1.0" encoding="UTF-8"?>\n<gpx version="1.1" creator="fieldkit" '
        f'xmlns="http://www.topografix.com/GPX/1/1">{waypoints}<trk>{title}<trkseg>{"".join(points)}</trkseg></trk></gpx>\n'
    ).encode()


def _positions(
    name: str, latitude: Float[Array, "time"], longitude: Float[Array, "time"], altitude: Float[Array, "time"] | None
) -> np.ndarray[Any, np.dtype[np.intp]]:
    """Rows of the known positions of a track, at most `MAX_POINTS`. Raises BadValue for fewer than two."""
    known = np.isfinite(latitude) & np.isfinite(longitude) & ((latitude != 0) | (longitude != 0))
    if altitude is not None:
        known &= np.isfinite(altitude)
    rows = np.flatnonzero(known)
    if len(rows) < 2:
        raise BadValue(f"{printable(name)}: found no GPS positions, expected a log of a tracker")
    return np.asarray(rows[np.unique(np.linspace(0, len(rows) - 1, min(MAX_POINTS, len(rows))).astype(int))])


def _places(points: Float[Array, "point axis"]) -> str:
    return " ".join(
        ",".join(f"{value:.7f}" if axis < 2 else f"{value:.1f}" for axis, value in enumerate(point)) for point in points
    )


def _style(name: str) -> str:
    return f'<Style id="{name}">{STYLES[name]}</Style>'


def _placemark(name: str, geometry: str, style: str = "") -> str:
    look = f"<styleUrl>#{style}</styleUrl>" if style else ""
    return f"<Placemark><name>{escape(printable(name))}</name>{look}{geometry}</Placemark>"


def _document(name: str, parts: Sequence[str]) -> bytes:
    head = '<?xml version="1.0" encoding="UTF-8"?>\n<kml xmlns="http://www.opengis.net/kml/2.2"><Document>'
    body = "\n".join([f"<name>{escape(printable(name))}</name>", *parts])
    return f"{head}\n{body}\n</Document></kml>\n".encode()
