"""Draws the pictures of `docs/evidence.md`, and prints its figures: `python -m tools.evidence [JOURNAL CONTEST]`.

The drag along the coasts of the flights with air brakes is that in `docs/real-forces.md`, the scores of forecasts are
those in `docs/held-out.md`; how far each reference flight differs from the others is computed, with no flight tagged.
With the ledgers of the journal and of the contest teams, the causes of their flights and what their rockets share are
found again and written to `docs/measured/evidence.json`.
"""

import html
import json
import re
import sys
from collections.abc import Iterator, Sequence
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

from fieldkit.ledger import Ledger
from fieldkit.motors import catalogue
from fieldkit.paths import REFERENCE_FLIGHTS
from fieldkit.presentation.fleet_text import fleet_document
from fieldkit.services.fleet_loop import close_fleet_loop
from fieldkit.services.imports import bring_in
from fieldkit.services.one_offs import flights_beside_others
from tools.markdown import MEASURED, commit
from tools.noted_causes import causes_found

DOCS = Path(__file__).parents[1] / "docs"
WIDTH, HEIGHT, LEFT, TOP, BOTTOM = 760, 300, 60, 40, 50
"""Size and margins of a picture. [px]"""
FOUND, MISSED, USUAL = "#c2410c", "#2563eb", "#64748b"
"""Colors of flights with something found, of those where it was missed, and of usual ones."""
OPEN_BRAKES = {
    "contest_2_15_26_flight_3": FOUND,
    "contest_2_7_26_flight_2": FOUND,
    "contest_12_23_25_flight_4": MISSED,
}
"""Flights whose brakes opened in the coast, by the color of what the loop found."""
OWN = ("fieldkit", "fieldkit, from apogees alone", "fieldkit, structure chosen again", "mixed with rivals")
"""Methods that are not simple rules."""
SETS = {"journal, by time": "one flyer's later flights", "contest_teams, left out": "contest teams"} | {
    "reference_flights, left out": "flights of a paper"
}
"""Sets of flights in `docs/held-out.md`, and their names in the picture."""


def drag_along_coasts() -> list[tuple[str, list[float]]]:
    """Flights with air brakes: their name, and drag relative to the rocket's own in each sixth of the coast. [1]"""
    rows = re.findall(r"^\| (contest_\w+) ((?:\| [\d.]+ ){6})\|", _page("real-forces"), flags=re.MULTILINE)
    return [(name, [float(cell) for cell in re.findall(r"[\d.]+", cells)]) for name, cells in rows]


def crps_beside_rules() -> list[tuple[str, float, float]]:
    """Sets of flights: the CRPS of fieldkit's forecasts of rockets that flew before, and that of the best simple rule.
    [%]"""
    found = []
    for head, name in SETS.items():
        section = _page("held-out").partition(f"## {head}: rockets flown before")[2].partition("## ")[0]
        rows = re.findall(r"^\| ([^|]+) (?:\| [^|]* ){4}\| ([\d.]+) ", section, flags=re.MULTILINE)
        scores = {method.strip(): float(crps) for method, crps in rows}
        found.append((name, scores["fieldkit"], min(crps for method, crps in scores.items() if method not in OWN)))
    return found


def chances_of_one_offs() -> list[tuple[str, str, float]]:
    """The reference flights with no tag: number, the authors' tag, and the probability that the flight differs from the
    others, in whole percents. [1]"""
    with TemporaryDirectory() as folder, Ledger.open(Path(folder) / "ledger.db") as ledger:
        bring_in(ledger, [REFERENCE_FLIGHTS], lambda name: None)
        tags = {flight.flight_id: ", ".join(flight.tags) for flight in ledger.flights()}
        for number, tagged in tags.items():
            if tagged:
                ledger.edit(number, tags=())
        beside = flights_beside_others(ledger, catalogue(), "Astra")
    return [(one.flight.flight_id, tags[one.flight.flight_id], round(one.probability, 2)) for one in beside]


def causes_and_shared(ledger: Ledger) -> dict[str, Any]:
    """The causes found in the flights of a ledger, and what its rockets share, without the names of rockets."""
    shared = fleet_document(close_fleet_loop(ledger, catalogue()))
    for finding in shared["findings"]:
        finding |= {"rockets": len(finding["rockets"]), "flights": len(finding["flights"]), "others": []}
    return {"n_flights": len(ledger.flights()), "causes": causes_found(ledger), "shared": shared}


def _page(name: str) -> str:
    return (DOCS / f"{name}.md").read_text(encoding="utf-8")


def brakes_picture() -> str:
    """A line for each flight with brakes."""
    flights = drag_along_coasts()
    top = max(max(ratios) for _, ratios in flights)
    marks = [*_axis("drag relative to the rocket's own", [0.5, 1.0, 1.5, 2.0, 2.5], top, "{:g}")]
    for name, ratios in flights:
        color = OPEN_BRAKES.get(name, USUAL)
        points = [(_across(place, len(ratios)), _up(ratio, top)) for place, ratio in enumerate(ratios)]
        path = " ".join(f"{x:.1f},{y:.1f}" for x, y in points)
        marks.append(f'<polyline points="{path}" fill="none" stroke="{color}" stroke-width="2.5"/>')
    marks += [_text(_across(place, 6), HEIGHT - 25, f"{place + 1}/6", "middle") for place in range(6)]
    marks.append(_text(WIDTH / 2, HEIGHT - 6, "part of the coast, burnout to apogee", "middle"))
    marks += _legend((FOUND, "brakes found"), (MISSED, "brakes missed"), (USUAL, "brakes shut, or no effect"))
    return _svg(marks)


