"""Contest points: seasons are files in `fieldkit/data/seasons`, flights and plans are scored by them."""

import tomllib
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from fieldkit.errors import BadValue, NoFlights
from fieldkit.flight import Flight
from fieldkit.motors import Found
from fieldkit.plan.learnt import Learnt, outcomes
from fieldkit.shapes import Array, Float
from fieldkit.units import FOOT

FOLDER = Path(__file__).parents[1] / "data" / "seasons"
DESCENT_SD = 0.10
"""Of the log descent speed from flight to flight, where too few flights tell. [1]"""


@dataclass(frozen=True, slots=True)
class Season:
    """The rule of one season, in SI; `per_metre` and `per_second` are points, the `best` of `declared` count."""

    year: int
    target: float
    window: tuple[float, float]
    per_metre: float
    per_second: float
    best: int
    declared: int
    checked: bool
    remarks: str

    def points(self, apogee: Float[Array, "*draw"], duration: Float[Array, "*draw"]) -> Float[Array, "*draw"]:
        """Points of flights, fewer being better; an unknown duration (nan) costs none."""
        late = np.maximum(np.maximum(self.window[0] - duration, duration - self.window[1]), 0.0)
        return np.asarray(self.per_metre * np.abs(apogee - self.target) + self.per_second * np.nan_to_num(late))


def seasons() -> list[int]:
    """The years there are files of."""
    return sorted(int(file.stem) for file in FOLDER.glob("*.toml"))


def season(year: int) -> Season:
    """The rule of a year. Raises BadValue that names the years there are, or what a file lacks."""
    file = FOLDER / f"{year}.toml"
    if not file.exists():
        raise BadValue(f"found no season {year}, expected one of {', '.join(map(str, seasons()))}")
    try:
        rule = tomllib.loads(file.read_text(encoding="utf-8"))
        low, high = (float(end) for end in rule["window_s"])
        return Season(
            year=int(rule["season"]),
            target=float(rule["target_ft"]) * FOOT,
            window=(low, high),
            per_metre=float(rule["points_per_ft"]) / FOOT,
            per_second=float(rule["points_per_s"]),
            best=int(rule["best"]),
            declared=int(rule["declared"]),
            checked=bool(rule["checked"]),
            remarks=str(rule.get("remarks", "")),
        )
    except (KeyError, ValueError, TypeError) as error:
        raise BadValue(
            f"{file.name}: found {error}, expected every key of a season with a value of its kind"
        ) from error


def score(rule: Season, flights: Sequence[Flight]) -> list[tuple[Flight, float]]:
    """Flights with an apogee and their points, in the order given. Raises NoFlights where none has one."""
    known = [(flight, flight.apogee) for flight in flights if flight.apogee is not None]
    if not known:
        raise NoFlights("found no flight with an apogee, expected at least one to score")
    return [
        (flight, float(rule.points(np.array(height), np.array(np.nan if flight.duration is None else flight.duration))))
        for flight, height in known
    ]


def descent_speeds(flights: Sequence[Flight]) -> Float[Array, "flight"]:
    """Of each clean flight that tells: as read, else from apogee and duration, a fifth of which is ascent. [m/s]"""
    speeds = [
        flight.descent_speed
        if flight.descent_speed is not None
        else flight.apogee / (0.8 * flight.duration)
        if flight.apogee and flight.duration
        else None
        for flight in flights
        if flight.clean
    ]
    return np.array([speed for speed in speeds if speed], float)


def expected_points(
    rule: Season, learnt: Learnt, plan: Flight, found: Found, flights: Sequence[Flight]
) -> tuple[Float[Array, "draw"], bool]:
    """Points of a plan as draws, and whether its duration counts: only where a flight told the descent."""
    flown = outcomes(learnt, [plan], [found])
    apogee = flown.of("apogee")[:, 0]
    speeds = descent_speeds(flights)
    if not speeds.size:
        return rule.points(apogee, np.full(len(apogee), np.nan)), False
    logs = np.log(speeds)
    spread = np.hypot(DESCENT_SD if len(logs) < 4 else logs.std(ddof=1), DESCENT_SD / np.sqrt(len(logs)))
    rng = np.random.default_rng([learnt.seed, 3])
    fall = np.exp(logs.mean() + spread * rng.normal(size=len(apogee)))
    up = np.nan_to_num(flown.of("coast_to_apogee") + flown.of("burn_time"))[:, 0]
    return rule.points(apogee, up + flown.of("true")[:, 0] / fall), True


def chance_to_qualify(rule: Season, points: Float[Array, "draw"], cut: float, seed: int = 0) -> float:
    """That the sum of the best declared flights is within a cut. [1] Flights are drawn as if independent."""
    rng = np.random.default_rng([seed, 4])
    declared = rng.choice(points, size=(4000, rule.declared))
    return float((np.sort(declared, axis=1)[:, : rule.best].sum(axis=1) <= cut).mean())
