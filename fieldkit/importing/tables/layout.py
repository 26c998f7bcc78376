"""Find the table in a text, and its separator, for undocumented tables.

Lines of text may come first (a block of settings, the name of the flight), then one line of names, optionally one of
units, and rows of numbers. The header may be marked as a comment, or missing.
"""

import codecs
import csv
import re
from collections import Counter
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from itertools import pairwise

from fieldkit.errors import DamagedLog
from fieldkit.importing.tables.cell import ABSENT_MARKS, is_grouped
from fieldkit.importing.tables.headings import channel, heading, unit_named
from fieldkit.importing.tables.text import encoding_of
from fieldkit.safe_text import whole_number
from fieldkit.units import UNITS, is_unit, plain

LOOKED_AT = 400
"""Number of lines among which the first rows of numbers must be. [1]"""
_MOST_ABOVE = 4
"""Number of lines above a table among which its names must be: a logger may write messages below them. [1]"""
_CLOCK_ROWS, _LEAST_CLOCK_STEPS, _EVEN_FRACTION = 100, 8, 0.8
"""Number of rows whose times are compared, least number of steps, and fraction of them within a factor of two. [1]"""
_NUMBER = re.compile(r"\s*[+-]?(\d+(?:[.,]\d*)?|[.,]\d+)([eE][+-]?\d+)?\s*|\s*nan\s*", re.I)
_CLOCK = re.compile(r"\d:\d\d")
_WITH_UNIT = re.compile(r"\s*[+-]?\d+(?:[.,]\d*)?\s*([A-Za-z°%][A-Za-z°%/²]{0,4})\s*")
"""A number with its unit in the cell, such as `57.6F` or `12.3 m/s`."""
_ABSENT_MARKS = ABSENT_MARKS | {"inf", "-inf", "true", "false"}
_WORDS_FOR_MISSING = frozenset(word for word in (*ABSENT_MARKS, "inf", "-inf") if any(map(str.isalpha, word)))
_MARK = re.compile(r"^\s*(#|%|//|;|!|\*)+\s*")
_DECIMALS = {mark: re.compile(rf"\s*[+-]?\d*[{mark}]\d+([eE][+-]?\d+)?\s*") for mark in ",."}
_THOUSANDS = re.compile(r"\s*[+-]?[1-9]\d{0,2}[,.]\d{3}\s*")
_SPACED = re.compile(r"(?<=\d)[ \u00a0\u2009\u202f'\u2019](?=\d)")
"""A mark between thousands that is no decimal mark."""
_OF_SAMPLES = re.compile(r"sampl|rate|interval|period|frequen|frequenz|fréquen|frecuen|abtast|échantill|@", re.I)
_OF_A_FILTER = re.compile(r"filter|cut.?off|low.?pass|baud|gps|gyro", re.I)
_RATE = re.compile(r"(\d{1,5}(?:\.\d{1,6})?)\s?(?:Hz\b|(?:samples? ?)?(?:/ ?s|per second)\b)", re.I)
_STEP = re.compile(
    r"(?:interval|period|step|intervall)\b\D{0,20}?(\d{1,6}(?:[.,]\d{1,6})?)\s?(ms|us|µs|s|sec|seconds)\b", re.I
)
"""Words of a line about how often samples are taken, words of one about something else, and the number in it."""
_LEAST_CELLS = 3
"""Fewest numbers of a column with and without a mark that show that it separates thousands. [1]"""
_UNITS = re.compile(r"[\[({]?[A-Za-zµμ°%]{0,8}([/^*²·\s-]?[A-Za-z0-9²-]{1,4}){0,4}[\])}]?")


