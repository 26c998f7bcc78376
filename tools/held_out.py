"""Forecasts by time and by flyer: `python -m tools.held_out JOURNAL CONTEST REFERENCE > docs/held-out.md`.

The arguments are one folder or table for each flyer. By time: the hyperprior is learned from flights before a year, and
the flights of the period that begins then are forecast forward in time. By flyer: it is learned without the flyer. The
structure of the model, the rule for unknown diameters and the bounds of plausible readouts were chosen when some of
these flights had been seen. With the *structure chosen again*, each group of random effects that was added since then
is in the model only if the flights learned from have a higher log evidence with it. Fewer than five flights have no
table.
"""

import argparse
import os
from collections.abc import Sequence
from dataclasses import dataclass
from datetime import date
from pathlib import Path

import numpy as np

from fieldkit.cli.session import known_motors
from fieldkit.forecast.evaluation.comparison import OWN_FORECAST, tally
from fieldkit.forecast.evaluation.forward_in_time import Forecast, forward, with_stacked
from fieldkit.forecast.evaluation.rivals import LABELS
from fieldkit.inference.laplace.learning import evidence, learn_hyperprior
from fieldkit.model.hyperprior import START, Hyperprior
from fieldkit.model.rocket_model import FlownFlight
from fieldkit.parallel import processes
from fieldkit.services.learn import Flyer, _restricted, read_flyer
from tools.markdown import prose

YEARS = (2013, 2015, 2017)
"""Starts of the periods by time; the last one has no end."""
MIN_FLIGHTS = 5
"""Minimum number of flights of a table. [1]"""
EXACT_SINCE = date(2011, 8, 1)
"""The journal's altitudes before are estimates."""
ROUNDS, STEPS = 1, 8
"""Linearizations and steps of each fit: all start from `START`."""
CHOSEN = ("mass.drift", "apogee.rocket_motor", "apogee.day", "peak_accel.motor")
"""Random effects that were added when some of the flights had been seen."""


def learned_from(flyers: Sequence[Flyer], before: date | None = None) -> tuple[Hyperprior, Hyperprior, list[str]]:
    """The hyperprior of some flyers' flights, of those before a day; the one without the random effects of `CHOSEN`
    that they do not support; and these."""
    fleets = []
    for flyer in flyers:
        known = [
            [one for one in own if before is None or (one[0].date_time and one[0].date_time.date() < before)]
            for own in flyer.rockets.values()
        ]
        fleets.append([own for own in known if own])
    fleets = [fleet for fleet in fleets if fleet]
    found = learn_hyperprior(fleets, START, ROUNDS, STEPS)
    whole = evidence(fleets, found)
    gone = [name for name in CHOSEN if evidence(fleets, without(found, [name])) > whole]
    return found, learn_hyperprior(fleets, without(START, gone), ROUNDS, STEPS) if gone else found, gone


def without(hyperprior: Hyperprior, gone: Sequence[str]) -> Hyperprior:
    """A hyperprior without some random effects."""
    return hyperprior.with_sds(**{name.replace(".", "__"): 0.0 for name in gone})


def forecasts(
    flown: Sequence[FlownFlight], hyperprior: Hyperprior, start: date | None, end: date | None
) -> list[Forecast]:
    """The forecasts of one period, with stacking weights from that period alone."""
    known = [one for one in flown if end is None or one[0].date_time is None or one[0].date_time.date() < end]
    return with_stacked(forward(known, hyperprior=hyperprior, since=start))


