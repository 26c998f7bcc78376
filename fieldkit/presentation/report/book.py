"""The subject of a report: one flight, every flight of a rocket, or the flights of a day, with the loop's findings."""

import re
from collections.abc import Callable, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from datetime import date
from functools import partial

import numpy as np

from fieldkit.errors import LedgerError, NoFlights, nearest, unknown
from fieldkit.flight import Flight
from fieldkit.flight.short_name import flight_label
from fieldkit.ledger import Ledger
from fieldkit.motors import Catalogue
from fieldkit.presentation.report.card import Card, cards, left_out, totals
from fieldkit.progress import ReportProgress, part
from fieldkit.quantities import ShownUnits, counted, in_system
from fieldkit.services.close_loop import look
from fieldkit.services.findings import Findings

MAX_FITS = 20
"""Maximum number of flights in a report that forecasts each flight without a saved prediction by a separate fit to the
others; longer reports use the loop's leave-one-out forecasts. [1]"""


@dataclass(frozen=True, slots=True, eq=False)
class FlightReport:
    """A report: the cards in the order flown, and the loop's findings by rocket if it has more than one flight.

    `earlier` counts the flights before these.
    """

    title: str
    subtitle: str
    cards: tuple[Card, ...]
    loops: tuple[Findings, ...] = ()
    summary: bool = False
    system: str = "SI"
    earlier: int = 0

    @property
    def figures(self) -> tuple[tuple[str, str], ...]:
        """Summary figures: value and title."""
        shown = ShownUnits(self.system)
        apogees = [one.flight.apogee for one in self.cards if one.flight.apogee is not None]
        predicted, miss, inside = totals(self.cards)
        rows = [(str(len(self.cards)), "flight" if len(self.cards) == 1 else "flights")]
        if apogees:
            rows.append((shown.length(max(apogees)), "highest apogee"))
        rows.append((str(predicted), "forecast"))
        if miss is not None:
            rows += [(shown.length(miss, 1), "mean miss"), (f"{inside} of {predicted}", "inside 90%")]
        return tuple(rows)

    @property
    def findings(self) -> tuple[str, ...]:
        """The loop's findings for each rocket, in one or two sentences."""
        return tuple(line for found in self.loops for line in loop_words(found, self.system))


def loop_words(found: Findings, system: str = "SI") -> list[str]:
    """The verdict on a rocket, and the mean miss of each flight forecast from the others, in the units of a system."""
    diagnosis, left, shown = found.diagnosis, found.left_out, ShownUnits(system)
    lines = [f"{found.rocket}: {diagnosis.effect}: {in_system(diagnosis.why, system)}."]
    before, after = left.before.score, left.after.score
    error = f"Each flight, forecast from the others, misses by {shown.length(before.mae, 1)} on average"
    lines.append(error + (f", by {shown.length(after.mae, 1)} with it." if diagnosis.effect != "none" else "."))
    if diagnosis.also:
        lines.append(f"These flights cannot distinguish it from {', '.join(diagnosis.also)}.")
    return lines


def book(
    ledger: Ledger,
    motors: Catalogue,
    what: str,
    on_progress: ReportProgress,
    system: str = "SI",
    last: int | None = None,
) -> FlightReport:
    """The report on a day such as 2026-05-01, a flight id, or a rocket, tried in that order, in the units of a system;
    of a day or a rocket with the `last` flights only.

    Raises LedgerError with similar names if nothing matches.
    """
    if re.fullmatch(r"\d{4}-\d{2}-\d{2}", what) and (flights := _of_day(ledger, what)):
        sites = ", ".join(dict.fromkeys(one.site for one in flights if one.site))
        day = FlightReport(f"Launch day {what}", sites, (), summary=True, system=system)
        return _of_several(ledger, motors, day, flights, last, on_progress)
    try:
        flight = ledger.flight(what)
    except LedgerError as error:
        rockets = ledger.names("rocket")
        if what not in rockets:
            if nearest(what, rockets):
                raise LedgerError(unknown("flight, rocket or day", what, rockets)) from error
            raise
        flights = ledger.flights(what)
        season = FlightReport(what, _span(flights), (), summary=True, system=system)
        return _of_several(ledger, motors, season, flights, last, on_progress)
    (card,) = cards(ledger, motors, [flight], on_progress, system)
    subtitle = " ".join((flight.rocket, flight.config)).strip()
    return FlightReport(flight_label(card.id, "Flight"), subtitle, (card,), system=system)


def _of_several(
    ledger: Ledger,
    motors: Catalogue,
    empty: FlightReport,
    flights: Sequence[Flight],
    last: int | None,
    on_progress: ReportProgress,
) -> FlightReport:
    """A report with the cards of the `last` of some flights, and the loop's findings for their rockets."""
    shown = flights[-last:] if last else flights
    rockets = list(dict.fromkeys(one.rocket for one in shown))
    loops = []
    for place, rocket in enumerate(rockets):
        own = part(part(on_progress, 0.0, 0.6), place / len(rockets), 1 / len(rockets))
        with suppress(NoFlights):  # too few flights for the loop
            loops.append(look(ledger, motors, rocket, own))
    known = None
    if len(shown) > MAX_FITS:
        known = {key: one for found in loops for key, one in left_out(found, empty.system).items()}
    made = cards(ledger, motors, shown, part(on_progress, 0.6, 0.4), empty.system, known)
    count = f"the latest {len(shown):,} of {counted(len(flights), 'flight')}" if len(shown) < len(flights) else ""
    subtitle = ", ".join(filter(None, (empty.subtitle, count)))
    return replace(empty, subtitle=subtitle, cards=tuple(made), loops=tuple(loops), earlier=len(flights) - len(shown))


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
    """The flights of a report as a table: headers, and one row per flight."""
    shown = ShownUnits(found.system)
    mass, height = shown.mass(0.0).split()[1], shown.length_unit
    heights = (f"forecast {height}", f"flown {height}", f"miss {height}")
    headers = ("flight", "rocket", "motor", f"mass {mass}", f"wind {shown.speed_unit}", *heights, "")
    rows: list[tuple[str, ...]] = []
    for card in found.cards:
        flight, forecast = card.flight, card.forecast
        mark = ", ".join(flight.tags)
        if forecast and forecast.kept and forecast.changes:
            mark = ", ".join(filter(None, ("stale forecast", mark)))
        rows.append(
            (
                card.id,
                " ".join((flight.rocket, flight.config)).strip(),
                flight.motor,
                _figure(flight.dry_mass, shown.mass),
                _figure(flight.wind, shown.speed),
                _figure(forecast.interval[1], shown.length) if forecast and forecast.kept else "",
                _figure(flight.apogee, partial(shown.length, digits=1)),
                _figure(card.miss, shown.difference) if forecast and forecast.kept else "",
                mark,
            )
        )
    return headers, rows


def _figure(value: float | None, shown: Callable[[float], str]) -> str:
    """A value [SI] as `shown` formats it, without its unit; empty for none."""
    return "" if value is None or not np.isfinite(value) else shown(value).split()[0]
