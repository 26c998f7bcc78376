"""Matching typed names of rockets and sites with known ones."""

from collections.abc import Iterable


def same_name(typed: str, names: Iterable[str]) -> str:
    """The known name that a typed one means: an identical one, or the only one that differs in case; else the typed
    one."""
    known = list(names)
    same_name = [name for name in known if name.casefold() == typed.strip().casefold()]
    return same_name[0] if typed not in known and len(same_name) == 1 else typed
