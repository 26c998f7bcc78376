"""Saved predictions with their outcome: the imported flight, or the changes since the prediction."""

from collections import Counter
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Any, Literal

from fieldkit.flight import Flight
from fieldkit.ledger import Ledger, Past, StoredPrediction
from fieldkit.motors import Catalogue
from fieldkit.quantities import ShownUnits
from fieldkit.rocket import Rocket
from fieldkit.services.forecasts import used_version
from fieldkit.services.manual_entry import FLOWN_BEFORE, PLAN, lapsed
from fieldkit.services.match_forecasts import made_for, residual, resolved
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
    predictions = [one for one in ledger.predictions(rocket) if "apogee_m" in one.payload]
    flights = ledger.flights(rocket) if predictions else []
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
