"""Saved predictions: their inputs, reasons for being stale, and the flight that each is compared with."""

import re
import shutil
from collections.abc import Callable, Iterator, Sequence
from datetime import datetime, timedelta
from pathlib import Path

import numpy as np
import pytest

from fieldkit.flight import Flight
from fieldkit.ledger import Ledger, models
from fieldkit.motors import catalogue
from fieldkit.planning.forecasts import RocketData, forecasts
from fieldkit.services.forecasts import predict_plans
from fieldkit.services.provenance import digest, model_parts, plan_parts
from fieldkit.services.saved_forecasts import SavedForecast, by_flight, in_words, list_forecasts
from tests.commands import Run

pytestmark = pytest.mark.fast

CHECK_SHAPES = False

PAST = [
    Flight(
        str(n), "Astra", "A", motor, datetime(2026, 5, n), dry_mass=0.32, diameter=0.066, apogee=apogee, top_speed=80.0
    )
    for n, (motor, apogee) in enumerate([("F24-4W", 250.0), ("F24-4W", 246.0), ("F39-6T", 240.0)], start=1)
]
MOMENT = "2026-06-01T09:00:00+00:00"
PLAN = Flight("4", "Astra", "A", "F24-4W", wind=2.0)
FLOWN = PAST[0].with_changes(flight_id="4", date_time=datetime(2026, 6, 2, 11), wind=2.0, apogee=255.0)


