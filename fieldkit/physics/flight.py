"""Simulate a batch in one call: arrays in, arrays out, the same code for one flight and for a million.

Derivation: burn, coast and descent in turn, whose modules name the sources of their equations.
"""

from collections.abc import Iterator
from itertools import chain, pairwise

import numpy as np

from fieldkit.physics.burn import AscentState, burn
from fieldkit.physics.coast import LEAST_DRAG, Apogee, coast, parachute
from fieldkit.physics.descent import FreeFall, Sinking, sink
from fieldkit.physics.forces import planar
from fieldkit.physics.state import FlightResult, Setup
from fieldkit.shapes import Array, Flags, Float, Integers

CHUNK = 16384
"""Number of draws simulated together: few enough for their state to fit in the processor's cache."""
ONE_GROUP_DRAWS = 500
"""Up to this number of draws, the forces of effects are computed for all: a separate group takes more time. [1]"""


def fly(setup: Setup) -> FlightResult:
    """Simulate every draw of a setup, from the pad to the ground.

    A draw whose motor never lifts it is all zeros, with `lift_off` 0.
    """
    values = {name: np.empty(int(np.prod(setup.draw_shape))) for name in FlightResult.__dataclass_fields__}
    for rows, part in _chunks(setup):
        flown = _flown(part, *_ascend(part))
        for name, column in values.items():
            column[rows] = getattr(flown, name)
    return FlightResult(**{name: column.reshape(setup.draw_shape) for name, column in values.items()})


def apogees(setup: Setup) -> Float[Array, "*draw"]:
    """True apogee height of every draw above the pad; faster than `fly`. [m]"""
    result = np.empty(int(np.prod(setup.draw_shape)))
    for rows, part in _chunks(setup):
        track, top, _ = _ascend(part, highlights=False)
        result[rows] = np.where(np.isfinite(track.time), top.height, 0.0)
    return result.reshape(setup.draw_shape)


def _chunks(setup: Setup) -> Iterator[tuple[Integers, Setup]]:
    """Rows that are simulated together, and their part of the setup.

    Vertical flights are separated from others, many flights with an effect's force from those without, and rows with
    the same motor are grouped. Grouping affects only the speed of the computation, not the results.
    """
    flat = setup.flat(setup.draw_shape)
    if flat.forces:
        flat = flat.with_changes(closed_coast=False)
    forced = _forced(flat) if flat.draws > ONE_GROUP_DRAWS else np.zeros(1, bool)
    group = planar(flat) + 2 * forced
    motors, rank = len(flat.burns.lengths), flat.burns.lengths.argsort().argsort()
    kind = np.broadcast_to(group * motors + rank[flat.motor], flat.draws).astype(np.min_scalar_type(4 * motors))
    order = np.argsort(kind, kind="stable")
    edges = np.searchsorted(kind[order], motors * np.arange(5)).tolist()
    cuts = [*chain.from_iterable(range(first, last, CHUNK) for first, last in pairwise(edges)), flat.draws]
    with np.errstate(invalid="ignore", divide="ignore", over="ignore"):
        for first, last in pairwise(cuts):
            part = flat.part(order[first:last])
            acting = tuple((force, strength) for force, strength in part.forces if strength.any())
            yield order[first:last], part.with_changes(forces=acting)


def _forced(flat: Setup) -> Flags:
    """The draws on which a force of an effect acts; one flag if all are the same."""
    acts = np.zeros(1, bool)
    for _, strength in flat.forces:
        acts = acts | (strength != 0)
    return acts


def _ascend(setup: Setup, *, highlights: bool = True) -> tuple[AscentState, Apogee, Array]:
    """The burn, the coast, and the time of the ejection charge after ignition. [s]"""
    track = burn(setup, highlights=highlights)
    fires = setup.burns.burnout[setup.motor] * setup.burn_stretch + setup.delay
    return track, coast(setup.after_burnout(), track, fires, timed=highlights), fires


def _upward(velocity: Array) -> Array:
    """Upward part of a velocity relative to its size [1]; 1 at rest."""
    size = np.sqrt((velocity**2).sum(axis=0))
    return np.asarray(np.divide(velocity[0], size, out=np.ones_like(size), where=size > 0))


def _flown(setup: Setup, track: AscentState, top: Apogee, fires: Array) -> FlightResult:
    lifted = np.isfinite(track.time)
    start = np.where(lifted, track.time - track.flying, 0.0)
    early, never = np.isfinite(top.eject_height), np.isnan(fires)
    fell = _fallen(setup.after_burnout(), top, fires - top.time)
    eject_height = np.where(early, top.eject_height, np.where(never, np.nan, fell.eject_height))
    burn_time = track.top_speed_time - start
    values = {
        "apogee": top.height,
        "apogee_shown": top.height * setup.altimeter_gain,
        "top_speed": track.top_speed,
        "top_climb": track.top_speed * _upward(track.velocity),
        "burn_time": burn_time,
        "peak_accel": track.peak_accel,
        "avg_accel": track.top_speed / np.where(burn_time > 0, burn_time, np.inf),
        "coast_to_apogee": top.time - track.top_speed_time,
        "apogee_to_eject": np.where(np.isfinite(eject_height), fires - top.time, np.nan),
        "eject_altitude": eject_height,
        "eject_altitude_shown": eject_height * setup.altimeter_gain,
        "eject_speed": np.where(early, top.eject_speed, np.where(never, np.nan, fell.eject_speed)),
        "descent_speed": setup.descent_speed,
        "duration": top.time + fell.time - start,
        "rail_speed": track.rail_speed,
        "drift": top.drift,
        "across": top.across,
        "drift_speed": top.sideways,
        "across_speed": top.sideways_across,
        "rise_time": top.time - start,
        "cut_short": top.cut_short,
        "coast_time": top.time - setup.burns.burnout[setup.motor] * setup.burn_stretch,
    }
    grounded = {name: np.where(lifted, value, 0.0) for name, value in values.items()}
    return FlightResult(lift_off=lifted.astype(float), **grounded)


def _fallen(setup: Setup, top: Apogee, wait: Float[Array, "draw"]) -> Sinking:
    """The descent; the charge fires `wait` after apogee [s]; without a charge the parachute opens at apogee."""
    mass = setup.dry_mass + setup.burns.casing_mass[setup.motor]
    drag = np.maximum(0.5 * setup.drag_area * setup.air.density / mass, LEAST_DRAG)
    terminal = np.sqrt(setup.gravity / drag)
    wait = np.where(np.isnan(wait), -np.inf, wait)
    free = FreeFall(top.height, wait, terminal, (top.sideways, top.sideways_across))
    return sink(free, parachute(setup), setup.air, setup.gravity)
