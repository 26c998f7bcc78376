"""Saved weather on the Import page: what a file has, and the form that fills in the weather of flights with it."""

from datetime import tzinfo
from functools import partial
from pathlib import Path
from typing import cast

from fieldkit.errors import BadValue
from fieldkit.importing.manual_entry import Question
from fieldkit.importing.weather import QUANTITIES, read_weather, weather_formats
from fieldkit.quantities import counted
from fieldkit.services.imports import read_file
from fieldkit.services.weather import FilledIn, NamedWeather, fill_ledger, flights_to_fill, read_zone
from fieldkit.tui.add.fields import Form
from fieldkit.tui.page import PageScreen
from fieldkit.tui.resources import Resources

SITE = Question(
    "site", "Site of the file", "The flights there are filled in. Empty: all flights, if they have one site."
)
ZONE = Question("zone", "Time zone", "Of your flights: America/Chicago, or hours ahead of UTC such as -5.")
REPLACE = Question(
    "replace", "Replace", "yes to replace weather that is recorded, too; otherwise only what is missing."
)


def weather_of_file(path: Path) -> tuple[str, NamedWeather, tuple[str, ...]]:
    """The format of a saved weather file, its weather, and what it has in words. Raises FieldkitError."""
    name, weather = read_weather(read_file(path), path.name)
    reports = weather.reports
    has = [one for one in QUANTITIES if any(getattr(report, one) is not None for report in reports)]
    has += ["wind aloft"] * any(report.aloft for report in reports)
    words = (
        f"{counted(len(reports), 'report')}: {', '.join(has)}",
        f"{reports[0].time:%Y-%m-%d %H:%M} to {reports[-1].time:%Y-%m-%d %H:%M}, {'UTC' if weather.utc else 'local'}",
        *(f"! {one}" for one in weather.rejected[:3]),
        *([f"! and {counted(len(weather.rejected) - 3, 'more damaged row')}"] if len(weather.rejected) > 3 else []),
    )
    return weather_formats()[name].title, NamedWeather(path.name, weather), words


def ask_weather_file(page: PageScreen, weather: NamedWeather) -> None:
    """Ask for the site of a file and the zone of the flights, and fill in the weather of the flights there."""
    questions = (SITE, *((ZONE,) if weather.weather.utc else ()), REPLACE)
    form = Form(
        f"Weather from {weather.file}",
        questions,
        {question.name: "" for question in questions},
        {},
        _read,
        page.resources.names,
    )

    def answered(values: dict[str, object]) -> None:
        page.change(partial(_fill, page.resources, weather, values), partial(_filled, page))

    page.ask_form(form, answered)


def _read(name: str, text: str, unit: str) -> object:
    """An answer. Raises BadValue for an unknown zone, or another word than yes."""
    typed = text.strip()
    if name == "site":
        return typed
    if name == "zone":
        return read_zone(typed)
    if typed.casefold() not in ("", "y", "yes", "n", "no"):
        raise BadValue(f"found {typed[:20]!r}, expected yes or no")
    return typed.casefold().startswith("y")


def _fill(resources: Resources, weather: NamedWeather, values: dict[str, object]) -> list[FilledIn]:
    zone = cast(tzinfo | None, values.get("zone"))
    flights = flights_to_fill(resources.ledger, str(values["site"]) or None)
    return fill_ledger(resources.ledger, flights, [weather], zone, replace=bool(values["replace"]))


def _filled(page: PageScreen, found: list[FilledIn]) -> None:
    done = sum(one.changed for one in found)
    why = next((one.reason for one in found if not one.changed), "no flight is there")
    page.show_change(
        f"Filled in the weather of {counted(done, 'flight')}. u to undo" if done else f"No flight was filled in: {why}"
    )
