"""The flights of a rocket beside their forecasts without them: by how much each missed, and what went wrong, if it did.

The model is that of the forecasts, averaged over the sets of effects that they use.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from fieldkit.flight import Flight
from fieldkit.flight.plausibility import not_measured
from fieldkit.forecast.assumed import FLIGHTS_ALONE, Assumed
from fieldkit.forecast.predict import Fits, fitted
from fieldkit.inference.laplace.one_offs import OneOffs, one_offs
from fieldkit.model.causes import CAUSES, NAMES
from fieldkit.model.readout_data import IS_LOGARITHMIC, OBSERVED_READOUTS, observe
from fieldkit.model.rocket_model import FlownFlights
from fieldkit.motors import Found
from fieldkit.physics.history import flown_and_planned
from fieldkit.selection.candidates import Averaged, Place
from fieldkit.shapes import Array, Float

SINGLED_OUT = 0.5
"""Probability of being a one-off above which a flight is singled out. [1]"""
SUGGESTED = 0.5
"""A tag is suggested for the most probable cause, and for others at least this fraction as probable. [1]"""

NORMAL_95 = 1.645
"""The 95% quantile of the standard normal distribution. [1]"""
JUDGED_BY = 0.9
"""Probability of the sets of effects that flights are compared with: the others hardly change what a flight misses by.
[1]"""


@dataclass(frozen=True, slots=True)
class PossibleCause:
    """A cause of a flight, its probability [1], and its expected strength in its `unit`."""

    cause: str
    probability: float
    strength: float
    unit: str


@dataclass(frozen=True, slots=True)
class Impossible:
    """A readout that cannot be a measurement: the reason, and the log of its ratio to the simulated one, nan if the
    model does not compare it so. [1]"""

    reason: str
    log_ratio: float


@dataclass(frozen=True, slots=True)
class FlightBesideOthers:
    """A flight compared with the forecast without it.

    `forecast` is the apogee to expect from the other flights, `miss` the flown one minus it, with the standard
    deviation of a usual flight; nan without an apogee. [m] `departures` has the difference of every readout that the
    model compares from its expectation and its standard deviation, as log ratios or for the time to ejection in
    seconds. `probability` is that of being a one-off, `causes` the possible ones, the most probable first. No fit uses
    the readouts in `impossible`, so the flight may be a usual one beside them.
    """

    flight: Flight
    forecast: float
    miss: float
    miss_sd: float
    departures: Mapping[str, tuple[float, float]]
    probability: float
    causes: tuple[PossibleCause, ...]
    impossible: Mapping[str, Impossible] = field(default_factory=dict)

    @property
    def interval(self) -> tuple[float, float, float] | None:
        """The apogee to expect from the other flights at 5, 50 and 95% [m]; None without an apogee to compare."""
        if "apogee" not in self.departures:
            return None
        spread = float(np.exp(NORMAL_95 * self.departures["apogee"][1]))
        return self.forecast / spread, self.forecast, self.forecast * spread

    @property
    def singled_out(self) -> bool:
        """Whether the flight probably differs from the others of its rocket."""
        return self.probability > SINGLED_OUT

    @property
    def suggested_tags(self) -> tuple[str, ...]:
        """The tags for a flight that is singled out and not yet tagged, the most probable first."""
        if not self.singled_out or not self.flight.clean:
            return ()
        near = [one for one in self.causes if one.probability >= SUGGESTED * self.causes[0].probability]
        return tuple(dict.fromkeys(tag for one in near if (tag := CAUSES[one.cause].tag)))


def beside_others(
    flown: FlownFlights, assumed: Assumed = FLIGHTS_ALONE, *, fits: Fits | None = None
) -> tuple[FlightBesideOthers, ...]:
    """The flights of one rocket in the order flown, each compared with the others; tagged ones are compared but not
    used. Arguments and errors as in `fieldkit.forecast.predict.predict`."""
    history = flown_and_planned(flown)
    flights = history.flights
    parts, simulated = [], np.zeros((len(flights), len(OBSERVED_READOUTS)))
    for chance, places in replace(assumed, sets=_flown_sets(assumed.sets)).acting(flights):
        model = assumed.model(history, places)
        known = set(model.shared.names) if model.shared else set()
        used = [i for i, term in enumerate(model.terms) if term.name in known or np.any(term.weight != 0)]
        every = observe(history.using([True] * len(flights)), model.hyperprior)
        fit = fitted(model.only(used), observe(history, model.hyperprior), {} if fits is None else fits)
        parts.append((chance, one_offs(fit, every)))
        simulated = simulated + chance * fit.tangent.values
    whole, simulated = _mixed(parts), simulated / sum(chance for chance, _ in parts)
    return tuple(
        replace(_beside(flight, whole, row), impossible=_impossible(flight, found, simulated[row]))
        for row, (flight, found) in enumerate(zip(flights, history.found, strict=False))
    )


def _impossible(flight: Flight, found: Found, simulated: Float[Array, "readout"]) -> dict[str, Impossible]:
    """The readouts of a flight that cannot be measurements, beside the simulated ones as compared [1] or [s]."""
    logs = dict(zip(np.array(OBSERVED_READOUTS)[IS_LOGARITHMIC].tolist(), simulated[IS_LOGARITHMIC], strict=True))
    gone = not_measured(flight, found.motor)
    values = {name: max(flight.number(name) or 0.0, 0.0) or np.nan for name in gone}
    return {
        name: Impossible(reason, float(np.log(values[name]) - logs.get(name, np.nan))) for name, reason in gone.items()
    }


def _flown_sets(averaged: Averaged) -> Averaged:
    """The sets that past flights distinguish, most probable first, that have `JUDGED_BY` of the probability."""
    chances: dict[tuple[Place, ...], float] = {}
    for chance, places in averaged or ((1.0, ()),):
        past = tuple(replace(one, switched=one.switched and replace(one.switched, ahead=False)) for one in places)
        chances[past] = chances.get(past, 0.0) + chance
    order = sorted(chances.items(), key=lambda item: -item[1])
    before = np.cumsum([0.0, *(chance for _, chance in order[:-1])])
    return tuple((chance, places) for (places, chance), total in zip(order, before, strict=True) if total < JUDGED_BY)


def _mixed(parts: Sequence[tuple[float, OneOffs]]) -> OneOffs:
    """The average over sets of effects."""
    chance = np.array([own for own, _ in parts]) / sum(own for own, _ in parts)
    each = {name: np.stack([getattr(one, name) for _, one in parts]) for name in OneOffs.__slots__ if name != "changed"}
    miss, normal, cause, strength = (
        np.tensordot(chance, each[name], 1) for name in ("miss", "normal", "cause", "strength")
    )
    sd = np.sqrt(np.tensordot(chance, each["sd"] ** 2 + (each["miss"] - miss) ** 2, 1))
    strength = np.tensordot(chance, each["cause"] * each["strength"], 1) / np.maximum(cause, 1e-300)
    return replace(parts[0][1], miss=miss, sd=sd, normal=normal, cause=cause, strength=strength)


def _cause(
    name: str, probability: float, strength: float, departures: Mapping[str, tuple[float, float]]
) -> PossibleCause:
    if name == "misread" and farthest(departures) == "apogee_to_eject":
        return PossibleCause(name, probability, departures["apogee_to_eject"][0], "s")
    return PossibleCause(name, probability, CAUSES[name].shown(strength), CAUSES[name].unit)


def farthest(departures: Mapping[str, tuple[float, float]]) -> str:
    """The readout that departs by the most standard deviations from its expectation."""
    return max(departures, key=lambda name: abs(departures[name][0]) / departures[name][1])


def _beside(flight: Flight, found: OneOffs, row: int) -> FlightBesideOthers:
    apogee, miss, sd = flight.apogee or np.nan, float(found.miss[row, 0]), float(found.sd[row, 0])
    forecast = apogee * np.exp(-miss)
    departures = {
        name: (float(found.miss[row, column]), float(found.sd[row, column]))
        for column, name in enumerate(OBSERVED_READOUTS)
        if np.isfinite(found.miss[row, column])
    }
    causes = [
        _cause(name, float(chance), float(found.strength[row, place]), departures)
        for place, (name, chance) in enumerate(zip(NAMES, found.cause[row], strict=True))
        if chance > 0
    ]
    return FlightBesideOthers(
        flight,
        float(forecast),
        float(apogee - forecast),
        float(sd * forecast),
        departures,
        float(1 - found.normal[row]),
        tuple(sorted(causes, key=lambda one: -one.probability)),
    )
