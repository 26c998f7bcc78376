"""Candidates for missing effects: every effect, everywhere or in one group of flights."""

from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np

from fieldkit.flight.short_name import flight_label
from fieldkit.model.rocket_model import Model, Term
from fieldkit.physics.effect import Effect, effects, spoken
from fieldkit.physics.setups import delays
from fieldkit.shapes import Array, Flags, Float

EACH_GROUP = "each"
"""The place of an effect with a separate strength in every group."""


SMOOTH_SUFFIX = ", smoothly"
"""Suffix of the name of a pattern that is a smooth function of a number."""
LASTING_PREFIX = "every flight from "
"""Start of the name of a lasting change, before the flight at which it starts."""


@dataclass(frozen=True, slots=True)
class Place:
    """The flights on which an effect acts: one group (empty for all, `EACH_GROUP` for every group with a separate
    strength), and from which flight on (empty for the first)."""

    effect: str
    where: str = ""
    since: str = ""

    def __str__(self) -> str:
        if not self.effect:
            return self.where
        group = f" of {self._group}" if self.where else ""
        return f"{self.effect}{group}{self._since}"

    @property
    def in_words(self) -> str:
        """For a flyer: an effect by its title, and its flights, `a weak or strong motor (F24)`; a pattern in words, `a
        trend with the hour of the day`, `a change from flight 4 on`."""
        if self.effect:
            title = effects()[self.effect].title if self.effect in effects() else self.effect
            return f"{title}{f' ({self._group})' if self.where else ''}{self._since}"
        if self.where.endswith(SMOOTH_SUFFIX):
            return f"a trend with {self.where.removesuffix(SMOOTH_SUFFIX)}"
        return self.where.replace(LASTING_PREFIX, "a change from flight ", 1)

    @property
    def _group(self) -> str:
        """The group of flights in words: its name, or `each motor`."""
        return f"each {effects()[self.effect].per}" if self.where == EACH_GROUP else self.where

    @property
    def _since(self) -> str:
        return f" from {flight_label(self.since)} on" if self.since else ""

    @property
    def start(self) -> str:
        """The flight at which an effect or a lasting change starts, empty for none."""
        lasting = not self.effect and self.where.startswith(LASTING_PREFIX)
        return self.where.removeprefix(LASTING_PREFIX).removesuffix(" on") if lasting else self.since

    def starting_at(self, flight_id: str) -> "Place":
        """The same with another flight at which it starts."""
        return replace(self, since=flight_id) if self.since else replace(self, where=f"{LASTING_PREFIX}{flight_id} on")


Averaged = tuple[tuple[float, tuple[Place, ...]], ...]
"""Sets of effects in their places for an averaged forecast, each with its probability."""


@dataclass(frozen=True, slots=True)
class Candidate:
    """One way to extend a model: its terms, and the starting points of their fit.

    `place.effect` is empty for a pattern. `starts` are values of the first term, each a starting point.
    `log_fraction` is the log of its fraction of the prior odds of its effect.
    """

    place: Place
    terms: tuple[Term, ...]
    starts: tuple[float, ...] = (0.0,)
    log_fraction: float = 0.0

    @property
    def effect(self) -> str:
        """The name of the effect in a verdict, or empty for a pattern."""
        return spoken(self.place.effect)


SINCE_FRACTION = 0.4
"""Fraction of an effect's prior odds for starting at some later flight. [1]"""


def effect_terms(place: Place, model: Model) -> tuple[Term, ...]:
    """The strength or strengths of an effect in a place, as terms of a model."""
    effect = effects()[place.effect]
    prior = effect.prior
    places = [place]
    if place.where == EACH_GROUP:
        kinds = dict.fromkeys(model.groups(effect.per))
        places = [Place(place.effect, kind, place.since) for kind in kinds if kind]
    weights = [(one, place_weight(one, model)) for one in places]
    return tuple(
        Term(str(one), effect, prior.mean, prior.sd, weight, prior.low, prior.high)
        for one, weight in weights
        if place.where != EACH_GROUP or weight.any()
    )


