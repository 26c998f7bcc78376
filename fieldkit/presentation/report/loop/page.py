"""The report as one self-contained HTML document: text from files is escaped, and scripts cannot run."""

from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from fieldkit import __version__
from fieldkit.errors import BadValue
from fieldkit.files import write
from fieldkit.flight import BY_NAME
from fieldkit.physics.effect import effect_named
from fieldkit.presentation.loop_text import forces_in_words, how_sure, in_next_flight, what_accepting_changes
from fieldkit.presentation.report.html import embedded, rendered
from fieldkit.presentation.report.loop.pictures import pictures, png, svg
from fieldkit.quantities import ShownUnits, in_system, strength_in_words
from fieldkit.scoring.bootstrap import Interval
from fieldkit.selection.diagnose import Diagnosis
from fieldkit.selection.recorded_columns import column_in_words, misses_of
from fieldkit.services.close_loop import version_payload
from fieldkit.services.findings import Compared, Findings

SUFFIXES = (".html", ".htm", ".png")


def check_page(path: Path) -> None:
    """Raise BadValue for a file name with an unsupported suffix."""
    if path.suffix.lower() not in SUFFIXES:
        raise BadValue(f"--report: found {path.name!r}, expected a name that ends in {', '.join(SUFFIXES)}")


def write_page(found: Findings, path: Path, *, force: bool = False, system: str = "SI") -> None:
    """Write the report to a file, as HTML or PNG by its name, in the units of a system; `force` replaces a file.

    Raises BadValue for another suffix, FieldkitError if the file cannot be written or exists.
    """
    check_page(path)
    content = png(found, system) if path.suffix.lower() == ".png" else page(found, system).encode()
    write(path, content, force=force)


def page(found: Findings, system: str = "SI") -> str:
    """The report as an HTML document, in the units of a system."""
    return rendered("loop/page.html", content(found, system))


def content(found: Findings, system: str = "SI") -> dict[str, Any]:
    """Everything that the page shows, as text and pictures, in the units of a system."""
    shown = ShownUnits(system)
    diagnosis = found.diagnosis
    dates = [flight.date_time for flight in diagnosis.model.flights if flight.date_time]
    return {
        "rocket": found.rocket or "this rocket",
        "count": found.left_out.before.flights,
        "span": f"{min(dates):%Y-%m-%d} to {max(dates):%Y-%m-%d}" if dates else "",
        "verdict": _verdict(found, system),
        "figures": _figures(found, shown),
        "tests": [test.words(system) for test in found.tests],
        "patterns": [
            f"{misses_of(row.readout)} follow {column_in_words(row.against)} (p {row.p:.2g} after correction)."
            for row in (*found.patterns, *found.readout_patterns)
            if row.p < 0.1
        ],
        "pictures": {name: embedded(svg(name, found, system)) for name in pictures(found)},
        "climbs": [f"{_capitalized(line)}." for line in forces_in_words(found.diagnosis.forces)],
        "implausible": [f"{_capitalized(line)}." for line in found.excluded],
        "errors": [
            row
            for title, compared in (("left out", found.left_out), ("forward in time", found.forward))
            for row in _errors(title, compared, shown)
        ],
        "how": {"left_out": found.left_out.how, "forward": found.forward.how},
        "parameters": _parameters(diagnosis, system),
        "digest": version_payload(diagnosis)["digest"],
        "spreads": _spreads(found),
        "flights": _flights(diagnosis, shown),
        "version": __version__,
        "unit": shown.length_unit,
    }


def _verdict(found: Findings, system: str) -> dict[str, Any]:
    diagnosis = found.diagnosis
    titles = {"none": "No missing effect found", "unexplained": "Unexplained residual"}
    named = [effect_named(trial.candidate.place.effect).title for trial in diagnosis.accepted]
    return {
        "effect": diagnosis.effect,
        "title": titles.get(diagnosis.effect) or f"{diagnosis.effect}: {' and '.join(named)}",
        "why": _capitalized(in_system(diagnosis.why, system)),
        "also": ", ".join(diagnosis.also),
        "next_flight": _capitalized(in_next_flight(found.next_flight, system)),
        "accepting": [_capitalized(line) for line in what_accepting_changes(found)],
        "how_sure": _capitalized(how_sure(found)),
        "goes_with": _capitalized(found.unexplained.words(system)) if found.unexplained else "",
    }


