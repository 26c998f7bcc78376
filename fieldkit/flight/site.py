"""Where flights are flown."""

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class Site:
    """A launch site: elevation of the pad above sea level, the field's shorter side, and the ceiling above the pad
    that its waiver or its owner sets, how far from the pad the people at the launch stand, and persons and property
    that have no part in it; None if not known. [m]

    `rules` names whose rules govern it, such as `NAR, FAA` or `UKRA`; empty for the usual.
    """

    name: str = ""
    elevation: float | None = None
    size: float | None = None
    ceiling: float | None = None
    people: float | None = None
    bystanders: float | None = None
    rules: str = ""


SITE_LENGTHS = ("elevation", "size", "ceiling", "people", "bystanders")
"""The lengths of a site. [m]"""