@pytest.fixture(scope="module")
def shown(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Three flights in May and a prediction of a fourth, made on June 1."""
    file = tmp_path_factory.mktemp("shown") / "ledger.db"
    with Ledger.open(file) as ledger, pytest.MonkeyPatch.context() as patch:
        patch.setattr(models, "now", lambda: MOMENT)
        ledger.add(PAST)
        predict_plans(ledger, catalogue(), [PLAN])
    return file


@pytest.fixture
def ledger(shown: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Ledger]:
    """A copy of that ledger, on the same day."""
    monkeypatch.setattr(models, "now", lambda: MOMENT)
    with Ledger.open(shutil.copy(shown, tmp_path / "ledger.db")) as ledger:
        yield ledger


def only(ledger: Ledger) -> SavedForecast:
    (one,) = list_forecasts(ledger, catalogue())
    return one


def test_a_prediction_is_saved_with_its_inputs(ledger: Ledger) -> None:
    made = only(ledger).made
    parts = made.payload["made_from"]
    assert parts["mass"] == {"dry_mass_g": "320"}
    assert parts["configuration"] == {"config": "A", "diameter_mm": "66"}
    assert parts["motor"]["motor"] == "AeroTech F24W"
    assert parts["conditions"]["wind_mps"] == "2"
    assert parts["model"]["version"] == "0"
    assert set(parts["flights"]) == {"1", "2", "3"}
    assert len(made.digest) == 64
    assert only(ledger).state == "open"


CHANGES: dict[str, tuple[Callable[[Ledger], object], str]] = {
    "tag": (lambda ledger: ledger.tag("2", "off_axis"), "flight 2 is tagged"),
    "edit": (lambda ledger: ledger.edit("1", apogee=261.0), "flight 1 was edited"),
    "remove": (lambda ledger: ledger.remove("3"), "flight 3 was removed"),
    "model": (
        lambda ledger: ledger.keep_version("Astra", {"effects": []}),
        "no correction replaced by model version 1",
    ),
    "flight": (lambda ledger: ledger.add([FLOWN.with_changes(flight_id="9")]), "flight 9 added since"),
    "plan": (
        lambda ledger: ledger.add([PLAN.with_changes(dry_mass=0.33, diameter=0.066, wind=4.0)]),
        "dry mass was 320 g, now 330 g; wind was 2 m/s, now 4 m/s",
    ),
}


@pytest.mark.parametrize("change", CHANGES)
def test_a_change_makes_it_stale_with_the_reason_until_undone(ledger: Ledger, change: str) -> None:
    alter, why = CHANGES[change]
    alter(ledger)
    one = only(ledger)
    assert (one.state, "; ".join(one.changes_in())) == ("stale", why)
    ledger.undo()
    assert only(ledger).state == "open"


def test_changes_that_the_model_does_not_use_make_nothing_stale(ledger: Ledger) -> None:
    ledger.edit("1", notes="drifted")
    ledger.tag("2", "my own mark")
    assert only(ledger).state == "open"


def test_a_change_of_any_input_changes_the_digest() -> None:
    def made(plan: Flight, history: Sequence[Flight] = PAST, version: int = 0) -> str:
        return digest(plan_parts(plan, catalogue().resolve(plan.motor)) | model_parts(history, "field", version))

    whole = PLAN.with_changes(dry_mass=0.32, diameter=0.066)
    changed = {"dry_mass": 0.33, "config": "B", "motor": "F39-6T", "wind": 3.0}
    digests = [made(whole), *(made(whole.with_changes(**{name: value})) for name, value in changed.items())]
    digests += [made(whole, PAST[:2]), made(whole, version=1)]
    assert len(set(digests)) == 7
    assert made(whole.with_changes(notes="a new shock cord", flight_id="9")) == digests[0]


@pytest.mark.parametrize(
    ("column", "text"),
    [("rail_direction", "away"), ("stability_cal", "4"), ("wind_aloft_mps", "9"), ("wind_aloft_height_m", "100")],
)
def test_extra_columns_that_change_the_climb_are_inputs_of_a_prediction(column: str, text: str) -> None:
    found, extra = catalogue().resolve(PLAN.motor), {column: text}
    changed = [PAST[0].with_changes(extra=extra), *PAST[1:]]
    assert plan_parts(PLAN.with_changes(extra=extra), found) != plan_parts(PLAN, found)
    assert model_parts(changed, "field", 0) != model_parts(PAST, "field", 0)
    unrelated = [PAST[0].with_changes(extra={"color": "red", column: ""}), *PAST[1:]]
    assert model_parts(unrelated, "field", 0) == model_parts(PAST, "field", 0)


def test_the_delay_of_a_plan_takes_precedence_over_that_in_the_motors_name() -> None:
    found = catalogue().resolve("F24-4W")
    (shown,) = forecasts(RocketData((), ()), [(PLAN.with_changes(dry_mass=0.3, delay=7.0), found)], draws=20)
    assert np.median(shown.eject + shown.coast_time) == pytest.approx(7.0, abs=0.6)
    assert plan_parts(PLAN.with_changes(delay=7.0), found)["motor"]["delay_s"] == "7"


def test_changes_after_the_flight_do_not_make_its_prediction_stale(ledger: Ledger) -> None:
    ledger.add([FLOWN])
    ledger.tag("1", "weak_launch")
    ledger.keep_version("Astra", {"effects": []})
    ledger.add([FLOWN.with_changes(flight_id="5")])
    one = only(ledger)
    assert (one.state, one.stale, one.flown) == ("flown", False, 255.0)
    assert one.miss == pytest.approx(255.0 - one.interval[1])
    assert any("flown 255.0 m" in line and "the interval" in line for line in in_words(one))


def test_changes_before_the_flight_remain_listed(ledger: Ledger) -> None:
    ledger.tag("1", "weak_launch")
    ledger.add([FLOWN])
    ledger.untag("1", "weak_launch")
    assert only(ledger).changes_in() == ("flight 1 is tagged",)


def test_a_change_undone_in_time_does_not_count(ledger: Ledger) -> None:
    ledger.tag("1", "weak_launch")
    ledger.undo()
    ledger.redo()
    ledger.undo()
    ledger.add([FLOWN])
    assert not only(ledger).stale


def test_a_different_mass_is_reported_but_not_weather_missing_in_the_plan(ledger: Ledger) -> None:
    ledger.add([FLOWN.with_changes(dry_mass=0.34, temperature=300.0)])
    assert only(ledger).changes_in() == ("dry mass was 320 g, now 340 g",)


def test_a_prediction_made_after_a_flight_is_not_paired_with_it(ledger: Ledger) -> None:
    ledger.add([FLOWN])
    predict_plans(ledger, catalogue(), [PLAN.with_changes(wind=2.5)])
    one = by_flight(list_forecasts(ledger, catalogue()))["Astra", "4"]
    assert one.made.number == 1


def test_of_several_unnamed_predictions_the_one_for_the_flown_mass_is_paired(ledger: Ledger) -> None:
    loose = PLAN.with_changes(flight_id="")
    predict_plans(ledger, catalogue(), [loose.with_changes(dry_mass=mass) for mass in (0.33, 0.34, 0.35)])
    ledger.add([FLOWN.with_changes(flight_id="7", dry_mass=0.34)])
    one = by_flight(list_forecasts(ledger, catalogue()))["Astra", "7"]
    assert one.made.payload["made_from"]["mass"] == {"dry_mass_g": "340"}
    assert one.changes_in() == ()


def test_a_forecast_at_a_mistyped_mass_is_not_paired(ledger: Ledger) -> None:
    predict_plans(ledger, catalogue(), [PLAN.with_changes(flight_id="", dry_mass=0.032)])
    ledger.add([FLOWN.with_changes(flight_id="7")])
    assert by_flight(list_forecasts(ledger, catalogue())).get(("Astra", "7")) is None


@pytest.mark.parametrize("later", [0, 1], ids=["in order", "typed in reverse"])
def test_an_unnamed_forecast_is_only_for_the_next_flight(ledger: Ledger, later: int) -> None:
    predict_plans(ledger, catalogue(), [PLAN.with_changes(flight_id="")])
    first = FLOWN.with_changes(flight_id="7")
    second = FLOWN.with_changes(flight_id="5", date_time=datetime(2026, 6, 2, 14), apogee=262.0)
    ledger.add([second, first] if later else [first, second])
    assert {flight for _, flight in by_flight(list_forecasts(ledger, catalogue()))} == {"7"}


def test_a_replaced_forecast_is_not_paired_with_the_second_flight(ledger: Ledger) -> None:
    for mass in (0.32, 0.33):
        predict_plans(ledger, catalogue(), [PLAN.with_changes(flight_id="", dry_mass=mass)])
    heavy = FLOWN.with_changes(flight_id="7", dry_mass=0.33)
    again = heavy.with_changes(flight_id="5", date_time=datetime(2026, 6, 2, 14))
    light = FLOWN.with_changes(flight_id="6", date_time=datetime(2026, 6, 2, 16))
    ledger.add([heavy, again, light])
    found = by_flight(list_forecasts(ledger, catalogue()))
    assert {flight: one.made.number for (_, flight), one in found.items()} == {"7": 3, "6": 2}


def test_a_flight_on_a_drilled_delay_is_compared_with_the_forecast_for_the_delay_on_the_bag(ledger: Ledger) -> None:
    plan = PLAN.with_changes(flight_id="", motor="AeroTech H128W-17A", dry_mass=0.6)
    predict_plans(ledger, catalogue(), [plan])
    ledger.add([FLOWN.with_changes(flight_id="8", motor="AeroTech H128W-8", dry_mass=0.6, apogee=900.0)])
    one = by_flight(list_forecasts(ledger, catalogue()))["Astra", "8"]
    assert one.made.payload["motor"] == plan.motor
    assert one.changes_in() == ("ejection delay was 17 s, now 8 s",)


def test_a_date_without_a_time_means_the_whole_day_and_two_weeks_are_the_limit(ledger: Ledger) -> None:
    predict_plans(ledger, catalogue(), [PLAN.with_changes(flight_id="")])
    dates = {"6": datetime(2026, 6, 1), "7": datetime(2026, 6, 1) + timedelta(days=16)}
    ledger.add([FLOWN.with_changes(flight_id=name, date_time=when) for name, when in dates.items()])
    assert set(by_flight(list_forecasts(ledger, catalogue()))) == {("Astra", "6")}


def test_of_predictions_that_name_a_flight_the_last_is_used(ledger: Ledger) -> None:
    predict_plans(ledger, catalogue(), [PLAN.with_changes(wind=5.0)])
    assert [one.state for one in list_forecasts(ledger, catalogue())] == ["replaced", "open"]


def test_predictions_of_an_older_fieldkit_are_paired_without_a_verdict(ledger: Ledger) -> None:
    apogee = {"mean": 250.0, "sd": 9.0, "p05": 235.0, "p50": 250.0, "p95": 265.0}
    ledger.keep_prediction({"motor": "F24-4W", "apogee_m": apogee}, digest="old", rocket="Astra", flight_id="8")
    ledger.add([FLOWN.with_changes(flight_id="8")])
    one = by_flight(list_forecasts(ledger, catalogue()))["Astra", "8"]
    assert (one.state, one.changes_in(), one.miss) == ("flown", (), pytest.approx(5.0))


def test_the_commands_show_forecast_and_flown_apogees(
    ledger: Ledger, run: Run, monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    monkeypatch.setenv("COLUMNS", "80")
    table = tmp_path / "day.csv"
    table.write_text("flight_id,rocket,config,motor,dry_mass_g,apogee_m\n4,Astra,A,F24-4W,330,255\n")
    shown = " ".join(run("import", table).out.split())
    assert "4: forecast 2026-06-01" in shown
    assert "stale at launch: dry mass was 320 g, now 330 g" in shown
    assert "flown 255.0 m" in run("show", "4").out
    out = run("predictions").out
    assert re.search(r"255\.0  \+\d\.\d  stale", out)
    assert max(map(len, out.splitlines())) <= 80
    (document,) = run("predictions", "--json").document["predictions"]
    assert document["changes"] == ["dry mass was 320 g, now 330 g"]
    assert document["flown"]["apogee_m"] == 255.0
    assert "made_from" not in document
