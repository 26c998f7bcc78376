"""Keys as they were pressed, if a terminal hands two on as one.

Terminals send Alt and a key as Esc and that key, and Textual takes what comes within a tenth of a second for the one
with the other. No key of the app goes with Alt, so here they are always two. If Textual keeps only the key behind
Esc (Enter, or a sign such as `/`), that key alone counts.
"""

from textual.events import Key

OPTION_DIGITS = dict(zip("¡™£¢∞§¶•ªº", "1234567890", strict=True))
"""The digit behind Esc, by what Textual makes of the two: the letter that a Mac types with Option and the digit."""


def pressed(key: Key, *, typed: bool) -> list[Key]:
    """The keys that an event stands for; `typed` says that a line takes its character as a letter.

    Enter comes as a line feed if it was pressed before the app had the terminal.
    """
    if key.character == "\n":
        return [Key("enter", "\r")]
    digit = None if typed else OPTION_DIGITS.get(key.character or "")
    letter = key.character if key.key.startswith("alt+") else digit
    return [Key("escape", "\x1b"), Key(letter, letter)] if letter else [key]
