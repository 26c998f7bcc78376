"""What could be missing from a rocket's model: every effect, everywhere or in one group of flights, and plain
patterns that no effect explains."""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from fieldkit.loop.model import Model, Term, groups
from fieldkit.shapes import Array, Float
from fieldkit.simulator.effect import Effect, effects
from fieldkit.simulator.field import delays, recorded


@dataclass(frozen=True, slots=True)
class Candidate:
    """One way to extend a model: its terms, and where the fit of them should begin.

    `effect` is the effect's name, or empty for a pattern; `where` names the group it acts in, empty for all
    flights. `starts` are values of the first term from which the fit is begun, each in turn.
    """

    effect: str
    where: str
    terms: tuple[Term, ...]
    starts: tuple[float, ...]

    @property
    def name(self) -> str:
        """`motor_thrust of AeroTech F24W`."""
        return f"{self.effect} of {self.where}" if self.where else self.effect


def effect_term(name: str, effect: Effect, weight: Float[Array, "flight"], where: str = "") -> Term:
    """The strength of an effect as an unknown of a model."""
    prior = effect.prior
    title = f"{name} of {where}" if where else name
    return Term(title, effect, prior.mean, prior.sd, weight, prior.low, prior.high)


def effect_candidates(model: Model) -> Iterator[Candidate]:
    """Every effect that these flights could show, everywhere and in each group it may differ in."""
    for name, effect in effects().items():
        if not _can_act(name, effect, model):
            continue
        starts = (effect.prior.mean, 0.02 * effect.prior.sd) if np.isfinite(effect.prior.low) else (effect.prior.mean,)
        for where, weight in places(effect, model):
            yield Candidate(name, where, (effect_term(name, effect, weight, where),), starts)


def _can_act(name: str, effect: Effect, model: Model) -> bool:
    if name == "early_ejection" and not np.isfinite(delays(model.flights, model.found)).any():
        return False
    if not effect.needs:
        return True
    column = recorded(model.flights, effect.needs)
    return bool(np.nanmax(np.abs(column), initial=0.0) > 0)


def places(effect: Effect, model: Model) -> Iterator[tuple[str, Array]]:
    """Groups of flights an effect may be confined to, each with the weight it has on every flight."""
    if effect.everywhere:
        yield "", place_weight(effect, model, "")
    if not effect.per:
        return
    group = groups(model.flights, model.found, effect.per)
    if len(set(group)) > 1:
        for kind in dict.fromkeys(group):
            if kind:
                yield kind, place_weight(effect, model, kind)


def place_weight(effect: Effect, model: Model, where: str) -> Float[Array, "flight"]:
    """How strongly an effect acts on each flight: only in its place, and growing if it grows."""
    flights = len(model.flights)
    weight = np.arange(flights, dtype=float) if effect.grows else np.ones(flights)
    if not where:
        return weight
    inside = [group == where for group in groups(model.flights, model.found, effect.per)]
    return np.asarray(weight * np.array(inside, float))


def pattern_candidates(model: Model) -> Iterator[Candidate]:
    """Patterns in thrust and drag that no effect stands for: days, hours, a lasting change between two flights."""
    flights = model.flights
    days = [flight.date_time.date().isoformat() if flight.date_time else "" for flight in flights]
    kinds = list(dict.fromkeys(days))
    if 2 < len(kinds) < 0.7 * len(flights):
        for kind in kinds:
            inside = np.array([day == kind for day in days], float)
            if inside.sum() >= 2:
                yield Candidate("", f"the day {kind}", _odd(f"day {kind}", inside), (0.0,))
    hours = [flight.date_time.hour + flight.date_time.minute / 60 if flight.date_time else np.nan for flight in flights]
    if np.isfinite(hours).all() and np.std(hours) > 1:
        yield Candidate("", "the hour of the day", _odd("hour", (np.array(hours) - np.mean(hours)) / 4), (0.0,))
    for first in range(3, len(flights) - 2):
        after = (np.arange(len(flights)) >= first).astype(float)
        label = flights[first].flight_id or str(first + 1)
        yield Candidate("", f"every flight from {label} on", _odd(f"from {label}", after), (0.0,))


def _odd(name: str, weight: Float[Array, "flight"]) -> tuple[Term, ...]:
    """Thrust and drag that differ without a reason given."""
    return (
        Term(f"drag of {name}", "drag", 0.0, 0.15, weight),
        Term(f"thrust of {name}", "thrust", 0.0, 0.06, weight),
    )
