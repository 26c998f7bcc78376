"""The contents of a flight card: figures in the user's units, forecast and flown, the log, the rocket's record."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import cache

import numpy as np

from fieldkit.errors import FieldkitError
from fieldkit.flight import CONDITIONS, READOUTS, SETUP, Column, Flight
from fieldkit.flight.short_name import flight_label
from fieldkit.ledger import Ledger
from fieldkit.motors import Catalogue
from fieldkit.planning.forecasts import RocketData
from fieldkit.progress import ReportProgress
from fieldkit.quantities import ShownUnits, counted, weighed
from fieldkit.services.findings import Findings
from fieldkit.services.forecasts import from_others, rocket_of
from fieldkit.services.inferred import FlightInference, Inferred
from fieldkit.services.replay import FlightRecordings
from fieldkit.services.saved_forecasts import by_flight, list_forecasts
from fieldkit.shapes import Array, Flags, Float

CARD_DRAWS = 2000
"""Number of draws from a forecast given as a mixture. [1]"""
CardRows = tuple[tuple[str, str], ...]
"""Title and value."""


@dataclass(frozen=True, slots=True, eq=False)
class CardForecast:
    """A forecast apogee as draws and 5, 50 and 95% quantiles [m]: whether it was made before the flight, its source,
    and what had changed."""

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
    """One flight with all its figures.

    `record` are the apogees of its rocket in the order flown [m], `clean` is which of those flights are clean, and
    `place` is its own index among them, -1 without an apogee.
    """

    id: str
    flight: Flight
    readouts: CardRows
    circumstances: CardRows
    learned: CardRows
    forecast: CardForecast | None
    trace: HeightTrace | None
    record: Float[Array, "flight"]
    clean: Flags
    place: int
    system: str = "SI"

    @property
    def miss(self) -> float | None:
        """Flown minus forecast. [m]"""
        if self.forecast is None or self.flight.apogee is None:
            return None
        return self.flight.apogee - self.forecast.interval[1]


@dataclass(frozen=True, slots=True, eq=False)
class _FlownApogees:
    """A rocket's apogees in the order flown [m], which flights are clean, and the index of each by flight_id."""

    apogees: Float[Array, "flight"]
    clean: Flags
    places: Mapping[str, int]


def cards(
    ledger: Ledger,
    motors: Catalogue,
    flights: Sequence[Flight],
    on_progress: ReportProgress,
    system: str = "SI",
    known: Mapping[tuple[str, str], CardForecast] | None = None,
) -> list[Card]:
    """A card for each of some flights of the ledger, in the units of a system; `known` are forecasts by rocket and
    flight_id, shown for flights without a saved one. If it is None, each of these takes a fit to the others."""
    rockets = {one.rocket for one in flights}
    forecasts = {rocket: by_flight(list_forecasts(ledger, motors, rocket)) for rocket in rockets}
    records = {rocket: _record(ledger.flights(rocket)) for rocket in rockets}
    learned, recordings = _learned(ledger, flights, motors), FlightRecordings(ledger)
    rocket = cache(lambda name: rocket_of(ledger, motors, name))
    found = []
    for number, (id, flight) in enumerate(zip(ledger.ids(flights), flights, strict=True)):
        on_progress(flight_label(id), number / len(flights))
        one = forecasts[flight.rocket].get((flight.rocket, flight.flight_id))
        if one is not None:
            likely = np.array(one.made.payload.get("likely_m", one.interval), float)
            when = f"{one.made.at.astimezone():%Y-%m-%d %H:%M}"
            words = f"forecast {when} by model {one.made.payload.get('model', '')}"
            forecast: CardForecast | None = CardForecast(likely, one.interval, True, words, one.changes_in(system))
        elif known is not None:
            forecast = known.get((flight.rocket, flight.flight_id))
        else:
            forecast = _afterwards(rocket, motors, flight, system)
        trace, record = _trace(recordings, id), records[flight.rocket]
        found.append(
            Card(
                id=id,
                flight=flight,
                readouts=_rows(flight, READOUTS, system),
                circumstances=_rows(flight, (*SETUP, *CONDITIONS), system),
                learned=learned.get(_identity(flight), ()),
                forecast=forecast,
                trace=trace,
                record=record.apogees,
                clean=record.clean,
                place=record.places.get(flight.flight_id, -1),
                system=system,
            )
        )
    return found


