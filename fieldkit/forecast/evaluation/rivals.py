"""Rivals of the model: simple forecasts from earlier flights that the model has to beat.

Each is a function of the earlier clean flights with an apogee, of all rockets in the order flown, and of the planned
one. It returns equally likely apogees [m], a single one if it has no spread, or None if it has too little data.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from fieldkit.flight import Flight
from fieldkit.forecast.evaluation.fleet_ratio import fleet_ratio
from fieldkit.forecast.evaluation.uncalibrated import Simulated, simulate, uncalibrated
from fieldkit.motors import Found
from fieldkit.scoring.proper_scores import crps
from fieldkit.shapes import Array, Float

DRAWS = 400
"""Number of equally likely values that represent a distribution. [1]"""
FEWEST_RATIOS = 3
"""Minimum number of ratios for a spread of the scalar correction. [1]"""

PRIOR_FLIGHTS, PRIOR_SD = 4.0, 0.15
"""Prior of the scatter of the last-flight rule: as many flights, with that standard deviation of the log ratio, a round
figure. [1]"""

RivalDraws = Float[Array, "draw"]
Rival = Callable[[Sequence[Simulated], Simulated], RivalDraws | None]


def own(earlier: Sequence[Simulated], plan: Simulated) -> list[Simulated]:
    """The earlier flights of the planned flight's rocket."""
    return [one for one in earlier if one.flight.rocket == plan.flight.rocket]


def scalar(earlier: Sequence[Simulated], plan: Simulated) -> RivalDraws | None:
    """The simulation times the mean ratio of the rocket's earlier flights: one plus their mean relative bias.

    With three or more ratios, the log of the next one is normal with their scatter around an uncertain mean.
    """
    ratios = np.array([one.ratio for one in own(earlier, plan) if np.isfinite(one.ratio)])
    if not len(ratios):
        return None
    middle = plan.simulated * ratios.mean()
    if len(ratios) < FEWEST_RATIOS:
        return np.array([middle])

    from scipy.special import ndtri  # only `score` and mixed forecasts need it, and it takes 0.1 s to import

    sd = np.log(ratios).std(ddof=1) * np.sqrt(1 + 1 / len(ratios))
    return np.asarray(middle * np.exp(sd * ndtri((np.arange(DRAWS) + 0.5) / DRAWS)))


def last_on_motor(earlier: Sequence[Simulated], plan: Simulated) -> RivalDraws | None:
    """The apogee of the rocket's last flight on the same motor type, or else the scalar correction."""
    same = [one for one in own(earlier, plan) if one.found.motor is plan.found.motor]
    return _flown(same[-1]) if same else scalar(earlier, plan)


def last_flight(earlier: Sequence[Simulated], plan: Simulated) -> RivalDraws | None:
    """The apogee of the rocket's last flight on the same motor type, or else the simulation times its last ratio, with
    the scatter that this rule had on the earlier flights of all rockets.

    The log of the next apogee over the rule's is a Student t around zero, whose scale has a scaled inverse chi-squared
    prior that counts as `PRIOR_FLIGHTS` flights with `PRIOR_SD` (Gelman et al., Bayesian Data Analysis, 3rd edition,
    2013, section 2.6).
    """
    middle = _rule(earlier, plan)
    if middle is None:
        return None

    from scipy.special import stdtrit  # only `score` and mixed forecasts need it, and it takes 0.1 s to import

    past = [(one.flight.apogee, _rule(earlier[:row], one)) for row, one in enumerate(earlier)]
    misses = np.array([np.log(flown / ruled) for flown, ruled in past if flown and ruled])
    freedom = PRIOR_FLIGHTS + len(misses)
    sd = np.sqrt((PRIOR_FLIGHTS * PRIOR_SD**2 + (misses**2).sum()) / freedom)
    return np.asarray(middle * np.exp(sd * stdtrit(freedom, (np.arange(DRAWS) + 0.5) / DRAWS)))


def _rule(earlier: Sequence[Simulated], plan: Simulated) -> float | None:
    """The last apogee on the same motor type, or else the simulation times the last ratio; None for a first flight.
    [m]"""
    before = own(earlier, plan)
    same = [one.flight.apogee for one in before if one.found.motor is plan.found.motor and one.flight.apogee]
    ratios = [one.ratio for one in before if np.isfinite(one.ratio)]
    return same[-1] if same else plan.simulated * ratios[-1] if ratios else None


def flight_before(earlier: Sequence[Simulated], plan: Simulated) -> RivalDraws | None:
    """The apogee of the rocket's previous flight, on any motor."""
    same = own(earlier, plan)
    return _flown(same[-1]) if same else None


def _flown(one: Simulated) -> RivalDraws:
    return np.array([one.flight.apogee], float)


RIVALS: Mapping[str, Rival] = {
    "uncalibrated": uncalibrated,
    "scalar": scalar,
    "last_on_motor": last_on_motor,
    "last_flight": last_flight,
    "flight_before": flight_before,
    "fleet_ratio": fleet_ratio,
}
MIXTURE = "stacked"
"""The mixture of the model with some rivals, weighted by their forecasts of earlier flights."""
LABELS: Mapping[str, str] = {
    "uncalibrated": "uncalibrated",
    "scalar": "scalar correction",
    "last_on_motor": "last on motor, else scalar",
    "last_flight": "last on motor, else last ratio",
    "flight_before": "flight before",
    "fleet_ratio": "fleet ratio",
    MIXTURE: "mixed with rivals",
}
"""Names of the rivals in tables."""
BAR = "scalar"
"""The main rival, which anyone can compute: a simulation times the mean ratio of the flights so far."""


@dataclass(frozen=True, slots=True)
class RivalScore:
    """The mean absolute error and the mean CRPS of a rival over some flights. [m]"""

    name: str
    mae_m: float
    crps_m: float


def rival_scores(flown: Sequence[tuple[Flight, Found]]) -> tuple[RivalScore, ...]:
    """The scores of every rival on the clean flights of one rocket, each forecast from the earlier ones; only on those
    that all of these rivals can forecast. Raises ImpossibleFlight for a flight without a dry mass."""
    clean = [one for one in simulate(flown) if one.flight.clean and one.flight.apogee is not None]
    made = [(rival_draws(clean[:turn], one), float(one.flight.apogee or 0.0)) for turn, one in enumerate(clean) if turn]
    names = [name for name in RIVALS if made and all(name in draws for draws, _ in made)]
    return tuple(
        RivalScore(
            LABELS[name],
            float(np.mean([abs(np.median(draws[name]) - apogee) for draws, apogee in made])),
            float(np.mean([crps(draws[name], apogee) for draws, apogee in made])),
        )
        for name in names
    )


def rival_draws(earlier: Sequence[Simulated], plan: Simulated) -> dict[str, RivalDraws]:
    """The forecasts of a planned flight by the rivals that have enough data."""
    made = {name: rival(earlier, plan) for name, rival in RIVALS.items()}
    return {name: draws for name, draws in made.items() if draws is not None}
