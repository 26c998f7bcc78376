"""First forecasts of designed rockets beside those of teams: `python -m tools.first_forecasts TABLE`.

The table has one flight of a rocket in each row: `forecast_m`, the apogee that its team forecast with a design
program, and `apogee_m`. It took no part in learning. The model forecasts typical designs of the same classes, relative
to their simulation with the Cd of the design. Flights below half of their forecast count as failures, which a forecast
of a usual flight does not contain. The rival is normal with the mean and standard deviation of the other rockets' log
ratios.
"""

import argparse
import csv
from collections.abc import Iterator
from pathlib import Path

import numpy as np

from fieldkit.flight import Flight
from fieldkit.forecast.predict import predict
from fieldkit.motors import catalogue
from fieldkit.physics.history import field_setup
from fieldkit.physics.unique import fly_unique
from fieldkit.scoring.proper_scores import crps
from fieldkit.shapes import Array, Float
from tools.markdown import table

DESIGNS = (("K550W", 5.0, 0.100), ("L1482", 12.0, 0.130), ("M1939W", 18.0, 0.152), ("M1939W", 25.0, 0.152))
"""Motor, dry mass [kg] and diameter [m] of typical rockets for 3 km."""
CD = 0.5
FAILED = 0.5
"""Ratio of apogee to forecast below which a flight failed. [1]"""
ENDS = (0.75, 0.85, 1.15, 1.25)
"""Ratios beyond which the fractions of flights are counted. [1]"""


def expected() -> Float[Array, "draw"]:
    """Draws of the log ratio of an apogee to the simulation of the design, equally many for each design. [1]"""
    found = []
    for name, mass, diameter in DESIGNS:
        motor = catalogue().resolve(name)
        flight = Flight("1", "R", "A", name, dry_mass=mass, diameter=diameter)
        simulated = fly_unique(field_setup([flight], [motor], np.array([np.pi / 4 * diameter**2 * CD]))).apogee
        (made,) = predict([], [(flight, motor)], cds={"A": CD})
        found.append(np.log(made.apogee / simulated))
    return np.concatenate(found)


def row(name: str, logs: Float[Array, "flight"], score: float | None) -> list[str]:
    """One line of the table, in percent."""
    middle = np.median(logs)
    spread = 1.4826 * np.median(np.abs(logs - middle))
    parts = [np.mean(logs < np.log(end)) if end < 1 else np.mean(logs > np.log(end)) for end in ENDS]
    figures = [100 * np.expm1(middle), 100 * spread, *(100 * part for part in parts)]
    return [name, *(f"{figure:.1f}" for figure in figures), "" if score is None else f"{100 * score:.2f}"]


def page(path: Path) -> Iterator[str]:
    """The table, and how many flights it leaves out."""
    with path.open(encoding="utf-8") as file:
        ratios = np.array([float(one["apogee_m"]) / float(one["forecast_m"]) for one in csv.DictReader(file)])
    logs, own = np.log(ratios[ratios > FAILED]), expected()
    others = [np.delete(logs, turn) for turn in range(len(logs))]
    even = np.random.default_rng(0).normal(size=len(own))
    rival = [crps(one.mean() + one.std(ddof=1) * even, flown) for one, flown in zip(others, logs, strict=True)]
    model, plain = (np.mean([crps(draws, flown) for flown in logs]) for draws in (own, np.zeros(1)))
    ends = [f"below {end - 1:+.0%}" if end < 1 else f"above {end - 1:+.0%}" for end in ENDS]
    yield from table(
        ["", "median", "robust sd", *ends, "CRPS"],
        [
            row(f"{len(logs)} flights", logs, None),
            row("fieldkit", own, model),
            row("design program", np.zeros(1), plain),
            row("program, mean ratio", np.mean(logs) + np.std(logs, ddof=1) * even, float(np.mean(rival))),
        ],
    )
    yield f"{np.sum(ratios <= FAILED)} of {len(ratios)} flights failed."


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("table", type=Path)
    print(*page(parser.parse_args().table), sep="\n")