@dataclass(frozen=True, slots=True)
class Layout:
    """A table's column names, the number of rows above its first numbers, and the format of its cells.

    `headers` are `#1`, `#2`, ... if there are none, and `named` is then False. `separator` None is whitespace; `first`
    are cells of the first row of numbers. `interval` is the time between rows that the text above states, 0 if it
    states none [s].
    """

    headers: tuple[str, ...]
    above: int
    separator: str | None
    decimal: str
    named: bool
    first: tuple[str, ...]
    interval: float = 0.0

    @property
    def saved_names(self) -> tuple[str, ...]:
        """What a saved mapping remembers the table by: its names; without names, the number and form of each column in
        its first row, such as `#1 0.00`, because the logger writes all its tables in the same form."""
        forms = zip(self.headers, map(_form, self.first), strict=False)
        return self.headers if self.named else tuple(f"{number} {form}" for number, form in forms)

    @property
    def splits_decimals(self) -> bool:
        """Whether commas separate both cells and decimals: a row has more cells than the header, all of them digits."""
        unnamed = sum(name.startswith("#") for name in self.headers)
        digits = all(re.fullmatch(r"[+-]?\d+", cell) for cell in self.first)
        return self.named and self.separator == "," and unnamed > 0 and digits

    def says(self, place: int) -> bool:
        """Whether the first row has a word rather than a number in this column."""
        cell = self.first[place] if place < len(self.first) else ""
        return cell.lower() not in _ABSENT_MARKS and not _is_number(cell) and not self.suffix(place)

    def suffix(self, place: int) -> str:
        """The unit after the number in the cells of a column, if the cell in the first row has one; otherwise ""."""
        match = _WITH_UNIT.fullmatch(self.first[place]) if place < len(self.first) else None
        return match[1] if match and match[1].isascii() and is_unit(match[1]) else ""


def _form(cell: str) -> str:
    """A number with each of its digits after the decimal mark as 0, and those before it as one."""
    if not _NUMBER.fullmatch(cell):
        return "text"
    return re.sub(r"\d", "0", re.sub(r"^[+-]?\d*", "0", cell))


def _is_number(cell: str) -> bool:
    """Whether a cell is a number, also with separated thousands, or a time of day."""
    spelled = cell.strip()
    grouped = is_grouped(spelled) or is_grouped(spelled.replace(",", "."))
    return bool(_NUMBER.fullmatch(cell) or _CLOCK.search(cell) or grouped)


def split(line: str, separator: str | None) -> list[str]:
    """The cells of a line; quoted cells may contain the separator."""
    if '"' in line:
        try:
            row = line.strip() if separator is None else line
            return next(csv.reader([row], delimiter=separator or " ", skipinitialspace=separator is None), [])
        except csv.Error:
            pass
    return line.split(separator)


def layout_of(head: bytes) -> Layout:
    """The layout of the table at the beginning of a log. Raises DamagedLog if there is none."""
    encoding = encoding_of(head[:2])
    try:
        text = codecs.getincrementaldecoder(encoding)().decode(head)
    except UnicodeDecodeError:
        text = head.decode("cp1252" if encoding == "utf-8" else encoding, "replace")
    return table_in(text if "\n" in text else text.replace("\r", "\n"))


def table_in(text: str) -> Layout:
    """The layout of the first table of numbers in a text. Raises DamagedLog if there is none."""
    lines = text.split("\n")[:LOOKED_AT]
    lines = [line.rstrip("\r").lstrip("\ufeff") for line in lines]
    for separator in ("\t", ";", ",", "|", None):
        start = _first_numbers(lines, separator)
        if start is not None:
            return _layout(lines, start, separator)
    raise DamagedLog("found no table of numbers, expected a line of names and rows of numbers below it")


def _first_numbers(lines: Sequence[str], separator: str | None) -> int | None:
    """Index of the first of three lines (or of fewer if there are no more) that are rows of numbers with the same count
    of cells; None if there are none."""
    rows = [split(line, separator) for line in lines]
    for start in range(len(rows)):
        if len(rows[start]) < 2 or not _numbers(rows[start], separator):
            continue
        filled = [cells for cells in rows[start : start + 7] if any(cell.strip() for cell in cells)][:3]
        if all(len(cells) == len(filled[0]) and _numbers(cells, separator) for cells in filled):
            return start
    return None


