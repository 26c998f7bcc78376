"""Records for reading logs: what a parser returns, and the result for a file."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Literal

from fieldkit.errors import DamagedLog
from fieldkit.flight import Flight, Series

if TYPE_CHECKING:
    from fieldkit.analysis import Recorded
    from fieldkit.importing.tables.columns_read import ColumnRead

NO_EVENTS: Mapping[str, float] = {}
"""The same for all readings, as a table may have 100,000."""
HEAD = 65_536
"""Size of the beginning of a log that parsers use to recognize it. [bytes]"""
MOST_FLIGHTS = 100
"""Largest number of flights with samples that are read from one log: measuring one takes 0.2 s. A parser may return
more. [1]"""


@dataclass(frozen=True, slots=True)
class Reading:
    """One flight as a log states it, or one rocket of a list of rockets.

    `stated` maps fields of `Flight` to their values, numbers in SI, and `columns` maps the same fields to the log's
    names for them (for messages). `extra` are further columns of the flight, as text. `rocket_key` is the log's own
    name of the rocket, which links it to a list of rockets read together with it. `series` contains the samples if
    there are any, a `Series` for each clock of the log. `events` maps what the logger itself marked, named as in
    `EVENTS` if possible, to seconds on the first of these clocks. A simulation can be compared with a flight and is
    never stored in the ledger. `part` is the kind of file, if a logger writes several for one flight; their clocks then
    share one zero, and those read together become one reading. `liftoff_mass` is the mass of the rocket with its motor
    [kg], if no dry mass is stated. `recorded` is what was measured from the samples, once that is done.
    """

    stated: Mapping[str, object] = field(default_factory=dict)
    extra: Mapping[str, str] = field(default_factory=dict)
    columns: Mapping[str, str] = field(default_factory=dict)
    row: int | None = None
    describes: Literal["flight", "rocket", "simulation"] = "flight"
    rocket_key: str = ""
    series: Series | tuple[Series, ...] = ()
    events: Mapping[str, float] = field(default_factory=lambda: NO_EVENTS)
    device: str = ""
    firmware: str = ""
    serial: str = ""
    part: str = ""
    liftoff_mass: float | None = None
    recorded: "Recorded | None" = field(default=None, compare=False)

    @property
    def clocks(self) -> tuple[Series, ...]:
        """The samples, a `Series` for each clock of the log."""
        return (self.series,) if isinstance(self.series, Series) else self.series


EVENTS = ("liftoff", "burnout", "apogee", "ejection", "drogue", "main", "landing")
"""Events that most loggers mark; `drogue` and `main` are outputs of a logger, `ejection` is the motor's own charge."""


@dataclass(frozen=True, slots=True)
class Note:
    """A note for the user about a log that does not prevent its import."""

    text: str
    row: int | None = None


EXCLUDE = "exclude"
"""What a choice says instead of a channel for a column that is not to be used; it may do so more than once."""


def is_exclusion(channel: str) -> bool:
    """Whether a choice excludes a column rather than naming its channel: `exclude`, `exclude 2`."""
    return channel.partition(" ")[0] == EXCLUDE


@dataclass(frozen=True, slots=True)
class ColumnChoice:
    """Channel to column, as the user wrote them, and the headers they apply to; without headers, any table.

    Columns that are not to be used have the channels `exclude`, `exclude 2`.
    """

    channels: Mapping[str, str]
    headers: tuple[str, ...] = ()


@dataclass(frozen=True, slots=True)
class Mapped(Note):
    """How the columns of a table were interpreted: displayed to the flyer, and remembered if the flyer chose it."""

    choice: ColumnChoice = ColumnChoice({})
    chosen: bool = False


Parsed = Reading | DamagedLog | Note
"""The result of a parser: readings, damaged rows (only those rows are lost), and notes."""


@dataclass(frozen=True, slots=True)
class Parser:
    """One logger or table format.

    `recognises` receives the first `HEAD` bytes; raising DamagedLog there means no. `read` receives the whole log, and
    raises DamagedLog when none of it can be used. A `fallback` is not specific to a logger: it is tried only for a log
    that no other parser recognizes. `mapped` is `read` with the flyer's choices of columns, best first, for formats
    that need one. `signs` are texts that the beginning of such a file contains, with alternative spellings separated by
    `|`. If several parsers recognize a log, the one whose signs are present is tried first, and the error for an
    unknown file names the missing ones. `simulates` means that its files are simulations; `maps` is what the columns of
    `mapped` describe.
    """

    title: str
    recognises: Callable[[bytes], bool]
    read: Callable[[bytes], Sequence[Parsed]]
    fallback: bool = False
    mapped: Callable[[bytes, Sequence[ColumnChoice]], Sequence[Parsed]] | None = None
    signs: tuple[str, ...] = ()
    simulates: bool = False
    maps: Literal["samples", "flights"] = "samples"


@dataclass(frozen=True, slots=True)
class Rejected:
    """A row that did not become a flight, and the reason."""

    file: str
    row: int | None
    column: str | None
    error: str


@dataclass(frozen=True, slots=True)
class Recognition:
    """How a file was read: the parser and why it was chosen, the columns used, rows used and rows dropped as
    damaged."""

    title: str = ""
    why: str = ""
    columns: "tuple[ColumnRead, ...]" = ()
    rows: int = 0
    dropped: int = 0


@dataclass(frozen=True, slots=True)
class ImportedFile:
    """The result of one file: flights and their rows, rejected rows, and notes.

    `recorded` contains the measurements from the samples of each flight, None for a flight without samples.
    """

    source: str
    format: str
    flights: tuple[Flight, ...]
    rejected: tuple[Rejected, ...]
    notes: tuple[str, ...]
    rows: tuple[int | None, ...]
    mapped: tuple[Mapped, ...] = ()
    recorded: "tuple[Recorded | None, ...]" = field(default=(), compare=False)
    recognition: Recognition = Recognition()
    simulated: "tuple[Recorded, ...]" = field(default=(), compare=False)
    """The values of each simulation in the file."""
