"""The forecast that a flight is compared with: the one made for it, or a recent one for a similar flight."""

from collections.abc import Callable, Sequence
from datetime import datetime, time, timedelta
from functools import cache

from fieldkit.errors import UnknownMotor
from fieldkit.flight import Flight
from fieldkit.ledger import StoredPrediction
from fieldkit.motors import Catalogue, Found
from fieldkit.services.manual_entry import LAPSES
from fieldkit.services.provenance import plan_changes, plan_parts


def made_for(
    flights: Sequence[Flight], predictions: Sequence[StoredPrediction], motors: Catalogue
) -> list[StoredPrediction | None]:
    """The forecast of each flight from before it flew; None if there is none.

    The latest forecast that names the flight has priority. Otherwise it is a forecast for the same rocket,
    configuration and motor from the two weeks before the flight: the one with the most similar mass and conditions,
    then the latest. Forecasts that used the flight are excluded. A forecast that names no flight is for the next one
    only: later flights of that setup have none unless another was made.
    """
    motor_of = _motors(motors)
    named: dict[tuple[str, str], list[StoredPrediction]] = {}
    unnamed: dict[tuple[str, str, str], list[StoredPrediction]] = {}
    for one in predictions:
        if "apogee_m" not in one.payload:
            continue  # a replayed forecast
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
            candidates = [one for one in like if in_time(one, flight) and not _knew(one, flight)]
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
    made = _local(prediction.at).replace(second=0, microsecond=0)  # a typed time has no seconds
    passed = flight.date_time - made + timedelta(days=1) * whole_day
    return timedelta() <= passed <= LAPSES


def _knew(prediction: StoredPrediction, flight: Flight) -> bool:
    return flight.flight_id in prediction.payload.get("made_from", {}).get("flights", ())


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


def _local(moment: datetime) -> datetime:
    """A time in local time, as flights have it."""
    return moment.astimezone().replace(tzinfo=None)
