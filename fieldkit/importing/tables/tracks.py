"""Tracks of satellite receivers for maps and gliders as a table: GPX, TCX, KML with times, and IGC.

A receiver in a rocket, a phone or a tracker writes a point for each fix: `<trkpt lat="45.1" lon="7.2"><ele>312</ele>
<time>2026-05-01T12:00:01Z</time></trkpt>` in GPX, `<Trackpoint>` in TCX, `<when>` and `<gx:coord>` in KML, and in IGC
`B1200014506000N00712000EA0031200315`, whose two heights are by the standard atmosphere and by satellites. A KML line
without times is not a log.

Source: the GPX 1.1 schema of Topografix, version 2 of Garmin's TCX schema, the KML 2.2 reference, the IGC Technical
Specification for GNSS flight recorders.
"""

import re
from collections.abc import Iterator

from fieldkit.importing.tables.text import MAX_TABLE_SIZE, lines

_MIN_POINTS, _LOOKED_AT = 10, 65_536
"""Fewest points that form a table [1], and size of the beginning that shows the format [bytes]."""
_HEADER = b"time,latitude [deg],longitude [deg],gps altitude [m]"
_IGC_HEADER = _HEADER + b",altitude above sea level [m]"
_NUMBER, _MOMENT = rb"\s?([^<>\"',\s]{1,30})\s?", rb"\s?([^<>\"',\s]{8,40})\s?"
"""A number or a time, loosely: the reader of the table refuses others with their row."""
_POINT, _END, _LONGEST_POINT = b"<trkpt", b"</trkpt>", 2300
"""What a point begins and ends with, and the longest one. [bytes]"""
_ATTRIBUTE = {name: re.compile(rb"\b" + name + rb"\s?=\s?[\"']" + _NUMBER + rb"[\"']") for name in (b"lat", b"lon")}
_HEIGHT, _TIME = re.compile(rb"<ele>" + _NUMBER + rb"</ele>"), re.compile(rb"<time>" + _MOMENT + rb"</time>")
_TCX_POINT = re.compile(
    rb"<Trackpoint>\s*<Time>"
    + _MOMENT
    + rb"</Time>\s*<Position>\s*<LatitudeDegrees>"
    + _NUMBER
    + rb"</LatitudeDegrees>\s*<LongitudeDegrees>"
    + _NUMBER
    + rb"</LongitudeDegrees>\s*</Position>\s*"
    + rb"<AltitudeMeters>"
    + _NUMBER
    + rb"</AltitudeMeters>"
)
_WHEN, _PLACE = re.compile(rb"<when>([^<>]{0,60})</when>"), re.compile(rb"<gx:coord>([^<>]{0,120})</gx:coord>")
"""The times and the places of a KML track, which belong together by their order."""
_FIX = re.compile(rb"B(\d\d)(\d\d)(\d\d)(\d\d)(\d{5})([NS])(\d{3})(\d{5})([EW])[AV](-\d{4}|\d{5})(-\d{4}|\d{5})")


def track_table(log: bytes) -> bytes | None:
    """The points of a track as CSV, a row for each; None if it is no track or has too few points with a time."""
    if len(log) > MAX_TABLE_SIZE:
        return None
    start, header = log[:_LOOKED_AT], _HEADER
    if b"<gpx" in start:
        rows = list(_of_gpx(log))
    elif b"<TrainingCenterDatabase" in start:
        rows = [b",".join(point.groups()) for point in _TCX_POINT.finditer(log)]
    elif b"<gx:coord>" in log and b"<when>" in log:
        rows = list(_of_kml(log))
    elif any(_FIX.match(line) for line in start.split(b"\n")):
        rows, header = list(_of_igc(log)), _IGC_HEADER
    else:
        return None
    return b"\n".join((header, *rows, b"")) if len(rows) >= _MIN_POINTS else None


def _of_gpx(log: bytes) -> Iterator[bytes]:
    """The points of a GPX track that have a place, a height and a time, as cells."""
    after = 0
    while (end := log.find(_END, after)) >= 0:
        begin = log.rfind(_POINT, max(after, end - _LONGEST_POINT), end)
        after = end + len(_END)
        if begin < 0:
            continue
        attributes, _, inside = log[begin:end].partition(b">")
        found = [
            _TIME.search(inside),
            *(name.search(attributes) for name in _ATTRIBUTE.values()),
            _HEIGHT.search(inside),
        ]
        cells = [match[1] for match in found if match]
        if len(cells) == len(found):
            yield b",".join(cells)


def _of_kml(log: bytes) -> Iterator[bytes]:
    """The points of a KML track that have a time and a place, as cells."""
    for when, place in zip(_WHEN.findall(log), _PLACE.findall(log), strict=False):
        cells = [*when.split(), *place.split()]
        if len(cells) == 4 and not any(mark in cell for cell in cells for mark in (b'"', b",")):
            yield b",".join((cells[0], cells[2], cells[1], cells[3]))


def _of_igc(log: bytes) -> Iterator[bytes]:
    """The fixes of an IGC file, as cells."""
    for fix in filter(None, map(_FIX.match, lines(log))):
        latitude, longitude = _degrees(fix[4], fix[5], fix[6] == b"S"), _degrees(fix[7], fix[8], fix[9] == b"W")
        yield b",".join((b":".join(fix.group(1, 2, 3)), latitude, longitude, b"%d,%d" % (int(fix[11]), int(fix[10]))))


def _degrees(whole: bytes, thousandths: bytes, negative: bool) -> bytes:
    """Degrees of whole degrees and thousandths of minutes."""
    degrees = int(whole) + int(thousandths) / 60_000
    return b"%.6f" % (-degrees if negative else degrees)
