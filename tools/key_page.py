"""The page of keys: what each key of the app does on each page, from the bindings of its screens."""

from collections.abc import Iterator

from textual.binding import Binding
from textual.screen import Screen

from fieldkit.tui.app import FieldkitApp
from fieldkit.tui.flights.flight_screen import FlightScreen
from fieldkit.tui.flights.log_view import LogView
from fieldkit.tui.flights.tag_screen import TagScreen
from fieldkit.tui.keys import in_capitals
from fieldkit.tui.next.plan_screen import PlanScreen
from fieldkit.tui.pad.pad_screen import PadScreen
from fieldkit.tui.page import PageScreen, pages
from tools.markdown import WRITTEN_BY, table

OVER_PAGES: "dict[type[Screen[None]], str]" = {
    FlightScreen: "A flight, opened by `Enter` on the Flights page",
    TagScreen: "Tags of a flight, opened by `t`",
    LogView: "The log of a flight, opened by `l`",
    PlanScreen: "Decide, opened by `d` on the Fly page",
    PadScreen: "The checklist at the pad, opened by `K` on the Home page",
}
"""Screens that are opened over a page, and their headings."""
SIGNS = {"question_mark": "?", "slash": "/", "exclamation_mark": "!", "asterisk": "*", "escape": "Esc"}
"""Keys whose names in Textual are not on keyboards."""


def key_table() -> str:
    """The page as Markdown: the keys of all pages, then those of each."""
    everywhere = list(_rows(FieldkitApp, PageScreen))
    parts = [
        "# Keys\n",
        f"{WRITTEN_BY}\n",
        "The words are those at the lower edge of the app. A key means the same on every page that has it; `e` opens "
        "the form that its word names.\n",
        f"## On every page\n\n{_table([('0 to 7', '', 'Open a page'), *everywhere])}",
    ]
    titles = {page.screen: f"{page.number} {page.title}" for page in pages().values()} | OVER_PAGES
    for screen, title in titles.items():
        own = [row for row in _rows(screen) if row not in everywhere]
        parts.append(f"## {title}\n\n{_table(own)}")
    return "\n".join(parts)


def _rows(*owners: type[FieldkitApp] | type[Screen[None]]) -> Iterator[tuple[str, str, str]]:
    """Key, word, and purpose of the bindings of some classes, without keys that only reverse another one."""
    for owner in owners:
        if (on_enter := getattr(owner, "ON_ENTER", ("", "")))[0]:
            yield "Enter", *on_enter
        for binding in owner.BINDINGS:
            if isinstance(binding, Binding) and binding.description and (binding.show or binding.tooltip):
                yield _key(binding), binding.description, binding.tooltip or binding.description


def _key(binding: Binding) -> str:
    """The key as the app shows it."""
    if binding.key_display:
        return binding.key_display
    return ", ".join(SIGNS.get(key, in_capitals(key.replace("ctrl+", "^"))) for key in binding.key.split(","))


def _table(rows: list[tuple[str, str, str]]) -> str:
    return "\n".join(table(["key", "word", "does"], [(f"`{key}`", *rest) for key, *rest in rows]))
