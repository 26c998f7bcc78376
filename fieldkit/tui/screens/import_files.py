"""Import: pick a file, see what was recognised and what would be rejected, then store it."""

from collections.abc import Iterable
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, ClassVar

from textual import on
from textual.binding import Binding, BindingType
from textual.containers import Horizontal, Vertical, VerticalScroll
from textual.content import Content
from textual.widget import Widget
from textual.widgets import Static

from fieldkit.errors import FieldkitError
from fieldkit.safe_text import printable
from fieldkit.tui.bars import KeyBar
from fieldkit.tui.dialogs import AskText
from fieldkit.tui.page import Help, Page, PageScreen
from fieldkit.tui.table import Head, Table

if TYPE_CHECKING:
    from fieldkit.intake import Receipt

MOST = 200
"""Rejected rows that are listed."""
UP = Path("..")
"""The row that leads to the folder above."""


@dataclass(frozen=True, slots=True)
class Look:
    """What a file would bring: the format it was recognised as, and the receipt of a dry run; or why it would not."""

    path: Path
    format: str
    receipt: "Receipt | None"
    trouble: str = ""


def told(folder: Path) -> str:
    """A folder as it is named above its files."""
    return str(folder)


def listed(folder: Path) -> list[Path]:
    """Folders and then files, without hidden ones. Raises FieldkitError where they cannot be read."""
    try:
        found = [path for path in folder.iterdir() if not path.name.startswith(".")]
        return [UP, *sorted(found, key=lambda path: (not path.is_dir(), path.name.lower()))]
    except OSError as error:
        raise FieldkitError(f"{folder}: cannot be read ({error.strerror})") from error


