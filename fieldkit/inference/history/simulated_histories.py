"""Simulated histories with their truth: the prior predictive of the model, with additional random deviations.

Everything in the model is drawn from a hyperprior. Each effect in `models/effects` is present with its prior inclusion
probability, with a strength and a place from its priors. Effects that the model always has always act: with the
hyperprior for effects, those that every rocket has; with that for forecasts, those of recorded conditions such as the
wind. The deviations from the model are a drag that differs between burn and coast and near the speed of sound, a little
weathercocking, failures that nobody noticed, standard deviations other than the hyperprior's, and patterns that no
effect represents: permanent changes, single days, every nth flight, smooth functions of recorded conditions.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from fieldkit.inference.history.drawn_rockets import Stock
from fieldkit.inference.history.modeled_rockets import ModeledRocket, modeled_rocket
from fieldkit.inference.history.placed_effects import Candidates, PlacedEffect
from fieldkit.inference.history.unexplained_patterns import unexplained_pattern
from fieldkit.model.random_effects import drawn
from fieldkit.model.readout_data import IS_LOGARITHMIC, OBSERVED_READOUTS, compared, reading_sd
from fieldkit.model.rocket_model import Model, Term, apogee_scatter, scatter_of
from fieldkit.model.shared_prior import SharedPrior
from fieldkit.model.simulated_readouts import bent, shown
from fieldkit.model.term_names import TermName
from fieldkit.physics.effect import Prior, effects
from fieldkit.physics.history import History, together
from fieldkit.shapes import Array, Float

UNEXPLAINED = "unexplained"
"""Name of the prior probability of a pattern that no effect represents."""
MIN_FLIGHTS_OF_PATTERN = 4
"""Minimum number of flights for a pattern. [1]"""
MISTAKES = 0.015
"""Fraction of flights that went wrong without a tag. [1]"""
DRAWS_PER_ROCKET = 4
"""Histories per rocket; they share its flights, whose simulation with every effect takes most of the time of one."""
ROCKETS_PER_BATCH = 25
"""Rockets per batch."""
BACKGROUND = 0.1
"""Standard deviation of the strengths of effects that are always weakly present, relative to the size of a strength by
its prior, the root mean square. Those that cannot be negative have the absolute values of the draws. [1]"""


@dataclass(frozen=True, slots=True)
class SimulatedHistory:
    """A history as recorded, the information from other rockets, and its truth.

    `effects` are the names of the active effects, and `unexplained` is whether a pattern is active. `apogee` is the
    plan's readout [m]; `cd` and `alpha` are logarithms of the plan's drag and thrust [1]. `selects` is whether it comes
    from the hyperprior for effects.
    """

    history: History
    shared: SharedPrior | None
    effects: tuple[str, ...]
    unexplained: bool
    selects: bool
    apogee: float
    cd: float
    alpha: float


def simulated_histories(
    rng: np.random.Generator,
    choice: Stock,
    candidates_of: Candidates,
    inclusion: Mapping[str, float],
    rockets: int = ROCKETS_PER_BATCH,
    draws: int = DRAWS_PER_ROCKET,
    flights: int | None = None,
) -> list[SimulatedHistory]:
    """Histories of this number of rockets, `draws` of each; those whose plan does not reach 3 m are left out.

    `inclusion` has the independent prior probabilities of each effect and of `UNEXPLAINED`; an effect that some flights
    cannot show does not change them. `flights` is the number of flights of each, random by default. Raises
    ImpossibleFlight for a flight without a dry mass, BadValue for a recovery figure or rail direction that cannot be
    read, and DamagedModel if the hyperprior cannot be read.
    """
    some = [modeled_rocket(rng, choice, candidates_of, flights) for _ in range(rockets)]
    kinds = [[_lacks(rng, one, inclusion) for _ in range(draws)] for one in some]
    world = _World(rng, some, kinds, draws)
    readings = world.fly()
    found = []
    for number in range(rockets):
        for draw in range(draws):
            made = world.history(readings, number, draw)
            if made is not None:
                found.append(made)
    return found


@dataclass(frozen=True, slots=True)
class _Lacks:
    """What the plain model of one history lacks: effects with their places, and shifts that no effect represents."""

    placed: tuple[PlacedEffect, ...]
    pattern: dict[str, Float[Array, "flight"]]


def _lacks(rng: np.random.Generator, one: ModeledRocket, inclusion: Mapping[str, float]) -> _Lacks:
    placed = []
    for name in sorted(one.candidates):
        if rng.uniform() >= inclusion[name]:
            continue
        family = one.candidates[name]
        odds = np.exp([candidate.log_fraction for candidate in family])
        placed.append(family[int(rng.choice(len(family), p=odds / odds.sum()))])
    strange = rng.uniform() < inclusion[UNEXPLAINED] and len(one.rocket.used_in_fit) >= MIN_FLIGHTS_OF_PATTERN
    return _Lacks(tuple(placed), unexplained_pattern(rng, one.rocket) if strange else {})


def _background() -> list[str]:
    """Effects that are always weakly present: those that act in flight, and those of recorded conditions."""
    return [name for name, effect in effects().items() if effect.acceleration is not None or effect.needs]


class _World:
    """The rockets of a batch as one model, whose draws are the histories."""

    def __init__(
        self, rng: np.random.Generator, some: Sequence[ModeledRocket], kinds: Sequence[Sequence[_Lacks]], draws: int
    ) -> None:
        self.rng, self.some, self.kinds, self.draws = rng, some, kinds, draws
        lengths = [len(one.rocket.flights) for one in some]
        self.ends = np.cumsum([0, *lengths])
        count = int(self.ends[-1])
        self.scatter_scale, self.reading_scale = np.empty((draws, count)), np.empty((draws, count))
        self.own = np.concatenate([apogee_scatter(one.model) for one in some])
        terms: list[Term] = []
        values: list[Array] = []
        self.scatter = {
            kind: np.zeros((draws, count)) for kind in ("drag", "thrust", "stretch", "delay", "tilt", "mass")
        }
        for number, one in enumerate(some):
            rows = slice(int(self.ends[number]), int(self.ends[number + 1]))
            self._one(one, kinds[number], rows, terms, values)
        known = effects()
        for name in _background():
            prior = known[name].prior
            usual = float(known[name].strength(np.hypot(prior.mean, prior.sd)))
            drawn_sizes = rng.normal(0.0, BACKGROUND * usual, len(some))
            each = np.abs(drawn_sizes) if prior.low >= 0 else drawn_sizes
            each *= [all(term.bends is not known[name] for term in one.always) for one in some]
            terms.append(Term(TermName(name, "background"), known[name], 0.0, 1.0, np.repeat(each, lengths)))
            values.append(np.ones(draws))
        self.model = Model(together([one.model.history for one in some]), tuple(terms), some[0].model.hyperprior)
        self.values = np.stack(values, axis=-1)

    def _one(
        self, one: ModeledRocket, kinds: Sequence[_Lacks], rows: slice, terms: list[Term], values: list[Array]
    ) -> None:
        """Add a rocket's terms and scatter."""
        rng, prior, width = self.rng, one.model.hyperprior, rows.stop - rows.start
        scales = {
            name: scale.median * np.exp(scale.log_sd * np.clip(rng.normal(size=self.draws), -2.2, 2.2))
            for name, scale in (("scatter", prior.scatter), ("reading", prior.reading), ("motors", prior.motors))
            if scale
        }
        self.scatter_scale[:, rows], self.reading_scale[:, rows] = (
            scales["scatter"][:, None],
            scales["reading"][:, None],
        )
        shared = one.shared
        for term in one.model.terms:
            mean, sd = term.mean, term.sd * (scales[term.scaled_by] if term.scaled_by else np.ones(self.draws))
            if shared is not None and term.name in shared.names:
                place = shared.names.index(term.name)
                mean, sd = shared.mean[place], np.full(self.draws, float(np.sqrt(shared.covariance[place, place])))
            self._add(term, rows, terms)
            values.append(np.clip(mean + sd * rng.normal(size=self.draws), term.low, term.high))
        for term in one.always:
            self._add(term, rows, terms)
            values.append(drawn(rng, Prior(term.mean, term.sd, term.low, term.high), self.draws))
        for draw, lacks in enumerate(kinds):
            for candidate in lacks.placed:
                for term in candidate.terms:
                    bounds = Prior(term.mean, term.sd, term.low, term.high)
                    own = np.zeros(self.draws)
                    own[draw] = drawn(rng, bounds, 1)[0]
                    self._add(term, rows, terms)
                    values.append(own)
            for bends, shift in lacks.pattern.items():
                self.scatter[bends][draw, rows] += shift
        for kind in scatter_of(prior):
            tailed = rng.normal(size=(self.draws, width))
            self.scatter[kind.bends][:, rows] += kind.sd * scales[prior.scale_of(kind.bends)][:, None] * tailed

    def _add(self, term: Term, rows: slice, terms: list[Term]) -> None:
        weight = np.zeros(int(self.ends[-1]))
        weight[rows] = term.weight
        terms.append(replace(term, weight=weight))

    def fly(self) -> Float[Array, "draw flight readout"]:
        """The altimeter's readouts in the form that a fit compares; nan if a flight does not leave the pad."""
        rng = self.rng
        readings = shown(self.model, self.values, self.scatter)
        flown = compared(np.stack([readings[name] for name in OBSERVED_READOUTS], axis=-1))
        shape = flown.shape
        tail = self.model.hyperprior.tail
        tailed = rng.normal(size=shape) * np.sqrt(tail / rng.chisquare(tail, shape))
        with np.errstate(over="ignore", invalid="ignore"):
            raw = np.where(IS_LOGARITHMIC, np.exp(flown), flown)
        errors = np.concatenate(
            [
                reading_sd(raw[:, slice(int(a), int(b))], one.model.hyperprior) * np.nan_to_num(one.rocket.sds, nan=1.0)
                for a, b, one in zip(self.ends[:-1], self.ends[1:], self.some, strict=True)
            ],
            axis=1,
        )
        noise = errors * tailed * self.reading_scale[..., None]
        noise[..., 0] = errors[..., 0] * rng.normal(size=shape[:2])
        noise[..., 0] += np.clip(self.own * self.scatter_scale * tailed[..., 0], -1.5, 1.5)
        wrong = rng.uniform(size=shape[:2]) < MISTAKES
        noise[..., 0] += np.where(wrong, np.log(rng.uniform(0.4, 0.85, shape[:2])), 0.0)
        return np.asarray(flown + noise)

    def history(self, readings: Float[Array, "draw flight readout"], number: int, draw: int) -> SimulatedHistory | None:
        """One history; None if its plan does not reach 3 m."""
        one, lacks = self.some[number], self.kinds[number][draw]
        rows = slice(int(self.ends[number]), int(self.ends[number + 1]))
        own, rocket = readings[draw, rows], one.rocket
        plan = own[-1, 0]
        if not np.isfinite(plan) or plan < np.log(3.0):
            return None
        values = np.where(IS_LOGARITHMIC, np.exp(np.clip(own, -20.0, 20.0)), own)
        sds = rocket.sds * reading_sd(values, one.model.hyperprior) * np.where(IS_LOGARITHMIC, values, 1.0)
        flights = []
        for i, flight in enumerate(rocket.flights[:-1]):
            numbers = _numbers(rocket.shows[i], values[i])
            sd = _numbers(tuple(numbers), sds[i])
            source = dict.fromkeys(numbers, rocket.source) if rocket.source else {}
            flights.append(flight.with_changes(**numbers, sd=sd, source=source))
        drag, thrust = (
            bent(self.model, self.values[draw : draw + 1], kind)[0, rows][-1] for kind in ("drag", "thrust")
        )
        return SimulatedHistory(
            replace(one.model.history, flights=(*flights, rocket.flights[-1])),
            one.shared,
            tuple(sorted(candidate.effect for candidate in lacks.placed)),
            bool(lacks.pattern),
            one.selects,
            float(np.exp(plan)),
            float(drag),
            float(thrust),
        )


def _numbers(names: Sequence[str], values: Float[Array, "readout"]) -> dict[str, Any]:
    """The numbers of some readouts by name, without missing ones."""
    found = {name: float(values[OBSERVED_READOUTS.index(name)]) for name in names}
    return {name: value for name, value in found.items() if np.isfinite(value)}
