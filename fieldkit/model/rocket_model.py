"""The flight model of one rocket: the unknown parameters and their priors.

Every parameter is a `Term`: a normal prior, possibly truncated, and the weight with which it acts on each flight. Terms
that act on many flights are shared (drag of the rocket, thrust of a motor type, strength of an effect); what varies
from flight to flight is scatter, drawn for each flight.
"""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field, replace
from typing import Any, Literal, TypeVar

import numpy as np

from fieldkit.flight import Flight
from fieldkit.model.documents import SEARCH_PRIOR
from fieldkit.model.fleet_drift import Period, years, years_passed
from fieldkit.model.hyperprior import FROM_DEVICES, FROM_LOGS, QUANTITIES, READOUTS, Hyperprior
from fieldkit.model.shared_prior import SharedPrior
from fieldkit.model.sources import IN_SAMPLES, has_log, measured_by
from fieldkit.model.term_names import SHARED_LEVELS, TermName, fleet_term
from fieldkit.motors import Found
from fieldkit.physics.effect import Effect, Prior, effects
from fieldkit.physics.history import History
from fieldkit.shapes import Array, Float

OPENING = TermName("opening")
"""The term for the time from the ejection charge to an open parachute. [s]"""

T = TypeVar("T")
FlownFlight = tuple[Flight, Found]
FlownFlights = Sequence[FlownFlight]
Bends = Literal["drag", "thrust", "stretch", "delay", "tilt", "mass", "opening"]


@dataclass(frozen=True, slots=True)
class Term:
    """One parameter: what it changes, its prior, and how strongly it acts on each flight.

    `bends` is a property of the flight, the name of a readout (a bias of the reading, as a ratio), or an effect. `low`
    and `high` truncate the prior; like `mean` and `sd` they are in the unit of what the term changes. `scaled_by` names
    the scale that multiplies its standard deviation, if there is one: a rocket with much scatter is known less well,
    and a noisy device has a larger bias.
    """

    name: TermName
    bends: Bends | str | Effect
    mean: float
    sd: float
    weight: Float[Array, "flight"]
    low: float = -np.inf
    high: float = np.inf
    scaled_by: Literal["", "scatter", "reading"] = ""


def strength_term(name: TermName, effect: Effect, weight: Float[Array, "flight"], prior: Prior | None = None) -> Term:
    """The strength of an effect as a term, in its unit, by default with the prior of one that a model lacks."""
    own = prior or effect.prior
    return Term(name, effect, own.mean, own.sd, weight, own.low, own.high)


@dataclass(frozen=True, slots=True)
class Scatter:
    """A random effect of single flights: what it changes, and its standard deviation around zero in that unit."""

    bends: str
    sd: float


