"""The weather of the day, typed once: every plan and flight of that day starts from it."""

from collections.abc import Mapping, Sequence
from datetime import datetime

from fieldkit.flight import Flight
from fieldkit.importing.manual_entry import answer_text, read_answer
from fieldkit.ledger import Ledger

WEATHER_DRAFT = "weather of the day"
"""Name under which the ledger keeps it."""
WEATHER = ("wind", "temperature", "pressure", "humidity")
"""Conditions that belong to the day and not to the rocket or the site."""
TYPED_AT = "at"
"""Key of the weather of the day: when it was typed, ISO 8601, local time."""


def typed_weather(ledger: Ledger, now: datetime | None = None) -> tuple[dict[str, str], datetime | None]:
    """The weather of today as it was typed, and when; empty if none was typed today."""
    kept = ledger.draft(WEATHER_DRAFT) or {}
    typed = datetime.fromisoformat(kept[TYPED_AT]) if TYPED_AT in kept else None
    if typed is None or typed.date() != (now or datetime.now()).date():
        return {}, None
    return {name: text for name, text in kept.items() if name in WEATHER}, typed


def weather_of(texts: Mapping[str, str]) -> Flight:
    """Typed weather as the conditions of a flight. [SI]"""
    return Flight().with_changes(**{name: read_answer(name, text) for name, text in texts.items()})


def save_weather(ledger: Ledger, conditions: Flight) -> bool:
    """Keep the weather of today, for every plan and flight of the day; False if it is so already. Undo brings back
    what was before."""
    texts = answer_texts(conditions, WEATHER)
    if texts == typed_weather(ledger)[0]:
        return False
    return ledger.change_draft(WEATHER_DRAFT, signed_now(texts), "plan", "weather of the day")


def signed_now(texts: Mapping[str, str]) -> dict[str, str]:
    """Typed weather with the time at which it was typed."""
    return {**texts, TYPED_AT: datetime.now().isoformat(timespec="seconds")}


def answer_texts(flight: Flight, names: Sequence[str]) -> dict[str, str]:
    """Some fields of a flight as one would type them, those that are known."""
    return {name: text for name in names if (text := answer_text(flight, name))}
