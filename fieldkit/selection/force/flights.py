"""The missing force of each flight whose log shows it, and the reason for the others."""

from dataclasses import dataclass

import numpy as np

from fieldkit.analysis import Forces, Recorded
from fieldkit.flight import Flight
from fieldkit.motors.motor import Motor
from fieldkit.physics.atmosphere import pad_air
from fieldkit.physics.setups import RAIL_LENGTH, recorded
from fieldkit.selection.force.climb import ClimbTrack, Missing, RocketInputs, track_of
from fieldkit.selection.force.one_flight import MIN_SPEED, Law, law, missing_force
from fieldkit.selection.force.regression import Regression, regression
from fieldkit.selection.force.terms import library
from fieldkit.shapes import Flags

FELT_GUARD, SMOOTHED_GUARD = 0.1, 0.5
"""Time left out on either side of burnout, with an accelerometer and with smoothed heights. [s]"""
FREE_TERMS = ("drag",)
"""Terms that are free in every flight: the level of drag is a parameter of the plain model, and missing effects bias
its fit."""
FEWEST_SAMPLES = 30
"""Number of samples in a climb below which its missing force is not computed. [1]"""
BOOST_POINTS, COAST_POINTS = 4, 8
"""Number of points that summarize each phase of a climb. [1]"""
TOO_SHORT = "too few samples between lift-off and apogee to separate thrust from drag"


@dataclass(frozen=True, slots=True)
class Point:
    """The mean missing force per mass over a stretch of a climb, and its standard deviation. SI."""

    burning: bool
    time_from_liftoff: float
    speed: float
    force: float
    sd: float


@dataclass(frozen=True, slots=True, eq=False)
class FlightForce:
    """The missing force in one flight's log, its explanation by that flight alone, and a few points of it.

    `source` are the channels from which the push was computed.
    """

    flight_id: str
    source: str
    missing: Missing
    regression: Regression
    law: Law
    points: tuple[Point, ...]


def rocket_of(flight: Flight, motor: Motor, drag_area: float) -> RocketInputs:
    """The model of a flight: certified motor, weighed mass, the air of the day; area [m^2]."""
    conditions = ("site_elevation", "temperature", "pressure", "humidity")
    air = pad_air(*(np.asarray(recorded([flight], name)[0]) for name in conditions))
    assert flight.dry_mass is not None
    rail = RAIL_LENGTH if flight.rail_length is None else flight.rail_length
    return RocketInputs(motor, flight.dry_mass, drag_area, air, rail)


def flight_force(flight_id: str, recording: Recorded, rocket: RocketInputs) -> FlightForce | str:
    """The missing force of one flight, or the reason its log does not show it."""
    if recording.forces is None:
        return "; ".join(recording.notes) or TOO_SHORT
    track = _climb_track(recording.forces)
    if (track.speed > MIN_SPEED).sum() < FEWEST_SAMPLES:
        return TOO_SHORT
    missing = missing_force(track, rocket, FELT_GUARD)
    if len(missing.force) < FEWEST_SAMPLES:
        return TOO_SHORT
    found = law(missing, FREE_TERMS)
    return FlightForce(
        flight_id,
        recording.forces.source,
        missing,
        regression(missing, library(), FREE_TERMS),
        found,
        _points(missing, found.worth),
    )


def _climb_track(forces: Forces) -> ClimbTrack:
    """The informative part of a climb: all of it with an accelerometer, only the coast with smoothed heights."""
    track = track_of(forces)
    if forces.window is not None:
        return track
    burnout = float(track.time_from_liftoff[track.burning].max(initial=-np.inf))
    return track.part(~track.burning & (track.time_from_liftoff > burnout + SMOOTHED_GUARD))


def _points(missing: Missing, worth: float) -> tuple[Point, ...]:
    """A climb summarized by means over equal numbers of samples in each phase."""
    track, weight = missing.track, worth / len(missing.force)

    def phase(which: Flags, most: int) -> list[Point]:
        rows = np.flatnonzero(which)
        parts = np.array_split(rows, min(most, len(rows) // 3)) if len(rows) >= 3 else []
        return [
            Point(
                bool(missing.burning[part[0]]),
                float(track.time_from_liftoff[part].mean()),
                float(track.speed[part].mean()),
                float(missing.force[part].mean()),
                float(missing.force[part].std() / np.sqrt(max(len(part) * weight, 1.0))),
            )
            for part in parts
        ]

    return (*phase(missing.burning, BOOST_POINTS), *phase(~missing.burning, COAST_POINTS))
