"""Fleets of five rockets with and without a motor type that becomes weaker for all of them, and what the loop over the
fleet says of it: `python -m bench.shared_changes`.

Apogees are those of the uncalibrated simulation times log-normal factors of rockets, motor types, days and single
flights. Their standard deviations are stated here and are not those of the model's hyperprior: rockets 12%, motor types
6%, days 2%, single flights 4% or 10%, the latter with the tails of a Student t with 3 degrees of freedom.
"""

import argparse
import sys
from collections.abc import Iterator
from dataclasses import dataclass
from datetime import datetime, timedelta

import numpy as np

from fieldkit.flight import Flight
from fieldkit.forecast.evaluation.uncalibrated import simulate
from fieldkit.model.hyperprior import learned
from fieldkit.model.rocket_model import FlownFlight
from fieldkit.motors import catalogue
from fieldkit.selection.fleet_search import fleet_of, search_fleet

MOTORS = ("F24-4W", "E35-5W", "F39T-6", "D12-5", "F52T-5", "E28T-4", "D15T-4")
DAYS = 10
CHANGE = 5
"""The day from which a motor type is weaker, counted from 0."""
ROCKETS = 5


@dataclass(frozen=True, slots=True)
class Case:
    """A kind of fleet: the scatter of single flights [1], its tails, and the change of log apogee on one motor type."""

    name: str
    scatter: float
    heavy: bool
    change: float


CASES = (
    Case("nothing, scatter 4%", 0.04, False, 0.0),
    Case("nothing, scatter 10%, heavy tails", 0.1, True, 0.0),
    Case("apogees 10% lower, scatter 4%", 0.04, False, -0.1),
    Case("apogees 18% lower, scatter 4%", 0.04, False, -0.2),
    Case("apogees 22% lower, scatter 10%, heavy tails", 0.1, True, -0.25),
)


def fleet(rng: np.random.Generator, case: Case) -> tuple[dict[str, list[FlownFlight]], str]:
    """The flights of a fleet by rocket, and the motor type that changes."""
    motors = [str(name) for name in rng.choice(MOTORS, 4, replace=False)]
    own = {name: rng.normal(0, 0.06) for name in motors}
    days = [datetime(2025, 4, 5, 10) + timedelta(days=14 * day) for day in range(DAYS)]
    weather = rng.normal(0, 0.02, DAYS)
    found = {}
    for number in range(ROCKETS):
        factor, count = rng.normal(0, 0.12), int(rng.integers(4, 12))
        rows, plans = [], []
        for flight in range(count):
            day, motor = flight * DAYS // count, str(rng.choice(motors))
            single = (rng.standard_t(3) if case.heavy else rng.normal()) * case.scatter
            changed = case.change if motor == motors[0] and day >= CHANGE else 0.0
            rows.append(factor + own[motor] + weather[day] + single + changed)
            when = days[day] + timedelta(minutes=10 * flight + number)
            plans.append(
                Flight(f"{number}.{flight}", f"R{number}", "A", motor, when, dry_mass=0.3, diameter=0.05, apogee=1.0)
            )
        simulated = simulate([(plan, catalogue().resolve(plan.motor)) for plan in plans])
        found[f"R{number}"] = [
            (one.flight.with_changes(apogee=float(one.simulated * np.exp(row))), one.found)
            for one, row in zip(simulated, rows, strict=True)
        ]
    return found, catalogue().resolve(motors[0]).motor.designation


def table(seed: int, fleets: int) -> Iterator[str]:
    """A row for each kind of fleet: how many have a finding at 50% and at 70%, and of which the right motor."""
    yield "| fleets | with a finding at 50% | at 70% | right motor at 50% | at 70% |"
    yield "|---|---|---|---|---|"
    for case in CASES:
        named, right = {0.5: 0, 0.7: 0}, {0.5: 0, 0.7: 0}
        for number in range(fleets):
            flown, motor = fleet(np.random.default_rng([seed, number]), case)
            first = next(iter(search_fleet(fleet_of(flown, learned()))), None)
            for level in named:
                if first and first.probability >= level:
                    named[level] += 1
                    right[level] += case.change != 0 and motor in first.candidate.of
        yield f"| {case.name} ({fleets}) | {named[0.5]} | {named[0.7]} | {right[0.5]} | {right[0.7]} |"


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--seed", type=int, default=2701)
    parser.add_argument("--fleets", type=int, default=40)
    given = parser.parse_args()
    for line in table(given.seed, given.fleets):
        sys.stdout.write(f"{line}\n")
        sys.stdout.flush()
