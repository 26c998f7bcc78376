"""Lines that another program wrapped: `> ` or a time before each line, or each whole line in quotation marks."""

import re

from fieldkit.importing.tables.text import first_lines, narrow

_LOOKED_AT, _MAX_LINE, _MAX_SIZE = 60, 4096, 32 << 20
"""Number of first lines that show a wrapping [1], what is looked at of each [character], and the largest size of a text
that is unwrapped [byte]."""
_CITED, _QUOTED = re.compile(r"[ \t]{0,8}>"), re.compile(r'"(?:[^"]|"")*"[,; \t\r]*')
_CITATION = re.compile(rb"^[ \t]{0,8}>[ \t]?", re.MULTILINE)
_STAMPED = (
    rb"(?:[ \t]{0,8}\[?(\d{1,2}:\d\d:\d\d(?:[.,]\d{1,6})?)(?:\]|[ \t]*->)"
    rb"|(?:\x1b\[[\d;]{0,8}m)?[EWIDV] \((\d{1,12})\) [^\s:]{1,40}:)[ \t]?"
)
"""The time of day that the monitor of the Arduino IDE or a terminal puts before each line, or the milliseconds of the
ESP32's logging library."""
_QUOTATION = re.compile(rb'^"((?:[^"\r\n]|"")*)"[,; \t]*(?=\r?$)', re.MULTILINE)


def unwrapped(log: bytes) -> bytes:
    """A log without what wraps each of its lines; unchanged if one of its first lines is not wrapped, or it is too
    large. Raises DamagedLog."""
    start = [line[:_MAX_LINE] for line in first_lines(log, most=_LOOKED_AT) if line.strip()]
    if len(log) > _MAX_SIZE or len(start) < 2:
        return log
    if all(map(_CITED.match, start)):
        return _CITATION.sub(b"", narrow(log))
    if all(map(_QUOTED.fullmatch, start)):
        return _QUOTATION.sub(lambda line: line[1].replace(b'""', b'"'), narrow(log))
    return log


def unstamped(log: bytes) -> tuple[bytes, bytes] | None:
    """A log without the time before each line, and with it as a first column; None if one of its first lines has no
    such time. Raises DamagedLog."""
    start = [line[:_MAX_LINE].encode() for line in first_lines(log, most=_LOOKED_AT) if line.strip()]
    if len(log) > _MAX_SIZE or len(start) < 2 or not all(re.match(_STAMPED, line) for line in start):
        return None
    plain, stamps = narrow(log), re.compile(rb"^" + _STAMPED, re.MULTILINE)
    separator = max((b",", b";", b"\t"), key=start[-1].count)
    counts = re.match(_STAMPED, start[-1])[2] is not None  # type: ignore[index]
    _, _, others = stamps.sub(lambda line: (line[1] or line[2]) + separator, plain).partition(separator)
    return stamps.sub(b"", plain), (b"time [ms]" if counts else b"time") + separator + others
