"""Shared by commands that print: tables, JSON, and sanitized text."""

import json
import os
import re
import sys
from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager, suppress
from shutil import get_terminal_size
from textwrap import wrap
from typing import TYPE_CHECKING, Annotated

import typer

from fieldkit import units
from fieldkit.errors import shortened
from fieldkit.flight import BY_NAME, COLUMNS
from fieldkit.presentation.json_values import finite
from fieldkit.progress import ReportProgress, no_op
from fieldkit.quantities import in_system, measure, unit_of, with_sd, with_unit
from fieldkit.safe_text import printable
from fieldkit.settings import read_settings

if TYPE_CHECKING:
    from fieldkit.flight import Flight

AsJson = Annotated[bool, typer.Option("--json", help="Print JSON.")]
"""The option of every command that prints a document."""


def say(text: str = "") -> None:
    """Print one line of a result."""
    sys.stdout.write(printable(text) + "\n")


def say_lines(text: str) -> None:
    """Print a text of several lines."""
    sys.stdout.write("".join(printable(line) + "\n" for line in text.splitlines()))


def say_wrapped(text: str, hanging: str = "") -> None:
    """Print one line of a result, wrapped to the terminal, later lines indented by `hanging`."""
    for line in _wrapped(text, min(get_terminal_size().columns, 100), hanging):
        say(line)


def _wrapped(text: str, width: int, hanging: str = "") -> list[str]:
    """Lines of at most `width` characters [1], broken only at spaces: a name such as F24-4W and a path stay whole."""
    start = text[: len(text) - len(text.lstrip())]
    return wrap(
        text.strip(),
        width,
        initial_indent=start,
        subsequent_indent=start + hanging,
        break_long_words=False,
        break_on_hyphens=False,
    )


def say_report(lines: Iterable[str]) -> None:
    """Print lines of a report; overflow is wrapped below the last column."""
    for line in lines:
        columns = list(re.finditer(r"\s{3,}", line.strip()))
        say_wrapped(line, " " * (columns[-1].end() if columns else 2)) if line else say()


def complain(text: str) -> None:
    """Print a message of one or a few lines, shortened, on stderr, apart from results; one that cannot be written is
    dropped.

    On a terminal its lines are wrapped; a program that reads them gets each whole.
    """
    lines = [shortened(printable(line)) for line in text.splitlines()]
    with suppress(OSError):  # not a terminal, or one without a size
        if sys.stderr.isatty() and (width := os.get_terminal_size(sys.stderr.fileno()).columns):
            lines = [part for line in lines for part in _wrapped(line, width) or [""]]
    with suppress(OSError):
        sys.stderr.write("".join(line + "\n" for line in lines))


def remark(text: str) -> None:
    """Print a note about the data on stderr, with its lengths and speeds in the user's units."""
    complain(f"note: {in_system(text, system())}")


def print_json(document: Mapping[str, object]) -> None:
    """Print one JSON document, null for numbers that are not finite, in characters that every terminal and pipe
    accepts."""
    sys.stdout.write(json.dumps(finite(document), indent=2, allow_nan=False) + "\n")


def print_table(headers: Sequence[str], rows: Iterable[Sequence[str]], numbers: Sequence[str] = ()) -> None:
    """Print a table fitted to the terminal's width, or to 80 columns if there is none; columns in `numbers` are
    right-aligned, and their cells are cut instead of wrapped."""
    from rich.console import Console
    from rich.table import Table
    from rich.text import Text

    table = Table(box=None, pad_edge=False, header_style="bold")
    for header in headers:
        right = header in numbers
        table.add_column(
            Text(printable(header)), justify="right" if right else "left", no_wrap=right, overflow="ellipsis"
        )
    for row in rows:
        table.add_row(*(Text(printable(cell)) for cell in row))
    Console(highlight=False).print(table)


def print_card(flight: "Flight", id: str) -> None:
    """Print everything known about a flight, one line each, in the user's units."""
    from fieldkit.importing.manual_entry import answer_text
    from fieldkit.presentation import logged

    chosen = system()

    texts = ("rocket", "config", "motor", "date_time", "site", "tags")
    lines = [
        ("Flight", id),
        *((name.replace("_", " ").capitalize(), answer_text(flight, name)) for name in texts),
    ]
    for column in COLUMNS:
        number = flight.number(column.name)
        unit = unit_of(column, chosen, number or 0.0)
        scale = units.unit(column.quantity, unit)
        sd = scale.difference_from_si(flight.sd.get(column.name, 0.0))
        lines.append((column.title, "" if number is None else with_unit(with_sd(scale.from_si(number), sd), unit)))
    lines += [("Notes", flight.notes), ("Log", flight.log), *logged.beside(flight.extra, chosen)]
    known = [(title, value) for title, value in lines if value]
    width = max(len(title) for title, _ in known)
    for title, value in known:
        say(f"{title:{width}}  {value}")


def system() -> str:
    """The user's system of units."""
    return read_settings().units


def measured(name: str, value: float | None) -> str:
    """A value of a column [SI] in the user's units: `281.3 m` or `923 ft`."""
    return measure(BY_NAME[name], value, system())


@contextmanager
def progress(title: str) -> Iterator[ReportProgress]:
    """A progress bar on stderr if that is a terminal; the callback takes the current step and the fraction done.

    It is drawn only when progress is reported.
    """
    if not sys.stderr.isatty():
        yield no_op
        return
    from rich.console import Console
    from rich.markup import escape
    from rich.progress import Progress

    with Progress(console=Console(stderr=True), transient=True, auto_refresh=False) as bar:
        task = bar.add_task(escape(title), total=1.0)
        yield lambda text, fraction: bar.update(
            task, description=escape(f"{title}: {printable(text)}"), completed=fraction, refresh=True
        )
