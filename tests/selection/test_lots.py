"""Lots of motors: read from names and columns, and places of the effects on motors instead of unexplained patterns."""

from dataclasses import replace

import numpy as np
import pytest

from fieldkit.flight.further import names_a_lot
from fieldkit.forecast.predict import predict
from fieldkit.model.hyperprior import START, learned
from fieldkit.model.readout_data import OBSERVED_READOUTS, observe
from fieldkit.model.rocket_model import Model, base_model, shared_names
from fieldkit.model.term_names import TermName
from fieldkit.motors.lots import lots, recorded_lot
from fieldkit.physics.history import history_of
from fieldkit.selection.candidates import Place, effect_candidates, effect_terms, place_weight
from fieldkit.selection.diagnose import diagnose
from fieldkit.selection.patterns import known_patterns
from tests.selection.test_verdict import measured, season

CHECK_SHAPES = False

HEADERS = {
    "motor_lot": True,
    "Lot": True,
    "Batch no.": True,
    "lot_number": True,
    "parachute_lot": False,
    "pilot": False,
}
WEAK_LOT = Place("motor_thrust", "AeroTech F24W lot 2")


def with_lots(header: str = "motor_lot") -> Model:
    """A season whose F24 are from two lots, the second from the ninth flight on."""
    model = season()
    flights = [
        flight.with_changes(extra={header: "2" if flight.motor == "F24" and row >= 8 else "1"})
        for row, flight in enumerate(model.flights)
    ]
    return base_model(history_of(flights, model.found))


@pytest.mark.parametrize(("header", "does"), HEADERS.items())
def test_a_column_of_lots_is_recognized_by_its_header(header: str, does: bool) -> None:
    assert names_a_lot(header) is does


def test_a_lot_is_read_from_the_name_or_a_column_and_lasts_until_the_next() -> None:
    model = season()
    flights = list(model.flights)
    flights[0] = flights[0].with_changes(motor="F24 lot 0412")
    flights[6] = flights[6].with_changes(extra={"batch": " 77 "})
    found = lots(model.groups("motor"), [recorded_lot(flight) for flight in flights])
    kinds = model.groups("motor")
    assert found[0] == f"{kinds[0]} lot 0412" == found[3]
    assert found[6] == f"{kinds[0]} lot 77" == found[9]
    assert found[1] == ""
    assert len(found) == len(flights)


@pytest.mark.fast
def test_effects_on_motors_act_on_lots_and_no_pattern_does() -> None:
    model = with_lots()
    candidates = [one for one in effect_candidates(model, np.ones(16, bool)) if one.place.effect == "motor_thrust"]
    places = [one.place for one in candidates]
    assert {place.where for place in places if "lot" in place.where} == {"AeroTech F24W lot 1", "AeroTech F24W lot 2"}
    assert sum(np.exp(one.log_fraction) for one in candidates) == pytest.approx(1.0)
    flown = [row for row, flight in enumerate(model.flights) if flight.motor == "F24" and row >= 8]
    assert np.flatnonzero(place_weight(WEAK_LOT, model)).tolist() == flown
    assert not any("lot" in str(pattern) for kind in known_patterns(model.flights) for pattern in kind)
    assert any("box" in str(pattern) for kind in known_patterns(with_lots("box").flights) for pattern in kind)


def test_a_weak_lot_is_named_and_its_thrust_is_right() -> None:
    truth = with_lots()
    (term,) = effect_terms(WEAK_LOT, truth)
    flights = measured(truth.with_terms(replace(term, mean=-0.12))).flights
    history = history_of(flights, truth.found)
    diagnosis = diagnose(base_model(history), observe(history))
    assert diagnosis.effect == "motor_thrust"
    assert diagnosis.posterior.inclusion["motor_thrust"] > 2 / 3  # lots that differ from their type are usual too
    lot = next(trial for one in diagnosis.ranking for trial in one.trials if trial.candidate.place == WEAK_LOT)
    mean, sd = lot.strength()
    assert abs(mean + 0.12) < 3 * sd


def test_flights_that_record_lots_share_their_thrust_and_others_are_as_before() -> None:
    plain, several = base_model(history_of(with_lots("box").flights, with_lots().found), learned()), with_lots()
    known = base_model(several.history, learned())
    lots_of_f24 = [TermName("thrust", "lot", f"AeroTech F24W lot {n}") for n in (1, 2)]
    assert set(lots_of_f24) <= set(known.names) - set(plain.names)
    assert set(plain.names) <= set(known.names)
    assert set(lots_of_f24) <= set(shared_names(known))
    term = known.terms[known.names.index(lots_of_f24[1])]
    assert term.sd == START.sds["thrust.lot"]
    flown = [row for row, flight in enumerate(several.flights) if flight.motor == "F24" and row >= 8]
    assert np.flatnonzero(term.weight).tolist() == flown


def test_a_lot_is_forecast_from_its_own_flights_and_a_new_one_from_the_type() -> None:
    """The forecast of the lot that flew low is lower, and that of an unknown lot in between and wider."""
    truth = with_lots()
    (term,) = effect_terms(WEAK_LOT, truth)
    flights = measured(truth.with_terms(replace(term, mean=-0.12))).flights
    past = list(zip(flights, truth.found, strict=True))
    plan = next(flight for flight in flights if flight.motor == "F24").with_changes(
        flight_id="next", **dict.fromkeys(OBSERVED_READOUTS)
    )
    found = past[0][1]
    plans = [(plan.with_changes(extra={"motor_lot": lot}), found) for lot in ("1", "2", "3")]
    first, second, new = (np.log(one.apogee) for one in predict(past, plans, draws=800, seed=1))
    assert np.median(second) < np.median(new) < np.median(first)
    assert new.std() > max(first.std(), second.std())
