"""The features of a flight for the field ensemble: one function of arrays, used in training and in the field.

A readout enters as the log of its ratio to a closed-form value at the middle of the prior, so that a sounding rocket
and a 13 mm toy have features of the same size. A missing readout is a zero and a flag.

Derivation: the log of a ratio is 0 for a flight at the middle of the prior, and errors proportional to the readout have
the same size everywhere. `closed_form` names its source.
"""

import numpy as np

from fieldkit.model.observations import (
    DECLARED_FIELDS,
    FIGURES,
    INDEPENDENT_READOUTS,
    READOUT_NAMES,
    Observed,
    drag_area_range,
)
from fieldkit.physics.atmosphere import GRAVITY, altimeter_gain, pad_air
from fieldkit.shapes import Array, Flags, Float

_PROBES = np.array([[1.0, 1.0], [2.0, 1.0], [0.5, 1.0], [1.0, 1.15], [1.0, 0.85]])
"""Multiples of drag area and thrust at which the closed form is evaluated, the middle of the prior first."""
_MIN_SCALE = 1e-3


def closed_form(
    motor: dict[str, Array], dry_mass: Array, drag_area: Array, thrust: Array, density: Array
) -> dict[str, Array]:
    """Top speed [m/s], apogee [m] and coast time [s] of vertical flights at constant thrust, mass and air density.

    One entry per flight: the figures of its motor in SI, dry mass [kg], drag area [m^2], thrust scale [1], air density
    [kg/m^3]. The height gained during the burn is scaled by how early the thrust comes. Source: Fehskens and Malewicki
    (Malewicki, Model Rocket Altitude Prediction Charts, 1967).
    """
    empty = dry_mass + motor["casing"]
    mass = empty + 0.5 * motor["propellant"]
    push = thrust * motor["total_impulse"] / motor["burn_time"]
    net = np.maximum(push - mass * GRAVITY, 0.1 * push)
    drag = 0.5 * density * drag_area
    limit = np.sqrt(net / drag)
    reach = np.minimum(drag * limit * motor["burn_time"] / mass, 300.0)
    speed = limit * np.tanh(reach)
    drag_to_weight = drag * speed**2 / (empty * GRAVITY)
    return {
        "top_speed": speed,
        "apogee": 2 * (1 - motor["middle"] / motor["burnout"]) * mass / drag * np.log(np.cosh(reach))
        + empty / (2 * drag) * np.log1p(drag_to_weight),
        "coast_to_apogee": np.sqrt(empty / (GRAVITY * drag)) * np.arctan(np.sqrt(drag_to_weight)),
    }


def _settled(observed: Observed) -> tuple[Array, Array]:
    """Top speed and burn time, each refined or replaced by the average acceleration if there is one.

    Top speed is average acceleration times burn time exactly, so acceleration adds only digits: it gives a burn time
    that is displayed to a tenth of a second more precisely.
    """
    speed, burn, average = (observed.readout(name) for name in ("top_speed", "burn_time", "avg_accel"))
    average = np.where(average > 0, average, np.nan)
    finer = np.clip(speed / average, burn - 0.05, burn + 0.05)
    settled = np.where(np.isnan(burn), speed / average, np.where(np.isnan(finer), burn, finer))
    return np.where(np.isnan(speed), average * burn, speed), settled


def _log(ratio: Array) -> Array:
    """The logarithm, floored so that a readout of zero stays finite."""
    return np.log(np.clip(ratio, _MIN_SCALE, 1 / _MIN_SCALE))


def features(observed: Observed) -> Float[Array, "flight feature"]:
    """The features for the ensemble, one column for each of `FEATURES`, without nan. [1]"""
    columns = _columns(observed)
    return np.nan_to_num(np.stack([columns[name] for name in FEATURES], axis=-1), nan=0.0)


