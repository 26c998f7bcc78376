"""The descent speed of a rocket, from its flights, from the entered parachute, or from a default.

Under a device drag balances weight, rho/2 v^2 Cd A = m g, which gives v = c sqrt(m / rho) / sqrt(A / A0): a single
number c for a rocket and its device covers every mass, air density, and fraction of the device's area (Knacke,
Parachute Recovery Systems Design Manual, 1991, chapter 5). Duration, landing and the fit to flights use the same
descent model (`fieldkit.physics.descent`): the charge fires at the end of its delay, not at apogee.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from fieldkit.flight import Flight
from fieldkit.flight.recovery import DESCENT_SPEED, Device, Recovery
from fieldkit.flight.recovery import LIMITS as RECOVERY_LIMITS
from fieldkit.motors import Found
from fieldkit.physics.descent import PARACHUTE_CD
from fieldkit.planning.flown_descent import DROGUE_SPEED, air_at_pads, landing_mass, shown_speeds
from fieldkit.shapes import Array, Float
from fieldkit.units import STANDARD_GRAVITY

FLIGHT_TO_FLIGHT_SD = 0.10
"""Prior standard deviation of the log descent speed from flight to flight. [1]"""
DESCENT_PRIOR_FLIGHTS = 4.0
"""Number of flights that the prior of the descent speed counts for. [1]"""
DEFAULT_DESCENT_SD = 0.30
"""Standard deviation of the log descent speed without flights: parachutes are sized for 3.5 to 7 m/s. [1]"""
STREAMER_SPEED = 10.0
"""Default speed under a streamer, an assumption: 7 to 14 m/s within `DEFAULT_DESCENT_SD`. [m/s]"""
AREA_CHANGE_SD = 0.15
"""Error of the predicted effect of a change of area, per unit of its log: lines and slots change Cd. [1]"""
USUAL_MASS, USUAL_DENSITY = 0.4, 1.225
"""Mass [kg] and air density [kg/m^3] that a default descent speed refers to."""
PARACHUTE_SD = 0.12
"""Standard deviation of the log descent speed computed from a parachute's diameter, due to holes, slots and short
lines. [1]"""
TYPED_FLIGHTS = 4
"""Number of flights that an entered descent speed counts for. [1]"""


@dataclass(frozen=True, slots=True)
class Fall:
    """The log of c = v sqrt(rho / m): its mean over `flights`, and its standard deviation. Without flights, the default
    of a device.

    `drogue` is the same for the drogue of a rocket with two devices, None if there is none. An entered speed (`typed`)
    counts for that many flights.
    """

    log_mean: float
    spread: float
    flights: int
    drogue: "Fall | None" = None
    typed: int = 0

    @property
    def assumed(self) -> bool:
        """Whether it is the default of a device, neither measured nor entered."""
        return not self.flights and not self.typed

    def relative_sd(self, more: int = 0) -> float:
        """Standard deviation of the log of the next descent speed, after `more` flights that record one. [1]"""
        count = (self.flights or self.typed) + more
        return float(np.hypot(self.spread, self.spread / np.sqrt(count) if count else DEFAULT_DESCENT_SD))

    def usual_speed(self, mass: float, density: float) -> float:
        """Median descent speed near the ground with a landing mass [kg] in air of a density [kg/m^3]. [m/s]"""
        return float(np.exp(self.log_mean) * np.sqrt(mass / density))

    def on_area(self, area: float) -> "Fall":
        """The descent with a fraction of the parachute's area, the main if there are two. [1]"""
        return replace(self, log_mean=self.log_mean - 0.5 * float(np.log(area)))

    def speeds(
        self, rng: np.random.Generator, shape: tuple[int, int], mass: float, density: float, area: float = 1.0
    ) -> Float[Array, "draw flight"]:
        """Descent speeds near the ground of flights with a landing mass [kg] in air [kg/m^3], with a fraction of the
        parachute's area. [m/s]

        Each row is one rocket: its variance and mean are drawn from their joint posterior (normal, inverse chi-square;
        Gelman et al., Bayesian Data Analysis, 2013, section 3.3), and its flights scatter about that mean.
        """
        draws, flights = shape
        count = self.flights or self.typed
        freedom = DESCENT_PRIOR_FLIGHTS + max(count - 1, 0)
        deviation = self.spread * np.sqrt(freedom / rng.chisquare(freedom, (draws, 1)))
        centre = self.log_mean + rng.normal(size=(draws, 1)) * (
            deviation / np.sqrt(count) if count else DEFAULT_DESCENT_SD
        )
        changed = -0.5 * np.log(area) * (1 + AREA_CHANGE_SD * rng.normal(size=(draws, 1)))
        logs = centre + changed + deviation * rng.normal(size=(draws, flights))
        return np.asarray(np.exp(logs) * np.sqrt(mass / density))


