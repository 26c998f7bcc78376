"""Fit how closely high-power flights follow their simulation, from first flights and the forecasts of programs."""

import hashlib
import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
from scipy.stats import norm

from fieldkit.errors import NoFlights, UnknownMotor
from fieldkit.files import read
from fieldkit.flight import Flight
from fieldkit.flight.further import texts_under
from fieldkit.flight.launch_conditions import check_conditions
from fieldkit.inference.laplace.high_power import Departure, DesignForecast, departure, learn_high_power, log_density
from fieldkit.model.high_power import is_high_power
from fieldkit.model.hyperprior import DESIGN_DRAG, Hyperprior
from fieldkit.motors import Catalogue
from fieldkit.physics.atmosphere import pad_air
from fieldkit.scoring.proper_scores import crps, interval_score
from fieldkit.services.imports import gather
from fieldkit.shapes import Array, Float

FORECAST_COLUMN = ("predicted_", "_m")
"""Beginning and end of the name of a column with forecast apogees."""
MACH_COLUMN = "peak_mach"
QUANTILES = norm.ppf((np.arange(400) + 0.5) / 400)
"""Draws that stand for a standard normal distribution in scores. [1]"""
Z90 = float(norm.ppf(0.95))


@dataclass(frozen=True, slots=True)
class HighPowerTable:
    """The usable flights of a table, its name and its digest."""

    name: str
    digest: str
    forecasts: tuple[DesignForecast, ...]


def read_table(path: Path, motors: Catalogue) -> HighPowerTable:
    """The flights with a diameter, an apogee, a known high-power motor, a peak Mach number and a forecast apogee.

    The table is a flight table with further columns: `peak_mach` and `predicted_..._m`, one for each program. Raises
    FieldkitError, BadValue for a wind aloft or rail direction that cannot be read, NoFlights.
    """
    flights = [incoming.flight for incoming in gather([path], motors.complaint).incoming_flights]
    found = [one for flight in flights if (one := _usable(flight, motors))]
    for one in found:
        check_conditions(one.flight)
    if not found:
        raise NoFlights(
            f"{path}: found no flight with diameter_mm, apogee_m, {MACH_COLUMN}, predicted_..._m and a known "
            "high-power motor, expected at least one"
        )
    return HighPowerTable(path.stem, hashlib.sha256(read(path)).hexdigest(), tuple(found))


def _usable(flight: Flight, motors: Catalogue) -> DesignForecast | None:
    """The flight and its forecasts in a row, or None if it lacks something or cannot be used."""
    begin, end = FORECAST_COLUMN
    forecasts = texts_under(flight, lambda header: header.startswith(begin) and header.endswith(end))
    mach, known = _positive(flight.text(MACH_COLUMN)), tuple(filter(None, map(_positive, forecasts)))
    if not (flight.clean and flight.diameter and flight.apogee and mach and known):
        return None
    try:
        found = motors.resolve(flight.motor)
    except UnknownMotor:
        return None
    if not is_high_power(found):
        return None
    conditions = (flight.site_elevation, flight.temperature, flight.pressure, flight.humidity)
    air = pad_air(*(np.array([math.nan if value is None else value]) for value in conditions))
    return DesignForecast(flight, found, known, mach * float(air.sound_speed(np.zeros(1))[0]))


def _positive(text: str) -> float:
    """A positive number, or 0 for any other text."""
    try:
        number = float(text)
    except ValueError:
        return 0.0
    return number if math.isfinite(number) and number > 0 else 0.0


def learn_from_table(table: HighPowerTable, hyperprior: Hyperprior) -> Hyperprior:
    """The hyperprior with its figures for high power fitted to a table, with a record and scores in `about`.

    Raises ImpossibleFlight if a flight cannot be simulated.
    """
    departures = [departure(one, hyperprior) for one in table.forecasts]
    start = replace(hyperprior, high_power=1.0, design_drag=DESIGN_DRAG)
    found = learn_high_power(departures, start)
    record = {
        "command": f"fieldkit learn --high-power {table.name}",
        "flights": len(departures),
        "rockets": len({one.rocket for one in departures}),
        "forecasts": sum(len(one.ratios) for one in departures),
        "sha256": table.digest,
        "log_density": {
            "before": sum(log_density(one, start) for one in departures),
            "after": sum(log_density(one, found) for one in departures),
        },
        "scores": scores(departures, start),
    }
    return replace(found, about={**hyperprior.about, "high_power_flights": record})


def scores(departures: Sequence[Departure], start: Hyperprior) -> list[dict[str, Any]]:
    """Scores of forecasts of first flights relative to the forecast apogee, cross-validated by rocket, for the card:
    with the figures of model rockets, with those fitted to the other rockets, and of simpler methods."""
    rows: dict[str, list[tuple[float, float, float]]] = {}
    for rocket in dict.fromkeys(one.rocket for one in departures):
        others = [one for one in departures if one.rocket != rocket]
        fitted = learn_high_power(others, start)
        seen = np.array([ratio for one in others for ratio in one.ratios])
        for one in (one for one in departures if one.rocket == rocket):
            ways = {
                "fieldkit": one.moments(fitted),
                "as model rockets": one.moments(start),
                "design program": (0.0, 0.0),
                "program, mean ratio": (float(seen.mean()), float(seen.std(ddof=1))),
            }
            for name, moments in ways.items():
                rows.setdefault(name, []).extend((ratio, *moments) for ratio in one.ratios)
    return [{"name": name, **_tally(np.array(own))} for name, own in rows.items()]


def _tally(rows: Float[Array, "forecast 3"]) -> dict[str, float]:
    """Mean absolute error, CRPS, 90% interval score and coverage of normal forecasts of log ratios."""
    ratio, mean, sd = rows.T
    low, high = mean - Z90 * sd, mean + Z90 * sd
    draws = mean[:, None] + sd[:, None] * QUANTILES
    return {
        "mean_share": float(np.abs(mean - ratio).mean()),
        "crps": float(np.mean([crps(own, flown) for own, flown in zip(draws, ratio, strict=True)])),
        "interval_score": float(np.mean([interval_score(*ends) for ends in zip(low, high, ratio, strict=True)])),
        "coverage90": float(((low <= ratio) & (ratio <= high)).mean()),
    }