def shown(observed: Observed) -> Float[Array, "flight seen"]:
    """Each readout relative to its closed-form value, one column for each of `INDEPENDENT_READOUTS`; nan if missing.
    [1]

    The ensemble predicts each from the others to find one that disagrees.
    """
    with np.errstate(invalid="ignore", divide="ignore"):
        motor, nominal = _nominal(observed)
        speed, burn = _settled(observed)
        heights = {name: observed.readout(name) / nominal["apogee"] for name in ("apogee", "eject_altitude")}
        expected = motor["burn_time"] + nominal["coast_to_apogee"] + nominal["apogee"] / 5.0
        lightest = observed.given("dry_mass") + motor["casing"] + motor["propellant"]
        values = {
            "top_speed": _log(speed / nominal["top_speed"]),
            "burn_time": _log(burn / motor["burn_time"]),
            "peak_accel": _log((observed.readout("peak_accel") + GRAVITY) * lightest / motor["peak_thrust"]),
            "coast_to_apogee": _log(observed.readout("coast_to_apogee") / nominal["coast_to_apogee"]),
            "apogee_to_eject": np.arcsinh(2 * observed.readout("apogee_to_eject")),
            "descent_speed": _log(observed.readout("descent_speed") / 5.0),
            "duration": _log(observed.readout("duration") / expected),
        } | {name: _log(height) for name, height in heights.items()}
        return np.stack([values[name] for name in INDEPENDENT_READOUTS], axis=-1)


def _nominal(observed: Observed) -> tuple[dict[str, Array], dict[str, Array]]:
    """The motors' figures by name, and the closed-form values at the middle of the prior in standard air."""
    motor = {name: observed.figure(name) for name in FIGURES}
    low, high = drag_area_range(observed)
    middle = np.exp(0.5 * (low + high))
    return motor, closed_form(motor, observed.given("dry_mass"), middle, np.asarray(1.0), np.asarray(1.225))


def _columns(observed: Observed) -> dict[str, Array]:
    with np.errstate(invalid="ignore", divide="ignore"):
        motor = {name: observed.figure(name) for name in FIGURES}
        dry_mass = observed.given("dry_mass")
        low, high = drag_area_range(observed)
        weather = [observed.given(name) for name in ("site_elevation", "temperature", "pressure")]
        density = pad_air(weather[0], weather[1], weather[2], observed.given("humidity")).density
        probes = closed_form(motor, dry_mass, _PROBES[:, :1] * np.exp(0.5 * (low + high)), _PROBES[:, 1:], density)
        nominal = {name: values[0] for name, values in probes.items()}
        columns = _readouts(observed, motor, nominal, altimeter_gain(weather[0], weather[1], weather[2]))
        columns |= _circumstances(observed, motor, nominal, (low, high), density)
        for name, values in probes.items():
            columns[f"expected_{name}"] = np.log(values[0])
            columns |= {f"expected_{name}_{n}": np.log(values[n] / values[0]) for n in range(1, len(_PROBES))}
        return columns


