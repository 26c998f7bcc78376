"""The descent of a plan: its path under each device, and the flight duration.

Derivation: the time is that of the climb plus the integral over the path of `fieldkit/physics/descent.py`.
"""

from collections.abc import Sequence

import numpy as np

from fieldkit.forecast.prediction import Prediction
from fieldkit.physics.descent import DescentResult, Devices, FreeFall, descend, filling
from fieldkit.physics.history import recorded_wind
from fieldkit.physics.wind import WindProfile
from fieldkit.planning.descent_rate import Fall
from fieldkit.planning.flown_descent import air_at_pads, landing_mass
from fieldkit.shapes import Array, Float
from fieldkit.units import STANDARD_GRAVITY


def descents(
    prediction: Prediction, fall: Fall, speed: Float[Array, "draw"], wind: WindProfile | None = None
) -> DescentResult:
    """The descent of each draw of a forecast at a descent speed near the ground [m/s].

    The charge fires after the plan's delay; if no delay is known, or if an altimeter opens two devices, at apogee. A
    draw that reaches the ground first, or before anything is open, lands ballistic.
    """
    plan, recovery = prediction.plan, prediction.plan.columns.recovery
    air = air_at_pads([plan])
    wait = prediction.eject if _has_delay(prediction) and not recovery.dual else np.zeros(len(speed))
    mass, density = landing_mass(plan, prediction.found), float(air.density[0])
    area = np.pi / 4 * (plan.diameter or prediction.found.motor.diameter) ** 2
    terminal = np.sqrt(2 * mass * STANDARD_GRAVITY / np.maximum(density * prediction.cd * area, 1e-9))
    first = speed
    if recovery.dual and fall.drogue is not None:
        first = fall.drogue.speeds(np.random.default_rng(8), (len(speed), 1), mass, density)[:, 0]
    sideways = (np.nan_to_num(prediction.drift_speed), np.nan_to_num(prediction.across_speed))
    fills = filling(np.array(mass), air.density)
    devices = Devices(first, speed, recovery.main_altitude or 0.0, recovery.opening_time, fills)
    free = FreeFall(prediction.true_apogee, wait, terminal, sideways)
    return descend(free, devices, air, wind or recorded_wind(plan))


def durations(
    predictions: Sequence[Prediction], fall: Fall, speeds: Float[Array, "draw flight"]
) -> Float[Array, "draw flight"]:
    """Time from lift-off to landing at these descent speeds near the ground; ballistic if nothing opened. [s]"""
    columns = [
        one.rise_time + descents(one, fall, speed).time for one, speed in zip(predictions, speeds.T, strict=True)
    ]
    return np.stack(columns, axis=-1)


def common_durations(
    predictions: Sequence[Prediction], fall: Fall, area: float = 1.0, seed: int = 7
) -> Float[Array, "draw flight"]:
    """The same for forecasts of one rocket in the same air, with common random descents under a fraction of the
    parachute's area [1]; 0 for a draw that stays on the pad. [s]"""
    density, count = float(air_at_pads([predictions[0].plan]).density[0]), len(predictions[0].apogee)
    speeds = [
        fall.speeds(np.random.default_rng(seed), (count, 1), landing_mass(one.plan, one.found), density, area)
        for one in predictions
    ]
    return np.nan_to_num(durations(predictions, fall, np.concatenate(speeds, axis=1)))


def _has_delay(prediction: Prediction) -> bool:
    delay = prediction.plan.delay if prediction.plan.delay is not None else prediction.found.delay
    return delay is not None and bool(np.isfinite(delay))
