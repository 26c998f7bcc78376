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
"""Left out on either side of burnout: with an accelerometer, and if heights were smoothed. [s]"""
FREE_TERMS = ("drag",)
"""Terms that every flight has for itself: how much drag there is on the whole is the plain model's own unknown, which
readouts that lack something have pulled from its place."""
FEWEST_SAMPLES = 30
"""Duration of a climb below which its missing force is not computed. [s]"""
BOOST_POINTS, COAST_POINTS = 4, 8
"""Points that summarize a climb in either phase. [1]"""
TOO_SHORT = "too few samples between lift-off and apogee to separate thrust from drag"


@dataclass(frozen=True, slots=True)
class Point:
    """The missing force over a stretch of a climb: its mean and the standard deviation of that, per mass. SI."""

    burning: bool
    time_from_liftoff: float
    speed: float
    force: float
    sd: float


@dataclass(frozen=True, slots=True, eq=False)
class FlightForce:
    """What one flight's log says: the missing force, what that flight alone makes of it, and a few points of it.

    `source` are the channels that the push was made from.
    """

    flight_id: str
    source: str
    missing: Missing
    regression: Regression
    law: Law
    points: tuple[Point, ...]


def rocket_of(flight: Flight, motor: Motor, drag_area: float) -> RocketInputs:
    """A flight in the model: certified motor, weighed mass, the air of the day; area in m^2."""
    conditions = ("site_elevation", "temperature", "pressure", "humidity")
    air = pad_air(*(np.asarray(recorded([flight], name)[0]) for name in conditions))
    assert flight.dry_mass is not None
    rail = RAIL_LENGTH if flight.rail_length is None else flight.rail_length
    return RocketInputs(motor, flight.dry_mass, drag_area, air, rail)


def flight_force(flight_id: str, said: Recorded, rocket: RocketInputs) -> FlightForce | str:
    """The missing force of one flight, or the reason why its log does not show it."""
    if said.forces is None:
        return "; ".join(said.notes) or TOO_SHORT
    track = _told(said.forces)
    if (track.speed > MIN_SPEED).sum() < FEWEST_SAMPLES:
        return TOO_SHORT
    missing = missing_force(track, rocket, FELT_GUARD)
    if len(missing.force) < FEWEST_SAMPLES:
        return TOO_SHORT
    found = law(missing, FREE_TERMS)
    return FlightForce(
        flight_id,
        said.forces.source,
        missing,
        regression(missing, library(), FREE_TERMS),
        found,
        _points(missing, found.worth),
    )


def _told(forces: Forces) -> ClimbTrack:
    """The informative part of a climb: all of it if an accelerometer recorded it, only the coast by smooth heights."""
    track = track_of(forces)
    if forces.window is not None:
        return track
    burnout = float(track.time_from_liftoff[track.burning].max(initial=-np.inf))
    return track.part(~track.burning & (track.time_from_liftoff > burnout + SMOOTHED_GUARD))


def _points(missing: Missing, worth: float) -> tuple[Point, ...]:
    """A climb summarized by means over equal numbers of samples in either phase."""
    track, share = missing.track, worth / len(missing.force)

    def phase(which: Flags, most: int) -> list[Point]:
        rows = np.flatnonzero(which)
        parts = np.array_split(rows, min(most, len(rows) // 3)) if len(rows) >= 3 else []
        return [
            Point(
                bool(missing.burning[part[0]]),
                float(track.time_from_liftoff[part].mean()),
                float(track.speed[part].mean()),
                float(missing.force[part].mean()),
                float(missing.force[part].std() / np.sqrt(max(len(part) * share, 1.0))),
            )
            for part in parts
        ]

    return (*phase(missing.burning, BOOST_POINTS), *phase(~missing.burning, COAST_POINTS))
