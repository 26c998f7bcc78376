"""Simulated altimeter readouts of a rocket's flights for draws of its model's parameters.

Derivation: terms act additively on the logarithm of a readout, so they multiply it by the exponential of their sum; the
time from apogee to ejection, which may be negative, is shifted instead.
"""

from collections.abc import Mapping
from typing import Any

import numpy as np

from fieldkit.model.hyperprior import FROM_LOGS
from fieldkit.model.readout_data import OBSERVED_READOUTS
from fieldkit.model.rocket_model import Model
from fieldkit.model.sources import has_log
from fieldkit.physics.effect import Effect
from fieldkit.physics.logged import (
    burn_impulse,
    climbed_drag,
    climbed_impulse,
    climbed_peak,
    coast_drag,
    felt_peak,
    highest_mean,
)
from fieldkit.physics.setups import in_other_weather
from fieldkit.physics.state import Setup
from fieldkit.physics.thrust_steps import FORECAST_RESOLUTION, Resolution
from fieldkit.physics.unique import fly_unique
from fieldkit.shapes import Array, Flags, Float

HEIGHT_SENSORS = ("baro", "gps")
"""Sensors of heights: a top speed from one is a climb rate."""
EXTRAS = (
    "rail_speed",
    "eject_speed",
    "coast_time",
    "rise_time",
    "cut_short",
    "drift",
    "across",
    "drift_speed",
    "across_speed",
)
"""Figures of a flight that a plan needs and the altimeter does not show."""
REFERENCE_LAUNCH_ANGLE = np.radians(5.0)
"""Unit of the scatter in launch angle. [rad]"""
COARSE_RESOLUTION = Resolution(steps=8, knots=12, stride=2.0)
"""Resolution of a coarse model. For 95% of motors they change the apogee by less than 0.2% and the speed
off the rail by less than 2% (twice that in wind), a small part of the scatter of flights."""


def shown(
    model: Model, values: Float[Array, "draw term"], scatter: Mapping[str, Float[Array, "draw flight"]]
) -> dict[str, Float[Array, "draw flight"]]:
    """Altimeter readouts of every flight, in SI, and a few figures that it does not show.

    `scatter` acts on single flights; errors of `UNCERTAIN_WEATHER` are in standard deviations. A flight that does not
    leave the pad is nan throughout. Raises ImpossibleFlight for a flight without a dry mass.
    """
    setup, readings_bends = _bent_setup(model, values, scatter)
    flown = fly_unique(setup)
    readings: Mapping[str, Any] = flown.readouts()
    peak_part = model.history.once("peak part", lambda: _peak_part(model))
    readings = {**readings, "peak_accel": felt_peak(readings["peak_accel"], peak_part)}
    for name, climbed in (("top_speed", flown.top_climb), ("peak_accel", climbed_peak(flown))):
        readings = {**readings, name: np.where(_by(model, name, *HEIGHT_SENSORS), climbed, readings[name])}
    by_pressure = _by(model, "top_speed", "baro", "baro+accel") & (flown.apogee > 0)
    standard = np.divide(flown.apogee_shown, flown.apogee, out=np.ones_like(flown.apogee), where=by_pressure)
    readings = {**readings, "top_speed": readings["top_speed"] * standard}
    for name, height in (("apogee", flown.apogee), ("eject_altitude", flown.eject_altitude)):
        readings = {**readings, name: np.where(_by(model, name, "gps"), height, readings[name])}
    for effect, strength in readings_bends:
        readings = effect.bend_reading(readings, strength)
    grounded = flown.lift_off == 0
    logged = dict.fromkeys(FROM_LOGS, np.full(grounded.shape, np.nan))
    if any(map(has_log, model.flights)):
        drag, impulse = coast_drag(setup, flown), burn_impulse(setup)
        logged = {
            "coast_drag": np.where(_by(model, "coast_drag", *HEIGHT_SENSORS), climbed_drag(flown, drag), drag),
            "burn_impulse": np.where(
                _by(model, "burn_impulse", *HEIGHT_SENSORS), climbed_impulse(flown, impulse), impulse
            ),
        }
    readings = {**readings, **logged}
    out = {name: np.where(grounded, np.nan, value) for name, value in readings.items()}
    for name in OBSERVED_READOUTS:
        bias = bent(model, values, name)
        ratio = name != "apogee_to_eject"
        out[name] = out[name] * np.exp(bias) if ratio else out[name] + bias
    figures = {name: np.where(grounded, np.nan, getattr(flown, name)) for name in EXTRAS}
    higher = np.exp(bent(model, values, "apogee"))  # this is an error of the simulator, not of the altimeter
    sinking = out["duration"] - figures["rise_time"] - np.fmax(np.nan_to_num(out["apogee_to_eject"]), 0.0)
    return out | figures | {"true": flown.apogee * higher, "duration": out["duration"] + (higher - 1) * sinking}


