"""The descent speed of a recorded flight, from its duration or its readouts: the inverse of the descent model.

Derivation: the speed at which the descent model takes the recorded time from the recorded apogee.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from fieldkit.errors import BadValue
from fieldkit.flight import TWO_DEVICES, Flight
from fieldkit.flight.recovery import DESCENT_SPEED, Recovery
from fieldkit.motors import Found
from fieldkit.physics.atmosphere import Air, altimeter_gain, pad_air
from fieldkit.physics.descent import Devices, FreeFall, fall_time, filling, lag, opening_time, sink
from fieldkit.physics.flight import fly
from fieldkit.physics.history import field_setup
from fieldkit.physics.setups import recorded
from fieldkit.planning.contest_flight import judged_duration
from fieldkit.shapes import Array
from fieldkit.units import STANDARD_GRAVITY

DROGUE_SPEED = 20.0
"""Default speed under a drogue, an assumption: 15 to 17 in student launches, 23 to 46 for large rockets. [m/s]"""
CD_GRID = np.exp(np.linspace(np.log(0.1), np.log(4.0), 12))
"""Drag coefficients among which the one matching a recorded apogee is searched. [1]"""
ROUNDS = 6
"""Iterations of the search for a descent speed; each correction is a small fraction of the last. [1]"""


def landing_mass(flight: Flight, found: Found) -> float:
    """Mass of the rocket with the motor burned out. [kg]"""
    return (flight.dry_mass or np.nan) + found.motor.casing_mass


def air_at_pads(flights: Sequence[Flight]) -> Air:
    """The air at the pad of each flight; the default for missing values is the standard atmosphere."""
    elevation, temperature, pressure, humidity = (
        recorded(flights, name) for name in ("site_elevation", "temperature", "pressure", "humidity")
    )
    return pad_air(elevation, temperature, pressure, humidity)


def shown_speeds(flight: Flight, found: Found) -> tuple[float | None, float | None]:
    """Descent speeds near the ground computed from a flight: of its last device, and of a drogue above it. [m/s]

    The speeds under two devices that a log shows are used as they are, because each is the slope of its own part of the
    descent. Otherwise a duration is what a stopwatch and a judge measure, and it averages over the whole descent, so it
    is preferred over a descent speed; with two devices the descent speed is the main's, and the duration determines the
    drogue's. Raises ImpossibleFlight for a flight without a dry mass.
    """
    duration, recovery = _timed(flight), flight.columns.recovery
    drogue_speed = recovery.drogue_speed if flight.columns.sd.get(TWO_DEVICES[0].name) else None
    if drogue_speed is not None or duration is None or flight.apogee is None or flight.dry_mass is None:
        return flight.descent_speed, drogue_speed
    path = _path(flight, found, recovery)
    left, air = duration - path.rise - path.free, air_at_pads([flight])
    if left <= 0:
        return flight.descent_speed, None
    devices = _devices(flight, found, recovery)
    if not recovery.dual or recovery.main_altitude is None:
        return _one_device(path, air, left), None
    return _two_devices(flight, devices, path, air, left)


def _timed(flight: Flight) -> float | None:
    """The duration of a flight: by the timers of a contest if it has them, else its own. [s]"""
    try:
        return judged_duration(flight)
    except BadValue:  # a timer that is not a number, which scoring the flight reports
        return flight.duration


def _one_device(path: "_Path", air: Air, left: float) -> float:
    """Speed under a device that descends a path in the remaining time of a flight [s]. [m/s]"""
    fall_height = float(air.sinking_path(np.array([path.opened]))[0])
    speed = fall_height / left
    for _ in range(ROUNDS):  # the device first has to slow to its own speed
        speed = fall_height / max(left - _lag(speed, path.speed), 0.5 * left)
    return speed


def _two_devices(
    flight: Flight, devices: Devices, path: "_Path", air: Air, left: float
) -> tuple[float | None, float | None]:
    """Speeds under main and drogue of a flight on which both opened, from its remaining time [s]. [m/s]"""
    main, drogue = flight.descent_speed, float(devices.first[0])
    shown: tuple[float | None, float | None] = main, None
    for _ in range(ROUNDS):  # the rocket falls farther under the drogue while the main opens
        late = float(opening_time(devices, devices.main, np.array(drogue))[0])
        open_main = min(max(devices.main_altitude - drogue * late, 0.0), path.opened)
        high, low = (float(fall_height) for fall_height in air.sinking_path(np.array([path.opened, open_main])))
        rest = left - _lag(drogue, path.speed)
        if not main:
            under = rest - (high - low) / drogue
            shown = (low / under if under > 0 else None), None
            continue
        under = rest - _lag(main, drogue) - low / main
        if under <= 0 or high <= low:
            return main, None
        drogue = (high - low) / under
        shown = main, drogue
    return shown


def _lag(device: float, before: float) -> float:
    """`lag` of a device that changes from another speed to its own; none without speeds, its limit. [s]"""
    return float(lag(np.array(device), np.array(before), np.array(device))) if device + before > 0 else 0.0


def _devices(flight: Flight, found: Found, recovery: Recovery) -> Devices:
    """The devices of a flight, with recorded or default speeds."""
    main = np.array([flight.descent_speed or recovery.main_speed or DESCENT_SPEED])
    first = np.array([recovery.drogue_speed or DROGUE_SPEED]) if recovery.dual else main
    fills = filling(np.array(landing_mass(flight, found)), air_at_pads([flight]).density)
    return Devices(first, main, recovery.main_altitude or 0.0, recovery.opening_time, fills)


@dataclass(frozen=True, slots=True)
class _Path:
    """A recorded flight: time from lift-off to apogee [s], free fall until a device is open [s], height [m] and fall
    speed [m/s] at which it is open."""

    rise: float
    free: float
    opened: float
    speed: float


def _path(flight: Flight, found: Found, recovery: Recovery) -> _Path:
    """The path of a flight until a device was open, from its readouts or else from simulating it to its apogee.

    The charge fires at its recorded time, else after the delay, else at its recorded height, else at apogee.
    """
    conditions = [recorded([flight], name) for name in ("site_elevation", "temperature", "pressure")]
    gain = float(altimeter_gain(*conditions)[0])
    height = (flight.apogee or 0.0) / gain
    area = np.pi / 4 * (flight.diameter or found.motor.diameter) ** 2
    plan = flight.with_changes(wind=None)
    flown = fly(field_setup([plan], [found], (CD_GRID * area)[:, None]))
    reached, order = flown.apogee[:, 0], np.argsort(flown.apogee[:, 0])

    def at(values: Array) -> float:
        return float(np.interp(height, reached[order], np.asarray(values)[order]))

    rise = at(flown.rise_time[:, 0])
    if flight.burn_time is not None and flight.coast_to_apogee is not None:
        rise = flight.burn_time + flight.coast_to_apogee
    mass, density = landing_mass(flight, found), float(air_at_pads([flight]).density[0])
    terminal = np.sqrt(2 * mass * STANDARD_GRAVITY / (density * at(CD_GRID) * area))
    charge = at(flown.rise_time[:, 0] - flown.coast_time[:, 0])  # time of burnout after lift-off
    delay = flight.delay if flight.delay is not None else found.delay
    if flight.apogee_to_eject is not None:
        wait = flight.apogee_to_eject
    elif recovery.dual:
        wait = 0.0
    elif delay is not None and np.isfinite(delay):
        wait = charge + delay - rise
    elif flight.eject_altitude is not None and flight.eject_altitude / gain < height:
        wait = float(fall_time(np.array(height - flight.eject_altitude / gain), np.array(terminal)))
    else:
        wait = 0.0
    free = FreeFall(np.array([height]), np.array([wait]), np.array([terminal]))
    descent = sink(free, _devices(flight, found, recovery), air_at_pads([flight]))
    opened, speed = (float(np.nan_to_num(one[0])) for one in (descent.open_height, descent.open_speed))
    return _Path(rise, float(descent.free_time[0]), opened, speed)
