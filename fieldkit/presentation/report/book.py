"""What a report is of: one flight, every flight of a rocket, or those of a day, with the loop's findings."""

import re
from collections.abc import Sequence
from contextlib import suppress
from dataclasses import dataclass
from datetime import date

import numpy as np

from fieldkit.errors import LedgerError, NoFlights
from fieldkit.flight import Flight
from fieldkit.ledger import Ledger
from fieldkit.motors import Catalogue
from fieldkit.presentation.report.card import Card, cards, left_out, totals
from fieldkit.progress import ReportProgress, part
from fieldkit.services.close_loop import look
from fieldkit.services.findings import Findings

MAX_FITS = 20
"""Flights of a report up to which each that has no saved prediction is forecast by a fit to the others; in longer ones
the loop's forecasts with the flight left out are shown, which cost nothing more. [1]"""


@dataclass(frozen=True, slots=True, eq=False)
class FlightReport:
    """A report: the cards in the order flown, and the loop's findings by rocket where it is of more than a flight."""

    title: str
    subtitle: str
    cards: tuple[Card, ...]
    loops: tuple[Findings, ...] = ()
    summary: bool = False

    @property
    def figures(self) -> tuple[tuple[str, str], ...]:
        """Figures of the whole: value and what it is."""
        apogees = [one.flight.apogee for one in self.cards if one.flight.apogee is not None]
        predicted, miss, inside = totals(self.cards)
        rows = [(str(len(self.cards)), "flights")]
        if apogees:
            rows.append((f"{max(apogees):.0f} m", "highest apogee"))
        rows.append((str(predicted), "predicted"))
        if predicted:
            rows += [(f"{miss:.1f} m", "mean miss"), (f"{inside} of {predicted}", "inside 90 %")]
        return tuple(rows)

    @property
    def findings(self) -> tuple[str, ...]:
        """What the loop found of each rocket, a sentence or two."""
        return tuple(line for found in self.loops for line in loop_words(found))


def loop_words(found: Findings) -> list[str]:
    """The verdict on a rocket, and what it does to errors of flights that the fit did not see."""
    diagnosis, left = found.diagnosis, found.left_out
    lines = [f"{found.rocket}: {diagnosis.effect}: {diagnosis.why}."]
    before, after = left.before.score, left.after.score
    error = f"Mean leave-one-out error {before.mae:.1f} m"
    lines.append(error + (f", {after.mae:.1f} m with it." if diagnosis.effect != "none" else "."))
    if diagnosis.also:
        lines.append(f"These flights cannot distinguish it from {', '.join(diagnosis.also)}.")
    return lines


def book(ledger: Ledger, motors: Catalogue, what: str, on_progress: ReportProgress) -> FlightReport:
    """The report of what a text means: a day as 2026-05-01, a flight's id, or a rocket's name, in that order.

    Raises LedgerError for one that means nothing, with near names.
    """
    if re.fullmatch(r"\d{4}-\d{2}-\d{2}", what) and (flights := _of_day(ledger, what)):
        rockets = list(dict.fromkeys(one.rocket for one in flights))
        sites = ", ".join(dict.fromkeys(one.site for one in flights if one.site))
        return _of_several(ledger, motors, f"Launch day {what}", sites, flights, rockets, on_progress)
    try:
        flight = ledger.flight(what)
    except LedgerError:
        if what not in ledger.names("rocket"):
            raise
        flights = ledger.flights(what)
        return _of_several(ledger, motors, what, _span(flights), flights, [what], on_progress)
    (card,) = cards(ledger, motors, [flight], on_progress)
    return FlightReport(f"Flight {card.id}", " ".join((flight.rocket, flight.config)).strip(), (card,))


def _of_several(
    ledger: Ledger,
    motors: Catalogue,
    title: str,
    subtitle: str,
    flights: Sequence[Flight],
    rockets: Sequence[str],
    on_progress: ReportProgress,
) -> FlightReport:
    loops = []
    for place, rocket in enumerate(rockets):
        own = part(part(on_progress, 0.0, 0.6), place / len(rockets), 1 / len(rockets))
        with suppress(NoFlights):  # too few flights to close it
            loops.append(look(ledger, motors, rocket, own))
    known = {} if len(flights) <= MAX_FITS else {key: one for found in loops for key, one in left_out(found).items()}
    made = cards(ledger, motors, flights, part(on_progress, 0.6, 0.4), known)
    return FlightReport(title, subtitle, tuple(made), tuple(loops), summary=True)


def _of_day(ledger: Ledger, what: str) -> list[Flight]:
    try:
        day = date.fromisoformat(what)
    except ValueError:
        return []
    return [one for one in ledger.flights() if one.date_time and one.date_time.date() == day]


def _span(flights: Sequence[Flight]) -> str:
    dates = [one.date_time for one in flights if one.date_time]
    return f"{min(dates):%Y-%m-%d} to {max(dates):%Y-%m-%d}" if dates else ""


def table(found: FlightReport) -> tuple[tuple[str, ...], list[tuple[str, ...]]]:
    """The flights of a report as a table: headers, and a row for each."""
    headers = ("flight", "rocket", "motor", "mass g", "wind m/s", "predicted m", "flown m", "miss m", "")
    rows: list[tuple[str, ...]] = []
    for card in found.cards:
        flight, said = card.flight, card.forecast
        mark = ", ".join(flight.tags)
        if said and said.kept and said.changes:
            mark = ", ".join(filter(None, ("stale prediction", mark)))
        rows.append(
            (
                card.id,
                " ".join((flight.rocket, flight.config)).strip(),
                flight.motor,
                _number(flight.dry_mass, 1e3, ".0f"),
                _number(flight.wind, 1.0, ".1f"),
                f"{said.interval[1]:.0f}" if said and said.kept else "",
                _number(flight.apogee, 1.0, ".1f"),
                _number(card.miss, 1.0, "+.1f") if said and said.kept else "",
                mark,
            )
        )
    return headers, rows


def _number(value: float | None, scale: float, form: str) -> str:
    return "" if value is None or not np.isfinite(value) else format(value * scale, form)
