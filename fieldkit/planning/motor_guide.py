"""The motor guide: every motor that fits a rocket, with a forecast from the rocket's flights."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from fieldkit.errors import UnknownMotor
from fieldkit.flight import Flight
from fieldkit.flight.site import Site
from fieldkit.forecast.kinds import by_kind
from fieldkit.forecast.predict import FittedForecast
from fieldkit.forecast.prediction import Prediction, median
from fieldkit.inference.laplace.linearization import coast_times
from fieldkit.motors import Catalogue, Found
from fieldkit.motors.motor import Motor
from fieldkit.motors.names import with_delay
from fieldkit.motors.several import CLUSTER_NOTE
from fieldkit.paths import data_file
from fieldkit.planning.check import SafetyCheck
from fieldkit.planning.delay import obtainable, sold_delays
from fieldkit.planning.descent_rate import Fall, completed_fall, flown_falls
from fieldkit.planning.forecasts import RocketData, fitted_forecast, forecast_plans
from fieldkit.planning.kits import DIAMETER_TOLERANCE
from fieldkit.planning.limits import Limits
from fieldkit.planning.margin import with_margin
from fieldkit.planning.quantiles import Three, named, three
from fieldkit.planning.rules import known_rules
from fieldkit.planning.safety import safety_lines, thrust_to_weight
from fieldkit.settings import read_settings
from fieldkit.units import STANDARD_GRAVITY

DRAWS = 64
"""Flights simulated for each motor, with common random numbers: a 5% quantile is accurate to a quarter of a standard
deviation."""
SLANTED_PATH_DRAWS = 40
"""The same if wind or rail angle make the paths slanted, which take several times as long: accurate to a third."""
RAIL_CHECK = "rail exit speed"
EJECTION_CHECK = "ejection speed"
THRUST_CHECK = "thrust to weight"
FIT_CHECKS = (RAIL_CHECK, THRUST_CHECK, EJECTION_CHECK, "ceiling", "field size")
"""Checks that a motor must pass to fit a rocket."""
LEAST_THRUST = 2.0
"""Thrust-to-weight ratio below which a motor is not offered at all: the rocket would not leave the rod. [1]"""


@dataclass(frozen=True, slots=True)
class Wanted:
    """Requirements for a motor. Lengths in m, impulse in N s, `classes` first and last letter, `names` a shortlist.

    Without a `mount` every diameter is allowed; with `adapter` also diameters below it. With `dry_mass` [kg] the motor
    must lift it.
    """

    mount: float | None = None
    length: float = math.inf
    impulse: float = math.inf
    classes: tuple[str, str] | None = None
    retired: bool = False
    adapter: bool = False
    names: frozenset[str] | None = None
    dry_mass: float | None = None

    def fits(self, motor: Motor) -> bool:
        """Whether a motor meets all requirements."""
        wide = 0.0 if self.mount is None else motor.diameter - self.mount
        letter = "A" if "/" in motor.impulse_class else motor.impulse_class
        return (
            (wide < DIAMETER_TOLERANCE if self.adapter else abs(wide) < DIAMETER_TOLERANCE)
            and motor.length <= self.length + DIAMETER_TOLERANCE
            and motor.total_impulse <= self.impulse
            and (self.retired or motor.available)
            and (self.classes is None or self.classes[0] <= letter <= self.classes[1])
            and (self.names is None or label(motor) in self.names)
            and (self.dry_mass is None or lifts(motor, self.dry_mass))
        )


def label(motor: Motor) -> str:
    """Maker and designation: `AeroTech F24W`."""
    return f"{motor.maker} {motor.designation}"


def _found(motor: Motor) -> Found:
    """A motor without a delay, with the note on a cluster."""
    return Found(motor, None, (CLUSTER_NOTE,) if motor.parts else ())


def lifts(motor: Motor, dry_mass: float) -> bool:
    """Whether a motor would lift a rocket of this dry mass [kg] off a rod."""
    return motor.average_thrust > LEAST_THRUST * (dry_mass + motor.loaded_mass) * STANDARD_GRAVITY


@dataclass(frozen=True, slots=True)
class MotorChoice:
    """A motor with its delay as in `guide`, the forecast flight and its safety lines.

    `ejections` are this and its delays for sale, and the expected time after apogee at which each would fire [s],
    negative before it; `flown` is whether this rocket has flown it. Thrust to weight is for the first half second and
    for the average [1]. `beyond_season` are the limits of a contest season that it breaks, if one was named.
    """

    motor: Motor
    delay: float | None
    ejections: tuple[tuple[float, float], ...]
    prediction: Prediction
    flown: bool
    first_thrust: float
    average_thrust: float
    lines: tuple[SafetyCheck, ...]
    fall: Fall
    """The basis of the descent."""
    beyond_season: tuple[SafetyCheck, ...] = ()

    @property
    def name(self) -> str:
        """The motor as it is bought: `AeroTech F24W-4`; without a known delay, `AeroTech F24W`."""
        return label(self.motor) if self.delay is None else with_delay(label(self.motor), self.delay)

    @property
    def apogee(self) -> float:
        """Median of the altimeter's apogee reading. [m]"""
        return float(np.median(self.prediction.apogee))

    @property
    def interval(self) -> Three:
        """The 5, 50 and 95% quantiles of the altimeter's apogee reading. [m]"""
        return self.prediction.apogee_quantiles()

    def with_forecast(self, prediction: Prediction) -> "MotorChoice":
        """The same motor with a forecast of more draws; its delays fire by as much earlier or later as that says of the
        chosen one."""
        fires, delay = prediction.median_eject, self.delay
        if fires is None or delay is None:
            return replace(self, prediction=prediction)
        ejections = tuple((one, one - delay + fires) for one, _ in self.ejections)
        return replace(self, prediction=prediction, ejections=ejections)

    @property
    def plan(self) -> Flight:
        """The planned flight on this motor with its delay."""
        return self.prediction.plan.with_changes(motor=self.name)

    @property
    def why_not(self) -> list[SafetyCheck]:
        """Why a motor does not fit: too weak, slow off the rail, no suitable delay, too high, too small a field, or
        beyond a limit of the season."""
        unsafe = [line for line in self.lines if line.name in FIT_CHECKS and line.verdict == "unsafe"]
        return [*unsafe, *self.beyond_season]

    @property
    def fits(self) -> bool:
        """Whether a motor is safe and sensible for this rocket, and allowed in the season, as far as known."""
        return not self.why_not

    @property
    def weak(self) -> bool:
        """Whether its thrust for this weight asks for caution, whatever the rail and the delay."""
        return any(line.name == THRUST_CHECK and line.failed for line in self.lines)

    @property
    def not_judged(self) -> list[str]:
        """What the fit depends on but the plan leaves open: the rail, a ceiling, an unknown delay."""
        rail = self.plan.rail_length is not None
        return [
            line.name
            for line in self.lines
            if line.name in FIT_CHECKS
            and (line.verdict == "unknown" or (line.name == RAIL_CHECK and not rail and line.failed))
        ]

    @property
    def failed(self) -> list[SafetyCheck]:
        """The safety lines that are neither ok nor unknown."""
        return [line for line in self.lines if line.failed]

    def json(self) -> dict[str, Any]:
        """Ready for JSON, with the unit in the key."""
        return {
            "maker": self.motor.maker,
            "motor": self.motor.designation,
            "class": self.motor.impulse_class,
            "delay_s": self.delay,
            "apogee_m": named(three(self.prediction.apogee)),
            "true_apogee_m": named(three(self.prediction.true_apogee)),
            "rail_speed_mps": median(self.prediction.rail_speed),
            "top_speed_mps": median(self.prediction.top_speed),
            "thrust_to_weight": {"first_half_second": self.first_thrust, "average": self.average_thrust},
            "apogee_to_eject_s": [{"delay_s": d, "after_apogee_s": after} for d, after in self.ejections],
            "flown": self.flown,
            "fits": self.fits,
            "why_not": [line.name for line in self.why_not],
            "not_judged": self.not_judged,
            "safety": [line.json() for line in self.lines],
        }


