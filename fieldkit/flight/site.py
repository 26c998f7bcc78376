"""Launch sites."""

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class Site:
    """A launch site: elevation of the pad above sea level, the shorter side of the field, the ceiling above the pad set
    by its waiver or owner, and the distances from the pad to the people at the launch and to uninvolved people and
    property; None if not known. [m]

    `rules` names the rules that apply, such as `NAR, FAA` or `UKRA`; empty for the default.
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
