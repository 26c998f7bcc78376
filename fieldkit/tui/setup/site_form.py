"""A launch site on the Setup page: its elevation, and its properties for safety checks."""

from dataclasses import replace
from typing import Any

from fieldkit.flight import BY_NAME
from fieldkit.flight.site import Site
from fieldkit.importing.manual_entry import Question, read_answer
from fieldkit.planning.contest_day import read_part
from fieldkit.quantities import measure, unit_of
from fieldkit.tui.widgets import cards

ROOM = (
    Question(
        "size", "Field size", "Shorter side of the field, for the safety check: 400m or 1300ft. Empty: not known."
    ),
    Question(
        "ceiling", "Ceiling", "Ceiling above the pad, by waiver or the field's owner: 900m or 3000ft. Empty: not known."
    ),
)
"""Questions about a site that flights do not answer."""
QUESTIONS = (
    Question("site", "Site", "Its name; renames it in every flight there."),
    Question("site_elevation", "Site elevation", f"{BY_NAME['site_elevation'].help} Changes every flight there."),
    *ROOM,
)
"""Questions about a listed site."""

NEW_SITE = (
    Question("site", "Site", "Its name, which Add and plans then offer."),
    Question("site_elevation", "Site elevation", BY_NAME["site_elevation"].help),
    *ROOM,
)
"""Questions about a new site."""


def room(site: Site, system: str) -> dict[str, str]:
    """Size and ceiling as text to edit."""
    return {question.name: measure(cards.APOGEE, getattr(site, question.name), system) for question in ROOM}


def units(system: str) -> dict[str, str]:
    """The units of numbers typed without one."""
    length = unit_of(cards.APOGEE, system)
    return {"site_elevation": unit_of(BY_NAME["site_elevation"], system), "size": length, "ceiling": length}


def read(name: str, text: str, unit: str) -> object:
    """The value of an answer. Raises BadValue."""
    return read_part(name, text, unit) if name in room_names() else read_answer(name, text, unit)


def room_names() -> set[str]:
    """The answers that are saved separately from the flights."""
    return {question.name for question in ROOM}


def answered(site: Site, values: dict[str, Any], texts: dict[str, str], system: str) -> Site:
    """The site from the answers; a length with the same text was not changed."""
    known: dict[str, Any] = {}
    for name, field in {"site_elevation": "elevation", **{name: name for name in room_names()}}.items():
        if read(name, texts[name], units(system)[name]) != values[name]:
            known[field] = values[name]
    return replace(site, name=values["site"], **known)
