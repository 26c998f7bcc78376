"""Separates two keys that a terminal sends as one, and names keys as they are printed on keyboards.

Terminals send Alt and a key as Esc and that key, and Textual combines the two if they arrive within 0.1 s. The app has
no keys with Alt, so here they are always two keys. If Textual reports only the key after Esc (Enter, or a character
such as `/`), only that key counts.
"""

from textual.events import Key

OPTION_DIGITS = dict(zip("¡™£¢∞§¶•ªº", "1234567890", strict=True))
"""The digit after Esc, by the combined key in Textual: the letter that a Mac types with Option and the digit."""


def pressed(key: Key, *, typed: bool) -> list[Key]:
    """The keys in an event; `typed` means that an input takes its character as a letter.

    Enter comes as a line feed if it was pressed before the app had the terminal.
    """
    if key.character == "\n":
        return [Key("enter", "\r")]
    digit = None if typed else OPTION_DIGITS.get(key.character or "")
    letter = key.character if key.key.startswith("alt+") else digit
    return [Key("escape", "\x1b"), Key(letter, letter)] if letter else [key]


def in_capitals(key: str) -> str:
    """`^q` as `^Q`, `shift+tab` as `Shift+Tab`, `pgup` as `PgUp`; a single letter is a key of its own."""
    if len(key) == 1:
        return key
    names = {"pgup": "PgUp", "pgdn": "PgDn"}
    return "+".join(names.get(part.lower(), part.title() if len(part) > 1 else part) for part in key.split("+"))
