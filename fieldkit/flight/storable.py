"""The texts of a flight that a ledger can store and a table can show."""

from fieldkit.errors import BadValue
from fieldkit.flight.flight import Flight

NAMES = ("flight_id", "rocket", "config", "site")
"""Fields that name something and are printed in tables."""
MAX_NAME = 200
"""Longest name, many times as long as any that fits in a table. [characters]"""


def check_name(name: str) -> str:
    """Return a name if it is short enough to be printed in a table. Raises BadValue."""
    if len(name) > MAX_NAME:
        raise BadValue(f"found {name[:20] + '…'!r} of length {len(name)}, expected at most {MAX_NAME} characters")
    return name


def long_names(flight: Flight) -> list[str]:
    """Names and tags of a flight that no table can show in full, one phrase each. A flyer is not allowed to type them,
    but ledgers of earlier versions hold them, and what is exported can be imported."""
    named = {name: (getattr(flight, name),) for name in NAMES} | {"tags": flight.tags}
    return [
        f"{name}: found {text[:20] + '…'!r} of length {len(text)}, which tables shorten"
        for name, texts in named.items()
        for text in texts
        if len(text) > MAX_NAME
    ]


TEXTS = ("rocket", "flight_id", "config", "motor", "site", "notes", "log")
"""Fields that are text."""
MAX_KEY_SIZE = 2600
"""Largest size of a tag, and of a rocket's name and a flight_id together, in UTF-8: the keys of a server are no longer,
and a ledger can move between a file and a server. [bytes]"""


def check_keys(flight: Flight) -> None:
    """Raise BadValue for names of a flight that not every kind of ledger can store."""
    check_key("rocket and flight_id", flight.rocket + flight.flight_id)
    for tag in flight.tags:
        check_key("tags", tag)


def check_key(name: str, key: str) -> None:
    """Raise BadValue for a key, or the columns of one together, that not every kind of ledger can store."""
    if (size := len(key.encode(errors="replace"))) > MAX_KEY_SIZE:
        raise BadValue(f"{name}: found {key[:20] + '…'!r} of {size:,} bytes, expected at most {MAX_KEY_SIZE}")


def check_texts(flight: Flight) -> None:
    """Raise BadValue for texts of a flight that no ledger can store: a NUL, or half of a character of two."""
    named: dict[str, tuple[str, ...]] = {name: (getattr(flight, name),) for name in TEXTS}
    named["tags and extra columns"] = (*flight.tags, *flight.extra, *flight.extra.values())
    for name, texts in named.items():
        for text in texts:
            if "\0" in text or any("\ud800" <= letter <= "\udfff" for letter in text):
                raise BadValue(f"{name}: found {text[:40]!r}, expected text without NUL and broken characters")