@dataclass(frozen=True, slots=True)
class Model:
    """A rocket's flights in the order flown, and their shared parameters.

    `hyperprior` has the standard deviations, and `shared` the information from other rockets in the ledger about the
    terms they have in common with this one. A `coarse` model simulates at the resolution `COARSE_RESOLUTION`,
    to fit flights or to try hundreds of motors at once.
    """

    history: History
    terms: tuple[Term, ...]
    hyperprior: Hyperprior = SEARCH_PRIOR
    shared: SharedPrior | None = None
    coarse: bool = False
    departure: tuple[float, ...] = ()
    _known: dict[str, Any] = field(init=False, repr=False, compare=False, default_factory=dict)

    @property
    def flights(self) -> tuple[Flight, ...]:
        """The flights in the order flown."""
        return self.history.flights

    @property
    def found(self) -> tuple[Found, ...]:
        """The motor of each flight."""
        return self.history.found

    @property
    def names(self) -> list[TermName]:
        """Names of the terms, in order."""
        return [term.name for term in self.terms]

    @property
    def scatter(self) -> tuple[Scatter, ...]:
        """The random effects of single flights, with the errors of their recorded weather in standard deviations."""
        return (*scatter_of(self.hyperprior), *(Scatter(name, 1.0) for name in self.history.uncertain))

    def scatter_scales(self) -> Float[Array, "scale scatter"]:
        """The scale of each random effect of single flights, for every point of the grid of scales. [1]"""
        scatter = self.hyperprior.scales()[0]
        grids = {"scatter": scatter, "motors": self.hyperprior.motor_scales(), "": np.ones_like(scatter)}
        return np.stack([grids[self.hyperprior.scale_of(one.bends)] for one in self.scatter], axis=-1)

    def recorded(self, name: str) -> Float[Array, "flight"]:
        """One number of every flight in SI, nan if it was not recorded."""
        return self.history.column(name)

    def groups(self, per: str) -> list[str]:
        """The group each flight belongs to, as in `History.groups`."""
        return self.history.groups(per)

    def once(self, name: str, compute: Callable[[], T]) -> T:
        """The result of a computation that depends only on this model, saved under a name, because candidates and steps
        of a fit ask for it again and again."""
        if name not in self._known:
            self._known[name] = compute()
        found: T = self._known[name]
        return found

    def with_terms(self, *terms: Term) -> "Model":
        """A copy with more terms."""
        return replace(self, terms=(*self.terms, *terms))

    def with_prior(self, name: TermName, mean: float, sd: float | None = None) -> "Model":
        """A copy with another prior mean, and standard deviation if `sd` is given, of a term, in its unit."""
        terms = (replace(term, mean=mean, sd=sd or term.sd) if term.name == name else term for term in self.terms)
        return replace(self, terms=tuple(terms))

    def only(self, terms: Sequence[int]) -> "Model":
        """A copy with only some of the terms."""
        return replace(self, terms=tuple(self.terms[i] for i in terms))

    def part(self, rows: slice) -> "Model":
        """A copy with only some of the flights."""
        terms = tuple(replace(term, weight=term.weight[rows]) for term in self.terms)
        return replace(self, history=self.history.part(rows), departure=self.departure[rows], terms=terms)


def base_model(
    history: History,
    hyperprior: Hyperprior = SEARCH_PRIOR,
    shared: SharedPrior | None = None,
    period: Period | None = None,
) -> Model:
    """The model of a rocket without effects: every random effect of the hyperprior for which there is a group.

    `shared` is as in `Model`. `period` is the fleet's, by default that of `shared` or else of these flights. Raises
    ImpossibleFlight for a flight without a dry mass.
    """
    times = [flight.date_time for flight in history.flights]
    passed = years_passed(years(times, history.flown, period or (shared.period if shared else None)))
    kinds = [name for name in QUANTITIES if name not in FROM_LOGS or any(map(has_log, history.flights))]
    terms = [term for quantity in kinds for term in _quantity_terms(quantity, history, hyperprior, passed)]
    if not history.diameter_known:
        terms = [
            replace(term, sd=float(np.hypot(term.sd, hyperprior.unknown_area)))
            if term.name == TermName("drag")
            else term
            for term in terms
        ]
    terms.append(Term(OPENING, "opening", *hyperprior.opening, np.ones(len(history.flights)), low=0.0))
    return with_shared(Model(history, tuple(terms), hyperprior), shared)


def with_shared(model: Model, shared: SharedPrior | None) -> Model:
    """The model with the information from other rockets about the terms that it shares with them."""
    own, scatter = shared.only(model.names) if shared else None, model.hyperprior.scatter
    if shared and shared.scatter and scatter.spread:
        scatter = scatter.pooled(shared.scatter)
        model = replace(model, hyperprior=replace(model.hyperprior, scatter=scatter))
    if own is None or not own.names:
        return replace(model, shared=None)
    means = dict(zip(own.names, own.mean.tolist(), strict=True))
    terms = tuple(replace(term, mean=means.get(term.name, term.mean)) for term in model.terms)
    return replace(model, terms=terms, shared=own)


