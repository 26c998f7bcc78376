"""Files on the Import page: the files of a folder, the preview of one, also of a design, and storing it."""

import re
from collections.abc import Mapping
from contextlib import suppress
from dataclasses import dataclass, field
from os.path import abspath, exists, isdir
from pathlib import Path

from textual.content import Content

from fieldkit.errors import BadValue, FieldkitError
from fieldkit.files import first_bytes
from fieldkit.flight import BY_NAME, Flight
from fieldkit.importing.manual_entry import read_changes
from fieldkit.importing.recognize import check_format
from fieldkit.openrocket import MAX_UNPACKED_SIZE, Design, read_design
from fieldkit.paths import expanded
from fieldkit.presentation import logged
from fieldkit.quantities import counted, in_system, measure
from fieldkit.rocket import Configuration
from fieldkit.safe_text import printable
from fieldkit.services.imports import ReadAs, Receipt, gather, read_as, read_file, take_in
from fieldkit.services.weather import NamedWeather
from fieldkit.tui.imports.weather_file import weather_of_file
from fieldkit.tui.resources import Resources
from fieldkit.tui.widgets import cards
from fieldkit.tui.widgets.bars import shortened
from fieldkit.tui.widgets.hanging import Hanging

MAX_LISTED, MAX_NOTES = 200, 6
"""Flights or rejected rows, and notes, that are listed. [1]"""
MAX_FIRST_LINES, MAX_LINE = 40, 120
"""First lines of a text file that are shown, and the characters of each. [1]"""
NAME_WIDTH = 44
"""Cells for the names of flights, before their apogees."""
PARENT_FOLDER = Path("..")
"""The row that leads to the folder above."""


@dataclass(frozen=True, slots=True)
class Look:
    """The preview of a file: its recognized format and the receipt of a dry run, or why it cannot be read; for a
    design, the `start` of a rocket, or the `weather` that was saved in it, described in `words`."""

    path: Path
    format: str
    receipt: Receipt | None
    trouble: str = ""
    start: Configuration | None = None
    weather: NamedWeather | None = None
    words: tuple[str, ...] = ()
    flights: tuple[Flight, ...] = ()
    """The flights in it that can be imported, including duplicates."""
    beginning: tuple[str, ...] = ()
    """The first lines of a file that cannot be read, if it is text."""
    owner: str = ""
    """If the only flight of a file names no rocket: the rocket under which the ledger has that flight; else empty."""


@dataclass(frozen=True, slots=True)
class ReadOptions:
    """Options for reading files: the parser by name, None to recognize it; values for fields that files lack; the
    mapping of a table's columns, as typed (`altitude=Alt (ft)`)."""

    format: str | None = None
    given: Mapping[str, str] = field(default_factory=dict)
    columns: tuple[str, ...] = ()
    marked: tuple[Path, ...] = ()
    """Files to read together: several logs of one flight."""

    def together(self, path: Path) -> tuple[Path, ...]:
        """The files to read together with the current one."""
        return self.marked if path in self.marked else (path,)

    def how(self) -> ReadAs:
        """What was typed, as read. Raises BadValue."""
        return read_as(self.format, read_changes(Flight(), self.given), self.columns)


def folder_text(folder: Path) -> str:
    """The text that names a folder above its files."""
    return str(folder)


def listed(folder: Path) -> list[Path]:
    """The folder above, folders, and files, without hidden ones. Raises FieldkitError if they cannot be read."""
    try:
        found = [path for path in folder.iterdir() if not path.name.startswith(".")]
        return [PARENT_FOLDER, *sorted(found, key=lambda path: (not isdir(path), path.name.lower()))]
    except OSError as error:
        raise FieldkitError(f"{folder}: cannot be read ({error.strerror})") from error


def look_at(resources: Resources, path: Path, reading: ReadOptions) -> Look:
    """The preview of a file; nothing is stored."""
    try:
        if path.suffix.lower() in SUFFIXES:
            start, words = design_at(path, reading.given, resources.settings.units)
            return Look(path, "a design", None, start=start, words=words)
        receipt, flights = _bring_in(resources, path, reading, dry_run=True)
    except FieldkitError as error:
        return _weather(path) or Look(path, "", None, by_keys(str(error)), beginning=beginning(path))
    if not flights and (saved := _weather(path)):
        return saved
    if (count := len(reading.together(path))) > 1:
        return Look(path, f"{count} files together", receipt, flights=flights)
    formats = dict.fromkeys(f"{one.title} ({one.format})" for one in receipt.files)
    return Look(path, ", ".join(formats), receipt, flights=flights, owner=_owner(resources, flights))


def beginning(path: Path) -> tuple[str, ...]:
    """The first lines of a text file; empty for another, or if it cannot be opened."""
    try:
        head = first_bytes(path, MAX_FIRST_LINES * MAX_LINE)
    except OSError:
        return ()
    lines = head.decode("utf-8", "replace").splitlines()[:MAX_FIRST_LINES] if b"\0" not in head else []
    return tuple(line[:MAX_LINE] for line in lines)


