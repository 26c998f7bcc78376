"""Matching typed names of rockets and sites with known ones."""

from collections.abc import Iterable
from difflib import get_close_matches


def same_name(typed: str, names: Iterable[str]) -> str:
    """The known name that a typed one means: an identical one, or the only one that differs in case; else the typed
    one."""
    known = list(names)
    same_name = [name for name in known if name.casefold() == typed.strip().casefold()]
    return same_name[0] if typed not in known and len(same_name) == 1 else typed


def similar_name(typed: str, names: Iterable[str]) -> str:
    """The known name most similar to a typed one that is not known; empty if none is similar."""
    known = {name.casefold(): name for name in names}
    near = get_close_matches(typed.casefold(), known, n=1)
    return known[near[0]] if near else ""
