"""Groups of flights: the configurations of rockets and the sites of a ledger."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

from fieldkit.flight import Flight
from fieldkit.flight.site import Site
from fieldkit.ledger import Ledger
from fieldkit.rocket import Configuration, Rocket

NUMBERS = ("dry_mass", "diameter", "site_elevation")
"""Columns whose last known values a group has."""


@dataclass(frozen=True, slots=True)
class Group:
    """The flights of one configuration or one site in the order flown; `last` is the latest of them, with the last
    known numbers."""

    names: tuple[str, ...]
    ids: tuple[str, ...]
    last: Flight
    flights: tuple[Flight, ...] = ()


@dataclass(frozen=True, slots=True)
class LaunchSite:
    """A launch site, from flights or saved, with its flights, their `ids` and the `last` of them."""

    site: Site
    ids: tuple[str, ...]
    last: Flight
    flights: tuple[Flight, ...] = ()


@dataclass(frozen=True, slots=True)
class LedgerNames:
    """The groups of a ledger: configurations of rockets with their mass and diameter, sites, and the rockets
    with a design."""

    builds: tuple[Group, ...]
    sites: tuple[LaunchSite, ...]
    rockets: tuple[Rocket, ...] = ()

    def design(self, rocket: str, config: str) -> Configuration | None:
        """The design of a configuration; None if none was imported."""
        return next((one.design(config) for one in self.rockets if one.name == rocket), None)


def grouped(ids: Sequence[str], flights: Sequence[Flight], *names: str) -> tuple[Group, ...]:
    """Flights by some of their text fields, the group flown last first, without flights that lack the first of these
    fields; a group carries the last known numbers."""
    groups: dict[tuple[str, ...], list[tuple[str, Flight]]] = {}
    for id, flight in zip(ids, flights, strict=True):
        key = tuple(str(getattr(flight, name)) for name in names)
        if key[0]:
            groups.setdefault(key, []).append((id, flight))
    found = []
    for key, members in groups.items():
        known = {c: next((v for _, f in reversed(members) if (v := f.number(c)) is not None), None) for c in NUMBERS}
        named, flown = zip(*members, strict=True)
        found.append(Group(key, named, flown[-1].with_changes(**known), flown))
    order = {id: place for place, id in enumerate(ids)}
    return tuple(sorted(found, key=lambda group: -order[group.ids[-1]]))


def placed(groups: Sequence[Group], known: Sequence[Site]) -> tuple[LaunchSite, ...]:
    """The sites of some flights with their saved properties, and saved sites without flights."""

    saved = {site.name: site for site in known}
    flown = {group.names[0]: group for group in groups}
    found = []
    for name in dict.fromkeys([*flown, *saved]):
        group = flown.get(name, Group((name,), (), Flight(site=name)))
        site = saved.get(name, Site(name))
        elevation = group.last.site_elevation if site.elevation is None else site.elevation
        found.append(LaunchSite(replace(site, elevation=elevation), group.ids, group.last, group.flights))
    return tuple(found)


def rocket_of(ledger: Ledger, flight: Flight) -> tuple[Group, Configuration | None] | None:
    """The flights of a flight's rocket in the same configuration, and its design; None for a flight without a
    rocket."""
    if not flight.rocket:
        return None
    flights = [one for one in ledger.flights(rocket=flight.rocket) if one.config == flight.config]
    found = grouped(ledger.ids(flights), flights, "rocket", "config")
    if not found:
        return None
    return found[0], ledger.rocket(flight.rocket).design(flight.config)
