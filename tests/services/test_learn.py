"""The record of the flights to which a hyperprior was fitted."""

from pathlib import Path

import pytest

from fieldkit.model.hyperprior import START
from fieldkit.motors import catalogue
from fieldkit.services import learn as learning

REFERENCE_FLIGHTS = Path(learning.__file__).parents[1] / "data" / "reference_flights.csv"


def test_the_record_counts_the_flights_used_in_the_fit(monkeypatch: pytest.MonkeyPatch) -> None:
    fitted: list[int] = []

    def fit(fleets: list[list[list[object]]], *_: object, **__: object) -> object:
        fitted.extend(sum(map(len, fleet)) for fleet in fleets)
        return START

    monkeypatch.setattr(learning, "learn_hyperprior", fit)
    monkeypatch.setattr(learning, "evidence", lambda *_: 0.0)
    flyer = learning.read_flyer(REFERENCE_FLIGHTS, catalogue())
    (record,) = learning.learn([flyer], from_start=True).about["data"]
    assert fitted == [record["flights"]]
    assert record["flights"] == sum(flight.clean for flight, _ in flyer.flown) < len(flyer.flown)
