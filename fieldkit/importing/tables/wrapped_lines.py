"""Lines that another program wrapped: `> ` or a time before each line, or each in quotation marks or parentheses, or
each number in the name of its type."""

import io
import re
from collections.abc import Callable

from fieldkit.importing.tables.text import MAX_TABLE_SIZE, first_lines, lines, narrow

_LOOKED_AT, _MAX_LINE = 60, 4096
"""Number of first lines that show a wrapping [1], and what is looked at of each [character]."""
_CITED, _QUOTED = re.compile(r"[ \t]{0,8}>"), re.compile(r'"(?:[^"]|"")*"[,; \t\r]*')
_TUPLE = re.compile(r"[ \t]{0,8}(?:\([^()]*\)|\[[^\[\]]*\])[, \t\r]*")
"""A row as Python prints it, `(0.05, 1013.2)`."""
_COUNTDOWN = re.compile(r"[ \t]{0,8}T ?[+-] ?\d")
_COUNTDOWN_MARK, _MOST_COUNTDOWNS = re.compile(rb"^[ \t]{0,8}T ?([+-]) ?(?=\d)"), 0.8
"""The time before and after a launch, `T-004.50` and `T+012.30`, in most of the first lines."""
_CITATION = re.compile(rb"^[ \t]{0,8}>[ \t]?")
_STAMPED = re.compile(
    rb"^(?:[ \t]{0,8}\[?(\d{1,2}:\d\d:\d\d(?:[.,]\d{1,6})?)(?:\]|[ \t]*->)"
    rb"|(?:\x1b\[[\d;]{0,8}m)?[EWIDV] \((\d{1,12})\) [^\s:]{1,40}:)[ \t]?"
)
"""The time of day that the monitor of the Arduino IDE or a terminal puts before each line, or the milliseconds of the
ESP32's logging library."""
_PRINTED = re.compile(rb'np\.(?:float|int|uint)\d{1,3}\(([^()\r\n]{1,40})\)|(?<![\w ])"?="{1,2}([^"\r\n]{1,40})"{1,3}')
"""A number as NumPy prints it, `np.float64(1.2)`, and as the formula of a sheet that keeps its digits, `="1.2"`."""
_QUOTATION = re.compile(rb'^"((?:[^"\r]|"")*+)"[,; \t]*(?=\r?$)')


def unwrapped(log: bytes) -> bytes:
    """A log without what wraps each of its lines; unchanged if one of its first lines is not wrapped, or it is too
    large. Raises DamagedLog."""
    start = [line[:_MAX_LINE] for line in first_lines(log, most=_LOOKED_AT) if line.strip()]
    if len(log) > MAX_TABLE_SIZE or len(start) < 2:
        return log
    if all(_PRINTED.search(line.encode()) for line in start[1:]):
        log = _each_line(log, lambda line: _PRINTED.sub(lambda found: found[1] or found[2], line))
        start = [line[:_MAX_LINE] for line in first_lines(log, most=_LOOKED_AT) if line.strip()]
    if all(map(_CITED.match, start)):
        return _each_line(log, lambda line: _CITATION.sub(b"", line))
    if sum(map(bool, map(_COUNTDOWN.match, start))) > _MOST_COUNTDOWNS * len(start):
        return _each_line(log, lambda line: _COUNTDOWN_MARK.sub(lambda found: found[1].strip(b"+"), line))
    if all(map(_TUPLE.fullmatch, start)):
        return _each_line(log, lambda line: line.strip(b" \t\r,()[]"))
    if all(map(_QUOTED.fullmatch, start)):
        return _each_line(log, lambda line: _QUOTATION.sub(lambda found: found[1].replace(b'""', b'"'), line))
    return log


def unstamped(log: bytes) -> tuple[bytes, bytes] | None:
    """A log without the time before each line, and with it as a first column; None if one of its first lines has no
    such time. Raises DamagedLog."""
    start = [line[:_MAX_LINE].encode() for line in first_lines(log, most=_LOOKED_AT) if line.strip()]
    if len(log) > MAX_TABLE_SIZE or len(start) < 2 or not all(map(_STAMPED.match, start)):
        return None
    separator = max((b",", b";", b"\t"), key=start[-1].count)
    counts = _STAMPED.match(start[-1])[2] is not None  # type: ignore[index]
    timed = _each_line(log, lambda line: _STAMPED.sub(lambda found: (found[1] or found[2]) + separator, line))
    _, _, others = timed.partition(separator)
    plain = _each_line(log, lambda line: _STAMPED.sub(b"", line))
    return plain, (b"time [ms]" if counts else b"time") + separator + others


def _each_line(log: bytes, changed: Callable[[bytes], bytes]) -> bytes:
    """A text with each line changed. Raises DamagedLog."""
    out = io.BytesIO()
    for line in lines(narrow(log)):
        out.write(changed(line) + b"\n")
    return out.getvalue()
