"""Saved predictions with their outcome: the imported flight, or the changes since the prediction.

The forecast that a flight is compared with: the one made for it, or a recent one for a similar flight.
"""

from collections import Counter
from collections.abc import Callable, Iterator, Sequence
from contextlib import suppress
from dataclasses import dataclass
from datetime import datetime, time, timedelta
from functools import cache
from typing import Any, Literal

from fieldkit.errors import UnknownMotor
from fieldkit.flight import BY_NAME, Flight
from fieldkit.ledger import Ledger, Past, StoredPrediction
from fieldkit.motors import Catalogue, Found
from fieldkit.quantities import ShownUnits
from fieldkit.rocket import Rocket
from fieldkit.services.forecasts import used_version
from fieldkit.services.manual_entry import FLOWN_BEFORE, LAPSES, PLAN, lapsed, saved_forecasts
from fieldkit.services.plausible_flights import followed
from fieldkit.services.provenance import (
    InputChange,
    SourceDigests,
    design_changes,
    model_changes,
    model_parts,
    plan_changes,
    plan_parts,
)

MAX_MASS_DIFFERENCE = 0.1
"""A forecast at a mass that differs by more is for another flight: it is 5 to 12% off. [1]"""
GRAM = 1e-3
"""[kg]"""


def made_for(
    flights: Sequence[Flight], predictions: Sequence[StoredPrediction], motors: Catalogue
) -> list[StoredPrediction | None]:
    """The forecast of each flight from before it flew; None if there is none.

    The latest forecast that names the flight has priority. Otherwise it is a forecast for the same rocket,
    configuration and motor, at a mass within a tenth, from the two weeks before the flight: the one with the most
    similar mass and conditions, then the latest. Forecasts that used the flight are excluded. A forecast that names no
    flight is for the next one only: later flights of that setup have none unless another was made.
    """
    motor_of = _motors(motors)
    named: dict[tuple[str, str], list[StoredPrediction]] = {}
    unnamed: dict[tuple[str, str, str], list[StoredPrediction]] = {}
    for one in predictions:
        if one.flight_id:
            named.setdefault((one.rocket, one.flight_id), []).append(one)
        else:
            key = (one.rocket, one.payload.get("config", ""), motor_of(one.payload.get("motor", "")))
            unnamed.setdefault(key, []).append(one)
    found: list[StoredPrediction | None] = []
    for flight in flights:
        candidates = [one for one in named.get((flight.rocket, flight.flight_id), ()) if not _knew(one, flight)]
        if not candidates and unnamed:
            like = unnamed.get((flight.rocket, flight.config, motor_of(flight.motor)), ())
            candidates = [
                one for one in like if in_time(one, flight) and not _knew(one, flight) and _of_its_mass(one, flight)
            ]
            candidates.sort(key=lambda one: (-_differences(one, flight, motors), one.number))
        found.append(candidates[-1] if candidates else None)
    return _once(flights, found)


def _once(flights: Sequence[Flight], found: Sequence[StoredPrediction | None]) -> list[StoredPrediction | None]:
    """The forecasts of flights, without those that name no flight and belong to an earlier one."""
    first: dict[int, int] = {}
    for place in sorted(range(len(flights)), key=lambda place: _flown_at(flights[place])):
        one = found[place]
        if one is not None and not one.flight_id:
            first.setdefault(one.number, place)
    return [one if one and first.get(one.number, place) == place else None for place, one in enumerate(found)]


def _flown_at(flight: Flight) -> datetime:
    """When a flight flew: the end of the day for a date without a time, last without a date."""
    at = flight.date_time or datetime.max
    return datetime.combine(at, time.max) if at.time() == time() else at


def in_time(prediction: StoredPrediction, flight: Flight) -> bool:
    """Whether a forecast was made in the two weeks before a flight, or in the same minute; a date without a time means
    the end of that day."""
    if flight.date_time is None:
        return False
    whole_day = flight.date_time.time() == time()
    made = prediction.at.astimezone().replace(second=0, microsecond=0, tzinfo=None)  # typed times have no seconds
    passed = flight.date_time - made + timedelta(days=1) * whole_day
    return timedelta() <= passed <= LAPSES


def _knew(prediction: StoredPrediction, flight: Flight) -> bool:
    return flight.flight_id in prediction.payload.get("made_from", {}).get("flights", ())


