"""Flights compared with the others of their rocket, in words."""

from dataclasses import replace
from math import log

import pytest

from fieldkit.flight import Flight
from fieldkit.forecast.one_offs import FlightBesideOthers, Impossible, PossibleCause
from fieldkit.presentation.one_off_text import one_off_lines, why

pytestmark = pytest.mark.fast


def flight(
    probability: float, *causes: tuple[str, float], tags: tuple[str, ...] = (), **departures: tuple[float, float]
) -> FlightBesideOthers:
    """Flight 8, which flew 20% low, with some probable causes."""
    return FlightBesideOthers(
        Flight("8", "Astra", "A", "F24-4W", apogee=200.0, top_speed=60.0, coast_to_apogee=5.0, tags=tags),
        forecast=250.0,
        miss=-50.0,
        miss_sd=15.0,
        departures={"apogee": (log(0.8), 0.06), **departures},
        probability=probability,
        causes=tuple(PossibleCause(name, chance, 1.0, "") for name, chance in causes),
    )


def test_a_likely_cause_comes_with_its_evidence() -> None:
    one = flight(0.9, ("arc", 0.71), ("mass", 0.1), top_speed=(0.01, 0.05), coast_to_apogee=(log(5 / 5.9), 0.05))
    assert why(one) == ("Flight 8 flew 20% low. Most likely an arc (71%): top speed as usual, coast 0.9 s short.")


def test_without_other_readouts_the_possible_causes_are_listed_with_what_would_decide() -> None:
    one = flight(0.9, ("extra_drag", 0.31), ("weak_motor", 0.29), ("arc", 0.2), ("mass", 0.1))
    assert why(one) == (
        "Flight 8 flew 20% low. Possible: extra drag (31%), a weak motor (29%) or an arc (20%); "
        "the apogee alone does not decide, top speed and coast time would."
    )


def test_a_usual_flight_is_scatter() -> None:
    assert why(flight(0.1, ("arc", 0.05))) == "Flight 8 flew 20% low, within the scatter of its rocket."
    assert list(one_off_lines([flight(0.1, ("arc", 0.05))])) == []


def test_a_flight_without_an_id_of_its_own_or_a_date_is_not_called_like_its_motor() -> None:
    one = flight(0.1, ("arc", 0.05))
    assert why(replace(one, flight=one.flight.with_changes(flight_id="flight-dd2afbb08f"))).startswith(
        "The flight on F24-4W flew 20% low"
    )


def test_a_misread_readout_is_named() -> None:
    one = flight(0.9, ("misread", 0.8), top_speed=(0.62, 0.05))
    assert "a misread top speed (80%): top speed 86% high" in why(one)


def test_a_tag_is_suggested_for_a_flight_that_has_none() -> None:
    one = flight(0.9, ("arc", 0.5), ("weak_motor", 0.3), ("misread", 0.1))
    assert one.suggested_tags == ("off_axis", "weak_launch")
    assert list(one_off_lines([one]))[1] == "If that is so: `fieldkit tag 8 off_axis`."
    foreign = replace(one, flight=one.flight.with_changes(flight_id="8; reboot"))
    assert list(one_off_lines([foreign]))[1] == "If that is so: `fieldkit tag '8; reboot' off_axis`."
    tagged = flight(0.9, ("arc", 0.5), tags=("off_axis",))
    assert tagged.suggested_tags == ()
    assert list(one_off_lines([tagged])) == []


def test_a_readout_off_by_the_ratio_of_two_units_comes_with_its_correction() -> None:
    one = flight(0.99, ("misread", 0.98), top_speed=(log(3.3), 0.05))
    assert "a misread top speed (98%), perhaps 60 ft/s taken for 60 m/s: top speed" in why(one)
    assert list(one_off_lines([one]))[1] == "If that is so: `fieldkit edit 8 top_speed=60ft/s`."
    twice = flight(0.99, ("misread", 0.98), top_speed=(log(1.85), 0.02))
    assert "perhaps" not in why(twice)
    assert list(one_off_lines([twice]))[1] == "If that is so: `fieldkit tag 8 altimeter_fault`."


def test_a_speed_that_follows_from_the_average_acceleration_is_not_called_misread() -> None:
    one = flight(0.99, ("misread", 0.98), top_speed=(log(3.3), 0.05))
    one = replace(one, flight=one.flight.with_changes(top_speed=None, avg_accel=200.0))
    assert "a misread average acceleration (98%): average acceleration" in why(one)


def test_a_readout_that_no_fit_uses_is_explained_on_a_usual_flight() -> None:
    one = flight(0.1, ("arc", 0.05))
    impossible = {
        "peak_accel": Impossible("found too much", float("nan")),
        "avg_accel": Impossible("found too much", float("nan")),
    }
    text = why(replace(one, impossible=impossible))
    assert text.endswith(
        "scatter of its rocket. Its peak acceleration and average acceleration are excluded from every fit: "
        "found too much."
    )
    assert list(one_off_lines([replace(one, impossible=impossible)])) == []
    feet = replace(one, impossible={"top_speed": Impossible("too fast", log(3.2))})
    assert why(feet).endswith("Its top speed is excluded from every fit: too fast; perhaps 60 ft/s taken for 60 m/s.")
    assert list(one_off_lines([feet]))[1] == "If that is so: `fieldkit edit 8 top_speed=60ft/s`."
