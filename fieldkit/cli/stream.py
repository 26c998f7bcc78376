"""Tables and JSON documents printed while they are read: the first rows appear before the last ones are read."""

import json
import sys
from collections.abc import Iterable, Iterator, Mapping, Sequence
from itertools import repeat
from shutil import get_terminal_size

from fieldkit.safe_text import printable

GAP = "  "
"""The gap between two columns."""
MIN_COLUMN_WIDTH = 5
"""Minimum width of a column if the terminal is too narrow. [cell]"""
CUT_MARK = "…"
"""The end of a text that was cut."""


def stream_table(headers: Sequence[str], pages: Iterable[Sequence[Sequence[str]]], numbers: Sequence[str] = ()) -> None:
    """Print a table page by page. A column is as wide as its widest text so far; it can widen but never narrows. If a
    line does not fit, the widest columns of text are cut. Columns in `numbers` are right-aligned and never cut."""
    room = get_terminal_size().columns  # 80 without a terminal
    right = [header in numbers for header in headers]
    head = [[printable(header)] for header in headers]
    wanted = [cells(title) for (title,) in head]
    for page in pages:
        columns = [_harmless(column) for column in zip(*page, strict=True)]
        wanted = [max(width, _widest(column)) for width, column in zip(wanted, columns, strict=True)]
        widths = _fitted(wanted, right, room)
        both = [[*titles, *column] for titles, column in zip(head, columns, strict=True)]
        sys.stdout.write(_lines(both, widths, right))
        sys.stdout.flush()
        head = [[] for _ in headers]


def _harmless(column: Sequence[str]) -> Sequence[str]:
    return column if "".join(column).isprintable() else [printable(cell) for cell in column]


def _widest(column: Sequence[str]) -> int:
    return max(map(len if "".join(column).isascii() else cells, column))


def _fitted(wanted: Sequence[int], right: Sequence[bool], room: int) -> list[int]:
    widths = list(wanted)
    texts = [place for place, number in enumerate(right) if not number]
    while sum(widths) + len(GAP) * (len(widths) - 1) > room:
        widest = max(texts, key=lambda place: widths[place])
        if widths[widest] <= MIN_COLUMN_WIDTH:
            break
        widths[widest] -= 1
    return widths


def _lines(columns: Sequence[Sequence[str]], widths: Sequence[int], right: Sequence[bool]) -> str:
    filled = (_filled(*column) for column in zip(columns, widths, right, strict=True))
    return "".join(GAP.join(row).rstrip() + "\n" for row in zip(*filled, strict=True))


def _filled(column: Sequence[str], width: int, right: bool) -> Iterator[str]:
    """The cells of a column, padded to its width."""
    if "".join(column).isascii() and max(map(len, column)) <= width:
        return map(str.rjust if right else str.ljust, column, repeat(width))
    return (_cell(text, width, right) for text in column)


def _cell(text: str, width: int, right: bool) -> str:
    room = width - cells(text)
    if room < 0:
        text = _cut(text, width)
        room = width - cells(text)
    return " " * room + text if right else text + " " * room


def _cut(text: str, width: int) -> str:
    while cells(text) > width - 1:
        text = text[:-1]
    return text + CUT_MARK


def cells(text: str) -> int:
    """Width of a text in a terminal. [cell]"""
    if text.isascii():
        return len(text)
    from rich.cells import cell_len

    return cell_len(text)


def stream_json(name: str, documents: Iterable[Mapping[str, object]]) -> None:
    """Print one JSON document of a list of flat ones under a name, as `json.dumps` with an indent of two writes it."""
    first = True
    for document in documents:
        sys.stdout.write((f'{{\n  "{name}": [\n' if first else ",\n") + _flat(document))
        first = False
    sys.stdout.write(f'{{\n  "{name}": []\n}}\n' if first else "\n  ]\n}\n")


def _flat(document: Mapping[str, object]) -> str:
    """One flat document; with line breaks as separators, json uses its fast encoder."""
    text = json.dumps(document, separators=(",\n      ", ": "), allow_nan=False)
    return f"    {{\n      {text[1:-1]}\n    }}"
