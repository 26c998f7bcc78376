"""The two E35 flights: 126 g lighter, the rocket flew 5 m higher; straight flight predicts about 60 m.

For each effect, the study computes the strength that explains the lighter flight, with the drag fitted to the heavier
one, and the next flight that would distinguish the possible causes.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from itertools import combinations

import numpy as np

from fieldkit.flight import Flight
from fieldkit.motors import Found, catalogue
from fieldkit.physics.effect import Effect, Prior, effects
from fieldkit.physics.flight import fly
from fieldkit.physics.history import field_setup
from fieldkit.physics.state import Setup
from fieldkit.reference.flights import Reference
from fieldkit.shapes import Array, Flags, Float

PAIR = ("1", "4")
"""The heavier flight (configuration B) and the lighter one (A), both on an E35-5W."""
ALPHAS = (0.8, 1.0, 1.2)
"""Thrust factors in the paper's prior at which the expected gain is computed."""
STRONGEST_WIND = 15.0
"""Maximum wind to try. [m/s]"""
BREEZE = 5.0
"""An unremarkable wind, the unit for judging winds. [m/s]"""
STRENGTHS_TRIED = 60
"""Number of strengths tried for each effect. [1]"""
MAX_APOGEE_MISS = 3.0
"""Tolerance for a strength to explain the flown apogee; an effect may have a jump there. [m]"""
MIN_SEPARATION_SDS = 2.0
"""Two causes are distinguishable at this separation or more, in standard deviations. [1]"""
OWN_DRAG = "another drag of configuration A"


def _more_drag(setup: Setup, strength: Float[Array, "*draw flight"]) -> Setup:
    return setup.with_changes(drag_area=setup.drag_area * (1 + strength))


OWN_EFFECT = Effect(
    title=OWN_DRAG,
    family="drag",
    explains="the payload changes shape or stability as well as mass",
    unit="fraction of Cd",
    prior=Prior(mean=0.0, sd=0.09, low=-0.6, high=3.0),
    source="the slack that forecasts leave between configurations",
    tell_apart="fly both configurations on one motor, and write down the coast",
    setup=_more_drag,
)
MAX_PRIOR_SDS = 2.5
"""A strength is likely within this number of standard deviations of its prior. [1]"""
READOUTS = ("apogee", "top_speed", "peak_accel", "coast_to_apogee", "apogee_to_eject")
"""Readouts that the next flight could record."""
READOUT_SCATTER = {
    "apogee": 16.0,
    "top_speed": 0.025,
    "peak_accel": 0.06,
    "coast_to_apogee": 0.04,
    "apogee_to_eject": 0.4,
}
"""Standard deviations of the readouts of single flights: apogee [m], from these flights; top speed, peak acceleration
and coast as fractions [1], motors and altimeter together; ejection [s], because delays are certified to 10%."""


@dataclass(frozen=True, slots=True)
class Cause:
    """An effect on the lighter flight: the strength that explains it, and its plausibility.

    `strength` is nan if none does. `away` is its distance from the prior mean in prior standard deviations. `shows` are
    the altimeter's readouts of that flight.
    """

    effect: str
    unit: str
    strength: float
    away: float
    shows: Mapping[str, float]

    @property
    def possible(self) -> bool:
        """Whether any strength explains it."""
        return bool(np.isfinite(self.strength))


@dataclass(frozen=True, slots=True)
class TwoFlights:
    """The flown apogees, the expectation of straight flight for each thrust factor, and the causes, the most likely
    first."""

    flown_gain: float
    lighter_by: float
    expected_gain: Mapping[float, float]
    causes: tuple[Cause, ...]
    discriminations: tuple["Discrimination", ...]


@dataclass(frozen=True, slots=True)
class Discrimination:
    """A readout of the lighter rocket, the number of pairs of likely causes that it would distinguish, and their
    total."""

    readout: str
    distinguished: int
    pairs: int


def two_flights(flights: Reference) -> TwoFlights:
    """The study of the pair."""
    heavy, light = (next(f for f in flights.flights if f.flight_id == name) for name in PAIR)
    gains = {alpha: _gain(heavy, light, alpha) for alpha in ALPHAS}
    causes = sorted(
        _causes(heavy, light),
        key=lambda cause: cause.away if cause.possible else np.inf,
    )
    return TwoFlights(
        _apogee(light) - _apogee(heavy),
        float(heavy.dry_mass or 0) - float(light.dry_mass or 0),
        gains,
        tuple(causes),
        _discriminations([cause for cause in causes if cause.possible and cause.away < MAX_PRIOR_SDS]),
    )


def _apogee(flight: Flight) -> float:
    assert flight.apogee is not None
    return flight.apogee


def _found(flight: Flight) -> Found:
    return catalogue().resolve(flight.motor)


def _setup(flight: Flight, area: float, alpha: float) -> Setup:
    return field_setup([flight], [_found(flight)], np.array([area]), alpha)


def _area(flight: Flight, alpha: float) -> float:
    """Drag area that reproduces the flown apogee. [m^2]"""
    from scipy.optimize import brentq

    def miss(log_area: float) -> float:
        return float(fly(_setup(flight, np.exp(log_area), alpha)).apogee_shown[0]) - _apogee(flight)

    return float(np.exp(brentq(miss, np.log(1e-5), np.log(0.1), xtol=1e-5)))