def effect_candidates(model: Model, used_in_fit: Flags) -> Iterator[Candidate]:
    """Every effect that these flights could show, on all flights and in each group in which it may differ.

    `used_in_fit` marks the flights used in the fit: an effect may start only between them.
    """
    acting = {name: effect for name, effect in effects().items() if _can_act(effect, model)}
    places = {name: list(_groups(name, effect, model)) for name, effect in acting.items()}
    beginnings = {name: list(_beginnings(name, effect, model, used_in_fit)) for name, effect in acting.items()}
    forms = Counter(spoken(name) for name in acting if places[name] or beginnings[name])
    for name, effect in acting.items():
        prior = effect.prior
        starts = effect.starts or ((prior.mean, 0.02 * prior.sd) if np.isfinite(prior.low) else (prior.mean,))
        since = beginnings[name]
        late, form = (SINCE_FRACTION if places[name] else 1.0) if since else 0.0, forms[spoken(name)]
        for place in places[name]:
            yield Candidate(place, effect_terms(place, model), starts, np.log((1 - late) / len(places[name]) / form))
        for place in since:
            yield Candidate(place, effect_terms(place, model), starts, np.log(late / len(since) / form))


def _can_act(effect: Effect, model: Model) -> bool:
    if effect.needs_delay and not np.isfinite(delays(model.flights, model.found)).any():
        return False
    if effect.lacks and np.isfinite(model.recorded(effect.lacks)).all():
        return False
    if not effect.needs:
        return True
    column = model.recorded(effect.needs)
    return bool(np.nanmax(np.abs(column), initial=0.0) > 0)


def _groups(name: str, effect: Effect, model: Model) -> Iterator[Place]:
    """Groups of flights to which an effect may be limited."""
    if not effect.from_first:
        return
    if effect.everywhere:
        yield Place(name)
    if effect.per:
        group = model.groups(effect.per)
        if effect.each and len(set(group)) > 1:
            yield Place(name, EACH_GROUP)
        elif len(set(group)) > 1:
            acts = np.isnan(model.recorded(effect.lacks)) if effect.lacks else np.ones(len(group), bool)
            yield from (Place(name, kind) for kind in dict.fromkeys(np.array(group)[acts].tolist()) if kind)
    if effect.per == "motor" and not effect.each:
        yield from (Place(name, lot) for lot in _different_lots(model))


def _different_lots(model: Model) -> list[str]:
    """The lots of the motor types that were flown from several."""
    pairs = dict.fromkeys(pair for pair in zip(model.groups("motor"), model.groups("lot"), strict=True) if pair[1])
    count = Counter(motor for motor, _ in pairs)
    return [lot for motor, lot in pairs if count[motor] > 1]


def _beginnings(name: str, effect: Effect, model: Model, used_in_fit: Flags) -> Iterator[Place]:
    """Flights of each group at which an effect may start, with a flight used in the fit on either side."""
    if not effect.starts_anywhere:
        return
    group = model.groups(effect.per) if effect.per else [""] * len(model.flights)
    several = len(set(group)) > 1
    for kind in dict.fromkeys(group):
        rows = [row for row, own in enumerate(group) if own == kind and used_in_fit[row]]
        margin = 1 if len(rows) < 6 else 2
        for row in rows[margin : len(rows) - margin + 1]:
            yield Place(name, kind if several else "", model.flights[row].flight_id)


def place_weight(place: Place, model: Model) -> Float[Array, "flight"]:
    """The weight of an effect on each flight: zero outside its place, and increasing for an effect that grows. [1]"""
    effect = effects()[place.effect]
    names = [flight.flight_id for flight in model.flights]
    first = names.index(place.since) if place.since and place.since in names else 0  # a plan may have no name
    since = np.array(model.flight_index) - first
    weight = np.maximum(since, 0.0) if effect.grows else np.where(since >= 0, 1.0, 0.0)
    if effect.lacks:
        weight = weight * np.isnan(model.recorded(effect.lacks))
    if not place.where:
        return np.asarray(weight)
    groups = [model.groups(per) for per in ((effect.per, "lot") if effect.per == "motor" else (effect.per,))]
    inside = [place.where in own for own in zip(*groups, strict=True)]
    return np.asarray(weight * np.array(inside, float))