def _quantity_terms(
    quantity: str, history: History, hyperprior: Hyperprior, passed: Float[Array, "year flight"]
) -> Iterator[Term]:
    """The random effects of one quantity, widest group first; the widest holds the mean."""
    every, mean = np.ones(len(history.flights)), hyperprior.mean(quantity)
    recorded = [flight.readout(quantity) for flight in history.flights] if quantity in READOUTS else []
    if quantity in FROM_DEVICES and (sd := hyperprior.sd(quantity, "logged")):
        logged = measured_by(IN_SAMPLES, recorded)
        if logged.any():
            yield Term(TermName(quantity, "logged"), quantity, 0.0, sd, logged)
        every = every - logged
        if not every.any():
            return
    scaled: Literal["", "scatter", "reading"] = "reading" if quantity in READOUTS and quantity != "apogee" else ""
    scaled = scaled if hyperprior.kind == "learned" else ""
    if sd := hyperprior.fleet_sd(quantity):
        yield Term(fleet_term(quantity), quantity, mean, sd, every)
        mean = 0.0
    if sd := hyperprior.sd(quantity, "drift"):
        for year, part in enumerate(passed, start=1):
            yield Term(TermName(quantity, "drift", year), quantity, 0.0, sd, part)
    if sd := hyperprior.sd(quantity, "rocket"):
        yield Term(TermName(quantity), quantity, mean, sd, every, scaled_by=scaled)
    if (sd := hyperprior.sd(quantity, "ports")) and (barometric := measured_by(("baro",), recorded)).any():
        yield Term(TermName(quantity, "ports"), quantity, 0.0, sd, barometric)
    for level in ("config", "motor", "lot", "rocket_motor", "day"):
        if not (sd := hyperprior.sd(quantity, level)):
            continue
        group = history.groups("motor" if level == "rocket_motor" else level)
        kinds = _shared_days(group, history.flown) if level == "day" else list(dict.fromkeys(group))
        for kind in filter(None, kinds) if level == "lot" else kinds:
            weight = every * np.array([own == kind for own in group], float)
            lasts = level == "rocket_motor" and hyperprior.documents  # how large it is, its own scale says
            scaled = "scatter" if level in ("rocket_motor", "day") and not lasts else ""
            yield Term(TermName(quantity, level, kind), quantity, 0.0, sd, weight, scaled_by=scaled)


def _shared_days(days: Sequence[str], flown: int) -> list[str]:
    """Days with more than one of the first `flown` flights; the effect of a day with one flight is part of its
    scatter."""
    return [day for day in dict.fromkeys(days[:flown]) if day and days.count(day) > 1]


def usual_terms(model: Model) -> list[Term]:
    """The terms of effects that every rocket has, on all flights; the learned hyperprior has them in its random
    effects."""
    if model.hyperprior.kind != "certified" and not model.hyperprior.documents:
        return []
    every = np.ones(len(model.flights))
    return [
        strength_term(TermName(name, "usual"), effect, every, effect.background)
        for name, effect in effects().items()
        if effect.background is not None
    ]


def shared_names(model: Model) -> list[TermName]:
    """The terms that other rockets of the same ledger also have: for the fleet, for motor types and their lots."""
    return [name for name in model.names if name.level in SHARED_LEVELS]


def scatter_of(hyperprior: Hyperprior) -> tuple[Scatter, ...]:
    """The random effects of single flights, including those of days with one flight."""
    kinds = ("thrust", "drag", "stretch", "delay", "tilt")
    return tuple(Scatter(kind, sd) for kind in kinds if (sd := hyperprior.sd(kind, "flight")))


def apogee_scatter(model: Model) -> Float[Array, "flight"]:
    """Standard deviation of the log apogee of single flights in addition to the effect of scatter in thrust and drag.
    [1]

    Derivation: variances of independent deviations add, per flight and, if a day has no term of its own, per day.
    """
    return model.once("apogee scatter", lambda: _apogee_scatter(model))


def _apogee_scatter(model: Model) -> Float[Array, "flight"]:
    flight, day = model.hyperprior.sd("apogee", "flight"), model.hyperprior.sd("apogee", "day")
    scaled = np.array(model.departure) if model.departure else np.ones(len(model.flights))
    if not day:
        return flight * scaled
    names = set(model.names)
    alone = np.array([TermName("apogee", "day", own) not in names for own in model.groups("day")])
    return np.asarray(np.hypot(flight, day * alone) * scaled)