def _by(model: Model, name: str, *sensors: str) -> Flags:
    """Whether a readout of each flight is by one of some sensors: heights show the upward part of a slanted path, and
    those of satellites are true, while an altimeter assumes the standard atmosphere, in speeds as in heights."""
    found = [flight.readout(name) for flight in model.flights]
    return np.array([one is not None and one.source in sensors for one in found], bool)


def _peak_part(model: Model) -> Float[Array, "flight"]:
    """The highest mean thrust of each flight's motor over the window of a peak in a log, as a fraction of its highest
    thrust [1]; 1 unless the samples of an accelerometer show the peak, because devices average over unknown times."""
    felt = _by(model, "peak_accel", "accel")
    found = zip(felt.tolist(), model.history.found, strict=True)
    return np.array([highest_mean(one.motor) if own else 1.0 for own, one in found])


def bent(model: Model, values: Float[Array, "draw term"], bends: str) -> Float[Array, "draw flight"]:
    """The sum of all terms that act on one property, in the unit of the property."""
    acting = [i for i, term in enumerate(model.terms) if isinstance(term.bends, str) and term.bends == bends]
    if not acting:
        return np.zeros((len(values), len(model.flights)))
    return np.asarray(values[:, acting] @ np.stack([model.terms[i].weight for i in acting]))


def _bent_setup(model: Model, values: Array, scatter: Mapping[str, Array]) -> tuple[Setup, list[tuple[Effect, Array]]]:
    def bend(what: str) -> Array:
        return np.asarray(bent(model, values, what) + scatter.get(what, 0.0))

    history = model.history
    setup = history.setup(COARSE_RESOLUTION if model.coarse else FORECAST_RESOLUTION)
    if off := {name: scatter[name] * history.weather_sd(name) for name in history.uncertain if name in scatter}:
        setup = in_other_weather(setup, history.flights, off)
    setup = setup.with_changes(
        drag_area=setup.drag_area * np.exp(bend("drag")),
        thrust_factor=np.exp(bend("thrust")),
        dry_mass=setup.dry_mass * np.exp(bend("mass")),
        burn_stretch=np.exp(bend("stretch")),
        delay=setup.delay * np.exp(bend("delay")),
        opening_time=np.maximum(bend("opening"), 0.0),
    )
    if np.any(tilt := bend("tilt")):
        launch_angle = REFERENCE_LAUNCH_ANGLE * np.sqrt(np.abs(tilt))
        steeper = np.hypot(setup.rail_angle, launch_angle)
        setup = setup.with_changes(rail_angle=np.where(setup.rail_angle < 0, -steeper, steeper))
    strengths = _strengths(model, values)
    for effect, strength in strengths:
        setup = effect.bend_setup(setup, strength)
    return setup, strengths


def _strengths(model: Model, values: Array) -> list[tuple[Effect, Array]]:
    """The strength of each effect on each flight, summed over its terms; effects that act on no flight are left out."""
    places: dict[Effect, list[int]] = {}
    for index, term in enumerate(model.terms):
        if isinstance(term.bends, Effect):
            places.setdefault(term.bends, []).append(index)
    found = []
    for effect, indices in places.items():
        weight = np.stack([model.terms[i].weight for i in indices])
        strength = np.asarray(effect.strength(values[:, indices]) @ weight)
        if strength.any():
            found.append((effect, strength))
    return found
