"""How fast a rocket comes down, from what it showed: descent speeds, and durations where nothing better was read.

Under a parachute drag carries the weight, rho/2 v^2 Cd A = m g, so that v = c sqrt(m / rho) / sqrt(A / A0): one number
c for a rocket and its parachute serves every mass, air, and share of the parachute's area (Knacke, Parachute Recovery
Systems Design Manual, 1991, chapter 5).
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from fieldkit.flight import Flight
from fieldkit.forecast.prediction import Prediction
from fieldkit.motors import Found
from fieldkit.physics.atmosphere import Air, altimeter_gain, drift_through, pad_air
from fieldkit.physics.setups import DESCENT_SPEED, recorded
from fieldkit.shapes import Array, Float
from fieldkit.units import STANDARD_GRAVITY

FLIGHT_TO_FLIGHT_SD = 0.10
"""Standard deviation of the log descent speed from flight to flight, before any flight. [1]"""
DESCENT_PRIOR_FLIGHTS = 4.0
"""Number of flights that the guess of the descent speed counts for. [1]"""
DEFAULT_DESCENT_SD = 0.30
"""Of the log descent speed where no flight told it: parachutes are cut for 3.5 to 7 m/s. [1]"""
AREA_CHANGE_SD = 0.15
"""By how much a change of area may miss what it should do, for each unit of its log: lines and slots alter Cd. [1]"""


@dataclass(frozen=True, slots=True)
class Fall:
    """The log of c = v sqrt(rho / m): mean over `flights`, and their spread. Without flights, of a usual parachute."""

    log_mean: float
    spread: float
    flights: int

    def speeds(
        self, rng: np.random.Generator, shape: tuple[int, int], mass: float, density: float, area: float = 1.0
    ) -> Float[Array, "draw flight"]:
        """Descent speeds near the ground of flights of a landing mass [kg] in air [kg/m^3], on a share of the
        parachute's area. [m/s]

        Each row is one rocket: variance and mean from their joint posterior (normal, inverse chi-square; Gelman et
        al., Bayesian Data Analysis, 2013, section 3.3), each flight of it scattered about that mean.
        """
        draws, flights = shape
        freedom = DESCENT_PRIOR_FLIGHTS + max(self.flights - 1, 0)
        deviation = self.spread * np.sqrt(freedom / rng.chisquare(freedom, (draws, 1)))
        centre = self.log_mean + rng.normal(size=(draws, 1)) * (
            deviation / np.sqrt(self.flights) if self.flights else DEFAULT_DESCENT_SD
        )
        changed = -0.5 * np.log(area) * (1 + AREA_CHANGE_SD * rng.normal(size=(draws, 1)))
        logs = centre + changed + deviation * rng.normal(size=(draws, flights))
        return np.asarray(np.exp(logs) * np.sqrt(mass / density))


def fall_of(history: Sequence[tuple[Flight, Found]]) -> Fall:
    """What the clean flights of a rocket tell of its descent."""
    told = [(flight, found) for flight, found in history if flight.clean]
    speeds = np.array([_speed(flight) or np.nan for flight, _ in told])
    known = np.isfinite(speeds) & (speeds > 0)
    if not known.any():
        usual = np.log(DESCENT_SPEED) - 0.5 * np.log(0.4 / 1.225)
        return Fall(float(usual), FLIGHT_TO_FLIGHT_SD, 0)
    masses = np.array([landing_mass(flight, found) for flight, found in told])
    logs = np.log(speeds[known]) - 0.5 * np.log(masses[known] / _density([flight for flight, _ in told])[known])
    count = len(logs)
    pooled = (DESCENT_PRIOR_FLIGHTS * FLIGHT_TO_FLIGHT_SD**2 + ((logs - logs.mean()) ** 2).sum()) / (
        DESCENT_PRIOR_FLIGHTS + count - 1
    )
    return Fall(float(logs.mean()), float(np.sqrt(pooled)), count)


def landing_mass(flight: Flight, found: Found) -> float:
    """Of the rocket with the motor burnt out. [kg]"""
    return (flight.dry_mass or np.nan) + found.motor.casing_mass


def durations(said: Sequence[Prediction], speeds: Float[Array, "draw flight"]) -> Float[Array, "draw flight"]:
    """From lift-off to landing at these descent speeds near the ground; ballistic where no charge opened it. [s]

    The forecast fell at `DESCENT_SPEED` through the same air, so its time under the parachute goes by the ratio.
    """
    columns = []
    for one, speed in zip(said, speeds.T, strict=True):
        under = one.duration - one.rise_time - np.fmax(np.nan_to_num(one.eject), 0.0)
        unopened = np.isnan(one.eject) & _has_delay(one)
        columns.append(np.where(unopened, one.duration, one.duration - under + under * DESCENT_SPEED / speed))
    return np.stack(columns, axis=-1)


def landing(said: Prediction, speed: Float[Array, "draw"]) -> Float[Array, "draw"]:
    """How far downwind of the pad it lands, negative upwind: the path to apogee, and the wind under the parachute. [m]

    Wind by the power law over open ground; what the airframe drifts on its fall to the charge is left out.
    """
    wind = np.array(said.plan.wind or 0.0)
    return np.nan_to_num(said.drift) + drift_through(said.true_apogee, wind) / speed


def _has_delay(said: Prediction) -> bool:
    delay = said.plan.delay if said.plan.delay is not None else said.found.delay
    return delay is not None and bool(np.isfinite(delay))


def _density(flights: Sequence[Flight]) -> Float[Array, "flight"]:
    return _air(flights).density


def _air(flights: Sequence[Flight]) -> Air:
    elevation, temperature, pressure, humidity = (
        recorded(flights, name) for name in ("site_elevation", "temperature", "pressure", "humidity")
    )
    return pad_air(elevation, temperature, pressure, humidity)


def _speed(flight: Flight) -> float | None:
    """Descent speed near the ground: from the whole of apogee and duration where both were read, else as read. [m/s]

    A duration is what a stopwatch and a judge have, and it averages over the whole descent. The rise takes burn and
    coast where they were read; else a body thrown to that height, sqrt(2 h / g), within a second.
    """
    if flight.duration is None or flight.apogee is None:
        return flight.descent_speed
    conditions = [recorded([flight], name) for name in ("site_elevation", "temperature", "pressure")]
    height = flight.apogee / float(altimeter_gain(*conditions)[0])
    rise = (
        flight.burn_time + flight.coast_to_apogee
        if flight.burn_time is not None and flight.coast_to_apogee is not None
        else float(np.sqrt(2 * height / STANDARD_GRAVITY))
    )
    under = flight.duration - rise - max(flight.apogee_to_eject or 0.0, 0.0)
    thin = float(np.sqrt(_air([flight]).density_ratio(np.array([0.5 * height]))[0]))
    return height * thin / under if under > 0 else flight.descent_speed
