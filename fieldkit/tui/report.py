"""A report from a page: on the current item, with a prompt for the name of its file."""

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
WRITING_TEXT = "Writing the report ..."


def ask_report(page: PageScreen, what: str) -> None:
    """Ask for the file of a report on a flight, a rocket or a day, and write it."""
    name = "".join(letter if letter.isalnum() or letter in "-_." else "_" for letter in what)
    offered = str(working_folder() / f"{name}.html")
    page.app.push_screen(AskText(f"Report of {what}", offered, ABOUT, check=_check), partial(_write, page, what))


def _check(name: str) -> None:
    """Raises BadValue for the name of a file in no known format; an empty one cancels."""
    if name.strip():
        check_report(expanded(name.strip()))


def _write(page: PageScreen, what: str, name: str | None) -> None:
    if not name or not name.strip():
        return
    path = expanded(name.strip())
    if is_taken(path):
        _ask_to_replace(page, what, path, path)
    else:
        _make(page, what, path, force=False)


def _ask_to_replace(page: PageScreen, what: str, path: Path, taken: Path) -> None:
    question = f"{taken} exists. Replace it?"
    page.app.push_screen(AskYes(question), lambda yes: _make(page, what, path, force=True) if yes else None)


def _make(page: PageScreen, what: str, path: Path, *, force: bool) -> None:
    def work() -> list[Path] | FileTaken:
        try:
            check_target(path, force=force)
            found = book(page.resources.ledger, page.resources.motors, what, no_op, page.resources.settings.units)
            return write_report(found, path, force=force)
        except FileTaken as error:  # one of several files: pages, pictures
            return error

    def written(files: list[Path] | FileTaken) -> None:
        if isinstance(files, FileTaken):
            page.field_app.withdraw(WRITING_TEXT)
            _ask_to_replace(page, what, path, files.file)
        else:
            page.show_notice(f"Wrote the report to {path if path in files else files[0]}")

    page.show_notice(WRITING_TEXT)
    page.ask(work, written, "report")
