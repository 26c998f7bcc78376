"""Where flights are flown."""

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class Site:
    """A launch site: elevation of the pad above sea level, the field's shorter side, and the ceiling above the pad
    that its waiver or its owner sets; None where not known. [m]"""

    name: str = ""
    elevation: float | None = None
    size: float | None = None
    ceiling: float | None = None