def _readouts(observed: Observed, motor: dict[str, Array], nominal: dict[str, Array], gain: Array) -> dict[str, Array]:
    """Each readout relative to its closed-form value, the pairs that determine drag without the rest, and the flags."""
    dry_mass = observed.given("dry_mass")
    speed, burn = _settled(observed)
    apogee = observed.readout("apogee") / gain
    coast, ejected = observed.readout("coast_to_apogee"), observed.readout("apogee_to_eject")
    descent = observed.readout("descent_speed")
    top = np.where(np.isnan(apogee), nominal["apogee"], apogee)
    known_burn = np.where(np.isnan(burn), motor["burn_time"], burn)
    up = known_burn + np.where(np.isnan(coast), nominal["coast_to_apogee"], coast)
    down = top / np.maximum(np.where(np.isnan(descent), 5.0, descent), 0.5)
    lightest = dry_mass + motor["casing"] + motor["propellant"]
    columns = {
        "apogee": _log(apogee / nominal["apogee"]),
        "top_speed": _log(speed / nominal["top_speed"]),
        "burn_time": _log(burn / motor["burn_time"]),
        "peak_accel": _log((observed.readout("peak_accel") + GRAVITY) * lightest / motor["peak_thrust"]),
        "coast_to_apogee": _log(coast / nominal["coast_to_apogee"]),
        "apogee_to_eject": np.arcsinh(2 * ejected),
        "eject_altitude": np.clip(observed.readout("eject_altitude") / gain / top, 0.0, 3.0),
        "descent_speed": _log(descent / 5.0),
        "duration": _log(observed.readout("duration") / (up + down)),
    }
    flags = {f"has_{name}": np.isfinite(columns[name]).astype(float) for name in INDEPENDENT_READOUTS}
    return (
        columns
        | flags
        | {
            "has_avg_accel": np.isfinite(observed.readout("avg_accel")).astype(float),
            "rise_by_speed": _log((apogee - 0.5 * speed * known_burn) * 2 * GRAVITY / speed**2),
            "coast_by_speed": _log(coast * GRAVITY / speed),
            "rise_by_coast": _log((apogee - 0.5 * nominal["top_speed"] * known_burn) / (0.5 * GRAVITY * coast**2)),
            "delay": _log(observed.given("delay") / nominal["coast_to_apogee"]),
            "charge": np.arcsinh(coast + ejected - observed.given("delay")),
        }
    )


def _circumstances(
    observed: Observed, motor: dict[str, Array], nominal: dict[str, Array], bounds: tuple[Array, Array], density: Array
) -> dict[str, Array]:
    """The conditions of the flight (rocket, motor, air, rail), without outcomes."""
    dry_mass = observed.given("dry_mass")
    mass = dry_mass + motor["casing"] + motor["propellant"]
    mean = motor["total_impulse"] / motor["burn_time"]
    names = ("delay", "site_elevation", "temperature", "pressure", "wind", "rail_angle", "rail_length")
    flags: dict[str, Flags] = {f"has_{name}": np.isfinite(observed.given(name)) for name in ("diameter", *names)}
    return {name: flag.astype(float) for name, flag in flags.items()} | {
        "log_mass": np.log(mass),
        "log_thrust_to_weight": np.log(mean / (mass * GRAVITY)),
        "log_ballistic": np.log(density * np.exp(0.5 * (bounds[0] + bounds[1])) * nominal["top_speed"] ** 2 / mass),
        "log_drag_area": 0.5 * (bounds[0] + bounds[1]),
        "drag_area_span": bounds[1] - bounds[0],
        "mach": nominal["top_speed"] / 340.0,
        "propellant_share": motor["propellant"] / mass,
        "casing_share": motor["casing"] / mass,
        "log_impulse": np.log(motor["total_impulse"]),
        "log_exhaust_speed": np.log(motor["total_impulse"] / motor["propellant"]),
        "log_burn_time": np.log(motor["burn_time"]),
        "log_peak": np.log(motor["peak_thrust"] / mean),
        "peak_to_weight": np.log(motor["peak_thrust"] / (mass * GRAVITY)),
        "middle": motor["middle"] / motor["burn_time"],
        "spread": motor["spread"] / motor["burn_time"],
        "late": motor["burnout"] / motor["burn_time"] - 1,
        "log_density": np.log(density / 1.225),
        "wind": observed.given("wind") / 5.0,
        "rail_angle": np.abs(observed.given("rail_angle")) * 10.0,
        "rail_length": np.log(observed.given("rail_length")),
    }


def _names() -> tuple[str, ...]:
    one = Observed(np.ones((1, len(FIGURES))), np.ones((1, len(DECLARED_FIELDS))), np.ones((1, len(READOUT_NAMES))))
    return tuple(_columns(one))


FEATURES = _names()
"""The columns of `features`, in order."""
