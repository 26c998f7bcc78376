"""Reading files for an import: the results of parsers, with the original bytes and the logs that a table names."""

import os
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import partial
from pathlib import Path, PurePosixPath, PureWindowsPath

from fieldkit import files
from fieldkit.errors import BadValue, DamagedLog, FieldkitError, UnknownFormat
from fieldkit.flight import FIELDS, MEASURED, Flight
from fieldkit.importing import ColumnChoice, Mapped, Rejected
from fieldkit.importing.incoming import IncomingFlight, Original
from fieldkit.importing.read import OpenedFile, imported_files, open_file, read
from fieldkit.importing.tables.mapping import read_choice, remembered
from fieldkit.importing.to_flights import CheckMotor
from fieldkit.messages import marked, message
from fieldkit.parallel import processes
from fieldkit.paths import CAPTURE_SUFFIXES
from fieldkit.progress import ReportProgress, no_op
from fieldkit.services.imports.view import FileView, file_view
from fieldkit.services.imports.within_motor import within_motor

READOUT_FIELDS = ("sd", "source")
"""Fields of a flight that describe its readouts."""
_NOTHING_GIVEN: Mapping[str, object] = {}


@dataclass(frozen=True, slots=True)
class ReadAs:
    """How files are read: the parser by name, None to recognize it; values for fields that flights lack; the channels
    of the columns of tables, by the best choice first."""

    format: str | None = None
    defaults: Mapping[str, object] = field(default_factory=dict)
    choices: tuple[ColumnChoice, ...] = ()


def read_as(format: str | None, defaults: Mapping[str, object], columns: Sequence[str]) -> ReadAs:
    """How the flyer wants files to be read: with columns as typed (`altitude=Alt (ft)`), else as in an earlier table
    with the same headers. Raises BadValue, FieldkitError if those that are saved cannot be read."""
    return ReadAs(format, defaults, (*([read_choice(columns)] if columns else []), *remembered()))


@dataclass(frozen=True, slots=True)
class Gathered:
    """The contents of files, read before a ledger is opened; their bytes are compressed."""

    incoming_flights: tuple[IncomingFlight, ...]
    rejected: tuple[Rejected, ...]
    notes: tuple[str, ...]
    mapped: tuple[Mapped, ...] = ()
    files: tuple[FileView, ...] = ()
    unusable: int = 0
    """Number of files that could not be used at all; each is also in `rejected`. [1]"""
    choices: tuple[ColumnChoice, ...] = ()
    """The column choices that they were read with."""


MIN_FILES_FOR_JOBS = 8
"""Below this number of files, one process is faster than several. [1]"""


@dataclass(frozen=True, slots=True, eq=False)
class _OneRead:
    """A file that was read, its folder, and its compressed bytes."""

    opened: OpenedFile
    original: Original
    folder: Path


@dataclass(frozen=True, slots=True)
class _Refused:
    """A file that cannot be used at all, with the reason."""

    name: str
    error: FieldkitError


def gather(
    paths: Sequence[Path],
    check_motor: CheckMotor,
    how: ReadAs = ReadAs(),
    *,
    jobs: int = 1,
    on_progress: ReportProgress = no_op,
) -> Gathered:
    """Read files for one import.

    A folder stands for the files in it. If one of several files cannot be used at all, it is listed in `rejected` and
    counted in `unusable`; if it is the only file, its FieldkitError is raised. With `jobs` above 1, that many processes
    read files in parallel.
    """
    found = list(_read_all(_files(paths), how, jobs, on_progress))
    refused = [one for one in found if isinstance(one, _Refused)]
    if len(found) == 1 and refused:
        raise refused[0].error
    read = [one for one in found if isinstance(one, _OneRead)]
    read_files = imported_files([one.opened for one in read], check_motor)
    originals, folders = [one.original for one in read], [one.folder for one in read]
    del found, read  # the rows of a large table take more memory than its flights
    by_digest = {original.digest: original for original in originals}
    incoming_flights: list[IncomingFlight] = []
    rejected = [Rejected(one.name, None, None, str(one.error).removeprefix(f"{one.name}: ")) for one in refused]
    notes: list[str] = []
    views: list[FileView] = []
    for folder, original, imported in zip(folders, originals, read_files, strict=True):
        name = imported.source
        rejected += imported.rejected
        first, first_note = len(incoming_flights), len(notes)
        notes += imported.notes
        for flight, row in zip(imported.flights, imported.rows, strict=True):
            given = _left_open(flight, how.defaults) if how.defaults else _NOTHING_GIVEN
            others = tuple(by_digest[one] for one in flight.origin.others if one in by_digest)
            complete = flight.with_changes(**given) if given else flight
            incoming = IncomingFlight(complete, original, name, row, given, others)
            try:
                incoming, remarks = _with_log(incoming, folder, check_motor)
            except BadValue as error:
                rejected.append(Rejected(name, row, "log", message(marked(error))))
            else:
                kept, beyond = within_motor(incoming.flight)
                incoming_flights.append(incoming if kept is incoming.flight else replace(incoming, flight=kept))
                remarks = [*remarks, *beyond]
                damage = [DamagedLog(text, row=row, column="log", source=name) for text in remarks]
                notes += [message(marked(one)) for one in damage]
        views.append(file_view(imported, [one.flight for one in incoming_flights[first:]], notes[first_note:]))
    mapped = tuple(one for imported in read_files for one in imported.mapped)
    found_in = mapped, tuple(views), len(refused), how.choices
    return Gathered(tuple(incoming_flights), tuple(rejected), tuple(notes), *found_in)