def left_out(found: Findings, system: str) -> dict[tuple[str, str], CardForecast]:
    """The loop's leave-one-out forecasts of a rocket's flights, by rocket and flight_id, in the units of a system."""
    diagnosis = found.diagnosis
    forecasts, rng = diagnosis.forecasts_after, np.random.default_rng(0)
    by = "no saved forecast; from its other flights the loop forecasts "
    known = {}
    for number, flight in enumerate(diagnosis.model.flights):
        weight = np.maximum(forecasts.weight[:, number], 0.0)
        part = rng.choice(len(weight), CARD_DRAWS, p=weight / weight.sum())
        draws = np.exp(rng.normal(forecasts.mean[part, number], forecasts.sd[part, number]))
        low, middle, high = (float(one) for one in np.quantile(draws, (0.05, 0.5, 0.95)))
        shown = ShownUnits(system).length(middle)
        known[flight.rocket, flight.flight_id] = CardForecast(draws, (low, middle, high), False, by + shown)
    return known


def _afterwards(
    rocket: Callable[[str], RocketData], motors: Catalogue, flight: Flight, system: str
) -> CardForecast | None:
    """The forecast of a flight from the other flights, if none was saved before it."""
    try:
        made = from_others(rocket(flight.rocket), motors, flight)
    except FieldkitError:
        return None
    interval = made.apogee_quantiles()
    shown = ShownUnits(system).length(interval[1])
    others = counted(made.rests_on, "other normal flight")
    words = f"no saved forecast; from {others} it would have been {shown}"
    return CardForecast(made.apogee, interval, False, words)


def _record(flights: Sequence[Flight]) -> _FlownApogees:
    flown = [one for one in flights if one.apogee is not None]
    return _FlownApogees(
        np.array([one.apogee for one in flown], float),
        np.array([one.clean for one in flown], bool),
        {one.flight_id: place for place, one in enumerate(flown)},
    )


def _rows(flight: Flight, columns: Sequence[Column], system: str) -> CardRows:
    """The recorded numbers, in the units of a system."""
    values = ((column, flight.number(column.name)) for column in columns)
    return tuple((column.title, weighed(column, value, system)) for column, value in values if value is not None)


def _learned(ledger: Ledger, flights: Sequence[Flight], motors: Catalogue) -> dict[tuple[str, str], CardRows]:
    """Drag and thrust from each flight alone, by rocket and flight_id, of the flights that allow it."""
    try:
        inferred = FlightInference(ledger, motors).infer(flights).inferred
    except FieldkitError:
        return {}
    return {_identity(one.flight): _drag_and_thrust(one) for one in inferred}


def _drag_and_thrust(one: "Inferred") -> CardRows:
    thrust = ("Thrust / certified", f"{one.alpha:.3f} ± {one.alpha_sd:.3f}")
    if one.cd is None:
        return (thrust,)
    return ("Drag coefficient Cd", f"{one.cd:.2f} ± {one.cd_sd:.2f}"), thrust


def _identity(flight: Flight) -> tuple[str, str]:
    return flight.rocket, flight.flight_id


def _trace(recordings: FlightRecordings, id: str) -> HeightTrace | None:
    """The log of a flight; None if it has no samples of height or cannot be read."""
    try:
        found = recordings.of(id)
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


def totals(cards: Sequence[Card]) -> tuple[int, float | None, int]:
    """For the cards with a saved prediction and an apogee: their number, the mean absolute error [m], and the number
    inside the interval."""
    scored = [one for one in cards if one.forecast and one.forecast.kept and one.miss is not None]
    inside = sum(
        one.forecast.interval[0] <= (one.flight.apogee or 0) <= one.forecast.interval[2]
        for one in scored
        if one.forecast
    )
    miss = float(np.mean([abs(one.miss) for one in scored if one.miss is not None])) if scored else None
    return len(scored), miss, inside
