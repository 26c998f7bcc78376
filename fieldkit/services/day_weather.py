"""The weather of the day, entered once as the default of every plan and flight of that day."""

from collections.abc import Mapping, Sequence
from datetime import datetime
from typing import TYPE_CHECKING

from fieldkit.flight import Flight
from fieldkit.flight.columns import WEATHER
from fieldkit.importing.manual_entry import answer_text, read_answer

if TYPE_CHECKING:
    from fieldkit.ledger import Ledger

WEATHER_DRAFT = "weather of the day"
"""Name under which the ledger saves it."""
TYPED_AT = "at"
"""Key of the time at which the weather was entered, ISO 8601, local time."""


def typed_weather(ledger: "Ledger") -> tuple[dict[str, str], datetime | None]:
    """Today's weather as entered, and when; empty if none was entered today."""
    kept = ledger.draft(WEATHER_DRAFT) or {}
    typed = datetime.fromisoformat(kept[TYPED_AT]) if TYPED_AT in kept else None
    if typed is None or typed.date() != datetime.now().date():
        return {}, None
    return {name: text for name, text in kept.items() if name in WEATHER}, typed


def weather_of(texts: Mapping[str, str]) -> Flight:
    """Entered weather as the conditions of a flight. Raises BadValue. [SI]"""
    return Flight().with_changes(**{name: read_answer(name, text) for name, text in texts.items()})


def save_weather(ledger: "Ledger", conditions: Flight) -> bool:
    """Save today's weather, for every plan and flight of the day; False if it is unchanged.

    Undo restores the earlier weather.
    """
    texts = answer_texts(conditions, WEATHER)
    if texts == typed_weather(ledger)[0]:
        return False
    return ledger.change_draft(WEATHER_DRAFT, signed_now(texts), "plan", "weather of the day")


def signed_now(texts: Mapping[str, str]) -> dict[str, str]:
    """Entered weather with the time at which it was entered."""
    return {**texts, TYPED_AT: datetime.now().isoformat(timespec="seconds")}


def answer_texts(flight: Flight, names: Sequence[str]) -> dict[str, str]:
    """The recorded values among some fields of a flight, as text to edit."""
    return {name: text for name in names if (text := answer_text(flight, name))}