def _files(paths: Sequence[Path]) -> list[Path]:
    """The files that paths stand for: those of a folder in order, without hidden ones."""
    found: list[Path] = []
    for path in paths:
        if path.is_dir():
            found += sorted(one for one in path.iterdir() if one.is_file() and not one.name.startswith("."))
        else:
            found.append(path)
    return found


def _read_all(
    paths: Sequence[Path], how: ReadAs, jobs: int, on_progress: ReportProgress
) -> Iterator[_OneRead | _Refused]:
    """The contents of files, in order."""
    one = partial(_read_one, how=how)
    if jobs < 2 or len(paths) < MIN_FILES_FOR_JOBS:
        for number, path in enumerate(paths):
            if len(paths) > 1:
                on_progress(path.name, number / len(paths))
            yield from one(path)
        return
    with processes(min(jobs, len(paths))) as pool:
        for number, (path, found) in enumerate(zip(paths, pool.map(one, paths), strict=True), start=1):
            on_progress(path.name, number / len(paths))
            yield from found


def _read_one(path: Path, how: ReadAs) -> list[_OneRead | _Refused]:
    """The contents of a file: a capture holds several logs."""
    try:
        logs = _logs(path)
    except FieldkitError as error:
        return [_Refused(_name(path), error)]
    found: list[_OneRead | _Refused] = []
    while logs:
        name, content = logs.pop(0)
        try:
            opened = open_file(name, content, how.format, how.choices)
        except FieldkitError as error:
            found.append(_Refused(name, error))
        else:
            found.append(_OneRead(opened, Original.of(content), path.parent))
    return found


def _logs(path: Path) -> list[tuple[str, bytes]]:
    """The named readings of a file, or of the logs in it if it is a capture."""
    if path.suffix in CAPTURE_SUFFIXES:
        from fieldkit.capture import is_capture, logs_in  # takes 20 ms to import

        if is_capture(path):
            return [(log.name, log.content) for log in logs_in(path)]
    return [(_name(path), read_file(path))]


def _name(path: Path) -> str:
    """A file's name for messages and the ledger, even if it is not valid Unicode."""
    return os.fsencode(path).decode("utf-8", "replace")


def _left_open(flight: Flight, defaults: Mapping[str, object]) -> dict[str, object]:
    """Defaults for the fields that a flight lacks, including standard deviations and sources of its readouts."""
    empty = (None, "", ())
    given = {f: v for f, v in defaults.items() if f not in READOUT_FIELDS and getattr(flight, f) in empty}
    readouts = flight.with_changes(**given).readouts()
    for part in READOUT_FIELDS:
        there, default = getattr(flight, part), defaults.get(part, {})
        known = (
            {name: value for name, value in default.items() if name in readouts} if isinstance(default, dict) else {}
        )
        if known.keys() - there.keys():
            given[part] = {**known, **there}
    return given


def read_file(path: Path, *, most: int | None = None, kind: str = "a log or a flight table") -> bytes:
    """The bytes of a file, by default at most `files.MAX_FILE_SIZE`. Raises DamagedLog with the reason if they cannot
    be read."""
    try:
        return files.read(path, most=most)
    except OSError as error:
        found = f"cannot be read ({error.strerror}), expected {kind}"
        raise DamagedLog(found, source=_name(path)) from error


def _with_log(incoming: IncomingFlight, folder: Path, check_motor: CheckMotor) -> tuple[IncomingFlight, list[str]]:
    """An incoming flight with the bytes and readouts of the log that it names, and the notes on that log. Raises
    BadValue for a log outside the folder of its table, with links resolved."""
    flight = incoming.flight
    if not flight.log:
        return incoming, []
    try:
        content = files.read(_inside(folder, flight.log), plain=True)
    except OSError as error:
        return incoming, [f"found {flight.log!r}, which cannot be read ({error.strerror}); imported without it"]
    try:
        found = read(content, flight.log, check_motor)
    except (UnknownFormat, DamagedLog) as error:
        return replace(incoming, log=Original.of(content), given=None), [f"stored but not read: {error}"]
    measured = {column.name for column in MEASURED if flight.number(column.name) is None}
    row = {name: getattr(flight, name) for name in FIELDS if name not in measured}
    filled = _filled(flight, found.flights)
    return replace(incoming, flight=filled, log=Original.of(content), given=row), list(found.notes)


def _inside(folder: Path, log: str) -> Path:
    """The log that a table names, in the path syntax of any system. Raises BadValue for a file outside the folder."""
    elsewhere = any(kind(log).anchor for kind in (PurePosixPath, PureWindowsPath))  # includes a network share
    if not elsewhere:
        as_named = folder / log
        path = as_named if os.path.exists(as_named) else folder.joinpath(*PureWindowsPath(log).parts)
        if path.resolve().is_relative_to(folder.resolve()):
            return path.resolve()
    raise BadValue(f"found the log {log!r}, expected a path inside the folder of the table")


def _filled(flight: Flight, found: Iterable[Flight]) -> Flight:
    """A flight completed with readouts and extra columns that its row lacks, if the log has exactly one flight."""
    found = list(found)
    if len(found) != 1:
        return flight
    recorded, own = found[0], flight.readouts()
    known = {
        part: {name: value for name, value in getattr(recorded, part).items() if name not in own}
        | getattr(flight, part)
        for part in READOUT_FIELDS
    }
    return flight.with_changes(**(recorded.readouts() | own), **known, extra={**recorded.extra, **flight.extra})
