"""Learn from first flights of high-power rockets how well a design, a certified motor and a weighed rocket determine
the apogee.

Derivation: each flight has the apogee and top speed that a design program forecast. The dry mass and Cd of the rocket
follow from these two, and its readouts are linear around them. The log ratio of flown to forecast apogee is then normal
with mean s m and variance u + s^2 v + d^2 w: u is the variance of single flights in thrust and drag; s
(`Hyperprior.high_power`) scales the other random effects of mass, thrust and apogee, whose mean effect on the apogee is
m and whose variance is v; d (`Hyperprior.design_drag`) is the
standard deviation of the log Cd around that of a design, and w the square of the effect of drag. s and d maximize the
likelihood times a scaled inverse chi-squared prior for each square, as do the other variances (see `learning`).
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from scipy.optimize import least_squares, minimize
from scipy.stats import norm

from fieldkit.flight import Flight
from fieldkit.inference.laplace.learning import PRIOR_GROUPS
from fieldkit.inference.laplace.leave_one_out import own_reading_sd
from fieldkit.inference.laplace.linearization import launch_angle_slope, tangents
from fieldkit.model.high_power import CLOSER_AT_HIGH_POWER
from fieldkit.model.hyperprior import DESIGN_DRAG, Hyperprior
from fieldkit.model.rocket_model import apogee_scatter, base_model
from fieldkit.model.term_names import TermName, fleet_term
from fieldkit.motors import Found
from fieldkit.physics.flight import fly
from fieldkit.physics.history import field_setup, history_of
from fieldkit.shapes import Array, Float

MASS_GRID = np.geomspace(0.2, 10.0, 40)
"""Dry masses at which the search for that of a forecast starts, relative to the loaded motor. [1]"""
CD_GRID = np.linspace(0.2, 1.2, 21)
"""The same for the drag coefficient, and its limits. [1]"""
ALL_BURNT = 60.0
"""Delay after which no ejection disturbs the climb. [s]"""


@dataclass(frozen=True, slots=True)
class DesignForecast:
    """A first flight on one motor with its diameter and apogee, and what design programs forecast for it: apogees [m],
    one or more, and the top speed [m/s]."""

    flight: Flight
    found: Found
    apogees: tuple[float, ...]
    top_speed: float


@dataclass(frozen=True, slots=True)
class Departure:
    """The log ratios of a flown apogee to its forecasts, and their variance by origin (see the module). [1]"""

    rocket: str
    ratios: tuple[float, ...]
    mean: float
    of_flights: float
    scaled: float
    by_drag: float

    def moments(self, hyperprior: Hyperprior) -> tuple[float, float]:
        """Mean and standard deviation of the log ratio. [1]"""
        scale = hyperprior.high_power
        variance = self.of_flights + scale**2 * self.scaled + hyperprior.design_drag**2 * self.by_drag
        return scale * self.mean, float(np.sqrt(variance))


def departure(forecast: DesignForecast, hyperprior: Hyperprior) -> Departure:
    """The departure of a flight from its forecasts. Raises ImpossibleFlight if no rocket fits the forecasts."""
    dry_mass, cd = matched(forecast)
    flight = replace(forecast.flight, dry_mass=dry_mass, delay=ALL_BURNT)
    model = base_model(history_of([flight], [forecast.found], flown=0), replace(hyperprior, high_power=1.0))
    model = model.with_prior(fleet_term("drag"), 0.0).with_prior(TermName("drag"), float(np.log(cd)))
    at = np.array([term.mean for term in model.terms])
    tangent = tangents(model, [(tuple(range(len(at))), at)], launch_angle_slope(model, at))[0]
    slope = dict(zip(model.names, tangent.slope[0, 0].tolist(), strict=True))
    scaled = [slope[term.name] * term.sd for term in model.terms if term.bends in CLOSER_AT_HIGH_POWER]
    flown = float(forecast.flight.apogee or 0.0)
    reading = float(own_reading_sd(np.array([flown]), hyperprior)[0])
    return Departure(
        rocket=flight.rocket,
        ratios=tuple(float(np.log(flown / apogee)) for apogee in forecast.apogees),
        mean=sum(slope.get(fleet_term(name), 0.0) * hyperprior.mean(name) for name in CLOSER_AT_HIGH_POWER),
        of_flights=float((tangent.scatter_slope[0, 0] ** 2).sum()) + reading**2,
        scaled=float(np.square([*scaled, *apogee_scatter(model)]).sum()),
        by_drag=slope[TermName("drag")] ** 2,
    )


def matched(forecast: DesignForecast) -> tuple[float, float]:
    """The dry mass [kg] and Cd [1] with which the simulation has the forecast apogee and top speed.

    Several forecast apogees count with their geometric mean. A light and a heavy rocket may reach the same
    apogee; the speed distinguishes them, so the search starts from the best point of a grid. Derivation: least squares
    with two equations for two unknowns.
    """
    wanted = np.log([np.exp(np.mean(np.log(forecast.apogees))), forecast.top_speed])
    area = np.pi / 4 * float(forecast.flight.diameter or np.nan) ** 2

    def misses(log_mass: Array, log_cd: Array) -> Array:
        flights = [replace(forecast.flight, dry_mass=float(mass), delay=ALL_BURNT) for mass in np.exp(log_mass)]
        setup = field_setup(flights, [forecast.found] * len(flights), area * np.exp(log_cd))
        shown = fly(setup).readouts()
        with np.errstate(divide="ignore", invalid="ignore"):
            logs = np.log([shown["apogee"], shown["top_speed"]]).T - wanted
        return np.asarray(np.nan_to_num(logs, nan=-10.0, neginf=-10.0))

    grid = np.log(np.array(np.meshgrid(MASS_GRID * forecast.found.motor.loaded_mass, CD_GRID)).reshape(2, -1))
    start = grid[:, (misses(*grid) ** 2).sum(axis=1).argmin()]
    ends = np.log(CD_GRID[[0, -1]])
    start[1] = np.clip(start[1], ends[0] + 1e-6, ends[1] - 1e-6)

    def one(at: Array) -> Array:
        return np.asarray(misses(at[:1], at[1:])[0])

    best = least_squares(one, start, bounds=([-np.inf, ends[0]], [np.inf, ends[1]]), diff_step=[1e-3, 1e-3])
    mass, cd = np.exp(best.x)
    return float(mass), float(cd)


def learn_high_power(departures: Sequence[Departure], hyperprior: Hyperprior) -> Hyperprior:
    """The hyperprior with `high_power` and `design_drag` from first flights. Several forecasts of one flight share its
    weight."""

    def loss(logs: Float[Array, "2"]) -> float:
        scale, drag = np.exp(logs)
        now = replace(hyperprior, high_power=float(scale), design_drag=float(drag))
        total = sum(-log_density(one, now) for one in departures)
        return float(total + sum(_prior_loss(log) for log in logs - np.log([1.0, DESIGN_DRAG])))

    best = minimize(
        loss, np.log([0.5, 0.5 * DESIGN_DRAG]), method="Nelder-Mead", options={"xatol": 1e-4, "fatol": 1e-6}
    )
    scale, drag = np.exp(best.x)
    return replace(hyperprior, high_power=float(scale), design_drag=float(drag))


def log_density(one: Departure, hyperprior: Hyperprior) -> float:
    """Log density of a flight's log ratio, the mean over its forecasts. Derivation: see the module. [nat]"""
    return float(np.mean(norm.logpdf(one.ratios, *one.moments(hyperprior))))


def _prior_loss(log_ratio: float) -> float:
    """Minus the log prior density of the logarithm of a standard deviation over its start.

    The variance has a scaled inverse chi-squared distribution (Gelman et al., Bayesian Data Analysis, 2013, appendix
    A), so the mode is 0.
    """
    return PRIOR_GROUPS / 2 * (2 * log_ratio + float(np.exp(-2 * log_ratio)))