class ImportScreen(PageScreen):
    """On the left the files, on the right what the one under the cursor would bring."""

    NAME = "import_files"
    TITLE = "Import"
    ABOUT = Help(
        "Choose a log or a flight table. While the cursor stands on a file, it is read and nothing is stored: you see "
        "what it was recognised as, how many flights it would bring, and each row that would be left out, with the "
        "reason. Enter stores it. What is in the ledger already changes nothing, so a file may be imported twice.",
        (
            ("format", "The parser that recognised the file, by what is in it. f names another one."),
            ("rejected", "Rows that cannot become flights: mend them in the file and import it again."),
            ("columns", "What each column of a table is: altitude=Alt (ft); time=T. Remembered for such tables."),
            ("set", "Columns the file leaves open, such as rocket=Astra; several apart by a semicolon."),
        ),
        (
            "fieldkit import FILE --dry-run",
            "fieldkit import FILE --format NAME --set rocket=Astra --map 'altitude=Alt (ft)'",
        ),
    )
    BINDINGS: ClassVar[list[BindingType]] = [
        Binding("backspace", "up", "Folder up", key_display="⌫"),
        Binding("f", "format", "Format", tooltip="Name the parser to read with"),
        Binding("s", "set", "Set", tooltip="What the file leaves open: rocket=Astra"),
        Binding("m", "columns", "Columns", tooltip="Say which column of a table is what"),
        Binding("o", "folder", "Go to", tooltip="Type the path of a folder or a file"),
    ]
    DEFAULT_CSS = """
    ImportScreen #where { height: 1; padding: 0 1; background: $panel; text-wrap: nowrap; text-overflow: ellipsis; }
    ImportScreen #files { width: 34; }
    ImportScreen.-wide #files { width: 60; }
    ImportScreen #look { width: 1fr; border-left: solid $border-blurred; }
    ImportScreen #said { height: auto; max-height: 60%; padding: 0 1; margin-bottom: 1; }
    ImportScreen #rows { height: 1fr; padding: 0 1; }
    ImportScreen #rejected { height: auto; }
    ImportScreen.-narrow #split { layout: vertical; }
    ImportScreen.-narrow #files { width: 1fr; height: 7; }
    """

    def __init__(self) -> None:
        super().__init__()
        self._folder = Path.cwd()
        self._format: str | None = None
        self._given: dict[str, str] = {}
        self._look: Look | None = None
        self._columns: list[str] = []

    def body(self) -> Iterable[Widget]:
        """Where we are, the files, what one would bring."""
        yield Static("", id="where")
        with Horizontal(id="split"):
            yield Table(id="files", empty="nothing here", enter="Store")
            with Vertical(id="look"):
                yield Static("", id="said")
                with VerticalScroll(id="rows"):
                    yield Static("", id="rejected")

    def on_mount(self) -> None:
        """Keys go to the files."""
        self.set_focus(self.query_one("#files", Table))

    def resting_place(self) -> Widget:
        """The files."""
        return self.query_one("#files", Table)

    def reload(self) -> None:
        """List the folder anew."""
        self.go(self._folder)

    def go(self, folder: Path, mark: Path | None = None) -> None:
        """Show a folder, the cursor on one of its files."""
        self.ask(partial(listed, folder), partial(self._listed, folder, mark), "list")

    def _listed(self, folder: Path, mark: Path | None, paths: list[Path]) -> None:
        self._folder = folder
        self.query_one("#where", Static).update(Content(printable(told(folder))))
        rows = {path: _row(path) for path in paths}
        table = self.query_one("#files", Table)
        table.show([Head("file", 0), Head("size", 7, True)], paths, rows.__getitem__)
        if mark is not None:
            table.move_to(mark)
        self._examine()

    @on(Table.Moved, "#files")
    def _examine(self) -> None:
        """Read the file under the cursor without storing anything."""
        table = self.query_one("#files", Table)
        path = table.current
        is_folder = path is None or path == UP or path.is_dir()
        table.enter = "Open" if is_folder else "Store"
        self.query_one(KeyBar).refresh(layout=True)
        self._look = None
        self.query_one("#rejected", Static).update("")
        if is_folder:
            self.query_one("#said", Static).update("Enter opens the folder")
            return
        self.query_one("#said", Static).update("reading ...")
        self.ask(partial(self._read, path, self._format, dict(self._given)), self._examined, "look")

    def _read(self, path: Path, format: str | None, given: dict[str, str]) -> Look:
        from fieldkit.intake import read_file
        from fieldkit.parsing import parsers, recognise

        try:
            receipt = self._bring_in(path, format, given, dry_run=True)
        except FieldkitError as error:
            return Look(path, "", None, str(error))
        try:
            parser = recognise(read_file(path), format, path.name)
        except FieldkitError:
            return Look(path, "a table of samples, by its columns", receipt)
        name = next(name for name, one in parsers().items() if one is parser)
        return Look(path, f"{parser.title} ({name})", receipt)

    def _defaults(self, given: dict[str, str]) -> dict[str, object]:
        from fieldkit.entry import read_changes
        from fieldkit.flight import Flight

        return read_changes(Flight(), given)

    def _examined(self, look: Look) -> None:
        self._look = look
        parts: list[str | tuple[str, str]] = [(printable(look.path.name), "b $primary")]
        if look.receipt is None:
            parts += [("\n✗ ", "b $error"), printable(look.trouble)]
            parts.append("\n\nf names the parser to read it with")
        else:
            receipt = look.receipt
            parts += ["\n", ("recognised as  ", "$text-muted"), (look.format, "b")]
            parts += ["\n", ("would bring    ", "$text-muted"), (_counted(len(receipt.ids)), "b")]
            parts += [f", {receipt.duplicates} there already, {len(receipt.rejected)} rejected"]
            given = "; ".join(f"{name}={value}" for name, value in self._given.items())
            parts += ["\n", ("set            ", "$text-muted"), (printable(given), "b")] if given else []
            parts += [f"\n! {printable(note)}" for note in receipt.notes[:6]]
            if len(receipt.notes) > 6:
                parts.append(f"\n  and {len(receipt.notes) - 6} more notes")
            if receipt.ids:
                parts.append(("\nEnter stores it", "b"))
        self.query_one("#said", Static).update(Content.assemble(*parts))
        rejected = look.receipt.rejected if look.receipt else ()
        lines: list[str | tuple[str, str]] = [("Left out, and why", "b $primary")] if rejected else []
        for one in rejected[:MOST]:
            place = ", ".join(part for part in (f"row {one.row}" if one.row else "", one.column or "") if part)
            lines += ["\n", (f"✗ {printable(place)}", "b"), f": {printable(one.error)}"]
        if len(rejected) > MOST:
            lines.append(f"\nand {len(rejected) - MOST} more; fieldkit import --dry-run lists all")
        self.query_one("#rejected", Static).update(Content.assemble(*lines))

    @on(Table.Chosen, "#files")
    def _chosen(self) -> None:
        """Open the folder, or store the file."""
        path = self.query_one("#files", Table).current
        if path == UP:
            self.action_up()
        elif path is not None and path.is_dir():
            self.go(path)
        elif self._look is not None and self._look.path == path and self._look.receipt is not None:
            self.ask(partial(self._store, path, self._format, dict(self._given)), self._stored, "store")
        elif self._look is not None:
            self.complain(self._look.trouble)
        else:
            self.tell("it is still being read; Enter again stores it")

    def _bring_in(self, path: Path, format: str | None, given: dict[str, str], *, dry_run: bool) -> "Receipt":
        """What a file brings, its columns read as chosen now, or once for such a table."""
        from fieldkit.intake import bring_in
        from fieldkit.logs.mapping import read_choice, remembered

        choices = ([read_choice(self._columns)] if self._columns else []) + list(remembered())
        return bring_in(
            self.desk.ledger,
            [path],
            self.desk.motors.complaint,
            format=format,
            defaults=self._defaults(given),
            choices=choices,
            dry_run=dry_run,
        )

    def _store(self, path: Path, format: str | None, given: dict[str, str]) -> "Receipt":
        from fieldkit.logs.mapping import remember

        receipt = self._bring_in(path, format, given, dry_run=False)
        for mapped in receipt.mapped:
            if mapped.chosen:
                remember(mapped.choice)
        return receipt

    def _stored(self, receipt: "Receipt") -> None:
        counts = f"{receipt.duplicates} there already, {len(receipt.rejected)} rejected"
        undo = "; u takes them back" if receipt.ids else ""
        self.tell(f"{len(receipt.ids)} imported, {counts}{undo}")
        self.field_app.changed()

    def action_up(self) -> None:
        """The folder above."""
        self.go(self._folder.parent, self._folder)

    def action_format(self) -> None:
        """Name a parser."""
        from fieldkit.parsing import parsers

        known = ", ".join(parsers())
        self.app.push_screen(
            AskText("Read it as", self._format or "", f"One of: {known}. Empty: by its content."), self._named
        )

    def _named(self, text: str | None) -> None:
        if text is not None:
            self._format = text.strip() or None
            self._examine()

    def action_set(self) -> None:
        """Columns that the file leaves open."""
        given = "; ".join(f"{name}={value}" for name, value in self._given.items())
        about = "COLUMN=VALUE for flights that leave it open, several apart by ; such as rocket=Astra; config=A"
        self.app.push_screen(AskText("Set", given, about), self._set)

    def _set(self, text: str | None) -> None:
        if text is None:
            return
        pairs = [part.partition("=") for part in text.split(";") if part.strip()]
        given = {name.strip(): value.strip() for name, _, value in pairs}
        try:
            self._defaults(given)
        except FieldkitError as error:
            self.complain(str(error))
            return
        self._given = given
        self._examine()

    def action_columns(self) -> None:
        """Say which column of a table is what."""
        from fieldkit.logs.headings import QUANTITIES

        known = ", ".join(QUANTITIES)
        about = f"CHANNEL=COLUMN, several apart by ; such as altitude=Alt (ft). Channels: {known}. Empty: as guessed."
        self.app.push_screen(AskText("Columns", "; ".join(self._columns), about), self._mapped)

    def _mapped(self, text: str | None) -> None:
        from fieldkit.logs.mapping import read_choice

        if text is None:
            return
        columns = [part.strip() for part in text.split(";") if part.strip()]
        try:
            read_choice(columns)
        except FieldkitError as error:
            self.complain(str(error))
            return
        self._columns = columns
        self._examine()

    def action_folder(self) -> None:
        """Type a path."""
        self.app.push_screen(AskText("Go to", str(self._folder), "A folder, or a file."), self._went)

    def _went(self, text: str | None) -> None:
        if not text:
            return
        path = Path(text.strip()).expanduser()
        if path.is_dir():
            self.go(path)
        elif path.exists():
            self.go(path.parent, path)
        else:
            self.complain(f"{path}: there is no such file or folder")

    def copied(self) -> str:
        """What the file would bring."""
        return "\n".join(str(self.query_one(name, Static).content) for name in ("#said", "#rejected"))


def _counted(count: int) -> str:
    return f"{count} flight" + ("" if count == 1 else "s")


def _row(path: Path) -> tuple[str, str]:
    """A file's name and size; folders end in a slash."""
    if path == UP:
        return "../", ""
    if path.is_dir():
        return f"{path.name}/", ""
    try:
        size = path.stat().st_size
    except OSError:
        return path.name, "?"
    return path.name, f"{size} B" if size < 1000 else f"{size / 1e3:.0f} kB" if size < 1e6 else f"{size / 1e6:.1f} MB"


PAGE = Page(3, "Import", ImportScreen)
