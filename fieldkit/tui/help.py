"""What `?` says of a screen."""

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class Help:
    """What `?` says of a screen: what it is for, each field in plain words, and the commands that do the same."""

    about: str
    fields: tuple[tuple[str, str], ...] = ()
    twin: tuple[str, ...] = ()
