"""What a flight card holds: figures in both units, the prediction and the flight, the log, the rocket's record."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from types import MappingProxyType

import numpy as np

from fieldkit.errors import FieldkitError
from fieldkit.flight import CONDITIONS, READOUTS, SETUP, Column, Flight
from fieldkit.ledger import Ledger
from fieldkit.motors import Catalogue
from fieldkit.progress import ReportProgress
from fieldkit.quantities import measure
from fieldkit.services.findings import Findings
from fieldkit.services.forecasts import forecast_from_others
from fieldkit.services.replay import recording_of
from fieldkit.services.saved_forecasts import by_flight, list_forecasts
from fieldkit.shapes import Array, Flags, Float

CARD_DRAWS = 2000
"""Draws of a forecast that is known as a mixture. [1]"""
Rows = tuple[tuple[str, str, str], ...]
"""What, in SI, and in the other units."""


@dataclass(frozen=True, slots=True, eq=False)
class CardForecast:
    """An apogee as draws and at 5, 50 and 95 % [m]: whether said before the flight, by what, and what had changed."""

    draws: Float[Array, "draw"]
    interval: tuple[float, float, float]
    kept: bool
    by: str
    changes: tuple[str, ...] = ()


@dataclass(frozen=True, slots=True, eq=False)
class HeightTrace:
    """Height [m] and, if it is known, vertical speed [m/s] against time [s], and the events on that clock."""

    device: str
    time: Float[Array, "time"]
    height: Float[Array, "time"]
    speed: Float[Array, "time"] | None
    events: Mapping[str, float]


@dataclass(frozen=True, slots=True, eq=False)
class Card:
    """One flight with everything that is shown of it; `record` are the apogees of its rocket, in order flown."""

    id: str
    flight: Flight
    readouts: Rows
    circumstances: Rows
    learned: Rows
    forecast: CardForecast | None
    trace: HeightTrace | None
    record: Float[Array, "flight"]
    clean: Flags
    place: int

    @property
    def miss(self) -> float | None:
        """Flown minus forecast. [m]"""
        if self.forecast is None or self.flight.apogee is None:
            return None
        return self.flight.apogee - self.forecast.interval[1]


def cards(
    ledger: Ledger,
    motors: Catalogue,
    flights: Sequence[Flight],
    on_progress: ReportProgress,
    known: Mapping[tuple[str, str], CardForecast] = MappingProxyType({}),
) -> list[Card]:
    """A card for each of these flights of the ledger; `known` are forecasts by rocket and flight_id, which are shown of
    flights without a saved one."""
    said = {rocket: by_flight(list_forecasts(ledger, motors, rocket)) for rocket in {one.rocket for one in flights}}
    found = []
    for number, (id, flight) in enumerate(zip(ledger.ids(flights), flights, strict=True)):
        on_progress(f"flight {id}", number / len(flights))
        one = said[flight.rocket].get((flight.rocket, flight.flight_id))
        if one is not None:
            likely = np.array(one.made.payload.get("likely_m", one.interval), float)
            when = f"{one.made.at.astimezone():%Y-%m-%d %H:%M}"
            words = f"predicted {when} by model {one.made.payload.get('model', '')}"
            forecast: CardForecast | None = CardForecast(likely, one.interval, True, words, one.changes)
        else:
            forecast = known.get((flight.rocket, flight.flight_id)) or _afterwards(ledger, motors, flight)
        found.append(_card(ledger, motors, id, flight, forecast))
    return found


def left_out(found: Findings) -> dict[tuple[str, str], CardForecast]:
    """What the loop forecasts each flight of a rocket to reach with the flight left out, by rocket and flight_id."""
    diagnosis = found.diagnosis
    forecasts, rng = diagnosis.forecasts_after, np.random.default_rng(0)
    by = "no saved prediction; with it left out of the fit, the loop forecasts {:.0f} m"
    known = {}
    for number, flight in enumerate(diagnosis.model.flights):
        weight = np.maximum(forecasts.weight[:, number], 0.0)
        part = rng.choice(len(weight), CARD_DRAWS, p=weight / weight.sum())
        draws = np.exp(rng.normal(forecasts.mean[part, number], forecasts.sd[part, number]))
        low, middle, high = (float(one) for one in np.quantile(draws, (0.05, 0.5, 0.95)))
        known[flight.rocket, flight.flight_id] = CardForecast(draws, (low, middle, high), False, by.format(middle))
    return known


def _afterwards(ledger: Ledger, motors: Catalogue, flight: Flight) -> CardForecast | None:
    """What the other flights say this one should have shown, if none was said before it."""
    try:
        made = forecast_from_others(ledger, motors, flight)
    except FieldkitError:
        return None
    low, middle, high = (float(x) for x in made.apogee_quantiles())
    words = f"no saved prediction; from the {made.rests_on} other clean flights it would have been {middle:.0f} m"
    return CardForecast(made.apogee, (low, middle, high), False, words)


def _card(ledger: Ledger, motors: Catalogue, id: str, flight: Flight, forecast: CardForecast | None) -> Card:
    own = [one for one in ledger.flights(flight.rocket) if one.apogee is not None]
    names = [one.flight_id for one in own]
    return Card(
        id=id,
        flight=flight,
        readouts=_rows(flight, READOUTS),
        circumstances=_rows(flight, (*SETUP, *CONDITIONS)),
        learned=_learned(ledger, flight, motors),
        forecast=forecast,
        trace=_trace(ledger, id),
        record=np.array([one.apogee or np.nan for one in own], float),
        clean=np.array([one.clean for one in own], bool),
        place=names.index(flight.flight_id) if flight.flight_id in names else -1,
    )


def _rows(flight: Flight, columns: Sequence[Column]) -> Rows:
    """The numbers that were recorded, in SI and, if those differ, in US units."""
    rows = []
    for column in columns:
        value = flight.number(column.name)
        if value is not None:
            metric, other = (measure(column, value, system) for system in ("SI", "US"))
            rows.append((column.title, metric, other if other != metric else ""))
    return tuple(rows)


def _learned(ledger: Ledger, flight: Flight, motors: Catalogue) -> Rows:
    """Drag and thrust by this flight alone."""
    from fieldkit.services.inferred import FlightInference

    try:
        (one,) = FlightInference(ledger, motors).infer([flight]).inferred
    except (FieldkitError, ValueError):
        return ()
    rows = []
    if np.isfinite(one.cd):
        rows.append(("Drag coefficient Cd", f"{one.cd:.2f} ± {one.cd_sd:.2f}", ""))
    rows.append(("Thrust / certified", f"{one.alpha:.3f} ± {one.alpha_sd:.3f}", ""))
    return tuple(rows)


def _trace(ledger: Ledger, id: str) -> HeightTrace | None:
    """The log of a flight, None if there are no samples of height or they cannot be read again."""
    try:
        found = recording_of(ledger, id)
    except FieldkitError:
        return None
    if found is None or found.reading is None:
        return None
    events = {name: event.time for name, event in found.recorded.events.items()}
    climb = found.recorded.climb
    for clock in found.reading.clocks:
        if clock.altitude is not None and np.isfinite(clock.altitude).sum() > 1:
            return HeightTrace(found.kind, clock.time, clock.altitude, clock.speed, events)
    return HeightTrace(found.kind, climb.time, climb.height, climb.speed, events) if climb is not None else None


def totals(cards: Sequence[Card]) -> tuple[int, float, int]:
    """Of the cards with a saved prediction and an apogee: how many, the mean absolute miss [m], how many inside."""
    told = [one for one in cards if one.forecast and one.forecast.kept and one.miss is not None]
    inside = sum(
        one.forecast.interval[0] <= (one.flight.apogee or 0) <= one.forecast.interval[2] for one in told if one.forecast
    )
    miss = float(np.mean([abs(one.miss) for one in told if one.miss is not None])) if told else float("nan")
    return len(told), miss, inside
