"""The ceiling is checked against the same interval that the forecast shows."""

import numpy as np
import pytest

from fieldkit.flight import Flight
from fieldkit.flight.site import Site
from fieldkit.forecast.earlier_forecasts import EarlierForecasts
from fieldkit.motors import catalogue
from fieldkit.planning.descent_rate import usual
from fieldkit.planning.forecasts import RocketData, forecasts
from fieldkit.planning.limits import limits
from fieldkit.planning.safety import safety_lines

FOUND = catalogue().resolve("F24-7W")
PLAN = Flight(rocket="Swift", dry_mass=0.4, diameter=0.05, motor="AeroTech F24-7W")


def test_an_interval_widened_by_calibration_is_also_used_for_the_ceiling() -> None:
    narrow, wide = (
        forecasts(RocketData((), (), EarlierForecasts(20, factor)), [(PLAN, FOUND)], draws=200)[0].true_apogee
        for factor in (1.0, 2.0)
    )
    assert np.median(wide) == pytest.approx(np.median(narrow), rel=1e-3)
    assert np.log(wide).std() == pytest.approx(2 * np.log(narrow).std(), rel=1e-6)
    ceiling = float(np.quantile(narrow, 0.96))
    for factor, verdict in ((1.0, "ok"), (2.0, "unsafe")):
        (forecast,) = forecasts(RocketData((), (), EarlierForecasts(20, factor)), [(PLAN, FOUND)], draws=200)
        lines = {one.name: one for one in safety_lines(forecast, Site(ceiling=ceiling), usual(), limits())}
        assert lines["ceiling"].verdict == verdict