def _numbers(cells: Sequence[str], separator: str | None) -> bool:
    """Whether most cells are numbers, and the others single words or numbers with a unit.

    A sensor that starts late writes `nan` or another word for a missing number at first: beside a number it counts as
    one.
    """
    absent = _ABSENT_MARKS - {"nan"}
    values = [c for c in cells if c.strip().lower() not in absent]
    count = sum(_is_number(cell) or _WITH_UNIT.fullmatch(cell) is not None for cell in values)
    missing = sum(c.strip().lower() in _WORDS_FOR_MISSING - {"nan"} for c in cells) if count else 0
    most = count + missing >= 2 and (count + missing) * 2 > len(values) + missing
    return most and not (separator is None and any("," in cell for cell in cells))


def _layout(lines: Sequence[str], start: int, separator: str | None) -> Layout:
    """The layout of the table whose numbers start at a line."""
    width = len(split(lines[start], separator))
    above = [row for row in range(start - 1, -1, -1) if lines[row].strip()][:_MOST_ABOVE]
    names = [_names(lines[row], separator, width) for row in above]
    whole = (i for i, found in enumerate(names) if found and (not i or not found[-1].startswith("#")))
    place = next(whole, 0)
    headers, higher = [*names, None, None][place : place + 2]
    if headers and higher and _are_units(headers, higher):
        pairs = zip(higher, headers, strict=True)
        headers = [f"{name} ({unit.strip('[](){}')})" if unit else name for name, unit in pairs]
    rows = [split(line, separator) for line in lines[start:]]
    if headers and headers[-1] == f"#{width}" and _are_numbered(rows, headers):
        headers = ["#1", *headers[:-1]]
    decimal = decimal_mark(rows)
    first = tuple(cell.strip() for cell in rows[0])
    if headers is None:
        return Layout(tuple(f"#{i}" for i in range(1, width + 1)), start, separator, decimal, False, first)
    return Layout(tuple(headers), start, separator, decimal, True, first, _interval(lines[:start]))


def _are_numbered(rows: Sequence[Sequence[str]], names: Sequence[str]) -> bool:
    """Whether the first cell of each row is its number, for which the header has no name, as in tables of statistics
    programs: then the clock is one column further right."""
    whole = [row for row in rows if len(row) == len(names)]
    clock = next((place for place, name in enumerate(names) if channel(heading(name)) == "time"), None)
    if clock is None or clock + 1 >= len(names) or len(whole) < _LEAST_CLOCK_STEPS:
        return False
    numbers = [number for row in whole if (number := whole_number(row[0].strip())) is not None]
    if len(numbers) < len(whole) or not all(row[-1].strip() for row in whole):
        return False
    times = [row[clock + 1].strip().replace(",", ".") for row in whole]
    rise = [float(time) for time in times if re.fullmatch(r"[+-]?\d+(\.\d+)?", time)]
    counts = all(after - before == 1 for before, after in pairwise(numbers))
    return counts and len(rise) == len(whole) and all(before < after for before, after in pairwise(rise))


def _interval(lines: Sequence[str]) -> float:
    """The time between rows that lines above a table state, as a rate or an interval of samples; 0 if they state none,
    or two. [s]"""
    found = set()
    for line in lines:
        if not _OF_SAMPLES.search(line) or _OF_A_FILTER.search(line):
            continue
        rate, step = _RATE.search(line), _STEP.search(line)
        if rate and float(rate[1]) > 0:
            found.add(1 / float(rate[1]))
        elif step and float(step[1].replace(",", ".")) > 0:
            found.add(float(step[1].replace(",", ".")) * UNITS["time"][plain(step[2])].factor)
    return found.pop() if len(found) == 1 else 0.0


def _are_units(cells: Sequence[str], names: Sequence[str]) -> bool:
    """Whether a line below a line of names contains their units, rather than names below a line of a preamble."""
    if not all(_UNITS.fullmatch(cell) for cell in cells):
        return False
    if any(channel(heading(cell)) and not is_unit(cell.strip("[](){}")) for cell in cells if cell):
        return False
    lower, upper = (sum(bool(channel(heading(cell))) for cell in line) for line in (cells, names))
    known = any(unit_named(quantity, cell.strip("[](){}")) for cell in cells for quantity in UNITS if cell)
    return upper >= lower and (upper > 0 or known)


