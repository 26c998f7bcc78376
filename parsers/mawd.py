"""PerfectFlite MAWD: the answers of its serial port to I, V, S and D, one after the other.

Model (two lines), firmware (one), then five statistics of a letter and five digits: G ground, A apogee and M main
altitude in feet, N samples, D Mach delay in seconds. Then a line with the sample interval, two digits of milliseconds
at its 21st character, and one sample per line: a character, which is interpreted as a sign or the first of five digits,
and four digits of feet.
Nothing marks the end; the statistics state the number of samples.

Source: readme.md, cmd/dump.go, cmd/stats.go (ukhpr/mawd), which its author describes as untested.
"""

import codecs
import re

import numpy as np

from fieldkit.errors import DamagedLog
from fieldkit.flight import Series
from fieldkit.importing import Note, Parsed, Parser, Reading
from fieldkit.importing.tables.text import line_end, narrow, shown
from fieldkit.quantities import counted
from fieldkit.units import FOOT

STATISTICS = re.compile(rb"^G([-+ \d]\d{4})\s+A(\d{5})\s+N(\d{5})\s+D(\d{5})\s+M(\d{5})\s*$", re.MULTILINE)
SAMPLE = re.compile(r"([^\r\n])(\d{4})")
INTERVAL = slice(20, 22)
"""The characters of the first line after the statistics that are the sample interval. [ms]"""
MAX_LOG_SIZE = 4 << 20
"""Largest file size: a sample is a line of 7 bytes, and the number of samples has five digits. [bytes]"""


def recognises(head: bytes) -> bool:
    return STATISTICS.search(_plain(head)) is not None


def read(log: bytes) -> list[Parsed]:
    if len(log) > MAX_LOG_SIZE:
        expected = f"expected at most {MAX_LOG_SIZE} for the 99999 samples that its statistics can count"
        raise DamagedLog(f"found {len(log)} bytes, {expected}")
    log = _plain(log).rstrip(b"\0\x1a")
    found = list(STATISTICS.finditer(log))
    if not found:
        raise DamagedLog("found no statistics, expected five lines such as G00812, A01204, N00512, D00000, M00700")
    ground, apogee, count, delay, main = (int(figure) for figure in found[-1].groups())
    before = [line.strip() for line in log[: found[0].start()].decode("latin-1").splitlines() if line.strip()]
    firmware = before[-1][:80] if before else ""
    first = log.count(b"\n", 0, found[-1].end()) + 1
    series, notes = _flight(log[found[-1].end() :].decode("latin-1").splitlines(), first, count)
    stated: dict[str, object] = {"apogee": apogee * FOOT, "site_elevation": ground * FOOT}
    extra = {"mach_delay_s": str(delay), "main_altitude_ft": str(main)} | (
        {"model": " ".join(before[:-1])[:80]} if before[:-1] else {}
    )
    columns = {"apogee": "A", "site_elevation": "G"}
    return [Reading(stated, extra, columns, series=series, device="PerfectFlite MAWD", firmware=firmware), *notes]


def _plain(log: bytes) -> bytes:
    """A log with one byte per character and line feeds as line ends, regardless of what a terminal changed."""
    log = narrow(log).removeprefix(codecs.BOM_UTF8)
    return log.replace(b"\r", b"\n") if line_end(log) == b"\r" else log


def _flight(lines: list[str], first: int, count: int) -> tuple[Series | tuple[()], list[Parsed]]:
    """The samples after the statistics, starting at line `first`. Raises DamagedLog without a usable interval."""
    rows = [(row, line) for row, line in enumerate(lines, start=first) if line.strip()]
    if not rows:
        return (), [Note("found statistics and no samples")]
    row, line = rows[0]
    if not re.fullmatch(r"[1-9]\d|0[1-9]", line[INTERVAL]):
        found = f"found {shown(line)}, expected the sample interval, two digits of ms at the 21st character"
        raise DamagedLog(found, row=row)
    rows = rows[: 1 + count]  # a terminal may have recorded further answers
    heights = [_height(text) for _, text in rows[1:]]
    notes: list[Parsed] = []
    lost = [row for (row, _), height in zip(rows[1:], heights, strict=True) if np.isnan(height)]
    if lost:
        notes.append(Note(f"is a damaged sample, left out; {counted(len(lost), 'such sample')} in all", lost[0]))
    if len(heights) < count:
        notes.append(Note(f"ends after {len(heights)} of {counted(count, 'sample')}"))
    if not heights:
        return (), notes
    time = np.arange(len(heights)) * int(line[INTERVAL]) / 1000
    return Series(time=time, altitude=np.array(heights) * FOOT), notes


def _height(text: str) -> float:
    """A sample, nan if it is invalid. [ft]"""
    match = SAMPLE.fullmatch(text.rstrip("\r"))
    if not match:
        return np.nan
    return float(text) if match[1] in "0123456789" else float(match[2]) * (-1 if match[1] == "-" else 1)


PARSER = Parser("PerfectFlite MAWD", recognises, read, signs=("PerfectFlite", "miniAlt/WD"))
