"""The dry mass that best meets a target, solved on the distribution: draws are common to all masses."""

from dataclasses import dataclass
from typing import Any, Literal

import numpy as np

from fieldkit.errors import ImpossibleFlight
from fieldkit.motors import Found
from fieldkit.plan.learnt import Learnt, outcomes
from fieldkit.shapes import Array, Float

GRID = 24
"""Masses that are flown. [1]"""
LIGHTEST, HEAVIEST = 0.6, 1.8
"""Of the masses tried where the flyer sets no bounds, in dry masses of today. [1]"""
SOFT = 0.5
"""By which the edge of the band is rounded, so that the chance is smooth in the mass. [m]"""

Aim = Literal["chance", "error"]


@dataclass(frozen=True, slots=True)
class Ballast:
    """The dry mass to fly [kg], what to add to today's [kg], and what it brings.

    `apogee` is at 5, 50 and 95 % [m], `slope` how the apogee changes with mass [m/kg], `chance` that of landing in
    the band [1] and `error` the mean miss [m], `today` both as they are without change. `reach` is the median
    apogee of the heaviest and the lightest mass tried [m]; the target is `met` where it lies between.
    """

    mass: float
    add: float
    apogee: tuple[float, float, float]
    slope: float
    chance: float
    error: float
    today: tuple[float, float]
    reach: tuple[float, float]
    met: bool

    def json(self) -> dict[str, Any]:
        """Ready for JSON, with the unit in the key."""
        return {
            "dry_mass_g": self.mass * 1e3,
            "add_g": self.add * 1e3,
            "apogee_m": dict(zip(("p05", "p50", "p95"), self.apogee, strict=True)),
            "slope_m_per_g": self.slope / 1e3,
            "chance": self.chance,
            "mean_error_m": self.error,
            "today": {"chance": self.today[0], "mean_error_m": self.today[1]},
            "reach_m": list(self.reach),
            "met": self.met,
        }


def ballast(
    learnt: Learnt,
    found: Found,
    target: float,
    within: float,
    aim: Aim = "chance",
    bounds: tuple[float | None, float | None] = (None, None),
) -> Ballast:
    """The dry mass in `bounds` [kg] that maximises the chance of an apogee `within` of the target, or with the aim
    "error" minimises the mean miss, which are the points of a contest for altitude. [m]

    The apogee is as the altimeter shows it, its own error included. Raises ImpossibleFlight where no mass lifts off.
    """
    from scipy.interpolate import PchipInterpolator
    from scipy.optimize import minimize_scalar

    today = learnt.plan.dry_mass
    if today is None:
        raise ImpossibleFlight("found no dry mass, expected --dry-mass, the rocket's mass without its motor")
    low, high = (edge or today * share for edge, share in zip(bounds, (LIGHTEST, HEAVIEST), strict=True))
    if not 0 < low < high:
        raise ImpossibleFlight(f"found masses from {low * 1e3:g} to {high * 1e3:g} g, expected the lighter first")
    masses = np.linspace(low, high, GRID)
    plans = [learnt.plan.with_changes(dry_mass=float(mass)) for mass in (*masses, today)]
    flown = outcomes(learnt, plans, [found] * len(plans)).of("apogee")
    if not np.median(flown[:, 0]) > 0:
        raise ImpossibleFlight(f"{found.motor.designation}: found too little thrust for {low * 1e3:.0f} g")
    curve = PchipInterpolator(masses, flown[:, :-1], axis=1)

    def cost(mass: float) -> float:
        chance, error = _score(np.asarray(curve(mass)), target, within)
        return -chance if aim == "chance" else error

    costs = [cost(float(mass)) if np.median(curve(mass)) > 0 else np.inf for mass in masses]
    # far from the target every chance is nothing: there the mean miss leads the way
    if aim == "chance" and min(costs) > -1e-3:
        return ballast(learnt, found, target, within, "error", bounds)
    best = int(np.argmin(costs))
    around = masses[max(best - 1, 0)], masses[min(best + 1, GRID - 1)]
    result = minimize_scalar(cost, bounds=around, method="bounded", options={"xatol": 1e-5})
    mass = float(result.x) if result.fun <= costs[best] else float(masses[best])
    there = np.asarray(curve(mass))
    p05, p50, p95 = (float(value) for value in np.quantile(there, (0.05, 0.5, 0.95)))
    chance, error = _score(there, target, within)
    reach = np.median(flown[:, :-1], axis=0)
    return Ballast(
        mass=mass,
        add=mass - today,
        apogee=(p05, p50, p95),
        slope=float(np.median(curve(mass, 1))),
        chance=chance,
        error=error,
        today=_score(flown[:, -1], target, within),
        reach=(float(reach.min()), float(reach.max())),
        met=bool(reach.min() <= target <= reach.max()),
    )


def _score(apogee: Float[Array, "draw"], target: float, within: float) -> tuple[float, float]:
    """The chance to be within the band, its edges rounded, and the mean miss. [1], [m]"""
    miss = np.abs(apogee - target)
    inside = 1 / (1 + np.exp(np.clip((miss - within) / SOFT, -50, 50)))
    return float(inside.mean()), float(miss.mean())
