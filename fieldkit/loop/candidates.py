"""What could be missing from a rocket's model: every effect, everywhere or in one group of flights, and plain
patterns that no effect explains."""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from fieldkit.loop.model import Model, Term, groups
from fieldkit.shapes import Array, Flags, Float
from fieldkit.simulator.effect import Effect, effects
from fieldkit.simulator.field import delays, recorded


@dataclass(frozen=True, slots=True)
class Place:
    """Where an effect acts: in one group of flights (empty for all), and only from a flight on (empty for
    from the first)."""

    effect: str
    where: str = ""
    since: str = ""

    def __str__(self) -> str:
        group = f" of {self.where}" if self.where else ""
        return f"{self.effect}{group}" + (f" from flight {self.since} on" if self.since else "")


@dataclass(frozen=True, slots=True)
class Candidate:
    """One way to extend a model: its terms, and where the fit of them should begin.

    `place.effect` is empty for a pattern. `starts` are values of the first term from which the fit is begun,
    each in turn. `log_share` is the log of its share of the prior odds of its effect.
    """

    place: Place
    terms: tuple[Term, ...]
    starts: tuple[float, ...] = (0.0,)
    log_share: float = 0.0

    @property
    def effect(self) -> str:
        """The effect's name, or empty for a pattern."""
        return self.place.effect


SINCE_SHARE = 0.4
"""Share of an effect's prior odds for beginning at some flight rather than at the first. [1]"""


def effect_term(place: Place, model: Model) -> Term:
    """The strength of an effect in a place as an unknown of a model."""
    effect = effects()[place.effect]
    prior = effect.prior
    return Term(str(place), effect, prior.mean, prior.sd, place_weight(place, model), prior.low, prior.high)


def effect_candidates(model: Model, teach: Flags) -> Iterator[Candidate]:
    """Every effect that these flights could show, everywhere and in each group it may differ in.

    `teach` marks the flights that teach: a beginning is only looked for between them.
    """
    for name, effect in effects().items():
        if not _can_act(name, effect, model):
            continue
        prior = effect.prior
        starts = effect.starts or ((prior.mean, 0.02 * prior.sd) if np.isfinite(prior.low) else (prior.mean,))
        whole, since = list(_groups(name, effect, model)), list(_beginnings(name, effect, model, teach))
        share = SINCE_SHARE if since else 0.0
        for place in whole:
            yield Candidate(place, (effect_term(place, model),), starts, np.log((1 - share) / len(whole)))
        for place in since:
            yield Candidate(place, (effect_term(place, model),), starts, np.log(share / len(since)))


def _can_act(name: str, effect: Effect, model: Model) -> bool:
    if name == "early_ejection" and not np.isfinite(delays(model.flights, model.found)).any():
        return False
    if not effect.needs:
        return True
    column = recorded(model.flights, effect.needs)
    return bool(np.nanmax(np.abs(column), initial=0.0) > 0)


def _groups(name: str, effect: Effect, model: Model) -> Iterator[Place]:
    """Groups of flights an effect may be confined to."""
    if effect.everywhere:
        yield Place(name)
    if effect.per:
        group = groups(model.flights, model.found, effect.per)
        if len(set(group)) > 1:
            yield from (Place(name, kind) for kind in dict.fromkeys(group) if kind)


def _beginnings(name: str, effect: Effect, model: Model, teach: Flags) -> Iterator[Place]:
    """Flights of each group from which on an effect may be there, with a flight that teaches on either side."""
    if not effect.starts_anywhere:
        return
    group = groups(model.flights, model.found, effect.per) if effect.per else [""] * len(model.flights)
    several = len(set(group)) > 1
    for kind in dict.fromkeys(group):
        rows = [row for row, own in enumerate(group) if own == kind and teach[row]]
        margin = 1 if len(rows) < 6 else 2
        for row in rows[margin : len(rows) - margin + 1]:
            yield Place(name, kind if several else "", model.flights[row].flight_id)


def place_weight(place: Place, model: Model) -> Float[Array, "flight"]:
    """How strongly an effect acts on each flight: only in its place, and growing if it grows."""
    effect = effects()[place.effect]
    names = [flight.flight_id for flight in model.flights]
    first = names.index(place.since) if place.since in names else 0
    since = np.arange(len(names)) - first
    weight = np.maximum(since, 0.0) if effect.grows else np.where(since >= 0, 1.0, 0.0)
    if not place.where:
        return np.asarray(weight)
    inside = [group == place.where for group in groups(model.flights, model.found, effect.per)]
    return np.asarray(weight * np.array(inside, float))


def pattern_candidates(model: Model) -> list[Candidate]:
    """Patterns in thrust, drag and mass that no effect stands for, each kind of pattern with the same odds.

    Single days, the hour, a lasting change between two flights, every second or third flight.
    """
    flights = model.flights
    number = np.arange(len(flights))
    days = [flight.date_time.date().isoformat() if flight.date_time else "" for flight in flights]
    hours = np.array([f.date_time.hour + f.date_time.minute / 60 if f.date_time else np.nan for f in flights])
    kinds: list[dict[str, Array]] = [
        {
            f"the day {day}": np.array([d == day for d in days], float)
            for day in dict.fromkeys(days)
            if 2 <= days.count(day) <= len(days) - 2
        },
        {"the hour of the day": (hours - hours.mean()) / 4} if np.isfinite(hours).all() and hours.std() > 1 else {},
        {
            f"every flight from {flights[k].flight_id} on": np.where(number >= k, 1.0, 0.0)
            for k in range(3, len(flights) - 2)
        },
        {
            f"every {n} flights, as {flights[k].flight_id}": np.where(number % n == k, 1.0, 0.0)
            for n in (2, 3)
            for k in range(n - (n == 2))
        }
        if len(flights) >= 8
        else {},
    ]
    kinds = [kind for kind in kinds if kind]
    return [
        Candidate(Place("", where), _odd(where, weight), log_share=float(-np.log(len(kind) * len(kinds))))
        for kind in kinds
        for where, weight in kind.items()
    ]


def _odd(name: str, weight: Float[Array, "flight"]) -> tuple[Term, ...]:
    """Drag, thrust and mass that differ without a reason given."""
    return (
        Term(f"drag with {name}", "drag", 0.0, 0.15, weight),
        Term(f"thrust with {name}", "thrust", 0.0, 0.06, weight),
        Term(f"mass with {name}", "mass", 0.0, 0.08, weight),
    )
