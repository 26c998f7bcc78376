"""Candidates for missing effects: every effect, everywhere or in one group of flights."""

from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import Literal

import numpy as np

from fieldkit.flight.short_name import flight_label
from fieldkit.model.rocket_model import Model, Term, strength_term
from fieldkit.model.term_names import TermName
from fieldkit.physics.effect import LOGGED_EFFECTS, Effect, effect_named, effects, spoken
from fieldkit.shapes import Array, Flags, Float

EACH_GROUP = "each"
"""The place of an effect with a separate strength in every group."""
ORDINALS = {2: "second", 3: "third"}
"""The numbers of flights after which patterns repeat, as ordinals."""


@dataclass(frozen=True, slots=True)
class Pattern:
    """Flights that differ from the others without a known effect.

    `of` is the day, the site, the first flight of a lasting or a repeated change, or the header of a column of numbers
    or texts, and `value` the text. A change repeats `every` so many flights. A `smooth` pattern is any smooth function
    of the number.
    """

    kind: Literal["day", "hour", "count", "lasting", "repeated", "site", "number", "text"]
    of: str = ""
    value: str = ""
    every: int = 0
    smooth: bool = False

    def __str__(self) -> str:
        return f"{self.follows}, smoothly" if self.smooth else self.follows

    @property
    def follows(self) -> str:
        """What the pattern correlates with."""
        match self.kind:
            case "hour":
                return "the hour of the day"
            case "count":
                return "the number of flights"
            case "lasting":
                return f"every flight from {self.of} on"
            case "repeated":
                return f"every {self.every} flights, as {self.of}"
            case "day" | "site":
                return f"the {self.kind} {self.of}"
            case "number" | "text":
                return f"{self.of} {self.value}".rstrip()

    @property
    def in_words(self) -> str:
        """For a flyer: `a trend with the hour of the day`, `a change from flight 4 on`."""
        if self.kind == "lasting":
            return f"a change from flight {self.of} on"
        if self.kind == "repeated":
            return f"every {ORDINALS[self.every]} flight, {self.of} among them"
        return f"a trend with {self.follows}" if self.smooth else self.follows


@dataclass(frozen=True, slots=True)
class Switched:
    """How long an effect acted in each flight, as logs show it: the fraction of the coast, weighted by what drag takes.

    `amounts` are those of past flights, by flight id, `usual` that of a flight on which it acts. It acts on a flight
    ahead with the probability `chance`, and does so in this place if it is `ahead`.
    """

    amounts: tuple[tuple[str, float], ...]
    usual: float
    chance: float
    ahead: bool = False


@dataclass(frozen=True, slots=True)
class Place:
    """The flights on which an effect acts: one group (empty for all, `EACH_GROUP` for every group with a separate
    strength), and from which flight on (empty for the first); or those whose logs show it. A pattern has no effect."""

    effect: str = ""
    where: str = ""
    since: str = ""
    pattern: Pattern | None = None
    switched: Switched | None = None

    def __str__(self) -> str:
        if self.pattern:
            return str(self.pattern)
        group = f" of {self._group}" if self.where else ""
        return f"{self.effect}{group}{self._since}"

    @property
    def in_words(self) -> str:
        """For a flyer: an effect by its title, and its flights, `a weak or strong motor (F24)`; a pattern in words."""
        if self.pattern:
            return self.pattern.in_words
        known = self.effect in effects() or self.effect in LOGGED_EFFECTS
        title = effect_named(self.effect).title if known else self.effect
        return f"{title}{f' ({self._group})' if self.where else ''}{self._since}"

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
        return self.pattern.of if self.pattern and self.pattern.kind == "lasting" else self.since

    def starting_at(self, flight_id: str) -> "Place":
        """The same with another flight at which it starts."""
        if self.pattern:
            return replace(self, pattern=replace(self.pattern, of=flight_id))
        return replace(self, since=flight_id)

    def term_name(self, group: str = "") -> TermName:
        """The name of the strength of an effect, or of that in one group of `EACH_GROUP`."""
        if self.where == EACH_GROUP:
            return TermName(self.effect, EACH_GROUP, (group, self.since))
        return TermName(self.effect, "effect", (self.where, self.since) if self.where or self.since else self._ahead)

    @property
    def _ahead(self) -> str:
        """Whether a switched effect acts on flights ahead: forecasts average over terms that do and that do not."""
        return "ahead" if self.switched and self.switched.ahead else ""

    def has(self, name: TermName) -> bool:
        """Whether a term is one of the effect or pattern in this place."""
        if self.pattern:
            return name.level == "pattern" and name.group == self.pattern
        if self.where == EACH_GROUP:
            return (name.quantity, name.level) == (self.effect, EACH_GROUP)
        return name == self.term_name() or (self.switched is not None and name == self.state_name)

    @property
    def state_name(self) -> TermName:
        """The name of what the flights have in common on which a switched effect acts."""
        return TermName(self.effect, "state", self._ahead)


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

    @property
    def own(self) -> tuple[Term, ...]:
        """The terms of the effect or pattern itself, without what its flights have in common otherwise."""
        return self.terms[:1] if self.place.switched else self.terms


