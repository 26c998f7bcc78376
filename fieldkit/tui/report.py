"""Files that a page writes: a report on the current item, or a page of a plan, with a prompt for the file's name."""

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from pathlib import Path

from fieldkit.errors import FileTaken
from fieldkit.files import check_target, is_taken
from fieldkit.paths import expanded, working_folder
from fieldkit.presentation.report.book import book
from fieldkit.presentation.report.write import check_report, write_report
from fieldkit.progress import no_op
from fieldkit.tui.page import PageScreen
from fieldkit.tui.widgets.dialogs import AskText, AskYes

ABOUT = "A name that ends in .html, .pdf, .png or .md; the same as `fieldkit report`."
WRITING_TEXT = "Writing the file ..."


@dataclass(frozen=True, slots=True)
class Written:
    """A file to be written: what it is (`report`), the title of its prompt and the offered name, what the name may be
    and how that is checked; `write` writes it to a path, with True over an existing file, and returns the path
    written."""

    what: str
    title: str
    name: str
    about: str
    check: Callable[[Path], None]
    write: Callable[[Path, bool], Path]


def ask_file(page: PageScreen, file: Written) -> None:
    """Ask for the name of a file, and write it."""

    def check(name: str) -> None:
        if name.strip():  # an empty one cancels
            file.check(expanded(name.strip()))

    offered = str(working_folder() / "".join(one if one.isalnum() or one in "-_." else "_" for one in file.name))
    page.app.push_screen(AskText(file.title, offered, file.about, check=check), partial(_named, page, file))


def _named(page: PageScreen, file: Written, name: str | None) -> None:
    if not name or not name.strip():
        return
    path = expanded(name.strip())
    if is_taken(path):
        _ask_to_replace(page, file, path, path)
    else:
        _make(page, file, path, force=False)


def _ask_to_replace(page: PageScreen, file: Written, path: Path, taken: Path) -> None:
    question = f"{taken} exists. Replace it?"
    page.app.push_screen(AskYes(question), lambda yes: _make(page, file, path, force=True) if yes else None)


def _make(page: PageScreen, file: Written, path: Path, *, force: bool) -> None:
    def work() -> Path | FileTaken:
        try:
            check_target(path, force=force)
            return file.write(path, force)
        except FileTaken as error:  # one of several files: pages, pictures
            return error

    def written(made: Path | FileTaken) -> None:
        if isinstance(made, FileTaken):
            page.field_app.withdraw(WRITING_TEXT)
            _ask_to_replace(page, file, path, made.file)
        else:
            page.show_notice(f"Wrote the {file.what} to {made}")

    page.show_notice(WRITING_TEXT)
    page.ask(work, written, "report")


def ask_report(page: PageScreen, what: str) -> None:
    """Ask for the file of a report on a flight, a rocket or a day, and write it."""

    def write(path: Path, force: bool) -> Path:
        resources = page.resources
        found = book(resources.ledger, resources.motors, what, no_op, resources.settings.units)
        files = write_report(found, path, force=force)
        return path if path in files else files[0]

    ask_file(page, Written("report", f"Report of {what}", f"{what}.html", ABOUT, check_report, write))