def usual(device: Device = "parachute", mass: float = USUAL_MASS, density: float = USUAL_DENSITY) -> Fall:
    """The default descent on an unknown device: at its default speed for a landing mass [kg] in air [kg/m^3], because a
    device is chosen to suit the mass."""
    return Fall(
        _log_speed_factor(DESCENT_SPEED if device == "parachute" else STREAMER_SPEED, mass, density),
        FLIGHT_TO_FLIGHT_SD,
        0,
    )


def fall_of(history: Sequence[tuple[Flight, Found]], plan: Flight | None = None, found: Found | None = None) -> Fall:
    """The descent of a rocket from its flights without anomaly tags, on the plan's device and parachute if named; else
    from the entered values; else the default at the plan's landing mass on its motor. Raises
    ImpossibleFlight for a flight without a dry mass.
    """
    return completed_fall(flown_falls(history, plan), plan, found)


FlownFalls = tuple[Fall | None, Fall | None]
"""The descent measured in flights, of the last device and of a drogue above it; None without data."""


def flown_falls(history: Sequence[tuple[Flight, Found]], plan: Flight | None = None) -> FlownFalls:
    """The descent measured in a rocket's flights without anomaly tags, on the plan's device and parachute if named.

    Raises ImpossibleFlight for a flight without a dry mass.
    """
    wanted = plan.columns.recovery if plan is not None else None
    used = [
        (flight, found)
        for flight, found in history
        if flight.clean and flight.columns.readable("recovery", *RECOVERY_LIMITS) and _same_device(flight, wanted)
    ]
    shown = [shown_speeds(flight, found) for flight, found in used]
    drogue = _pooled([one[1] for one in shown], used) if wanted is not None and wanted.dual else None
    return _pooled([one[0] for one in shown], used), drogue


def completed_fall(flown: FlownFalls, plan: Flight | None = None, found: Found | None = None) -> Fall:
    """The descent measured in flights, completed with the plan's entered values or with defaults."""
    if plan is None:
        return flown[0] or usual()
    wanted, mass, density = plan.columns.recovery, USUAL_MASS, float(air_at_pads([plan]).density[0])
    if plan.dry_mass is not None:
        mass = plan.dry_mass + (found.motor.casing_mass if found is not None else 0.0)
    fall = flown[0] or _typed(wanted, mass, density) or usual(wanted.device, mass, density)
    if not wanted.dual:
        return fall
    return replace(fall, drogue=flown[1] or _typed_drogue(wanted, mass, density))


def _same_device(flight: Flight, wanted: Recovery | None) -> bool:
    """Whether a flight used the device of a plan, and its parachute if the plan names one."""
    if wanted is None:
        return True
    own = flight.columns.recovery
    typed = wanted.main_speed, wanted.parachute_diameter
    return own.device == wanted.device and (typed == (None, None) or typed == (own.main_speed, own.parachute_diameter))


def _typed(wanted: Recovery, mass: float, density: float) -> Fall | None:
    """The descent from an entered speed at a landing mass [kg] in air [kg/m^3], or from the parachute's diameter."""
    if wanted.main_speed is not None:
        return Fall(_log_speed_factor(wanted.main_speed, mass, density), FLIGHT_TO_FLIGHT_SD, 0, typed=TYPED_FLIGHTS)
    if wanted.parachute_diameter is None:
        return None
    drag_area = PARACHUTE_CD * np.pi / 4 * wanted.parachute_diameter**2
    return Fall(float(0.5 * np.log(2 * STANDARD_GRAVITY / drag_area)), PARACHUTE_SD, 0, typed=1)


def _typed_drogue(wanted: Recovery, mass: float, density: float) -> Fall:
    """The drogue as entered, or a default one, at a landing mass [kg] in air [kg/m^3]."""
    if wanted.drogue_speed is None:
        return Fall(_log_speed_factor(DROGUE_SPEED, mass, density), FLIGHT_TO_FLIGHT_SD, 0)
    return Fall(_log_speed_factor(wanted.drogue_speed, mass, density), FLIGHT_TO_FLIGHT_SD, 0, typed=TYPED_FLIGHTS)


def _log_speed_factor(speed: float, mass: float, density: float) -> float:
    """The log of c for a speed near the ground [m/s]."""
    return float(np.log(speed) - 0.5 * np.log(mass / density))


def _pooled(speeds: Sequence[float | None], flights: Sequence[tuple[Flight, Found]]) -> Fall | None:
    """The descent estimated from measured speeds [m/s], None without any."""
    values = np.array([np.nan if speed is None else speed for speed in speeds], float)
    known = np.isfinite(values) & (values > 0)
    if not known.any():
        return None
    masses = np.array([landing_mass(flight, found) for flight, found in flights])
    density = air_at_pads([flight for flight, _ in flights]).density
    logs = np.log(values[known]) - 0.5 * np.log(masses[known] / density[known])
    count = len(logs)
    squares = DESCENT_PRIOR_FLIGHTS * FLIGHT_TO_FLIGHT_SD**2 + ((logs - logs.mean()) ** 2).sum()
    return Fall(float(logs.mean()), float(np.sqrt(squares / (DESCENT_PRIOR_FLIGHTS + count - 1))), count)
