"""The forms of the Setup page: changes of a configuration or a site apply to all its flights."""

from collections.abc import Sequence
from functools import partial
from typing import Any

from fieldkit.errors import DamagedLog
from fieldkit.flight import BY_NAME
from fieldkit.importing.manual_entry import Question
from fieldkit.motors import Motor
from fieldkit.motors.own import import_file
from fieldkit.paths import expanded, motor_folder
from fieldkit.quantities import counted, measure, unit_of
from fieldkit.services.renaming import Edited, edit_flights
from fieldkit.services.sites import SITES, keep_site, with_site
from fieldkit.tui.add.fields import Form
from fieldkit.tui.page import PageScreen
from fieldkit.tui.setup import site_form
from fieldkit.tui.setup.setup_lists import RAIL, answer_of, same
from fieldkit.tui.widgets.dialogs import AskText
from fieldkit.tui.widgets.groups import Group, LaunchSite

BUILD = (
    Question("rocket", "Rocket", "Its name; renames it in every flight of this build."),
    Question("config", "Configuration", "The name of this build."),
    Question("dry_mass", "Dry mass", f"{BY_NAME['dry_mass'].help} Changes every flight of this build."),
    Question("diameter", "Diameter", f"{BY_NAME['diameter'].help} Changes every flight of this build."),
)


def change_build(page: PageScreen, group: Group) -> None:
    """Open a form over a build of a rocket."""
    _edit(page, group, BUILD, " ".join(name for name in group.names if name))


def _edit(page: PageScreen, group: Group, questions: Sequence[Question], what: str) -> None:
    """Open a form over a group; its changes apply to every flight of the group."""
    system = page.resources.settings.units
    texts = {question.name: answer_of(group.last, question, system) for question in questions}
    units = {question.name: unit_of(question.column, system) if question.column else "" for question in questions}
    title = f"{what}: {counted(len(group.ids), 'flight')}"
    page.ask_form(Form(title, questions, texts, units), partial(_edited, page, group, what, texts))


def _edited(page: PageScreen, group: Group, what: str, texts: dict[str, str], values: dict[str, object]) -> None:
    system = page.resources.settings.units
    changes = {name: value for name, value in values.items() if not same(name, value, texts[name], system)}

    def work() -> Edited:
        ledger = page.resources.ledger
        return edit_flights(ledger, [ledger.flight(id) for id in group.ids], [changes] * len(group.ids))

    if changes:
        page.change(work, lambda done: _changed(page, what, done.count, done.notes))


def add_site(page: PageScreen) -> None:
    """Open a form for a site at which nothing has flown yet."""
    system = page.resources.settings.units
    form = Form("A new site", site_form.NEW_SITE, {}, site_form.units(system), site_form.read)
    page.ask_form(form, partial(_site_added, page))


def _site_added(page: PageScreen, values: dict[str, Any]) -> None:
    name = str(values["site"] or "")
    if not name:
        page.complain("Site: found no name, expected one, such as North field")
        return
    lengths = {"elevation": values["site_elevation"], "size": values["size"], "ceiling": values["ceiling"]}
    page.change(partial(keep_site, page.resources.ledger, name, **lengths), lambda _: _changed(page, name, 0))


def change_site(page: PageScreen, place: LaunchSite) -> None:
    """Open a form over a site: name and elevation belong to its flights, the rest is saved separately."""
    system, site = page.resources.settings.units, place.site
    elevation = measure(BY_NAME["site_elevation"], site.elevation, system)
    texts = {"site": site.name, "site_elevation": elevation} | site_form.room(site, system)
    form = Form(
        f"{site.name}: {counted(len(place.ids), 'flight')}",
        site_form.QUESTIONS,
        texts,
        site_form.units(system),
        site_form.read,
    )
    page.ask_form(form, partial(_site_edited, page, place, texts))


def _site_edited(page: PageScreen, place: LaunchSite, texts: dict[str, str], values: dict[str, object]) -> None:
    system, was = page.resources.settings.units, place.site
    flown = {"site": values["site"], "site_elevation": values["site_elevation"]}
    changes = {name: new for name, new in flown.items() if not same(name, new, texts[name], system)}
    site = site_form.answered(was, values, texts, system)

    def work() -> int:
        ledger = page.resources.ledger
        beside = {SITES: with_site(ledger, site, was.name)} if site != was else {}
        return ledger.edit_all(place.ids, was.name, beside, **changes)

    if changes or site != was:
        page.change(work, partial(_changed, page, was.name))


def _changed(page: PageScreen, what: str, count: int, notes: Sequence[str] = ()) -> None:
    saved = f"Saved {what}: {counted(count, 'flight')}" if count else f"Saved {what}"
    page.show_change("; ".join([saved, *notes]) + ". u to undo")


def ask_rail(page: PageScreen) -> None:
    """Ask for length and angle of the default rail of plans."""
    settings = page.resources.settings
    questions = [Question(name, BY_NAME[name].title, f"{BY_NAME[name].help} Empty: none.") for name in RAIL]
    texts = {name: measure(BY_NAME[name], getattr(settings, name), settings.units) for name in RAIL}
    units = {name: unit_of(BY_NAME[name], settings.units) for name in RAIL}

    def save_rail(values: dict[str, object]) -> None:
        changes = {n: new for n, new in values.items() if not same(n, new, texts[n], settings.units)}
        if changes:
            page.field_app.choose("Saved your usual rail", **changes)

    page.ask_form(Form("Your usual rail", questions, texts, units), save_rail)


def ask_motors(page: PageScreen) -> None:
    """Add the motors of a file."""
    page.app.push_screen(AskText("Add motors", "", "The path of a .eng or .rse file."), partial(_import, page))


def _import(page: PageScreen, text: str | None) -> None:
    if not text or not text.strip():
        return

    def work() -> tuple[list[Motor], list[DamagedLog]]:
        return import_file(expanded(text.strip()), motor_folder())

    page.ask(work, partial(_imported, page), "import")


def _imported(page: PageScreen, found: tuple[list[Motor], list[DamagedLog]]) -> None:
    motors, errors = found
    page.resources.forget_motors()
    added = f"Added {counted(len(motors), 'motor')}: {', '.join(one.designation for one in motors[:4])}"
    remarks = (remark for motor in motors for remark in motor.remarks)
    page.show_change("; ".join([added, *map(str, errors), *remarks][:4]))
