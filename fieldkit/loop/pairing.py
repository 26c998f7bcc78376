"""Which forecast a flight is measured against: the one made for it, or for a flight like it just before."""

from bisect import bisect_right
from collections.abc import Callable, Sequence
from datetime import datetime, timedelta
from functools import cache

from fieldkit.errors import UnknownMotor
from fieldkit.flight import Flight
from fieldkit.ledger import Prediction
from fieldkit.motors import Catalogue

STALE = timedelta(days=14)
"""A forecast without a flight's name is taken to be of a flight no later than this after it."""


def made_for(
    flights: Sequence[Flight], predictions: Sequence[Prediction], motors: Catalogue
) -> list[Prediction | None]:
    """The forecast of each flight as it was said beforehand, None where nothing was.

    One that names the flight wins; of several the last. Else it is the last one of the same rocket,
    configuration and motor made in the two weeks before the flight.
    """
    motor_of = _motors(motors)
    named = {(one.rocket, one.flight_id): one for one in predictions if one.flight_id}
    alike: dict[tuple[str, str, object], list[Prediction]] = {}
    for one in predictions:
        if not one.flight_id:
            key = (one.rocket, one.payload.get("config", ""), motor_of(one.payload.get("motor", "")))
            alike.setdefault(key, []).append(one)
    moments = {key: [_local(one.at) for one in made] for key, made in alike.items()}
    found: list[Prediction | None] = []
    for flight in flights:
        said = named.get((flight.rocket, flight.flight_id))
        if said is None and alike and flight.date_time is not None:
            like = (flight.rocket, flight.config, motor_of(flight.motor))
            place = bisect_right(moments.get(like, ()), flight.date_time)
            if place and flight.date_time - moments[like][place - 1] <= STALE:
                said = alike[like][place - 1]
        found.append(said)
    return found


def _motors(motors: Catalogue) -> Callable[[str], object]:
    """The motor that a text means, whatever its delay and however it is written; else the text."""

    @cache
    def motor_of(text: str) -> object:
        try:
            return motors.resolve(text).motor
        except UnknownMotor:
            return text

    return motor_of


def residual(flight: Flight, prediction: Prediction | None) -> float | None:
    """Flown less forecast apogee, None where one is missing. [m]"""
    if prediction is None or flight.apogee is None:
        return None
    return flight.apogee - float(prediction.payload["apogee_m"]["p50"])


def _local(moment: datetime) -> datetime:
    """A moment as the clock at the field shows it, as flights have it."""
    return moment.astimezone().replace(tzinfo=None)
