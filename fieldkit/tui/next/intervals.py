"""Intervals below each other on one scale, as wide as their widget: `├──●──┤`, with marks."""

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from math import isfinite

from rich.cells import cell_len, set_cell_size
from textual.content import Content
from textual.css.styles import RulesMap
from textual.strip import Strip
from textual.style import Style
from textual.visual import RenderOptions, Visual

from fieldkit.flight import BY_NAME
from fieldkit.quantities import number, spelled, unit_of
from fieldkit.safe_text import printable
from fieldkit.tui.widgets.states import runs

FLOWN_MARK = "◆"
"""The mark of a flight's result, which is neither an error (✗) nor unsafe."""
TARGET = "◎"
"""The mark of a target."""
FAR_OUT = 3.0
"""Interquartile ranges beyond the quartiles from which a value is far out (J. W. Tukey, Exploratory Data Analysis,
1977). [1]"""
Bounds = tuple[float, float, float]
"""A forecast: the 5%, the median and the 95%. [m]"""


@dataclass(frozen=True, slots=True)
class IntervalBar:
    """A line: its name, the 5%, median and 95%, and the result, if known."""

    name: str
    low: float
    middle: float
    high: float
    flown: float | None = None

    @property
    def ends(self) -> tuple[float, float]:
        """The minimum and maximum of all marked values that are finite; zero without any."""
        marked = [self.low, self.high] + ([self.flown] if self.flown is not None else [])
        known = [value for value in marked if isfinite(value)]
        return min(known, default=0.0), max(known, default=0.0)


