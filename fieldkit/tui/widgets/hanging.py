"""Wrapped lines with a hanging indent, so that text stays in its column."""

import re
from collections.abc import Iterable
from dataclasses import dataclass, field

from textual.content import Content
from textual.css.styles import RulesMap
from textual.strip import Strip
from textual.style import Style
from textual.visual import RenderOptions, Visual

from fieldkit.safe_text import printable
from fieldkit.tui.widgets.states import STATES

MIN_LINE_WIDTH = 20
"""Minimum width of a wrapped line; below it the indent is only two. [cell]"""
MARKS = {symbol: f"b ${color}" for symbol, color in STATES.items()}
"""Colors of the marks of a verdict at the start of a line."""
NAME = re.compile(r"  (?=[a-z1]).{9} (?=\S)| {12}(?=\S)")
"""The name before a value in a line of an answer, or the spaces below it."""
LEAD = re.compile(r"\s*(?:\S+ )*\S+ {2,}(?=\S)|\s*(?=\S)")
"""The prefix of a line: a name and the spaces after it, or spaces."""


@dataclass(frozen=True)
class Hanging(Visual):
    """Lines, each with the column at which it continues if it is wrapped."""

    lines: tuple[tuple[int, Content], ...] = ()
    _broken: dict[int, Content] = field(default_factory=dict, compare=False, repr=False)

    def __str__(self) -> str:
        """As text, each line unbroken."""
        return "\n".join(line.plain for _, line in self.lines)

    def render_strips(self, width: int, height: int | None, style: Style, options: RenderOptions) -> list[Strip]:
        """The lines in a width."""
        return self._within(width).render_strips(width, height, style, options)

    def get_optimal_width(self, rules: RulesMap, container_width: int) -> int:
        """The width of the longest line."""
        return max((line.cell_length for _, line in self.lines), default=0)

    def get_height(self, rules: RulesMap, width: int) -> int:
        """The number of lines at a width."""
        return self._within(width).get_height(rules, width)

    def _within(self, width: int) -> Content:
        """The lines wrapped to a width, cached because they are measured and drawn."""
        if width not in self._broken:
            parts = (part for column, line in self.lines for part in _broken(line, width, column))
            self._broken[width] = Content("\n").join(parts)
        return self._broken[width]


def hanging(text: Iterable[str]) -> Hanging:
    """Lines of text; a wrapped line continues below its text after a name or spaces, else two cells to the right."""
    return Hanging(tuple((_column(line), marked(line)) for line in map(printable, text)))


def marked(line: str) -> Content:
    """A line of text, the mark of a verdict at its start in its color, and bars in theirs."""
    style = MARKS.get(line[:1]) if line[1:2] == " " else None
    bar = line.find("█")
    text = Content(line).stylize("$primary", bar) if bar >= 0 else Content(line)
    return text.stylize(style, 0, 1) if style else text


def answered(text: Iterable[str]) -> Hanging:
    """The lines of an answer, wrapped in the same way: a heading, and values that stand out from their names."""
    first, *rest = [printable(line) for line in text] or [""]
    lines = [(_column(first), Content(first).stylize("b $primary"))]
    return Hanging((*lines, *((_column(line), _named(line)) for line in rest)))


def _named(line: str) -> Content:
    name = NAME.match(line)
    if name is None:
        return marked(line)
    return Content(line).stylize("$text-muted", 0, name.end()).stylize("b", name.end())


def stacked(blocks: Iterable[Hanging]) -> Hanging:
    """Blocks below each other, an empty line between two."""
    lines: list[tuple[int, Content]] = []
    for block in blocks:
        lines += [(0, Content())] if lines else []
        lines += block.lines
    return Hanging(tuple(lines))


def _column(line: str) -> int:
    lead = LEAD.match(line)
    start = len(lead[0]) if lead else 0
    return start or 2


def _broken(line: Content, width: int, column: int) -> list[Content]:
    """A line if it fits, or its parts below each other, indented to a column."""
    if line.cell_length <= width:
        return [line]
    first, *more = line.wrap(width)
    if not more:
        return [line]
    column = column if width - column >= MIN_LINE_WIDTH else 2
    word = line.plain[column:].partition(" ")[0]
    if len(first.plain) <= column and len(word) > width - column:  # a path or an address that no line holds
        first = line[: line.plain.rfind("/", column + 1, width) + 1 or width]
    rest = line[len(first.plain) :]
    rest = rest[len(rest.plain) - len(rest.plain.lstrip()) :]
    return [first, *(part.pad_left(column) for part in rest.wrap(max(1, width - column)))]
