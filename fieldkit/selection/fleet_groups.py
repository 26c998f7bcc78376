"""Groups of flights of several rockets that may differ together: a motor type or lot, a day, a site, an altimeter.

Which effects may act on which groups is stated by the effects (`shared_by` in `models/effects`). A motor type may also
differ from some day on, as a lot that nobody recorded, and so may all heights, as with a new altimeter.
"""

from collections import defaultdict
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from datetime import date
from itertools import combinations, pairwise

import numpy as np

from fieldkit.model.rocket_model import Model, Term
from fieldkit.model.term_names import TermName
from fieldkit.physics.effect import SharedBy, effects
from fieldkit.shapes import Flags

PRIOR_WIDTHS = (0.5, 1.0, 2.0)
"""Factors on the prior standard deviation of an effect, equally probable a priori: a judgment. [1]"""
MIN_FLIGHTS = 2
"""Minimum number of flights with and without a difference. [1]"""


@dataclass(frozen=True, slots=True)
class SharedDifference:
    """Effects on a group of flights of several rockets: of a motor type or lot, a day, a site, a device, or from some
    day on.

    `members` marks its flights, by rocket.
    """

    effects: tuple[str, ...]
    level: SharedBy
    of: str
    since: date | None
    members: Mapping[str, Flags]

    @property
    def effect(self) -> str:
        """The names of the effects, joined by a plus."""
        return "+".join(self.effects)

    @property
    def quantities(self) -> tuple[str, ...]:
        """The quantities of the model that change."""
        return tuple(effects()[name].quantity for name in self.effects)

    @property
    def sds(self) -> tuple[float, ...]:
        """Prior standard deviation of each change, as a log ratio, with a width of 1. [1]"""
        return tuple(effects()[name].prior.sd for name in self.effects)

    @property
    def place(self) -> tuple[SharedBy, str]:
        """The group, without the day from which on it differs."""
        return self.level, self.of

    @property
    def names(self) -> tuple[TermName, ...]:
        """The names of its terms, common to all rockets."""
        group = (self.level, self.of, self.since)
        return tuple(TermName(quantity, "difference", group) for quantity in self.quantities)

    def terms(self, rocket: str, width: float = PRIOR_WIDTHS[-1]) -> tuple[Term, ...]:
        """Its terms in the model of a rocket, with one of `PRIOR_WIDTHS` [1]; none if it does not
        concern it."""
        weight = self.members.get(rocket)
        if weight is None or not weight.any():
            return ()
        rows = zip(self.names, self.quantities, self.sds, strict=True)
        return tuple(Term(name, bends, 0.0, width * sd, weight.astype(float)) for name, bends, sd in rows)


def shared_quantities() -> tuple[str, ...]:
    """The quantities that some effect may change on flights of several rockets."""
    return tuple(dict.fromkeys(one.quantity for one in effects().values() if one.shared_by))


def effects_at(level: SharedBy) -> list[tuple[str, ...]]:
    """The effects that may act at a level, alone and in pairs."""
    names = [name for name, one in effects().items() if level in one.shared_by]
    return [*((name,) for name in names), *combinations(names, 2)]


def differences(models: Mapping[str, Model], seen: Mapping[str, Flags]) -> list[SharedDifference]:
    """Every group of flights that may differ, with each effect that may act on it, by the models of all rockets.

    `seen` marks the flights used in the fit. A group has at least `MIN_FLIGHTS` of them, and so have the flights
    without the difference.
    """
    found: list[SharedDifference] = []
    labels_at = _labels(models)
    for kind, labels in labels_at.items():
        for of in dict.fromkeys(label for own in labels.values() for label in own if label):
            there = {name: np.array([label == of for label in own]) for name, own in labels.items()}
            found += _at(kind, of, None, there, seen)
    motors = labels_at["motor_type"]
    groups: list[tuple[SharedBy, str, Mapping[str, Flags]]] = [
        ("fleet", "all heights", {name: np.ones(len(model.flights), bool) for name, model in models.items()})
    ]
    groups += [
        ("lot", of, {name: np.array([label == of for label in own]) for name, own in motors.items()})
        for of in dict.fromkeys(label for own in motors.values() for label in own)
    ]
    days = {name: _days(model) for name, model in models.items()}
    for level, of, members in groups:
        pairs = [zip(own, members[name], strict=True) for name, own in days.items()]
        for _, day in pairwise(sorted({day for own in pairs for day, member in own if member and day})):
            since = {name: np.array([each is not None and each >= day for each in own]) for name, own in days.items()}
            later = {name: members[name] & since[name] for name in members}
            if sum(int((members[name] & ~later[name] & seen[name]).sum()) for name in members) >= MIN_FLIGHTS:
                found += _at(level, of, day, later, seen)
    return found


def _at(
    level: SharedBy, of: str, since: date | None, members: Mapping[str, Flags], seen: Mapping[str, Flags]
) -> Iterator[SharedDifference]:
    """A group with each effect that may act on it, if it has enough flights."""
    inside = sum(int((members[name] & own).sum()) for name, own in seen.items())
    total = sum(int(own.sum()) for own in seen.values())
    if inside >= MIN_FLIGHTS and total - inside >= MIN_FLIGHTS:
        for names in effects_at(level):
            yield SharedDifference(names, level, of, since, members)


def _days(model: Model) -> list[date | None]:
    """The day of each flight, None for one without a date."""
    return [flight.date_time.date() if flight.date_time else None for flight in model.flights]


def _labels(models: Mapping[str, Model]) -> dict[SharedBy, dict[str, list[str]]]:
    """The group of each flight at every level, empty if unknown, by rocket."""
    found: dict[SharedBy, dict[str, list[str]]] = defaultdict(dict)
    for name, model in models.items():
        groups: dict[SharedBy, list[str]] = {
            "motor_type": model.groups("motor"),
            "lot": model.groups("lot"),
            "day": model.groups("day"),
            "site": model.groups("site"),
            "device": model.groups("device"),
        }
        for level, labels in groups.items():
            found[level][name] = labels
    return dict(found)
