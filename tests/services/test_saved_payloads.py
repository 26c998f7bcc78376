"""Forecasts and models that another program saved in the ledger: what cannot be read is left out or named."""

import copy
import math
from collections.abc import Iterator
from contextlib import suppress
from dataclasses import replace
from datetime import datetime
from pathlib import Path
from typing import Any

import pytest

from fieldkit.errors import BadValue
from fieldkit.flight import Flight
from fieldkit.ledger import Ledger, Version
from fieldkit.motors import catalogue
from fieldkit.services import saved_forecasts
from fieldkit.services.forecasts import predict_plans
from fieldkit.services.manual_entry import waiting_plan
from fieldkit.services.model_versions import version_average, version_summary
from fieldkit.tui.loop.loop_words import version_rows
from tests.commands import Run

CHECK_SHAPES = False
JUNK: tuple[object, ...] = (None, "x", "", -1, 10**400, math.nan, True, [], ["x"], {}, {"x": 1})
VERSION: dict[str, Any] = {
    "effects": [{"effect": "wind", "where": "", "since": "2", "pattern": None, "switched": None, "mean": 1, "sd": 1}],
    "averaged": [
        {"probability": 0.7, "places": [{"effect": "wind", "where": "", "since": "2"}]},
        {
            "probability": 0.3,
            "places": [{"effect": "", "pattern": {"kind": "repeated", "of": "2", "every": 2, "smooth": False}}],
        },
    ],
    "unexplained": {"pattern": []},
    "before": {"mae_m": 5.0},
    "after": {"mae_m": 4.0},
    "flights": ["1", "2"],
}


def damaged(whole: Any) -> Iterator[tuple[str, Any]]:
    """A document with each of its values in turn lost or replaced by each kind of junk, and what was done to it."""
    places = list(_places(whole, ()))
    for place in places:
        for junk in JUNK:
            one = copy.deepcopy(whole)
            _at(one, place[:-1])[place[-1]] = junk
            yield f"{'.'.join(map(str, place))}: {junk!r}", one
        one = copy.deepcopy(whole)
        del _at(one, place[:-1])[place[-1]]
        yield f"no {'.'.join(map(str, place))}", one


def _places(value: Any, above: tuple[Any, ...]) -> Iterator[tuple[Any, ...]]:
    within = value.items() if isinstance(value, dict) else enumerate(value) if isinstance(value, list) else ()
    for key, below in within:
        yield (*above, key)
        yield from _places(below, (*above, key))


def _at(value: Any, place: tuple[Any, ...]) -> Any:
    for key in place:
        value = value[key]
    return value


@pytest.fixture
def flown(tmp_path: Path) -> Iterator[Ledger]:
    """A ledger of three flights, the last of which had a forecast, and a plan that waits."""
    flights = [
        Flight(str(number), "Astra", "A", "F24-4W", dry_mass=0.322, diameter=0.066, apogee=250.0 + number)
        for number in range(1, 4)
    ]
    with Ledger.open(tmp_path / "ledger.db") as ledger:
        ledger.add(flights[:2])
        predict_plans(ledger, catalogue(), [flights[2].unflown()])
        predict_plans(ledger, catalogue(), [flights[2].unflown().with_changes(flight_id="4")], save="plan")
        ledger.add(flights[2:])
        yield ledger


def test_a_forecast_of_another_program_is_read_or_left_out(flown: Ledger, monkeypatch: pytest.MonkeyPatch) -> None:
    motors, kept = catalogue(), flown.predictions()
    assert [one.state for one in saved_forecasts.list_forecasts(flown, motors)] == ["flown", "stale"]
    tried = 0
    for number, one in enumerate(kept):
        for what, payload in damaged(dict(one.payload)):
            others = [replace(one, payload=payload), *kept[:number], *kept[number + 1 :]]
            monkeypatch.setattr(Ledger, "predictions", lambda *_, others=others: others)
            found = saved_forecasts.list_forecasts(flown, motors)
            assert found, what
            for forecast in found:
                assert all(map(math.isfinite, forecast.interval)), what
                assert list(saved_forecasts.in_words(forecast, "US")), what
                assert forecast.json()["changes"] == list(forecast.changes_in()), what
            waiting_plan(flown)
            tried += 1
    assert tried > 500


def test_commands_leave_out_a_forecast_that_they_cannot_read(run: Run, tmp_path: Path, flown: Ledger) -> None:
    flown.keep_prediction({"apogee_m": 250.0, "plan": 3}, digest="x", rocket="Astra", flight_id="1")
    flown.keep_prediction({"apogee_m": {"p50": None}, "made_from": 3}, digest="x", rocket="Astra", flight_id="2")
    for line in (
        ("predictions", "--all"),
        ("predictions", "--json"),
        ("show", "1"),
        ("score",),
        ("predict", "--motor", "F24-4W"),
    ):
        run(*line)


def test_a_model_of_another_program_is_read_or_named(tmp_path: Path) -> None:
    assert version_average(VERSION)[0][0] == 0.7
    tried = 0
    for what, payload in damaged(VERSION):
        version = Version("Astra", 1, datetime(2026, 1, 1), payload, True)
        with suppress(BadValue):
            assert all(str(place) for _, places in version_average(payload) for place in places), what
        adds, *errors = version_summary(version)
        assert adds, what
        assert all(error is None or math.isfinite(error) for error in errors), what
        assert len(version_rows([version], "SI")) == 2, what
        tried += 1
    assert tried > 300


def test_a_model_that_cannot_be_read_is_listed_and_given_up(run: Run, flown: Ledger) -> None:
    flown.keep_version("Astra", {"effects": 3})
    assert "cannot be read by this program" in run("model").out
    assert "run it again" in run("predict", "--motor", "F24-4W", status=1).err
    run("model", "--use", 0)
    run("predict", "--motor", "F24-4W")