def inside(folder: Path) -> Hanging:
    """The folders and files in a folder, with their sizes; nothing for one that cannot be read."""
    with suppress(FieldkitError):
        rows = [name_and_size(path) for path in listed(folder)[1:]]
        more = [("", f"and {len(rows) - MAX_LISTED} more")] if len(rows) > MAX_LISTED else []
        named = [(name, size or "folder") for name, size in rows[:MAX_LISTED]]
        return cards.lines(f"In {folder.name or folder}", [*named, *more]) if rows else Hanging()
    return Hanging()


def _weather(path: Path) -> Look | None:
    """The preview of a file of saved weather; None for another."""
    with suppress(FieldkitError):
        title, weather, words = weather_of_file(path)
        return Look(path, title, None, weather=weather, words=words)
    return None


def _owner(resources: Resources, flights: tuple[Flight, ...]) -> str:
    """The rocket with which a flight that names none was imported before; empty if it was not."""
    if len(flights) != 1 or flights[0].rocket:
        return ""
    with suppress(FieldkitError):
        return resources.ledger.flight(flights[0].flight_id).rocket
    return ""


def by_keys(trouble: str) -> str:
    """An error message with the key m instead of the equivalent command option; the page says itself that m maps the
    columns of a table that no parser recognizes."""
    trouble = re.sub(r"; a table of samples is read with --map .*", "", trouble)
    trouble = re.sub(r"--map '[^']*' for all rows", "m to choose the unit of the column", trouble)
    return re.sub(r"(?:write )?--map '([^']*)'(?: --map '([^']*)')?", _by_key, trouble).replace("--map: ", "columns: ")


def _by_key(options: re.Match[str]) -> str:
    return "m, then " + "; ".join(part for part in options.groups() if part)


def store(resources: Resources, path: Path, reading: ReadOptions) -> Receipt:
    """Store a file in the ledger, and save its column mapping."""
    return _bring_in(resources, path, reading, dry_run=False)[0]


def stored_in_words(receipt: "Receipt") -> str:
    """The notice of an import, with its counts."""
    counts = f"{counted(receipt.duplicates, 'duplicate')}, {len(receipt.rejected)} rejected"
    return f"Imported {len(receipt.ids)}, {counts}" + (". u to undo" if receipt.ids else "")


def _bring_in(
    resources: Resources, path: Path, reading: ReadOptions, *, dry_run: bool
) -> tuple[Receipt, tuple[Flight, ...]]:
    """The result of importing a file, and its flights."""
    found = gather(reading.together(path), resources.motors.complaint, reading.how())
    receipt = take_in(resources.ledger, found, dry_run=dry_run, motors=resources.motors)
    return receipt, tuple(incoming.flight for incoming in found.incoming_flights)


def what_it_brings(look: Look, given: Mapping[str, str], system: str) -> Content:
    """The format of a file, how many flights it would add, and notes; or why it cannot be read."""
    parts: cards.Styled = [(printable(look.path.name), "b $primary")]
    receipt = look.receipt
    if look.start is not None or look.weather is not None:
        does = "save it as this rocket's starting point" if look.start else "fill in the weather of flights"
        parts += ["\n", ("recognized as  ", "$text-muted"), (look.format, "b")]
        parts += [f"\n{printable(shortened(line))}" for line in look.words]
        return Content.assemble(*parts, (f"\nEnter to {does}", "b"))
    if receipt is None:
        parts += [
            ("\n✗ ", "b $error"),
            _unnamed(look, look.trouble),
            "\n\nF to choose a parser, m to map the columns of a table",
        ]
        return Content.assemble(*parts)
    parts += ["\n", ("recognized as  ", "$text-muted"), (look.format, "b")]
    parts += ["\n", ("would add      ", "$text-muted"), (counted(len(receipt.ids), "flight"), "b")]
    parts += [f", {counted(receipt.duplicates, 'duplicate')}, {len(receipt.rejected)} rejected"]
    parts += ["\n", ("set            ", "$text-muted"), (printable(in_a_line(given)), "b")] if given else []
    parts += [f"\n! {_unnamed(look, by_keys(in_system(note, system)))}" for note in receipt.notes[:MAX_NOTES]]
    if len(receipt.notes) > MAX_NOTES:
        parts.append(f"\n  and {counted(len(receipt.notes) - MAX_NOTES, 'more note')}")
    if look.owner:
        parts.append(f"\n! already in the ledger as a flight of {printable(look.owner)}")
    if receipt.ids:
        unnamed = (name for name in ("rocket", "motor") if not all(getattr(flight, name) for flight in look.flights))
        lacking = ", ".join(f"no {name}" for name in unnamed if name not in given)
        parts.append(f"\n! {lacking} in the file: Enter asks for what it lacks" if lacking else "")
        parts.append(("\nEnter to import", "b"))
    return Content.assemble(*parts)


