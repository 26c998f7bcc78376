"""The flight model of one rocket: which numbers are unknown, and what the altimeter shows given them.

Every unknown is a `Term`: a normal prior, possibly cut off, and the weight with which it acts on each
flight. Terms that act on many flights are shared (drag of the rocket, thrust of a motor type, the strength
of an effect); what differs from flight to flight is scatter, drawn anew for each.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any, Literal

import numpy as np

from fieldkit.flight import Flight
from fieldkit.model.readout_data import OBSERVED
from fieldkit.motors import Found
from fieldkit.physics.effect import Effect
from fieldkit.physics.flight import apogees
from fieldkit.physics.setups import dry_masses, field_setup, recorded
from fieldkit.physics.state import Setup
from fieldkit.physics.unique import fly_alike
from fieldkit.shapes import Array, Float

CD = (np.log(0.6), 0.35)
"""Prior of log Cd: typical models lie between 0.35 and 1.1 (Mandell et al., 1973; Hoerner, 1965)."""
UNKNOWN_AREA_SD = 0.45
"""Of log area where the diameter was not recorded and follows from the mass. [1]"""

DOUBT_OF = {"top_speed": 0.03, "coast_to_apogee": 0.02}
"""Least standard deviation of what is alike in all readings of a device, where it is doubted, by ratio: speed is
integrated from when the device noticed the launch, the coast ends when it notices apogee. [1]"""

EXTRAS = ("rail_speed", "eject_speed", "coast_time", "rise_time", "drift")
"""Figures of a flight that the altimeter does not show and a plan asks for."""
OPENING = "opening of the parachute"
"""The term for the time from the ejection charge to an open parachute. [s]"""

DISCREPANCY = 0.05
"""By what share of an apogee a rocket disagrees with its model on one motor and not on another, in units of
scatter: as much as single flights disagree. [1]"""

PER = ("motor", "config", "site", "day")
"""What flights are grouped by."""

Bends = Literal["drag", "thrust", "stretch", "delay", "tilt", "mass", "opening"]


@dataclass(frozen=True, slots=True)
class Term:
    """One unknown number: what it bends, its prior, and how strongly it acts on each flight.

    `bends` is a property of the flight, the name of a readout (a bias of the reading, by ratio), or an
    effect. `low` and `high` cut the prior off. `rough` names the scale that multiplies its standard deviation,
    where it has one: a rocket whose flights scatter is less well known, a device that reads roughly reads askew.
    """

    name: str
    bends: Bends | str | Effect
    mean: float
    sd: float
    weight: Float[Array, "flight"]
    low: float = -np.inf
    high: float = np.inf
    rough: Literal["", "scatter", "reading"] = ""


@dataclass(frozen=True, slots=True)
class Scatter:
    """What differs from flight to flight: a standard deviation about zero."""

    bends: Bends
    sd: float


SCATTER = (
    Scatter("thrust", 0.025),
    Scatter("drag", 0.03),
    Scatter("stretch", 0.02),
    Scatter("delay", 0.08),
    Scatter("tilt", 1.0),
)
"""Ordinary scatter of single flights: certified motors vary by 2 to 3 % within a lot, drag with the angle of
attack, delays by a tenth; `tilt` is in units of a lean of 5 degrees, squared."""
TILT = np.radians(5.0)
"""The lean that scatter in tilt is measured in. [rad]"""
COARSE: dict[str, Any] = {"steps": 8, "knots": 12, "stride": 2.0}
"""Thrust curves and steps of a coarse model: they move apogees by less than 0.2 % and the speed off the rail by less
than 2 % for nineteen motors in twenty, in wind by twice as much, which are a small part of how far flights scatter."""


@dataclass(frozen=True, slots=True)
class Model:
    """A rocket's flights, in the order flown, and the unknowns they share.

    A `doubtful` one takes neither the simulator nor what the device shows beside the apogee on trust. A `coarse` one
    flies by `COARSE` curves and steps: to learn from flights, or for hundreds of motors at once. `turns` are the places
    of the flights in the order flown, from 0; plans that a flyer chooses among share one.
    """

    flights: tuple[Flight, ...]
    found: tuple[Found, ...]
    area: Float[Array, "flight"]
    terms: tuple[Term, ...]
    turns: tuple[int, ...]
    doubtful: bool = False
    coarse: bool = False

    @property
    def names(self) -> list[str]:
        """Names of the terms, in order."""
        return [term.name for term in self.terms]

    def with_terms(self, *terms: Term) -> "Model":
        """The same model with more unknowns."""
        return replace(self, terms=(*self.terms, *terms))

    def with_prior(self, name: str, mean: float, sd: float | None = None) -> "Model":
        """The same model with another belief about one unknown, as sure as before where no `sd` is said."""
        terms = (replace(term, mean=mean, sd=sd or term.sd) if term.name == name else term for term in self.terms)
        return replace(self, terms=tuple(terms))

    def only(self, terms: Sequence[int]) -> "Model":
        """The same flights with some of the unknowns."""
        return replace(self, terms=tuple(self.terms[i] for i in terms))

    def part(self, rows: slice) -> "Model":
        """The same unknowns acting on some of the flights."""
        terms = tuple(replace(term, weight=term.weight[rows]) for term in self.terms)
        kept = {name: getattr(self, name)[rows] for name in ("flights", "found", "area", "turns")}
        return replace(self, **kept, terms=terms)


def reference_area(flights: Sequence[Flight], flown: int | None = None) -> Float[Array, "flight"]:
    """Frontal area of the body; without a diameter, that of a rocket of this dry mass as they are built. [m^2]

    The mass is the mean of the first `flown` flights, by default of all; of a rocket never flown, each plan's own.

    The law of thumb, d = 60 mm (m / 0.4 kg)^0.2, is a fit to the drag of 34 rockets from 36 g to 3.8 kg in a
    public launch ledger (jdsmith39/RocketLaunchJournal, flights to 2017), with Cd as in `CD`.

    Raises ImpossibleFlight for a flight without a dry mass.
    """
    guess = 0.060 * (dry_masses(flights) / 0.4) ** 0.2
    guess = guess if flown == 0 else guess[:flown].mean()
    diameter = recorded(flights, "diameter")
    result: Float[Array, "flight"] = np.pi / 4 * np.where(np.isnan(diameter), guess, diameter) ** 2
    return result


def groups(flights: Sequence[Flight], found: Sequence[Found], per: str) -> list[str]:
    """The group each flight belongs to: its motor type, configuration, site or day."""
    if per == "motor":
        return [f"{item.motor.maker} {item.motor.designation}" for item in found]
    if per == "day":
        return [flight.date_time.date().isoformat() if flight.date_time else "" for flight in flights]
    return [str(getattr(flight, per)) for flight in flights]


def base_model(
    flights: Sequence[Flight],
    found: Sequence[Found],
    slack: float = 1.0,
    flown: int | None = None,
    turns: Sequence[int] | None = None,
) -> Model:
    """The plain model: one drag for the rocket, certified motors, and the small print of both.

    `slack` scales how far motors may be from their certificate and configurations from each other. Forecasts
    take it as it is; a search for effects takes less, for what it leaves to chance it cannot find. `flown` as in
    `reference_area`, `turns` as in `Model`, by default one after the other.
    """
    area = reference_area(flights, flown)
    unknown = bool(np.isnan(recorded(flights, "diameter")).any())
    several = flown != 0  # of a rocket never flown each plan stands for itself
    every = np.ones(len(flights))
    terms = [
        Term("drag", "drag", CD[0], float(np.hypot(CD[1], UNKNOWN_AREA_SD * unknown)), every),
        Term("thrust", "thrust", 0.0, 0.02 * slack, every),
        Term("mass", "mass", 0.0, 0.02 * slack, every),
        *(_per_group("drag", "drag", 0.03 * slack, groups(flights, found, "config")) if several else []),
        *(_per_group("thrust", "thrust", 0.02 * slack, groups(flights, found, "motor")) if several else []),
        *_per_group("burn", "stretch", 0.04 * slack, groups(flights, found, "motor"), alone=True),
        *_per_group("delay", "delay", 0.08, groups(flights, found, "motor"), alone=True),
        Term(OPENING, "opening", 0.6, 0.4, every, low=0.0),
        Term("top speed read", "top_speed", 0.0, 0.01, every),
        Term("burn time read", "burn_time", 0.0, 0.05, every),
        Term("peak read", "peak_accel", 0.0, 0.06, every),
        Term("coast read", "coast_to_apogee", 0.0, 0.01, every),
        Term("ejection read", "apogee_to_eject", 0.0, 0.1, every),
    ]
    return Model(tuple(flights), tuple(found), area, tuple(terms), tuple(turns or range(len(flights))))


def doubted(model: Model) -> Model:
    """The model as forecasts take it: neither the simulator nor the device is exact, and by how much is unknown.

    On each motor a rocket disagrees with the simulator by a share of its own, which its flights on that motor show
    (model discrepancy: Kennedy and O'Hagan, J. R. Stat. Soc. B 63, 2001). What the device shows beside the apogee
    has errors that are alike in all flights and grow with those that are not.
    """
    motor = groups(model.flights, model.found, "motor")
    terms = tuple(
        replace(term, sd=max(term.sd, DOUBT_OF.get(str(term.bends), 0.0)), rough="reading")
        if term.bends in OBSERVED
        else term
        for term in model.terms
    )
    alone = _per_group("apogee", "apogee", DISCREPANCY, motor, alone=True)
    own = (replace(term, rough="scatter") for term in alone)
    return replace(model, terms=(*terms, *own), doubtful=True)


def _per_group(name: str, bends: Bends | str, sd: float, group: Sequence[str], *, alone: bool = False) -> list[Term]:
    """A term a group where there are several (or `alone`: even where there is one)."""
    kinds = list(dict.fromkeys(group))
    if len(kinds) < 2 and not alone:
        return []
    return [Term(f"{name} of {kind}", bends, 0.0, sd, np.array([g == kind for g in group], float)) for kind in kinds]


def shown(
    model: Model, values: Float[Array, "draw term"], scatter: Mapping[str, Float[Array, "draw flight"]]
) -> dict[str, Float[Array, "draw flight"]]:
    """What the altimeter shows of every flight, in SI, and a few figures it does not show.

    `scatter` bends single flights. A flight that would not leave the pad has nan throughout.
    """
    setup, readings_bends = _bent_setup(model, values, scatter)
    flown = fly_alike(setup)
    readings: Mapping[str, Any] = flown.readouts()
    for effect, strength in readings_bends:
        readings = effect.bend_reading(readings, strength)
    grounded = flown.lift_off == 0
    out = {name: np.where(grounded, np.nan, value) for name, value in readings.items()}
    for name in OBSERVED:
        bias = bent(model, values, name)
        ratio = name != "apogee_to_eject"
        out[name] = out[name] * np.exp(bias) if ratio else out[name] + bias
    figures = {name: np.where(grounded, np.nan, getattr(flown, name)) for name in EXTRAS}
    higher = np.exp(bent(model, values, "apogee"))  # the simulator is doubted here, not the altimeter
    sinking = out["duration"] - figures["rise_time"] - np.fmax(np.nan_to_num(out["apogee_to_eject"]), 0.0)
    return out | figures | {"true": flown.apogee * higher, "duration": out["duration"] + (higher - 1) * sinking}


def tops(
    model: Model, values: Float[Array, "draw term"], scatter: Mapping[str, Float[Array, "draw flight"]]
) -> Float[Array, "draw flight"]:
    """True apogees as in `shown`, alone and quicker; 0 for a flight that would not leave the pad. [m]"""
    return apogees(_bent_setup(model, values, scatter)[0])


def bent(model: Model, values: Float[Array, "draw term"], bends: str) -> Float[Array, "draw flight"]:
    """Everything that bends one thing, added up."""
    acting = [i for i, term in enumerate(model.terms) if isinstance(term.bends, str) and term.bends == bends]
    if not acting:
        return np.zeros((len(values), len(model.flights)))
    return np.asarray(values[:, acting] @ np.stack([model.terms[i].weight for i in acting]))


def _bent_setup(model: Model, values: Array, scatter: Mapping[str, Array]) -> tuple[Setup, list[tuple[Effect, Array]]]:
    def bend(what: str) -> Array:
        return np.asarray(bent(model, values, what) + scatter.get(what, 0.0))

    drag, thrust = model.area * np.exp(bend("drag")), np.exp(bend("thrust"))
    setup = field_setup(model.flights, model.found, drag, thrust, **(COARSE if model.coarse else {}))
    setup = setup.with_changes(
        dry_mass=setup.dry_mass * np.exp(bend("mass")),
        burn_stretch=np.exp(bend("stretch")),
        delay=setup.delay * np.exp(bend("delay")),
        opening_time=np.maximum(bend("opening"), 0.0),
    )
    if np.any(tilt := bend("tilt")):
        lean = TILT * np.sqrt(np.abs(tilt))
        setup = setup.with_changes(rail_angle=np.hypot(setup.rail_angle, lean))
    strengths = _strengths(model, values)
    for effect, strength in strengths:
        setup = effect.bend_setup(setup, strength, model.flights)
    return setup, strengths


def _strengths(model: Model, values: Array) -> list[tuple[Effect, Array]]:
    """How strongly each effect acts on each flight, all its places together; those that act on none are left out."""
    places: dict[int, list[int]] = {}
    for index, term in enumerate(model.terms):
        if isinstance(term.bends, Effect):
            places.setdefault(id(term.bends), []).append(index)
    found = []
    for indices in places.values():
        effect = model.terms[indices[0]].bends
        assert isinstance(effect, Effect)
        weight = np.stack([model.terms[i].weight for i in indices])
        strength = np.asarray(effect.strength(values[:, indices]) @ weight)
        if strength.any():
            found.append((effect, strength))
    return found