def _names(line: str, separator: str | None, width: int) -> list[str] | None:
    """The names in the line above a table, if there is one for every cell; a comment mark is not part of them."""
    cells = [cell.strip() for cell in split(_MARK.sub("", line), separator)]
    if separator is None and len(cells) > width:  # names of several words
        cells = re.split(r"\t|\s{2,}", _MARK.sub("", line).strip())
    while len(cells) > width and not cells[-1]:
        cells.pop()
    words = sum(bool(re.search(r"[^\W\d]", cell)) for cell in cells)
    enough = words * 2 >= len(cells) or words == sum(map(bool, cells)) > 1  # a spreadsheet adds empty columns
    if len(cells) > width or len(cells) < 2 or not enough:
        return None
    return cells + [f"#{i}" for i in range(len(cells) + 1, width + 1)]


def decimal_mark(rows: Sequence[Sequence[str]]) -> str:
    """The decimal mark of a table from some of its rows: the one that more cells certainly have. Raises DamagedLog if
    `1,148` could be either number.
    """
    cells = [cell for row in rows for cell in row]
    cells = [_SPACED.sub("", cell) if is_grouped(cell.strip().replace(",", ".")) else cell for cell in cells]
    commas, points = ([cell for cell in cells if _DECIMALS[mark].fullmatch(cell)] for mark in ",.")
    certain = [sum(not _THOUSANDS.fullmatch(cell) for cell in numbers) for numbers in (commas, points)]
    if commas and not points and not certain[0] and not groups_thousands(rows, ","):
        found = f"found {commas[0].strip()!r}, which may be {commas[0].strip().replace(',', '')!r} or a decimal comma"
        raise DamagedLog(f"{found}, expected unambiguous numbers")
    return "," if certain[0] > certain[1] else "."


def groups_thousands(rows: Iterable[Sequence[str]], mark: str) -> bool:
    """Whether a mark with three digits behind it separates thousands: in a column with such numbers those without the
    mark have at most three digits. `%g` and spreadsheets write `1.5` and `1.04` among thousandths, `%.3f` writes no
    whole numbers among them."""
    grouped, single, long = (Counter[int]() for _ in range(3))
    for row in rows:
        for place, cell in enumerate(row):
            digits = cell.strip().lstrip("+-")
            counts = grouped if mark in digits else single if len(digits) <= 3 else long
            counts[place] += digits.replace(mark, "").isdecimal()
    return any(count >= _LEAST_CELLS <= single[place] and not long[place] for place, count in grouped.items())


def runs_like_a_log(head: bytes) -> bool:
    """Whether a table has a clock that increases in even steps from row to row, beside numbers: samples of one flight,
    whatever running totals are among its columns."""
    try:
        layout = layout_of(head)
    except DamagedLog:
        return False
    clocks = [place for place, name in enumerate(layout.headers) if channel(heading(name)) == "time"]
    return layout.named and bool(clocks) and is_even_clock(head, layout, clocks[0])


def is_even_clock(head: bytes, layout: Layout, place: int) -> bool:
    """Whether the numbers of a column at the beginning of a table increase in even steps from row to row."""
    return bool(clock_steps(head, layout, place))


def clock_steps(head: bytes, layout: Layout, place: int) -> list[float]:
    """The steps of a column at the beginning of a table if its numbers increase evenly from row to row, sorted and in
    its unit; empty if they do not."""
    text = head.decode(encoding_of(head[:2]), "replace").splitlines()
    lines = text[layout.above : layout.above + _CLOCK_ROWS]
    cells = [split(line, layout.separator) for line in lines if line.strip()][:-1]
    times = [row[place].replace(layout.decimal, ".") for row in cells if len(row) > place]
    plain = (re.fullmatch(r"\s*([+-]?\d+(?:\.\d+)?(?:[eE][+-]?\d{1,3})?)\s*", cell) for cell in times)
    numbers = [float(one[1]) for one in plain if one]
    steps = sorted(after - before for before, after in pairwise(numbers))
    if len(steps) < _LEAST_CLOCK_STEPS or steps[0] <= 0:
        return []
    middle = steps[len(steps) // 2]
    even = sum(middle / 2 <= step <= 2 * middle for step in steps)
    return steps if even > _EVEN_FRACTION * len(steps) else []