@dataclass(frozen=True)
class Intervals(Visual):
    """A title, lines of intervals and the scale below them; `spelled` formats a value, and `marks` are common values by
    their names."""

    rows: tuple[IntervalBar, ...]
    spelled: Callable[[float], str]
    marks: Mapping[str, float]
    title: str = ""

    def render_strips(self, width: int, height: int | None, style: Style, options: RenderOptions) -> list[Strip]:
        """The lines in a width."""
        return self._within(width).render_strips(width, height, style, options)

    def get_optimal_width(self, rules: RulesMap, container_width: int) -> int:
        """The whole available width."""
        return container_width

    def get_height(self, rules: RulesMap, width: int) -> int:
        """One line each, and the scale; the title may have several lines."""
        return self._within(width).get_height(rules, width)

    def __str__(self) -> str:
        """As text, in a usual width."""
        return self._within(76).plain

    def _within(self, width: int) -> Content:
        names = [printable(row.name) for row in self.rows]
        lead = min(max(map(cell_len, names), default=0), width // 3)
        room = max(10, width - lead - 3)
        ends = [end for row in self.rows for end in row.ends] + list(self.marks.values())
        start, end = min(ends, default=0.0), max(ends, default=1.0)
        parts: list[str | tuple[str, str]] = [(f"{self.title}\n" * bool(self.title), "b $primary")]
        for name, row in zip(names, self.rows, strict=True):
            line = bar(row, start, end, room, tuple(self.marks.values()))
            colored = ((text, f"${color}" if color else "") for text, color in runs(line))
            parts += [f"{set_cell_size(name, lead)}  ", *colored, "\n"]
        return Content.assemble(*parts, f"{'':{lead}}  {self._scale(start, end, room)}")

    def _scale(self, start: float, end: float, room: int) -> str:
        """The first and the last value, and each mark that has room between them."""
        line = f"{self.spelled(start):{room}}"
        last = self.spelled(end)
        line = line[: room - len(last)] + last
        for name, value in self.marks.items():
            text = f"{name} {self.spelled(value)}"
            at = min(max(0, _cell(value, start, end, room) - len(text) // 2), room - len(text))
            if not line[max(0, at - 1) : at + len(text) + 1].strip():
                line = line[:at] + text + line[at + len(text) :]
        return line


def bar(row: IntervalBar, start: float, end: float, width: int, marks: tuple[float, ...] = ()) -> str:
    """An interval on a scale from `start` to `end`, `width` cells wide: `├──●──┤`, with `◎` at the marks (`◉` on the
    median) and `◆` at the result; an arrow points to an end of the interval beyond the scale. Blank if a value of the
    interval is not finite: no flight of some draws."""
    line = [" "] * width
    if not all(map(isfinite, (row.low, row.middle, row.high, start, end))):
        return "".join(line)
    low, middle, high = (_cell(value, start, end, width) for value in (row.low, row.middle, row.high))
    line[low : high + 1] = "─" * (high - low + 1)
    line[low] = "├" if row.low >= start else "←"
    line[high] = "┤" if row.high <= end else "→"
    if start <= row.middle <= end:
        line[middle] = "●"
    for mark in marks:
        if start <= mark <= end:
            at = _cell(mark, start, end, width)
            line[at] = TARGET if line[at] != "●" else "◉"
    if row.flown is not None and isfinite(row.flown):
        line[_cell(row.flown, start, end, width)] = _flown_sign(row.flown, start, end)
    return "".join(line)


def _flown_sign(flown: float, start: float, end: float) -> str:
    """The mark of a result on a scale, or an arrow to one beyond it."""
    return FLOWN_MARK if start <= flown <= end else "←" if flown < start else "→"


@dataclass(frozen=True, slots=True)
class HeightScale:
    """The common scale of a column of forecasts and flown apogees, with the target if there is one. [m]"""

    low: float
    high: float
    target: float | None = None

    @classmethod
    def of(cls, shown: Iterable[tuple[Bounds | None, float | None]], target: float | None) -> "HeightScale":
        """A scale that holds these, each an interval and a flown apogee, and the target, unless a few are so far from
        the others that they would leave no room for them (`_near`)."""
        ends = [end for bounds, flown in shown for end in (*(bounds or ()), flown) if end is not None and isfinite(end)]
        ends = _near(sorted(ends)) + ([target] if target and ends else [])
        return cls(min(ends, default=0.0), max(ends, default=1.0), target)

    def line(self, bounds: Bounds | None, flown: float | None, width: int) -> str:
        """A forecast, a flown apogee, or both; empty if neither is known."""
        marks = (self.target,) if self.target else ()
        if bounds is not None:
            return bar(IntervalBar("", *bounds, flown), self.low, self.high, width, marks)
        if flown is None or not isfinite(flown):
            return ""
        line = [" "] * width
        for value, sign in (*((mark, TARGET) for mark in marks), (flown, _flown_sign(flown, self.low, self.high))):
            line[_cell(value, self.low, self.high, width)] = sign
        return "".join(line)


def _near(ends: list[float]) -> list[float]:
    """Those of some values in order that are within `FAR_OUT` interquartile ranges of the middle half."""
    if not ends:
        return ends
    low, high = ends[len(ends) // 4], ends[3 * len(ends) // 4]
    room = FAR_OUT * (high - low) or max(ends) - min(ends)
    return [end for end in ends if low - room <= end <= high + room]


def heading(width: int, scale: HeightScale, system: str) -> str:
    """The heading of a column of forecasts and flown apogees in a width [cell], with a target if there is one, and with
    the ends of the scale if there is room."""
    aim, sign = (f", target {TARGET}", f" {TARGET}") if scale.target else ("", "")
    long = f"forecast, flown {FLOWN_MARK}{aim}"
    low, high = (number(BY_NAME["apogee"], end, system) for end in (scale.low, scale.high))
    unit = spelled(unit_of(BY_NAME["apogee"], system))
    low, last = f"{low} {unit}", f"{high} {unit}"
    if scale.low < scale.high != 1.0 and len(low) + len(long) + len(last) + 4 <= width:
        return f"{low}{long:^{width - len(low) - len(last)}}{last}"
    return long if len(long) <= width else f"forecast {FLOWN_MARK}{sign}"


def _cell(value: float, start: float, end: float, width: int) -> int:
    return min(width - 1, max(0, round((value - start) / ((end - start) or 1.0) * (width - 1))))
