"""Sentences of a satellite receiver (NMEA 0183) as a table: the fixes of its `GGA` sentences.

A receiver or the ground station of a tracker sends `$GPGGA,130405.20,4807.038,N,01131.000,E,1,08,0.9,545.4,M,...`: the
time of day in UTC, latitude and longitude in degrees and minutes, the quality of the fix (0 for none), satellites,
dilution, and the height above sea level. Other sentences, and those with a wrong checksum, are left out.

Source: the description of GGA in the protocol specification of u-blox 8 receivers (UBX-13003221).
"""

import io
import re
from functools import reduce
from operator import xor

from fieldkit.importing.tables.text import first_lines, lines, narrow

_FIX = re.compile(rb"\$([A-Z]{2}GGA,(\d\d)(\d\d)(\d\d(?:\.\d{1,6})?),([^*\r\n]{0,100}))(?:\*([0-9A-Fa-f]{2}))?")
_MIN_FIXES, _LOOKED_AT = 10, 200
"""Fewest fixes that form a table, and the number of first lines among which one must be. [1]"""
_HEADER = b"time,latitude [deg],longitude [deg],satellites,gps altitude [m]"


def fixes_table(log: bytes) -> bytes | None:
    """The fixes of a text of sentences as CSV, a row for each; None if it has too few. Raises DamagedLog."""
    if not any("GGA," in line[:200] for line in first_lines(log, most=_LOOKED_AT)):
        return None
    found = (_FIX.search(line[:1000]) for line in lines(narrow(log)))
    table, count = io.BytesIO(), 0
    table.write(_HEADER)
    for row in filter(None, map(_row, filter(None, found))):
        table.write(b"\n" + row)
        count += 1
    return table.getvalue() + b"\n" if count >= _MIN_FIXES else None


def _row(fix: "re.Match[bytes]") -> bytes:
    """A fix as cells; empty if there is none or its checksum is wrong."""
    sentence, hours, minutes, seconds, rest, checksum = fix.groups()
    cells = rest.split(b",")
    if len(cells) < 9 or cells[4] == b"0" or (checksum and reduce(xor, sentence) != int(checksum, 16)):
        return b""
    latitude, longitude = _degrees(cells[0], cells[1] == b"S"), _degrees(cells[2], cells[3] == b"W")
    return b",".join((b":".join((hours, minutes, seconds)), latitude, longitude, cells[5], cells[7]))


def _degrees(text: bytes, negative: bool) -> bytes:
    """Degrees of `4807.038`, which is 48 degrees and 7.038 minutes; empty if it is not a number."""
    if not (found := re.fullmatch(rb"(\d{1,3})(\d\d(?:\.\d*)?)", text)):
        return b""
    degrees = float(found[1]) + float(found[2]) / 60
    return b"%.7f" % (-degrees if negative else degrees)
