"""Weather with a standard deviation, as saved weather files state it, is a measurement error of each flight."""

import math
from functools import cache
from pathlib import Path

import numpy as np
import pytest

from fieldkit.flight import Flight
from fieldkit.inference.laplace.fit import fit
from fieldkit.inference.laplace.linearization import launch_angle_slope, tangents
from fieldkit.model.certified_prior import CERTIFIED_PRIOR
from fieldkit.model.readout_data import observe
from fieldkit.model.rocket_model import Model, base_model, scatter_of, strength_term
from fieldkit.model.simulated_readouts import shown
from fieldkit.model.term_names import TermName
from fieldkit.motors import catalogue
from fieldkit.physics.effect import effects
from fieldkit.physics.history import history_of
from tests.commands import Run

WINDS = (0.5, 3.0, 5.0, 1.0, 6.0, 4.0)
WIND = TermName("wind")


def flown(**sds: str) -> list[Flight]:
    """Flights in winds of `WINDS`, the apogee lower by 0.4% per (m/s)^2, with further columns."""
    plain = Flight(rocket="Lark", motor="F24-4W", dry_mass=0.322, diameter=0.066, temperature=300.0, pressure=101e3)
    return [
        plain.with_changes(flight_id=str(i), wind=wind, apogee=255.0 * (1 - 0.004 * wind**2)).with_columns(**sds)
        for i, wind in enumerate(WINDS)
    ]


def windy(flights: list[Flight]) -> Model:
    """The model of flights whose rocket weathercocks."""
    found = [catalogue().resolve("AeroTech F24W-4")] * len(flights)
    model = base_model(history_of(flights, found), CERTIFIED_PRIOR)
    return model.with_terms(strength_term(WIND, effects()["wind"], np.ones(len(flights))))


def at_prior(model: Model) -> np.ndarray[tuple[int], np.dtype[np.float64]]:
    return np.array([term.mean for term in model.terms])


def slope_of(model: Model, kind: str, **terms: float) -> np.ndarray[tuple[int], np.dtype[np.float64]]:
    """The change of every log apogee by one standard deviation of a condition, with some terms at another value."""
    at = at_prior(model)
    for name, value in terms.items():
        at[model.names.index(TermName(name))] = value
    (near,) = tangents(model, [(tuple(range(len(at))), at)], launch_angle_slope(model, at))
    found: np.ndarray[tuple[int], np.dtype[np.float64]] = near.scatter_slope[
        :, 0, [one.bends for one in model.scatter].index(kind)
    ]
    return found


def test_weather_without_a_standard_deviation_adds_no_scatter() -> None:
    assert windy(flown()).scatter == scatter_of(CERTIFIED_PRIOR)
    assert (
        windy(flown(wind_sd_mps="")).scatter == windy(flown(wind_sd_mps="none")).scatter == scatter_of(CERTIFIED_PRIOR)
    )


def test_without_drag_an_error_of_the_temperature_is_one_of_the_altimeter() -> None:
    """A barometric altimeter takes standard air: it reads lower by the ratio of the temperatures."""
    model = windy(flown(temperature_sd_c="3"))
    assert slope_of(model, "temperature", drag=-12.0, wind=0.0) == pytest.approx(-math.log(303 / 300), rel=0.01)


def test_an_error_of_the_wind_moves_an_apogee_as_the_square_of_the_wind_does() -> None:
    """The height lost by weathercocking is near k w^2, so one standard deviation more loses k (2 w s + s^2)."""
    slope = slope_of(windy(flown(wind_sd_mps="0.5")), "wind", wind=0.3)
    expected = np.array([2 * wind * 0.5 + 0.25 for wind in WINDS])
    assert (slope < 0).all()
    np.testing.assert_allclose(slope / slope.sum(), expected / expected.sum(), rtol=0.05)


def test_the_added_variance_is_that_of_flights_in_random_weather() -> None:
    model, rng = windy(flown(temperature_sd_c="3", pressure_sd_hpa="8", wind_sd_mps="0.3")), np.random.default_rng(3)
    scatter = {kind: rng.normal(size=(2000, len(WINDS))) for kind in ("temperature", "pressure", "wind")}
    at = at_prior(model)
    apogees = shown(model, np.tile(at, (2000, 1)), scatter)["apogee"]
    added = sum(slope_of(model, kind) ** 2 for kind in scatter)
    np.testing.assert_allclose(np.log(apogees).var(axis=0), added, rtol=0.12)


@cache
def strength(sd: str) -> tuple[float, float]:
    """Mean and standard deviation of the strength of weathercocking, fitted with a standard deviation of the wind."""
    model = windy(flown(**({"wind_sd_mps": sd} if sd else {})))
    mean, spread = fit(model, observe(model.history, CERTIFIED_PRIOR)).moments()
    place = model.names.index(WIND)
    return float(mean[place]), float(spread[place])


def test_the_less_a_wind_is_known_the_less_it_shows_of_weathercocking() -> None:
    assert strength("0.001") == pytest.approx(strength(""), rel=0.01)
    sds = [strength(sd)[1] for sd in ("", "1", "3")]
    assert sds[0] < sds[1] < sds[2]
    assert sds[2] > 1.1 * sds[0]


def test_an_impossible_standard_deviation_is_at_most_that_of_ignorance() -> None:
    (history,) = (history_of(flown(wind_sd_mps="1e9"), [catalogue().resolve("F24-4W")] * len(WINDS)),)
    assert history.weather_sd("wind").max() == 5.0
    assert history_of(flown(wind_sd_mps="-3"), [catalogue().resolve("F24-4W")] * len(WINDS)).uncertain == ()


def test_the_forecast_of_a_plan_is_as_uncertain_as_its_weather(run: Run, tmp_path: Path) -> None:
    """A degree moves the apogee on the altimeter by 0.2%, 15 degrees by 3%."""
    flights, plans = tmp_path / "flights.csv", tmp_path / "plans.csv"
    heights = (255, 257, 254, 256, 255, 253, 256, 255)
    flown = "".join(f"{i},2026-05-{i + 1:02}T10:00,Lark,F24-4W,322,66,20,{one}\n" for i, one in enumerate(heights))
    flights.write_text(f"flight_id,date_time,rocket,motor,dry_mass_g,diameter_mm,temperature_c,apogee_m\n{flown}")
    plan = "Lark,F24-4W,322,66,20,"
    plans.write_text(f"rocket,motor,dry_mass_g,diameter_mm,temperature_c,temperature_sd_c\n{plan}\n{plan}15\n")
    run("import", flights)
    known, unknown = (
        one["apogee_m"]["sd"] / one["apogee_m"]["mean"]
        for one in run("predict", "--flights", plans, "--json").document["predictions"]
    )
    assert math.sqrt(unknown**2 - known**2) == pytest.approx(0.03, rel=0.25)