def _of_its_mass(prediction: StoredPrediction, flight: Flight) -> bool:
    """Whether a forecast is for about the mass that flew; one for half of it was a question, or a typing error."""
    made: SourceDigests | None = prediction.payload.get("made_from")
    text = made["mass"].get(BY_NAME["dry_mass"].header, "") if made is not None else ""
    try:
        planned = float(text) * GRAM if text else None
    except ValueError:  # saved by another program
        planned = None
    return not (planned and flight.dry_mass) or abs(flight.dry_mass / planned - 1) <= MAX_MASS_DIFFERENCE


def _differences(prediction: StoredPrediction, flight: Flight, motors: Catalogue) -> int:
    made = prediction.payload.get("made_from")
    found = resolved(motors, flight)
    if made is None or found is None:
        return 0
    return len(list(plan_changes(made, plan_parts(flight, found), flown=True)))


def resolved(motors: Catalogue, flight: Flight) -> Found | None:
    """A flight's motor or cluster, None for stages or an unknown one."""
    try:
        return motors.resolve_several(flight.motor)
    except UnknownMotor:
        return None


def _motors(motors: Catalogue) -> Callable[[str], str]:
    """The motor or cluster that a text names, without its delay and its lot; the text if there is none."""

    @cache
    def motor_of(text: str) -> str:
        found = resolved(motors, Flight(motor=text))
        if found is None:
            return text
        return f"{found.motor.maker} {found.motor.designation}"

    return motor_of


def residual(flight: Flight, prediction: StoredPrediction | None) -> float | None:
    """Flown minus forecast apogee, None if one is missing. [m]"""
    if prediction is None or flight.apogee is None:
        return None
    return flight.apogee - float(prediction.payload["apogee_m"]["p50"])


ForecastState = Literal["open", "stale", "flown", "replaced", "lapsed"]
LISTED_STATES: tuple[ForecastState, ...] = ("open", "stale", "flown")
"""States of predictions that are listed by default."""


@dataclass(frozen=True, slots=True)
class SavedForecast:
    """A saved prediction, its flight, and what changed before that flight was added.

    `changes` is empty if all inputs are unchanged. `over` means that no flight will be compared with it
    anymore, because a later prediction replaced it or two weeks have passed.
    """

    made: StoredPrediction
    flight: Flight | None
    changes: tuple[InputChange, ...]
    over: ForecastState | None = None

    @property
    def stale(self) -> bool:
        """Whether any of its inputs has changed, or had changed when the flight was added."""
        return bool(self.changes)

    @property
    def state(self) -> ForecastState:
        """The state in one word."""
        if self.flown is not None:
            return "flown"
        return self.over or ("stale" if self.stale else "open")

    @property
    def waits(self) -> bool:
        """Whether it was saved for a planned flight that has not flown yet."""
        return PLAN in self.made.payload and self.state in ("open", "stale")

    @property
    def interval(self) -> tuple[float, float, float]:
        """The forecast apogee, at 5, 50 and 95%. [m]"""
        at = self.made.payload["apogee_m"]
        return float(at["p05"]), float(at["p50"]), float(at["p95"])

    @property
    def flown(self) -> float | None:
        """The flown apogee. [m]"""
        return self.flight.apogee if self.flight else None

    @property
    def miss(self) -> float | None:
        """Flown minus forecast. [m]"""
        return residual(self.flight, self.made) if self.flight else None

    def changes_in(self, system: str = "") -> tuple[str, ...]:
        """The changes in words, in the units of a system, by default in those of the flight table."""
        return tuple(one.words(system) for one in self.changes)

    def json(self) -> dict[str, Any]:
        """The prediction, the digest of its inputs, and its outcome."""
        inner = ("made_from", "likely_m", PLAN, FLOWN_BEFORE)
        payload = {key: value for key, value in self.made.payload.items() if key not in inner}
        return payload | {
            "number": self.made.number,
            "at": self.made.at.isoformat(),
            "digest": self.made.digest,
            "state": self.state,
            "stale": self.stale,
            "changes": list(self.changes_in()),
            "flown": {"flight_id": self.flight.flight_id, "apogee_m": self.flown, "miss_m": self.miss}
            if self.flight
            else None,
        }