def _capitalized(sentence: str) -> str:
    """The text with its first letter capitalized; names inside do not change."""
    return sentence[:1].upper() + sentence[1:]


def _figures(found: Findings, shown: ShownUnits) -> list[dict[str, str]]:
    before, after = found.left_out.before.score, found.left_out.after.score
    sure = f"{found.diagnosis.confidence:.0%}" if found.diagnosis.confidence < 0.995 else "over 99%"
    figures = [{"value": shown.length(before.mae, 1), "what": "mean miss, each flight forecast from the others"}]
    if found.diagnosis.effect != "none":
        figures.append({"value": shown.length(after.mae, 1), "what": "with it"})
    return [*figures, {"value": sure, "what": "probability, given what was tried"}]


def _errors(title: str, compared: Compared, shown: ShownUnits) -> list[dict[str, Any]]:
    if not compared.before.flights:
        return []
    rows = []
    for when, judged in (("before", compared.before), ("after", compared.after)):
        score = judged.score
        cells = [
            _cell(score.mae, judged.mae, partial(_height, shown)),
            _cell(score.rmse, judged.rmse, partial(_height, shown)),
            _cell(score.bias, judged.bias, lambda bias: shown.difference(bias).split()[0]),
            _cell(score.coverage90, judged.coverage90, "{:.0%}".format),
        ]
        rows.append({"title": f"{title}, {when}", "flights": judged.flights, "cells": cells})
    return rows


def _cell(value: float, interval: Interval, text: Callable[[float], str]) -> dict[str, str]:
    low, high = interval
    return {"value": text(value), "interval": f"{text(low)} to {text(high)}"}


def _height(shown: ShownUnits, height: float) -> str:
    """A height without its unit."""
    return shown.length(height, 1).split()[0]


def _parameters(diagnosis: Diagnosis, system: str) -> list[dict[str, str]]:
    rows = []
    for trial in diagnosis.accepted:
        mean, sd = trial.strength()
        effect = effect_named(trial.candidate.place.effect)
        rows.append(
            {
                "place": str(trial.candidate.place),
                "explains": effect.explains,
                "strength": strength_in_words(mean, sd, trial.unit, system),
                "source": effect.source,
            }
        )
    return rows


def _spreads(found: Findings) -> list[dict[str, Any]]:
    def cell(value: float, p: float) -> dict[str, str]:
        return {"value": f"{value:+.2f}" if np.isfinite(value) else "", "p": f"p {p:.2g}" if np.isfinite(p) else ""}

    return [
        {
            "title": BY_NAME[row.readout].title.lower(),
            "flights": row.flights,
            "cells": [
                cell(row.bias, row.bias_p),
                {**cell(row.spread, row.spread_p), "value": f"{row.spread:.2f}" if np.isfinite(row.spread) else ""},
                cell(row.autocorrelation, row.autocorrelation_p),
            ],
        }
        for row in found.spreads
    ]


def _flights(diagnosis: Diagnosis, shown: ShownUnits) -> list[dict[str, str]]:
    before, after = diagnosis.forecasts_before.apogee, diagnosis.forecasts_after.apogee
    rows = []
    for number, (flight, used) in enumerate(zip(diagnosis.model.flights, diagnosis.data.seen[:, 0], strict=True)):
        rows.append(
            {
                "id": flight.flight_id,
                "date": f"{flight.date_time:%Y-%m-%d}" if flight.date_time else "",
                "config": flight.config,
                "motor": flight.motor,
                "apogee": "" if flight.apogee is None else _height(shown, flight.apogee),
                "before": _height(shown, before[number]) if used else "",
                "after": _height(shown, after[number]) if used else "",
                "tags": ", ".join(flight.tags),
            }
        )
    return rows
