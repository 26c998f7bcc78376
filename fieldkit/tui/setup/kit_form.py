"""Kits on the Setup page: add, change, and delete one."""

from functools import partial
from typing import Any

from fieldkit.errors import BadValue
from fieldkit.flight import BY_NAME
from fieldkit.importing.manual_entry import Question, read_answer
from fieldkit.planning.kits import Kit
from fieldkit.quantities import measure, unit_of
from fieldkit.services.kits import delete_kit, save_kit
from fieldkit.tui.add.fields import Form
from fieldkit.tui.page import PageScreen
from fieldkit.tui.widgets.dialogs import AskYes

QUESTIONS = (
    Question("name", "Kit", "Its name: a rocket of this name starts with the figures of the kit."),
    Question(
        "dry_mass", "Dry mass", "Ready to fly, with recovery and payload, without the motor: 80g. Empty: unknown."
    ),
    Question("diameter", "Diameter", "The widest tube of its body: 41.6mm. Empty: unknown."),
    Question("mount", "Motor mount", "The widest motor that fits: 18mm; wider ones are not offered. Empty: unknown."),
)


def ask_kit(page: PageScreen, kit: Kit | None) -> None:
    """Open a form over a kit, or over a new one."""
    system = page.resources.settings.units
    units = {name: unit_of(BY_NAME[_column(name)], system) for name in ("dry_mass", "diameter", "mount")}
    texts = {name: kit_text(kit, name, system) for name in units} | {"name": kit.name if kit else ""}
    form = Form(kit.name if kit else "A new kit", QUESTIONS, texts, units, read)
    page.ask_form(form, partial(_answered, page, kit, texts))


def ask_delete(page: PageScreen, kit: Kit) -> None:
    """Delete a kit if that is confirmed: its file has no undo."""

    def sure(yes: bool | None) -> None:
        if yes:
            page.change(partial(delete_kit, kit.name), lambda _: page.show_change(f"Deleted the kit {kit.name}"))

    page.app.push_screen(AskYes(f"Delete the kit {kit.name}? Flights and rockets stay as they are."), sure)


def kit_text(kit: Kit | None, name: str, system: str) -> str:
    """A figure of a kit in the units of a system; diameters of mounts in mm."""
    value = None if kit is None else getattr(kit, name)
    if name == "mount":
        return "" if value is None else f"{value * 1e3:g} mm"
    return measure(BY_NAME[name], value, system)


def read(name: str, text: str, unit: str) -> object:
    """The value of an answer. Raises BadValue, also for a kit without a name."""
    if name != "name":
        return read_answer(_column(name), text, unit)
    if not text.strip():
        raise BadValue("expected a name such as Big Bertha")
    return text.strip()


def _column(name: str) -> str:
    return "diameter" if name == "mount" else name


def _answered(page: PageScreen, kit: Kit | None, texts: dict[str, str], values: dict[str, Any]) -> None:
    """Save the kit; a figure with the same text was not changed."""
    system, typed = page.resources.settings.units, Kit("", *(values[q.name] for q in QUESTIONS[1:]))
    same = {name for name in texts if name != "name" and kit_text(typed, name, system) == texts[name]}
    figures = (getattr(kit if kit and q.name in same else typed, q.name) for q in QUESTIONS[1:])
    new = Kit(str(values["name"]), *figures)
    if new != kit:
        was = kit.name if kit else ""
        page.change(partial(save_kit, new, was), lambda _: page.show_change(f"Saved the kit {new.name}"))