def _gain(heavy: Flight, light: Flight, alpha: float) -> float:
    """Expected difference of the apogees, lighter minus heavier. [m]"""
    shown = fly(_setup(light, _area(heavy, alpha), alpha)).apogee_shown
    return float(shown[0]) - _apogee(heavy)


TESTABLE_CONDITIONS = ("", "wind")
"""Conditions that an effect may need to be tested here."""


def _causes(heavy: Flight, light: Flight) -> list[Cause]:
    """Every registered effect, and a separate drag for the lighter configuration.

    Effects that need an unrecorded condition are left out; for wind, the required speed is computed.
    """
    area = _area(heavy, 1.0)
    flown_between = int(light.flight_id) - int(heavy.flight_id)
    own = [
        _cause(name, effect, light, area, flown_between)
        for name, effect in effects().items()
        if effect.needs in TESTABLE_CONDITIONS
    ]
    return [*own, _cause(OWN_DRAG, OWN_EFFECT, light, area, 1)]


def _cause(name: str, effect: Effect, light: Flight, area: float, flown_between: int) -> Cause:
    """The strength nearest to zero that reproduces the lighter flight's apogee."""
    assumed = light.with_changes(**{effect.needs: 1.0}) if effect.needs else light
    prior = effect.prior
    low, high = (0.0, STRONGEST_WIND) if effect.needs else _bounds(effect)
    strengths = np.linspace(low, high, STRENGTHS_TRIED)
    miss = _readings(effect, assumed, area, strengths)["apogee"] - _apogee(light)

    def root(part: Flags) -> float:
        ends = _crossing(strengths[part], miss[part])
        return _refined(lambda x: float(_readings(effect, assumed, area, x)["apogee"][0]) - _apogee(light), ends)

    found = [root(strengths >= 0), root(strengths <= 0)]
    found = [root for root in found if np.isfinite(root)]
    if not found:
        return Cause(name, effect.unit, np.nan, np.inf, {})
    strength = min(found, key=abs)
    readings = _readings(effect, assumed, area, np.array([strength, strength]))
    shows = {key: float(readings[key][0]) for key in READOUTS}
    if effect.needs:
        return Cause(name, "m/s of wind that it turns into", strength, strength / BREEZE, shows)
    strength /= flown_between if effect.grows else 1
    away = abs((strength**2 if effect.squared else strength) - prior.mean) / prior.sd
    return Cause(name, effect.unit, strength, away, shows)


def _bounds(effect: Effect) -> tuple[float, float]:
    """Bounds of an effect's strength."""
    low, high = effect.prior.low, effect.prior.high
    return (0.0, float(np.sqrt(high))) if effect.squared else (low, high)


def _crossing(strengths: Array, miss: Array) -> Array:
    """The pair of strengths nearest to zero between which the error changes sign, or None."""
    order = np.argsort(np.abs(strengths))
    strengths, miss = strengths[order], miss[order]
    crossed = np.flatnonzero(miss[1:] * miss[:-1] <= 0)
    return strengths[crossed[0] : crossed[0] + 2] if len(crossed) else strengths[:0]


def _refined(miss: Callable[[Array], float], ends: Array) -> float:
    from scipy.optimize import brentq

    if not len(ends):
        return float("nan")
    root = float(brentq(lambda x: miss(np.array([x])), ends[0], ends[1], xtol=1e-4))
    return root if abs(miss(np.array([root]))) < MAX_APOGEE_MISS else float("nan")


def _readings(effect: Effect, flight: Flight, area: float, strengths: Array) -> Mapping[str, Array]:
    """The readouts of a flight at each strength."""
    count = len(strengths)
    setup = field_setup([flight] * count, [_found(flight)] * count, np.full(count, area), 1.0)
    setup = effect.bend_setup(setup, strengths)
    return effect.bend_reading(fly(setup).readouts(), strengths)


def _discriminations(causes: Sequence[Cause]) -> tuple[Discrimination, ...]:
    """For each readout, how many pairs of causes it would distinguish, and then for all of them."""
    pairs = list(combinations(causes, 2))
    counts = [
        Discrimination(
            name, sum(_separation(one, other, (name,)) > MIN_SEPARATION_SDS for one, other in pairs), len(pairs)
        )
        for name in READOUTS
    ]
    return (
        *counts,
        Discrimination(
            "all five", sum(_separation(one, other, READOUTS) > MIN_SEPARATION_SDS for one, other in pairs), len(pairs)
        ),
    )


def _separation(one: Cause, other: Cause, readouts: Sequence[str]) -> float:
    """The difference of readouts between two causes, in standard deviations of single flights."""
    total = 0.0
    for name in readouts:
        a, b = one.shows[name], other.shows[name]
        if not np.isfinite(a) or not np.isfinite(b):
            continue
        ratio = name in ("top_speed", "peak_accel", "coast_to_apogee")
        total += ((np.log(a / b) if ratio else a - b) / READOUT_SCATTER[name]) ** 2
    return float(np.sqrt(total))
