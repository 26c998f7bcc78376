"""The columns that a flyer named once: those that are remembered, put right, or forgotten."""

from collections.abc import Sequence

from fieldkit.importing import ColumnChoice
from fieldkit.importing.tables.mapping import edit, forget, is_of_flights, remembered

__all__ = ["edit", "forget", "in_words", "list_mappings"]


def list_mappings() -> Sequence[ColumnChoice]:
    """The choices of columns that are remembered, the latest first: `forget` and `edit` count them from 1."""
    return remembered()


def in_words(choice: ColumnChoice) -> tuple[str, str, str]:
    """What a choice is for (`flights` or `samples`), the headers of its tables, and its columns."""
    columns = "; ".join(f"{name}={column}" for name, column in choice.channels.items())
    return "flights" if is_of_flights(choice) else "samples", ", ".join(choice.headers), columns