SINCE_FRACTION = 0.4
"""Fraction of an effect's prior odds for starting at some later flight. [1]"""


_DISTANCE_OF_HALVES = 2 * (2 / np.pi) ** 0.5
"""Distance between the means of both halves of a normal distribution, in its standard deviations. [1]"""
_IMPULSE_POWER = 2.0
"""Power of the impulse with which the apogee grows without drag. [1]"""


def effect_terms(place: Place, model: Model) -> tuple[Term, ...]:
    """The strength or strengths of an effect in a place, as terms of a model."""
    effect = effect_named(place.effect)
    named = [(place, place.term_name())]
    if place.where == EACH_GROUP:
        kinds = dict.fromkeys(model.groups(effect.per))
        named = [(replace(place, where=kind), place.term_name(kind)) for kind in kinds if kind]
    weights = [(name, place_weight(one, model)) for one, name in named]
    terms = [
        strength_term(name, effect, weight) for name, weight in weights if place.where != EACH_GROUP or weight.any()
    ]
    return (*terms, *([_state_term(place, model)] if place.switched else []))


def _state_term(place: Place, model: Model) -> Term:
    """By how much the flights on which an effect acts would differ without it.

    A controller opens brakes on the flights that would be the highest, a test series on any. Half of rockets, by a
    round judgment, have a controller, which separates the upper half of normally distributed flights from the lower;
    mean and standard deviation are those of this alternative.
    """
    acts = np.asarray(place_weight(place, model) != 0, float)
    half = (
        _DISTANCE_OF_HALVES
        / 2
        * float(
            np.hypot(model.hyperprior.sd("apogee", "flight"), _IMPULSE_POWER * model.hyperprior.sd("thrust", "flight"))
        )
    )
    return Term(place.state_name, "apogee", half, half, acts)


def effect_candidates(model: Model, used_in_fit: Flags, min_flights: int = 2) -> Iterator[Candidate]:
    """Every effect that these flights could show, on all flights and in each group in which it may differ.

    `used_in_fit` marks the flights used in the fit: an effect may start only between them, and acts on `min_flights` of
    them at least. What acts on one is the cause of a single flight (`fieldkit.model.causes`).
    """
    acting = {name: effect for name, effect in effects().items() if _can_act(effect, model)}

    def acts_on(weight: Float[Array, "flight"]) -> int:
        return int(((weight != 0) & used_in_fit).sum())

    def lasting(places: Iterator[Place]) -> list[Place]:
        return [one for one in places if one.where == EACH_GROUP or acts_on(place_weight(one, model)) >= min_flights]

    places = {name: lasting(_groups(name, effect, model)) for name, effect in acting.items()}
    beginnings = {name: lasting(_beginnings(name, effect, model, used_in_fit)) for name, effect in acting.items()}
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
    if effect.needs_delay and not np.isfinite(model.history.delays).any():
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


def _switched_weight(switched: Switched, model: Model) -> Float[Array, "flight"]:
    """What logs show for past flights; for the others what the flyer recorded, or else whether it acts ahead."""
    known, flown = dict(switched.amounts), model.history.flown
    past = [known.get(flight.flight_id) if row < flown else None for row, flight in enumerate(model.flights)]
    usual = [switched.usual * (switched.ahead if own is None else own) for own in model.history.drag_switches]
    return np.array([one if own is None else own for own, one in zip(past, usual, strict=True)], float)


def place_weight(place: Place, model: Model) -> Float[Array, "flight"]:
    """The weight of an effect on each flight: zero outside its place, and increasing for an effect that grows. [1]"""
    if place.switched is not None:
        return _switched_weight(place.switched, model)
    effect = effects()[place.effect]
    names = [flight.flight_id for flight in model.flights]
    first = names.index(place.since) if place.since and place.since in names else 0  # a plan may have no name
    since = np.array(model.history.flight_index) - first
    weight = np.maximum(since, 0.0) if effect.grows else np.where(since >= 0, 1.0, 0.0)
    if effect.lacks:
        weight = weight * np.isnan(model.recorded(effect.lacks))
    if not place.where:
        return np.asarray(weight)
    groups = [model.groups(per) for per in ((effect.per, "lot") if effect.per == "motor" else (effect.per,))]
    inside = [place.where in own for own in zip(*groups, strict=True)]
    return np.asarray(weight * np.array(inside, float))