def table(rows: Sequence[Forecast], alone: Sequence[Forecast], chosen: Sequence[Forecast]) -> list[str]:
    """One table in percent of the flown apogee: forecasts by the model, from apogees alone, and with the structure
    chosen again."""
    lines = [
        "| method | flights | median error | mean error | bias | CRPS | interval score | coverage | width |",
        "|---|---|---|---|---|---|---|---|---|",
    ]

    def line(name: str, some: Sequence[Forecast], way: str) -> None:
        one = tally(some, way)
        if not one.flights:
            return
        width = np.mean([(row.p95 - row.p05) / row.flown for row in some]) if way == OWN_FORECAST else np.nan
        figures = (one.median_share, one.mean_share, one.median_bias, one.crps, one.interval_score)
        cells = [name, str(one.flights), *(f"{100 * figure:.1f}" for figure in figures), f"{one.coverage90:.0%}"]
        lines.append("| " + " | ".join([*cells, f"{100 * width:.0f}" if np.isfinite(width) else ""]) + " |")

    line("fieldkit", rows, OWN_FORECAST)
    line("fieldkit, from apogees alone", alone, OWN_FORECAST)
    line("fieldkit, structure chosen again", chosen, OWN_FORECAST)
    for name, label in LABELS.items():
        line(label, rows, name)
    return lines


@dataclass(frozen=True, slots=True)
class Fold:
    """Flights of a flyer from a day to another, to be forecast with what those of the teachers before show."""

    title: str
    flyer: Flyer
    teachers: Sequence[Flyer]
    start: date | None = None
    end: date | None = None

    def forecast(self) -> tuple[list[str], list[list[Forecast]]]:
        """The random effects left out of the structure chosen again, and the forecasts by the model, from apogees
        alone, and with that structure."""
        whole, chosen, gone = learned_from(self.teachers, self.start)
        every = self.flyer.flown
        apogees = [(_restricted(flight, ("apogee",)), motor) for flight, motor in every]
        ways = ((every, whole), (apogees, whole), (every, chosen))
        return gone, [forecasts(flown, by, self.start, self.end) for flown, by in ways]


def folds(flyers: Sequence[Flyer]) -> list[Fold]:
    """Periods of the first flyer, then each of the others left out."""
    journal, *others = flyers
    years = [date(year, 1, 1) for year in YEARS]
    by_time = [
        Fold(f"{journal.name}, by time", journal, [journal], start, end)
        for start, end in zip(years, (*years[1:], None), strict=True)
    ]
    return by_time + [
        Fold(f"{flyer.name}, left out", flyer, [other for other in flyers if other is not flyer]) for flyer in others
    ]


def main() -> None:
    """Print the page."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("flyers", nargs="+", type=Path)
    motors = known_motors()
    every = folds([read_flyer(path, motors, EXACT_SINCE) for path in parser.parse_args().flyers])
    with processes(os.cpu_count() or 1) as pool:
        found = list(pool.map(Fold.forecast, every))
    parts: dict[str, list[list[Forecast]]] = {}
    left_out: dict[str, list[str]] = {}
    for fold, (gone, ways) in zip(every, found, strict=True):
        left_out[f"{fold.title}, from {fold.start.year}" if fold.start else fold.title] = gone
        for rows, own in zip(parts.setdefault(fold.title, [[], [], []]), ways, strict=True):
            rows += own
    print("# Forecasts by time and by flyer\n")
    print("Written by `python -m tools.held_out JOURNAL CONTEST REFERENCE`.\n")
    print(*prose(" ".join(__doc__.split("\n\n", 1)[1].split())), sep="\n")
    years = ", ".join(map(str, YEARS))
    print(*prose(f"Periods begin in {years}. All figures are in percent of the flown apogee, for the 90% interval."))
    print("\n| forecasts of | left out of the structure chosen again |\n|---|---|")
    print(*(f"| {title} | {', '.join(gone) or 'nothing'} |" for title, gone in left_out.items()), sep="\n")
    for title, ways in parts.items():
        for later, words in ((True, "rockets flown before"), (False, "first flights")):
            some = [[row for row in each if bool(row.earlier) is later] for each in ways]
            if len(some[0]) >= MIN_FLIGHTS:
                print(f"\n## {title}: {words}\n", *table(*some), sep="\n")


if __name__ == "__main__":
    main()
