"""Forecasts by time and by flyer: `python -m tools.held_out JOURNAL CONTEST REFERENCE > docs/held-out.md`.

The arguments are one folder or table for each flyer. By time: the hyperprior is learned from flights before a year, and
the flights of the period that begins then are forecast forward in time. By flyer: it is learned without the flyer. Only
the hyperprior is learned again. The structure of the model, the rule for unknown diameters and the bounds of plausible
readouts were chosen when some of these flights had been seen.
"""

import argparse
from collections.abc import Sequence
from datetime import date
from pathlib import Path

import numpy as np

from fieldkit.cli.session import known_motors
from fieldkit.forecast.evaluation.comparison import OWN_FORECAST, tally
from fieldkit.forecast.evaluation.forward_in_time import Forecast, forward, with_stacked
from fieldkit.forecast.evaluation.rivals import LABELS
from fieldkit.inference.laplace.learning import learn_hyperprior
from fieldkit.model.hyperprior import START, Hyperprior
from fieldkit.model.rocket_model import FlownFlight
from fieldkit.services.learn import Flyer, _restricted, read_flyer
from tools.markdown import prose

YEARS = (2013, 2015, 2017)
"""Starts of the periods by time; the last one has no end."""
EXACT_SINCE = date(2011, 8, 1)
"""The journal's altitudes before are estimates."""
ROUNDS, STEPS = 1, 8
"""Linearizations and steps of each fit: all start from `START`."""


def learned_from(flyers: Sequence[Flyer], before: date | None = None) -> Hyperprior:
    """The hyperprior of some flyers' flights, of those before a day."""
    fleets = []
    for flyer in flyers:
        known = [
            [one for one in own if before is None or (one[0].date_time and one[0].date_time.date() < before)]
            for own in flyer.rockets.values()
        ]
        fleets.append([own for own in known if own])
    return learn_hyperprior([fleet for fleet in fleets if fleet], START, ROUNDS, STEPS)


def forecasts(
    flown: Sequence[FlownFlight], hyperprior: Hyperprior, start: date | None, end: date | None
) -> list[Forecast]:
    """The forecasts of one period, with stacking weights from that period alone."""
    known = [one for one in flown if end is None or one[0].date_time is None or one[0].date_time.date() < end]
    return with_stacked(forward(known, hyperprior=hyperprior, since=start))


def table(rows: Sequence[Forecast], alone: Sequence[Forecast]) -> list[str]:
    """One table in percent of the flown apogee."""
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
    for name, label in LABELS.items():
        line(label, rows, name)
    return lines


def main() -> None:
    """Print the page."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("flyers", nargs="+", type=Path)
    motors = known_motors()
    flyers = [read_flyer(path, motors, EXACT_SINCE) for path in parser.parse_args().flyers]
    journal = flyers[0]
    parts: dict[str, tuple[list[Forecast], list[Forecast]]] = {}

    def add(title: str, flyer: Flyer, hyperprior: Hyperprior, start: date | None, end: date | None) -> None:
        apogees = [(_restricted(flight, ("apogee",)), motor) for flight, motor in flyer.flown]
        found = [forecasts(flown, hyperprior, start, end) for flown in (flyer.flown, apogees)]
        own = parts.setdefault(title, ([], []))
        own[0].extend(found[0])
        own[1].extend(found[1])

    for first, last in zip(YEARS, (*YEARS[1:], None), strict=True):
        start, end = date(first, 1, 1), date(last, 1, 1) if last else None
        add(f"{journal.name}, by time", journal, learned_from([journal], start), start, end)
    for flyer in flyers[1:]:
        others = [other for other in flyers if other is not flyer]
        add(f"{flyer.name}, left out", flyer, learned_from(others), None, None)
    print("# Forecasts by time and by flyer\n")
    print("Written by `python -m tools.held_out JOURNAL CONTEST REFERENCE`.\n")
    print(*prose(" ".join(__doc__.split("\n\n", 1)[1].split())), sep="\n")
    years = ", ".join(map(str, YEARS))
    print(*prose(f"Periods begin in {years}. All figures are in percent of the flown apogee, for the 90% interval."))
    for title, (rows, alone) in parts.items():
        for later, words in ((True, "rockets flown before"), (False, "first flights")):
            some = [[row for row in each if bool(row.earlier) is later] for each in (rows, alone)]
            if some[0]:
                print(f"\n## {title}: {words}\n", *table(*some), sep="\n")


if __name__ == "__main__":
    main()