def scores_picture() -> str:
    """Two bars for each set of flights."""
    scores = crps_beside_rules()
    top = max(max(own, rule) for _, own, rule in scores)
    marks = [*_axis("CRPS in percent of the apogee", [0.0, 5.0, 10.0, 15.0], top, "{:g}%")]
    for place, (name, own, rule) in enumerate(scores):
        middle = _across(place, len(scores))
        marks += _bar(middle - 46, own, top, FOUND, f"{own}%") + _bar(middle + 2, rule, top, USUAL, f"{rule}%")
        marks.append(_text(middle, HEIGHT - 25, name, "middle"))
    return _svg(marks + list(_legend((FOUND, "fieldkit"), (USUAL, "best simple rule"))))


def one_offs_picture() -> str:
    """A bar for each reference flight."""
    flights = chances_of_one_offs()
    marks = [*_axis("probability that it differs", [0.0, 0.25, 0.5], 0.5, "{:.0%}")]
    for place, (number, tag, chance) in enumerate(flights):
        middle = _across(place, len(flights))
        marks += _bar(middle - 20, chance, 0.5, FOUND if tag else USUAL, f"{chance:.0%}")
        marks.append(_text(middle, HEIGHT - 25, number, "middle"))
    marks.append(_text(WIDTH / 2, HEIGHT - 6, "reference flight", "middle"))
    return _svg(marks + list(_legend((FOUND, "its authors noted a failure"), (USUAL, "its authors noted none"))))


def _across(place: int, of: int) -> float:
    """The middle of a column. [px]"""
    return LEFT + (WIDTH - LEFT - 10) * (place + 0.5) / of


def _up(value: float, top: float) -> float:
    """The height of a value. [px]"""
    return HEIGHT - BOTTOM - (HEIGHT - TOP - BOTTOM) * value / (1.05 * top)


def _axis(title: str, ticks: Sequence[float], top: float, form: str) -> Iterator[str]:
    """The title above, and a line for each value."""
    yield _text(10, 18, title, "start")
    for tick in (one for one in ticks if one <= 1.05 * top):
        y = _up(tick, top)
        yield f'<line x1="{LEFT}" y1="{y:.1f}" x2="{WIDTH - 10}" y2="{y:.1f}" stroke="#cbd5e1"/>'
        yield _text(LEFT - 8, y + 5, form.format(tick), "end")


def _bar(x: float, value: float, top: float, color: str, text: str) -> list[str]:
    y = _up(value, top)
    bar = f'<rect x="{x:.1f}" y="{y:.1f}" width="40" height="{HEIGHT - BOTTOM - y:.1f}" fill="{color}"/>'
    return [bar, _text(x + 20, y - 5, text, "middle")]


def _legend(*entries: tuple[str, str]) -> Iterator[str]:
    """Colors and their meaning, from the right of the upper edge."""
    x = float(WIDTH)
    for color, text in reversed(entries):
        x -= 40 + 7 * len(text)
        yield f'<rect x="{x:.0f}" y="7" width="14" height="14" fill="{color}"/>'
        yield _text(x + 20, 19, text, "start")


def _text(x: float, y: float, text: str, anchor: str) -> str:
    return f'<text x="{x:.1f}" y="{y:.1f}" text-anchor="{anchor}">{html.escape(text)}</text>'


def _svg(marks: Sequence[str]) -> str:
    head = f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {WIDTH} {HEIGHT}" font-family="sans-serif"'
    back = f'<rect width="{WIDTH}" height="{HEIGHT}" fill="#ffffff"/>'
    return "\n".join([f'{head} font-size="14" fill="#1e293b">', back, *marks, "</svg>"]) + "\n"


PICTURES = {"brakes": brakes_picture, "one_offs": one_offs_picture, "scores": scores_picture}
"""Pictures of the page by the last part of their names."""


def main(*ledgers: str) -> None:
    """Write the pictures, and the figures of the two ledgers if they are given."""
    for name, draw in PICTURES.items():
        path = DOCS / f"evidence_{name}.svg"
        path.write_text(draw(), encoding="utf-8")
        print(path)
    found: dict[str, Any] = {"command": "python -m tools.evidence JOURNAL CONTEST", "commit": commit()}
    for name, file in zip(("journal", "contest"), ledgers, strict=False):
        with Ledger.open(Path(file)) as ledger:
            found[name] = causes_and_shared(ledger)
    if ledgers:
        text = json.dumps(found, indent=1, ensure_ascii=False) + "\n"
        (MEASURED / "evidence.json").write_text(text, encoding="utf-8")
        print(text)


if __name__ == "__main__":
    main(*sys.argv[1:])
