"""What could be missing from a rocket's model: every effect, everywhere or in one group of flights, and plain
patterns that no effect explains."""

from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from fieldkit.flight import Flight
from fieldkit.loop.model import Model, Term, groups
from fieldkit.shapes import Array, Flags, Float
from fieldkit.simulator.effect import Effect, effects, spoken
from fieldkit.simulator.field import delays, recorded

EACH = "each"
"""The place of an effect that has a strength of its own in every group."""


@dataclass(frozen=True, slots=True)
class Place:
    """Where an effect acts: in one group of flights (empty for all, `EACH` for every one with a strength of its
    own), and only from a flight on (empty for from the first)."""

    effect: str
    where: str = ""
    since: str = ""

    def __str__(self) -> str:
        group = f" of {self.where}" if self.where else ""
        if self.where == EACH:
            group = f" of each {effects()[self.effect].per}"
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
        """The name by which a verdict speaks of the effect, or empty for a pattern."""
        return spoken(self.place.effect)


SINCE_SHARE = 0.4
"""Share of an effect's prior odds for beginning at some flight rather than at the first. [1]"""


def effect_terms(place: Place, model: Model) -> tuple[Term, ...]:
    """The strength of an effect in a place, or its strengths, as unknowns of a model."""
    effect = effects()[place.effect]
    prior = effect.prior
    places = [place]
    if place.where == EACH:
        kinds = dict.fromkeys(groups(model.flights, model.found, effect.per))
        places = [Place(place.effect, kind, place.since) for kind in kinds if kind]
    weights = [(one, place_weight(one, model)) for one in places]
    return tuple(
        Term(str(one), effect, prior.mean, prior.sd, weight, prior.low, prior.high)
        for one, weight in weights
        if place.where != EACH or weight.any()
    )


def effect_candidates(model: Model, teach: Flags) -> Iterator[Candidate]:
    """Every effect that these flights could show, everywhere and in each group it may differ in.

    `teach` marks the flights that teach: a beginning is only looked for between them.
    """
    acting = {name: effect for name, effect in effects().items() if _can_act(name, effect, model)}
    places = {name: list(_groups(name, effect, model)) for name, effect in acting.items()}
    forms = Counter(spoken(name) for name in acting if places[name])
    for name, effect in acting.items():
        prior = effect.prior
        starts = effect.starts or ((prior.mean, 0.02 * prior.sd) if np.isfinite(prior.low) else (prior.mean,))
        since = list(_beginnings(name, effect, model, teach))
        share, form = SINCE_SHARE if since else 0.0, forms[spoken(name)]
        for place in places[name]:
            yield Candidate(place, effect_terms(place, model), starts, np.log((1 - share) / len(places[name]) / form))
        for place in since:
            yield Candidate(place, effect_terms(place, model), starts, np.log(share / len(since) / form))


def _can_act(name: str, effect: Effect, model: Model) -> bool:
    if name == "early_ejection" and not np.isfinite(delays(model.flights, model.found)).any():
        return False
    if effect.lacks and np.isfinite(recorded(model.flights, effect.lacks)).all():
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
        if effect.each and len(set(group)) > 1:
            yield Place(name, EACH)
        elif len(set(group)) > 1:
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
    if effect.lacks:
        weight = weight * np.isnan(recorded(model.flights, effect.lacks))
    if not place.where:
        return np.asarray(weight)
    inside = [group == place.where for group in groups(model.flights, model.found, effect.per)]
    return np.asarray(weight * np.array(inside, float))


def pattern_candidates(model: Model) -> list[Candidate]:
    """Patterns in thrust, drag and mass that no effect stands for, each kind of pattern with the same odds.

    Single days, the hour, a lasting change between two flights, every second or third flight, a site, a condition
    that was written down, and whatever else the flyer's own table has a column for.
    """
    kinds = [kind for kind in (*_in_time(model.flights), *_in_columns(model.flights)) if kind]
    return [
        Candidate(Place("", where), _odd(where, weight), log_share=float(-np.log(len(kind) * len(kinds))))
        for kind in kinds
        for where, weight in kind.items()
    ]


Kind = Mapping[str, Float[Array, "flight"]]
"""Patterns of one kind: how each is called, and how strongly it acts on each flight."""


def _in_time(flights: Sequence[Flight]) -> Iterator[Kind]:
    """Patterns in the order and the hours of flying."""
    number = np.arange(len(flights))
    days = [flight.date_time.date().isoformat() if flight.date_time else "" for flight in flights]
    hours = np.array([f.date_time.hour + f.date_time.minute / 60 if f.date_time else np.nan for f in flights])
    yield {f"the day {day}": weight for day, weight in _members(days)}
    if np.isfinite(hours).all() and hours.std() > 1:
        yield {"the hour of the day": (hours - hours.mean()) / 4}
    yield {
        f"every flight from {flights[k].flight_id} on": np.where(number >= k, 1.0, 0.0)
        for k in range(3, len(flights) - 2)
    }
    if len(flights) >= 8:
        yield {
            f"every {n} flights, as {flights[k].flight_id}": np.where(number % n == k, 1.0, 0.0)
            for n in (2, 3)
            for k in range(n - (n == 2))
        }


def _in_columns(flights: Sequence[Flight]) -> Iterator[Kind]:
    """Patterns that go with what was written down of the flights."""
    yield {f"the site {site}": weight for site, weight in _members([flight.site for flight in flights])}
    columns = {name: recorded(flights, name) for name in ("temperature", "humidity", "pressure")}
    for name in dict.fromkeys(name for flight in flights for name in flight.extra):
        texts = [flight.extra.get(name, "") for flight in flights]
        numbers = _numbers(texts)
        if np.isfinite(numbers).all() and len(set(texts)) > MOST_VALUES:
            columns[name] = numbers
        elif 1 < len(set(texts)) <= MOST_VALUES:
            yield {f"{name} {value}": weight for value, weight in _members(texts)}
    for name, column in columns.items():
        if np.isfinite(column).all() and np.ptp(column) > 0:
            yield {f"{name}": (column - column.mean()) / column.std()}


MOST_VALUES = 6
"""Different texts in a column of the flyer's own up to which it is taken to sort flights. [1]"""


def _members(labels: Sequence[str]) -> Iterator[tuple[str, Float[Array, "flight"]]]:
    """The flights of every label that at least two flights bear and two do not."""
    for label in dict.fromkeys(labels):
        if label and 2 <= labels.count(label) <= len(labels) - 2:
            yield label, np.array([own == label for own in labels], float)


def _numbers(texts: Sequence[str]) -> Float[Array, "flight"]:
    """The texts as numbers, nan for those that are none."""
    try:
        return np.array([float(text) for text in texts])
    except ValueError:
        return np.full(len(texts), np.nan)


def _odd(name: str, weight: Float[Array, "flight"]) -> tuple[Term, ...]:
    """Drag, thrust and mass that differ without a reason given."""
    return (
        Term(f"drag with {name}", "drag", 0.0, 0.15, weight),
        Term(f"thrust with {name}", "thrust", 0.0, 0.06, weight),
        Term(f"mass with {name}", "mass", 0.0, 0.08, weight),
    )
