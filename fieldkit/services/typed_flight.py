"""The estimate while a flight is being entered: Cd, alpha and the next apogee so far, by a linear pass."""

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from threading import Lock

from fieldkit.errors import UnknownMotor
from fieldkit.flight import Flight
from fieldkit.flight.plan import repeated
from fieldkit.flight.plausibility import implausible
from fieldkit.forecast.at_once import prepare_at_once
from fieldkit.inference.history.quick_forecast import NORMAL_95, PreparedHistory, QuickAnswer, answers
from fieldkit.ledger import Ledger
from fieldkit.model.readout_data import OBSERVED_READOUTS
from fieldkit.model.rocket_model import FlownFlights
from fieldkit.model.shared_prior import SharedPrior
from fieldkit.motors import Catalogue, Found, is_cluster
from fieldkit.planning.quantiles import Three
from fieldkit.services.fleet import fleet_prior
from fieldkit.services.plausible_flights import followed

SET_UP = {"motor": "motor", "dry_mass": "mass", "diameter": "diameter"}
"""Columns needed for a flight to constrain Cd, and their names in messages."""


@dataclass(frozen=True, slots=True)
class TypedEstimate:
    """The provisional estimate from a rocket's flights and the one being entered.

    `cd` (on the body's frontal area) [1], `alpha` [1] and `next_apogee` [m] are for repeating the flight. All are None
    if `needs` names missing inputs, or `implausible_because` gives the reason the figures are impossible.
    """

    needs: tuple[str, ...] = ()
    implausible_because: str = ""
    cd: Three | None = None
    alpha: Three | None = None
    next_apogee: Three | None = None
    flights: int = 0


def missing(typed: Flight, others: int) -> tuple[str, ...]:
    """The missing inputs for an estimate, given `others` of the same rocket that are used in the fit."""
    lacks = [name for column, name in SET_UP.items() if not getattr(typed, column)]
    if not others and not shows(typed):
        lacks.append("a readout")
    return tuple(lacks)


def shows(flight: Flight) -> bool:
    """Whether a flight has a readout that the fit uses."""
    return any(flight.number(name) is not None for name in OBSERVED_READOUTS)


def set_up(flight: Flight) -> Flight:
    """A flight without its readouts and notes: everything that determines its simulation."""
    return replace(flight.unflown(sd={}, source={}, tags=(), flight_id="typed"), notes="", extra={})


class TypedFlight:
    """The flight being entered, together with its rocket's flights in a ledger.

    Results that do not depend on readouts are cached, so that a readout costs one linear pass.
    Thread-safe; calls are answered one at a time.
    """

    def __init__(self, ledger: Ledger, motors: Catalogue) -> None:
        self._ledger, self._motors, self._lock = ledger, motors, Lock()
        self._rocket: str | None = None
        self._flown: FlownFlights = ()
        self._shared: SharedPrior | None = None
        self._asked: tuple[Flight, bool] | None = None
        self._ready: PreparedHistory | None = None

    def estimate(self, typed: Flight) -> TypedEstimate:
        """The estimate from the flight as entered so far; all values are finite. Raises DamagedModel if the
        hyperprior cannot be read.
        """
        with self._lock:
            self._turn_to(typed.rocket)
            if lacks := missing(typed, sum(flight.clean and shows(flight) for flight, _ in self._flown)):
                return TypedEstimate(lacks)
            found = None if is_cluster(typed.motor) else self._motor(typed.motor)
            if found is None:
                return TypedEstimate(("a motor in the catalog",))
            if implausible_because := implausible(typed, found.motor):
                return TypedEstimate(implausible_because=implausible_because)
            used = typed.clean and shows(typed)
            ready = self._prepared(typed, found, used)
            flights = [*(flight for flight, _ in self._flown), typed]
            return _estimate(answers(ready, flights)[0])

    def _motor(self, name: str) -> Found | None:
        try:
            return self._motors.resolve(name)
        except UnknownMotor:
            return None

    def _turn_to(self, rocket: str) -> None:
        """Read the flights of a rocket, once."""
        if rocket == self._rocket:
            return
        self._flown = followed(self._ledger.flights(rocket), self._motors) if rocket else ()
        self._shared = fleet_prior(self._ledger, self._motors, rocket)
        self._rocket, self._asked = rocket, None

    def _prepared(self, typed: Flight, found: Found, used: bool) -> PreparedHistory:
        """The simulated response of the flights, recomputed only if the setup changes."""
        asked = (set_up(typed), used)
        if self._ready is None or asked != self._asked:
            plan = repeated(asked[0])
            before = [flight.clean for flight, _ in self._flown]
            flown = [*self._flown, (asked[0], found)]
            self._ready = prepare_at_once(flown, [(plan, found)], [*before, used], shared=self._shared)
            self._asked = asked
        return self._ready


def _estimate(answer: QuickAnswer) -> TypedEstimate:
    """An answer as intervals, or the reason there is none."""
    low, middle, high = (answer.apogee_at(level) for level in (0.05, 0.5, 0.95))
    cd, alpha = _interval(answer.log_cd), _interval(answer.log_alpha)
    if not all(map(math.isfinite, (low, middle, high, *cd, *alpha))):
        return TypedEstimate(implausible_because="these values are inconsistent")
    return TypedEstimate(cd=cd, alpha=alpha, next_apogee=(low, middle, high), flights=answer.rests_on)


def _interval(logarithm: Sequence[float]) -> Three:
    mean, sd = logarithm
    return math.exp(mean - NORMAL_95 * sd), math.exp(mean), math.exp(mean + NORMAL_95 * sd)