def _unnamed(look: Look, note: str) -> str:
    """A note without the name of its file, which is above it; with it if several files are read together."""
    name = look.path.name
    return printable(shortened(note).removeprefix(f"{name}: ").removeprefix(f"{name}, "))


def what_it_holds(look: Look, system: str) -> Hanging:
    """The flights of a file: all data of a single one, one line for each of several; the first lines of a file that
    cannot be read."""
    if look.beginning:
        return cards.lines("It begins", [("", line or " ") for line in look.beginning])
    if len(look.flights) == 1:
        flight = look.flights[0]
        figures = [*cards.readouts(flight, system), *cards.circumstances(flight, system)]
        figures += logged.beside(flight.extra, system)
        return cards.lines(cards.heading(flight, flight.flight_id) or "One flight", figures, 20)
    named = [(cards.heading(one, one.flight_id), cards.apogee(one, system)) for one in look.flights[:MAX_LISTED]]
    width = min(max((len(name) for name, _ in named), default=0), NAME_WIDTH)
    more = [("", f"and {len(look.flights) - MAX_LISTED} more")] if len(look.flights) > MAX_LISTED else []
    return cards.lines("Flights, and the apogee of each" if named else "", [*named, *more], width)


def left_out(look: Look) -> Hanging:
    """Each row that would be rejected: its position and the reason."""
    rejected = look.receipt.rejected if look.receipt else ()
    lines = [Content.assemble(("Rejected, and why", "b $primary"))] if rejected else []
    for one in rejected[:MAX_LISTED]:
        place = ", ".join(part for part in (f"row {one.row}" if one.row else "", one.column or "") if part)
        lines.append(Content.assemble((f"✗ {printable(place)}", "b"), f": {printable(by_keys(one.error))}"))
    if len(rejected) > MAX_LISTED:
        lines.append(Content(f"and {len(rejected) - MAX_LISTED} more; fieldkit import --dry-run --json lists all"))
    return Hanging(tuple((2, line) for line in lines))


def in_a_line(given: Mapping[str, str]) -> str:
    """The given values in one line: `rocket=Astra; config=A`."""
    return "; ".join(f"{name}={value}" for name, value in given.items())


def name_and_size(path: Path) -> tuple[str, str]:
    """A file's name and size; folders end in a slash."""
    if path == PARENT_FOLDER:
        return "../", ""
    if isdir(path):
        return f"{path.name}/", ""
    try:
        size = path.stat().st_size
    except OSError:
        return path.name, "?"
    return path.name, f"{size} B" if size < 1000 else f"{size / 1e3:.0f} kB" if size < 1e6 else f"{size / 1e6:.1f} MB"


def check_format_name(name: str) -> None:
    """Raises UnknownFormat for a name that no parser has; an empty one means that the content decides."""
    if name.strip():
        check_format(name.strip())


def typed_path(text: str) -> Path:
    """The absolute path of a typed one."""
    return Path(abspath(expanded(text.strip())))


def check_path(text: str) -> None:
    """Raises BadValue for a path at which there is no file or folder; an empty one cancels."""
    if text.strip() and not exists(typed_path(text)):
        raise BadValue(f"{typed_path(text)}: no such file or folder")


SUFFIXES = (".ork", ".rkt", ".cdx1")


def design_at(path: Path, given: Mapping[str, str], system: str) -> tuple[Configuration, tuple[str, ...]]:
    """The start of a rocket from a design, with its text.

    Rocket and configuration come from `given`, or else the rocket from the file. Raises FieldkitError if the file
    cannot be read or the rocket is named in neither.
    """
    design = read_design(read_file(path, most=MAX_UNPACKED_SIZE, kind="a design"), path.name)
    name = given.get("rocket") or design.name
    if not name:
        raise BadValue(f"{path.name}: found no name of the rocket, expected one; press e to enter it")
    config = given.get("config", "")
    start = design.start(name, config, path.name)
    return start, (*_facts(start, design, system), *design.notes)


def _facts(start: Configuration, design: Design, system: str) -> list[str]:
    facts = [f"starts {start.rocket} {start.config}".rstrip()]
    if start.dry_mass is not None:
        facts.append(f"{measure(BY_NAME['dry_mass'], start.dry_mass, system)} without motor, from {design.mass_by}")
    if start.diameter is not None:
        facts.append(f"{measure(BY_NAME['diameter'], start.diameter, system)} across")
    if start.margin is not None:
        facts.append(f"stability {start.margin:.1f} calibers with its motor, at small angles")
    facts.append(f"Cd {start.cd:.2f}, from {design.cd_by}" if start.cd else "no Cd in the file")
    return facts