def mount_of(rocket: RocketData, config: str) -> float | None:
    """The mount of a rocket: the diameter of the widest motor flown in its configuration, or else by the rocket. [m]"""
    diameters = [found.motor.diameter for flight, found in rocket.history if flight.config == config]
    return max(diameters or [found.motor.diameter for found in rocket.motors], default=None)


def widest_motor(rocket: RocketData, plan: Flight) -> float | None:
    """The mount of a rocket as in `mount_of`; for one that has not flown, that of its kit, else its body diameter, an
    upper bound. [m]"""
    return mount_of(rocket, plan.config) or rocket.mount or plan.diameter


def suitable_motors(catalogue: Catalogue, wanted: Wanted) -> list[Motor]:
    """The motors that fit, from the catalog and the user's own. Raises UnknownMotor if none does."""
    widest = math.inf if wanted.mount is None else wanted.mount + DIAMETER_TOLERANCE
    near = [
        listing
        for listings in catalogue.listings.values()
        for listing in listings
        if listing.diameter < widest and (wanted.retired or listing.available)
    ]
    motors = [motor for listing in near if wanted.fits(motor := listing.motor())]
    if not motors:
        mount = "any" if wanted.mount is None else f"a {wanted.mount * 1e3:g} mm"
        raise UnknownMotor(f"found no motor for {mount} mount within these limits, expected wider limits")
    return motors