def list_forecasts(ledger: Ledger, motors: Catalogue, rocket: str | None = None) -> list[SavedForecast]:
    """Every prediction of one rocket or of all, oldest first, once for each flight compared with it."""
    predictions = saved_forecasts(ledger, rocket)
    flights = [flight for one in dict.fromkeys(p.rocket for p in predictions) for flight in ledger.flights(one)]
    pairs = [
        (made.number, flight)
        for flight, made in zip(flights, made_for(flights, predictions, motors), strict=True)
        if made is not None
    ]
    pasts = iter(ledger.before([flight for _, flight in pairs if flight.apogee is not None]))
    compared = [(number, flight, None if flight.apogee is None else next(pasts)) for number, flight in pairs]
    now = {one: Past(tuple(ledger.flights(one)), used_version(ledger, one)) for one in {p.rocket for p in predictions}}
    rockets = {one: ledger.rocket(one) for one in now}
    later = _replaced(predictions)
    found: list[SavedForecast] = []
    for one in predictions:
        own: list[tuple[Flight | None, Past | None]] = [
            (flight, past) for number, flight, past in compared if number == one.number
        ]
        for flight, before in own or [(None, None)]:
            past = before or now[one.rocket]
            over = later.get(one.number) or ("lapsed" if flight is None and lapsed(one) else None)
            changes = [*_changes(one, flight, past, motors), *_redesigned(one, flight, rockets[one.rocket])]
            found.append(SavedForecast(one, flight, tuple(changes), over))
    return found


def of_flight(ledger: Ledger, motors: Catalogue, flight: Flight) -> SavedForecast | None:
    """The prediction for a flight, or None."""
    return by_flight(list_forecasts(ledger, motors, flight.rocket)).get((flight.rocket, flight.flight_id))


def by_flight(found: Sequence[SavedForecast]) -> dict[tuple[str, str], SavedForecast]:
    """Predictions by the rocket and flight_id of their flight."""
    return {(one.flight.rocket, one.flight.flight_id): one for one in found if one.flight}


def in_words(one: SavedForecast, system: str = "SI") -> Iterator[str]:
    """Forecast and flown apogee of a flight, one line each, in the units of a system."""
    shown = ShownUnits(system)
    low, middle, high = one.interval
    text = f"{shown.length(middle)}, 90% interval {shown.lengths(low, high)}"
    yield f"forecast {one.made.at.astimezone():%Y-%m-%d %H:%M}: {text}"
    if one.flown is not None and one.miss is not None:
        way, where = "higher" if one.miss >= 0 else "lower", "inside" if low <= one.flown <= high else "outside"
        yield f"flown {shown.length(one.flown, 1)}: {shown.length(abs(one.miss), 1)} {way}, {where} the interval"
    if one.stale:
        yield f"stale {'at launch' if one.flown is not None else 'now'}: {'; '.join(one.changes_in(system))}"


def _replaced(predictions: Sequence[StoredPrediction]) -> dict[int, ForecastState]:
    """Predictions of a named flight that were replaced by a later one."""
    named = [one for one in predictions if one.flight_id]
    last = {(one.rocket, one.flight_id): one.number for one in named}
    return {one.number: "replaced" for one in named if last[one.rocket, one.flight_id] != one.number}


def _changes(
    prediction: StoredPrediction, flight: Flight | None, past: Past, motors: Catalogue
) -> Iterator[InputChange]:
    """What changed in the plan, and in the model as of when the flight was added, or now."""
    made: SourceDigests | None = prediction.payload.get("made_from")
    if made is None:
        return  # saved by an older version, without this part
    flown = flight is not None and flight.apogee is not None
    if flight is not None and (found := resolved(motors, flight)):
        yield from plan_changes(made, plan_parts(flight, found), flown=flown)
    history = [one for one, _ in followed(past.flights, motors)]
    now = model_parts(history, made["model"]["name"], past.version)
    yield from model_changes(made, now if not flown else {**now, "model": now["model"] | {"fieldkit": ""}})


def _redesigned(prediction: StoredPrediction, flight: Flight | None, rocket: Rocket) -> Iterator[InputChange]:
    """What changed in the rocket's design while the prediction is open; the design at a past flight is not saved."""
    made: SourceDigests | None = prediction.payload.get("made_from")
    if made is None or (flight is not None and flight.apogee is not None):
        return
    yield from design_changes(made, rocket.design(made["configuration"].get("config", "")))


def standing(found: Sequence[SavedForecast]) -> str:
    """The number of each kind in words."""
    counts = Counter(one.state for one in found)
    stale = sum(one.stale for one in found if one.state == "flown")
    beside = f" ({stale} stale at launch)" if stale else ""
    return ", ".join(f"{count} {state}{beside if state == 'flown' else ''}" for state, count in counts.items())


def motors_with_open_forecast(ledger: Ledger, motors: Catalogue, rocket: str, config: str) -> list[Found]:
    """The motors, with their delays, for which a flight of a configuration is forecast and not flown yet, the latest
    first; without those of another catalog."""
    found = []
    for one in reversed(list_forecasts(ledger, motors, rocket)):
        if one.waits and one.made.payload.get("config", "") == config:
            with suppress(UnknownMotor):
                found.append(motors.resolve(str(one.made.payload.get("motor", ""))))
    return found
