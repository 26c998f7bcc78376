"""Simulated histories of the one model, with their truth, not linearized.

How closely a flyer keeps to documents, and the scales of scatter, motors and readings, are drawn from their
heavy-tailed priors as in `fieldkit.model.scale`, all other parameters of the model given those. Each effect is present
with its prior inclusion probability, with a strength and a place from its priors, and every flight may have a cause of
`fieldkit.model.causes` with its prevalence. Beyond the model go patterns that no effect represents, and single readouts
that were not recorded.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from fieldkit.errors import FieldkitError
from fieldkit.inference.history.placed_effects import PlacedEffect
from fieldkit.model.causes import (
    CAUSES,
    DEGREES_OF_LAUNCH_ANGLE,
    EJECT_ERROR,
    LOG_SD,
    MISREAD_LOG_SD,
    NAMES,
    OTHER_MOTOR_SD,
    USUAL_PROBABILITY,
)
from fieldkit.model.documents import SEARCH_PRIOR, power
from fieldkit.model.readout_data import IS_LOGARITHMIC, OBSERVED_READOUTS, compared, reading_sd
from fieldkit.model.rocket_model import Model, Term, apogee_scatter, base_model, scatter_of, usual_terms
from fieldkit.model.simulated_readouts import shown
from fieldkit.physics.effect import Prior
from fieldkit.physics.history import History, history_of, together
from fieldkit.selection.prior import UNEXPLAINED
from fieldkit.selection.quick_candidates import quick_candidates
from fieldkit.shapes import Array, Float, Int, Integers
from studies.quick_network.drawn_rockets import DrawnRocket, Stock, coast_time, draw_rocket
from studies.quick_network.unexplained_patterns import unexplained_pattern

DRAWS = 3
"""Histories of each rocket, which share its flights and the simulation of their response."""
MIN_FLIGHTS_OF_PATTERN = 4
"""Minimum number of flights for a pattern. [1]"""
MAX_LOG_RATIO = 1.5
"""Limit of the scatter of a log apogee, because the tail of a Student t has no physical bound. [1]"""
DOCUMENTS_RANGE, SCALE_RANGE = (0.05, 4.0), (0.1, 4.0)
"""Bounds of the scale of documents and of the other scales. [1]"""
BENT = ("drag", "thrust", "stretch", "delay", "tilt", "mass")
"""Properties of single flights that scatter and causes change."""
USUAL = len(NAMES)
"""The index of a flight without a cause."""


@dataclass(frozen=True, slots=True)
class WorldHistory:
    """A history as recorded and its truth: the active `effects`, whether a pattern is active, the index of each flown
    flight's cause in `NAMES` or `USUAL`, and the reading of the planned apogee [m]. `rocket` numbers the rockets of a
    batch."""

    history: History
    rocket: int
    effects: tuple[str, ...]
    unexplained: bool
    causes: Int[Integers, "flight"]
    apogee: float


@dataclass(frozen=True, slots=True)
class _Rocket:
    drawn: DrawnRocket
    model: Model
    candidates: Mapping[str, Sequence[PlacedEffect]]
    coast: Float[Array, "flight"]


def secant(rng: np.random.Generator, median: float, sd: float, bounds: tuple[float, float]) -> float:
    """A scale whose logarithm is hyperbolic secant, within bounds: the inverse of its distribution function. [1]"""
    while True:
        x = median * np.exp(2 * sd / np.pi * np.log(np.tan(np.pi / 2 * rng.uniform())))
        if bounds[0] <= x <= bounds[1]:
            return float(x)


def _rocket(rng: np.random.Generator, choice: Stock, flights: int | None) -> _Rocket:
    rocket = draw_rocket(rng, choice, flights)
    source = {"source": dict.fromkeys(OBSERVED_READOUTS, rocket.source)} if rocket.source else {}
    placeholders = [  # the biases in the model depend on which readouts there are, and on their sources
        flight.with_changes(**dict.fromkeys(names, 1.0), **source)
        for flight, names in zip(rocket.flights, rocket.shows, strict=False)
    ]
    used = rocket.used_in_fit
    history = history_of((*placeholders, rocket.flights[-1]), rocket.found, len(used), used_in_fit=used)
    model = base_model(history, SEARCH_PRIOR)
    model = model.with_terms(*usual_terms(model))
    candidates: dict[str, list[PlacedEffect]] = {}
    for candidate in quick_candidates(model):
        if candidate.effect:
            candidates.setdefault(candidate.effect, []).append(candidate)
    areas = [0.6 * np.pi / 4 * (flight.diameter or 0.04) ** 2 for flight in rocket.flights]
    coasts = [
        coast_time(motor.motor, flight.dry_mass or 0.1, area)
        for motor, flight, area in zip(rocket.found, rocket.flights, areas, strict=True)
    ]
    return _Rocket(rocket, model, candidates, np.array(coasts))


def simulated_histories(
    rng: np.random.Generator,
    choice: Stock,
    inclusion: Mapping[str, float],
    rockets: int,
    flights: int | None = None,
) -> list[WorldHistory]:
    """`DRAWS` histories of each of some rockets, without those whose plan does not reach 3 m; `inclusion` are the prior
    probabilities of the effects and of `UNEXPLAINED`."""
    some: list[_Rocket] = []
    while len(some) < rockets:
        try:
            some.append(_rocket(rng, choice, flights))
        except FieldkitError:  # a motor too strong or weak for the rocket
            continue
    return _Batch(rng, some, inclusion).histories()


class _Batch:
    """Rockets as one model, whose draws are the histories."""

    def __init__(self, rng: np.random.Generator, some: Sequence[_Rocket], inclusion: Mapping[str, float]) -> None:
        self.rng, self.some, self.inclusion = rng, some, inclusion
        self.ends = np.cumsum([0, *(len(one.drawn.flights) for one in some)])
        shape = (DRAWS, int(self.ends[-1]))
        self.scatter = {kind: np.zeros(shape) for kind in BENT}
        self.own, self.reading = np.zeros(shape), np.ones(shape)
        self.causes, self.misread = np.full(shape, USUAL), np.zeros((*shape, len(OBSERVED_READOUTS)))
        self.terms: list[Term] = []
        self.values: list[Array] = []
        self.effects: list[list[tuple[str, ...]]] = []
        self.strange: list[list[bool]] = []
        for number, one in enumerate(some):
            self._add(one, slice(int(self.ends[number]), int(self.ends[number + 1])))

    def _add(self, one: _Rocket, rows: slice) -> None:
        """A rocket's terms, scatter, effects and causes."""
        rng, prior, width = self.rng, one.model.hyperprior, rows.stop - rows.start
        scatter, reading = (
            [secant(rng, scale.median, scale.spread, SCALE_RANGE) for _ in range(DRAWS)]
            for scale in (prior.scatter, prior.reading)
        )
        motors = [secant(rng, 1.0, prior.motors.spread if prior.motors else 0.1, SCALE_RANGE) for _ in range(DRAWS)]
        documents = np.array([secant(rng, 1.0, np.pi / 2, DOCUMENTS_RANGE) for _ in range(DRAWS)])
        factors = {"": np.ones(DRAWS), "scatter": np.array(scatter), "reading": np.array(reading)}
        for term in one.model.terms:
            sd = term.sd * factors[term.scaled_by] * documents ** power(term.name.quantity, term.name.level)
            self._term(term, rows, np.clip(term.mean + sd * rng.normal(size=DRAWS), term.low, term.high))
        tail = np.sqrt(prior.tail / rng.chisquare(prior.tail, (DRAWS, width)))
        for kind in scatter_of(prior):
            scale = np.array(motors if prior.scale_of(kind.bends) == "motors" else scatter)
            self.scatter[kind.bends][:, rows] += kind.sd * scale[:, None] * rng.normal(size=(DRAWS, width))
        own = apogee_scatter(one.model) * np.array(scatter)[:, None] * tail * rng.normal(size=(DRAWS, width))
        self.own[:, rows] = np.clip(own, -MAX_LOG_RATIO, MAX_LOG_RATIO)
        self.reading[:, rows] = np.array(reading)[:, None]
        present: list[tuple[str, ...]] = []
        strange: list[bool] = []
        for draw in range(DRAWS):
            names = [name for name in sorted(one.candidates) if rng.uniform() < self.inclusion[name]]
            for name in names:
                family = one.candidates[name]
                odds = np.exp([candidate.log_fraction for candidate in family])
                for term in family[int(rng.choice(len(family), p=odds / odds.sum()))].terms:
                    values = np.zeros(DRAWS)
                    values[draw] = drawn(rng, Prior(term.mean, term.sd, term.low, term.high), 1)[0]
                    self._term(term, rows, values)
            pattern = rng.uniform() < self.inclusion[UNEXPLAINED] and width > MIN_FLIGHTS_OF_PATTERN
            for bends, shift in (unexplained_pattern(rng, one.drawn) if pattern else {}).items():
                self.scatter[bends][draw, rows] += shift
            self._causes(one, rows, draw)
            present.append(tuple(names))
            strange.append(bool(pattern))
        self.effects.append(present)
        self.strange.append(strange)

    def _term(self, term: Term, rows: slice, values: Float[Array, "draw"]) -> None:
        weight = np.zeros(int(self.ends[-1]))
        weight[rows] = term.weight
        self.terms.append(replace(term, weight=weight))
        self.values.append(values)

    def _causes(self, one: _Rocket, rows: slice, draw: int) -> None:
        """Causes of single flights; the plan is a usual flight or has one too, like the flown ones."""
        rng, odds = self.rng, [*(cause.prevalence for cause in CAUSES.values()), USUAL_PROBABILITY]
        delays = one.model.history.delays
        for place, cause in enumerate(rng.choice(len(odds), rows.stop - rows.start, p=odds).tolist()):
            if cause == USUAL:
                continue
            row, name = rows.start + place, NAMES[cause]
            strength = CAUSES[name].median * float(np.exp(LOG_SD * rng.normal()))
            side = float(rng.choice((-1.0, 1.0)))
            bends: dict[str, float] = {}
            if name == "weak_motor":
                bends = {"thrust": -strength}
            elif name == "other_motor":
                bends = {"thrust": OTHER_MOTOR_SD * rng.normal(), "stretch": OTHER_MOTOR_SD * rng.normal()}
            elif name == "extra_drag":
                bends = {"drag": strength}
            elif name == "arc":
                bends = {"tilt": (min(strength, 80.0) / DEGREES_OF_LAUNCH_ANGLE) ** 2}
            elif name == "mass":
                bends = {"mass": side * strength}
            elif name == "misread":
                shows = one.drawn.shows[place] if place < len(one.drawn.shows) else ()
                if not shows:
                    continue
                column = OBSERVED_READOUTS.index(str(rng.choice(shows)))
                error = side * CAUSES[name].median * float(np.exp(MISREAD_LOG_SD * rng.normal()))
                self.misread[draw, row, column] = error if IS_LOGARITHMIC[column] else EJECT_ERROR * error
            elif np.isfinite(delays[place]):
                early = one.coast[place] * rng.uniform(0.1, 0.9)
                if name == "early_ejection" and early >= delays[place]:
                    continue
                at = early if name == "early_ejection" else delays[place] + strength
                bends = {"delay": float(np.log(at / delays[place]))}
            else:
                continue
            for kind, amount in bends.items():
                self.scatter[kind][draw, row] += amount
            self.causes[draw, row] = cause

    def histories(self) -> list[WorldHistory]:
        """Fly all, and record what each altimeter shows."""
        rng = self.rng
        model = Model(together([one.model.history for one in self.some]), tuple(self.terms), SEARCH_PRIOR, coarse=True)
        readings = shown(model, np.stack(self.values, axis=-1), self.scatter)
        flown = compared(np.stack([readings[name] for name in OBSERVED_READOUTS], axis=-1))
        tail = SEARCH_PRIOR.tail
        error = rng.normal(size=flown.shape) * np.sqrt(tail / rng.chisquare(tail, flown.shape))
        with np.errstate(over="ignore", invalid="ignore"):
            raw = np.where(IS_LOGARITHMIC, np.exp(flown), flown)
        recorded = np.concatenate([one.drawn.sds for one in self.some])
        sd = reading_sd(raw, SEARCH_PRIOR) * np.nan_to_num(recorded, nan=1.0)
        noise = sd * error * self.reading[..., None]
        noise[..., 0] = sd[..., 0] * rng.normal(size=noise.shape[:2]) + self.own
        values = flown + noise + self.misread
        whole = [self._one(values, sd, number, draw) for number in range(len(self.some)) for draw in range(DRAWS)]
        return [one for one in whole if one is not None]

    def _one(self, values: Array, sd: Array, number: int, draw: int) -> WorldHistory | None:
        one, rows = self.some[number], slice(int(self.ends[number]), int(self.ends[number + 1]))
        own, plan = values[draw, rows], values[draw, rows][-1, 0]
        if not np.isfinite(plan) or plan < np.log(3.0):
            return None
        raw = np.where(IS_LOGARITHMIC, np.exp(np.clip(own, -20.0, 20.0)), own)
        spread = np.where(np.isfinite(one.drawn.sds), sd[draw, rows], np.nan) * np.where(IS_LOGARITHMIC, raw, 1.0)
        flights = []
        for place, flight in enumerate(one.drawn.flights[:-1]):
            columns = {name: OBSERVED_READOUTS.index(name) for name in one.drawn.shows[place]}
            numbers = {name: float(raw[place, i]) for name, i in columns.items() if np.isfinite(own[place, i])}
            sds = {name: float(spread[place, columns[name]]) for name in numbers}
            source = dict.fromkeys(numbers, one.drawn.source) if one.drawn.source else {}
            sds = {name: value for name, value in sds.items() if np.isfinite(value)}
            flights.append(flight.with_changes(**numbers, sd=sds, source=source))
        history = replace(one.model.history, flights=(*flights, one.drawn.flights[-1]))
        causes = self.causes[draw, rows][:-1]
        strange = self.strange[number][draw]
        return WorldHistory(history, number, self.effects[number][draw], strange, causes, float(np.exp(plan)))


def drawn(rng: np.random.Generator, prior: Prior, count: int) -> Float[Array, "flight"]:
    """Draws of a prior, within its bounds, in the unit of the effect.

    Source: rejection of draws out of bounds, von Neumann (1951), which gives the truncated normal distribution.
    """
    values = rng.normal(prior.mean, prior.sd, count)
    while (beyond := (values < prior.low) | (values > prior.high)).any():
        values[beyond] = rng.normal(prior.mean, prior.sd, int(beyond.sum()))
    return np.asarray(values)