def guide(
    rocket: RocketData,
    plan: Flight,
    motors: Sequence[Motor],
    limits: Limits,
    site: Site,
    draws: int | None = None,
    saved: Sequence[Found] = (),
) -> list[MotorChoice]:
    """The forecast flight of a plan on each motor, in the same order; nothing is saved.

    A motor has the delay of the plan, or else that with which it is `saved` in an open forecast, if that is for sale or
    can be drilled; else the one for sale that fires closest to apogee. It is simulated `draws` times, by default as
    many as are quick. Raises ImpossibleFlight for a plan without a mass, BadValue for a damaged file of rules.
    """
    if not motors:
        return []
    draws = draws or (SLANTED_PATH_DRAWS if plan.wind or plan.rail_angle else DRAWS)
    planned = [
        (with_margin(plan.with_changes(motor=label(motor), delay=None), rocket.known, motor), _found(motor))
        for motor in motors
    ]

    def flown(rows: Sequence[int]) -> list[ForecastWithDelay]:
        fitted = fitted_forecast(rocket, [planned[row] for row in rows], draws)
        wanted = saved_delays(saved) if plan.delay is None else dict.fromkeys(map(label, motors), plan.delay)
        return _flown(rocket, replace(fitted, model=replace(fitted.model, coarse=True)), wanted)

    known, falls = {label(found.motor) for found in rocket.motors}, flown_falls(rocket.history, plan)
    by = limits, known_rules(), read_settings()
    return [
        MotorChoice(
            motor,
            delay,
            _ejections(motor, delay, coast if (prediction.apogee > 0).mean() > 0.5 else math.nan),
            prediction,
            label(motor) in known,
            *thrust_to_weight(motor, prediction.plan.dry_mass or math.nan),
            tuple(
                safety_lines(prediction, site, fall := completed_fall(falls, prediction.plan, prediction.found), *by)
            ),
            fall,
        )
        for motor, (delay, coast, prediction) in zip(motors, by_kind(rocket.history, planned, flown), strict=True)
    ]


ForecastWithDelay = tuple[float | None, float, Prediction]
"""The delay in `guide`, if any [s], the coast from burnout to apogee without a charge [s], and the flight
with that delay. A charge before apogee would end the coast."""


def saved_delays(saved: Sequence[Found]) -> dict[str, float]:
    """The delays of motors in open forecasts, the latest first, by the motors' labels. [s]"""
    return {label(found.motor): found.delay for found in reversed(saved) if found.delay is not None}


def _flown(rocket: RocketData, fitted: FittedForecast, wanted: Mapping[str, float]) -> list[ForecastWithDelay]:
    """Each motor of the fit, with the delay `wanted` for its label [s] if it can have that, else its most suitable
    one."""
    coasts = coast_times(fitted.model, fitted.at)
    delays = [
        _delay(found.motor, coast, wanted.get(label(found.motor)))
        for found, coast in zip(fitted.model.found, coasts, strict=True)
    ]
    made = forecast_plans(rocket, _with_delays(fitted, delays))
    return list(zip(delays, coasts.tolist(), made, strict=True))


def _with_delays(fitted: FittedForecast, delays: Sequence[float | None]) -> FittedForecast:
    return replace(fitted, model=replace(fitted.model, history=fitted.model.history.with_delays(delays)))


def _delay(motor: Motor, coast: float, wanted: float | None) -> float | None:
    """The `wanted` delay if it is for sale or can be drilled, else the one for sale that fires closest to apogee, the
    shortest for a motor that would not lift the rocket. [s]"""
    if wanted is not None and wanted in obtainable(motor, data_file("drills.toml")):
        return wanted
    return min(sold_delays(motor), key=lambda delay: abs(delay - np.nan_to_num(coast)), default=None)


def _ejections(motor: Motor, chosen: float | None, coast: float) -> tuple[tuple[float, float], ...]:
    delays = sorted({*sold_delays(motor), *([chosen] if chosen else [])})
    return tuple((delay, delay - coast) for delay in delays if math.isfinite(coast))


@dataclass(frozen=True, slots=True)
class MotorOrder:
    """The order of motors in every list, after those that fit: by distance from a `target` [m]; without one those
    `preferred` first, then those whose thrust needs no caution, nearest to the last apogee of the rocket [m]."""

    target: float | None = None
    preferred: Sequence[Motor] = ()
    last_apogee: float = 0.0

    def place(self, motor: Motor, apogee: float, *, weak: bool) -> tuple[float, bool, float]:
        """The sort key of a motor with a forecast apogee [m], whose thrust for the weight may be `weak`."""
        if self.target is not None:
            return math.inf, False, abs(apogee - self.target)
        names = [label(one) for one in self.preferred]
        rank = names.index(label(motor)) if label(motor) in names else math.inf
        return rank, weak, abs(apogee - self.last_apogee)

    def sorted(self, found: Sequence[MotorChoice]) -> list[MotorChoice]:
        """Those that fit first."""
        return sorted(found, key=lambda one: (not one.fits, *self.place(one.motor, one.apogee, weak=one.weak)))


def motor_order(rocket: RocketData, config: str, target: float | None, saved: Sequence[Found] = ()) -> MotorOrder:
    """The order for a configuration of a rocket, with a `target` or without [m]: preferred are the motors `saved` in
    open forecasts and those that it has flown on, the latest first. Without a flight of the configuration, the last
    apogee is that of the rocket."""
    preferred = tuple(dict.fromkeys(found.motor for found in [*saved, *reversed(rocket.motors)]))
    clean = [flight for flight in rocket.flights if flight.clean and flight.apogee is not None]
    own = [flight for flight in clean if flight.config == config]
    return MotorOrder(target, preferred, next((flight.apogee or 0.0 for flight in reversed(own or clean)), 0.0))
