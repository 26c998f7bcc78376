"""The missing force of one climb as the sum of a few physical terms."""

from collections.abc import Collection
from dataclasses import dataclass, replace

import numpy as np

from fieldkit.selection.force.climb import ClimbTrack, Missing, RocketInputs, beside_model
from fieldkit.selection.force.regression import forward, price, regression
from fieldkit.selection.force.terms import ForceTerm, library

SHIFTS = tuple(sorted(np.linspace(-0.15, 0.15, 13).tolist(), key=abs))
"""Clock shifts to try, the smallest first. [s]"""
MIN_SPEED = 5.0
"""A climb ends below this speed, because its direction is then unknown. [m/s]"""


@dataclass(frozen=True, slots=True)
class FoundTerm:
    """A selected term with its coefficient, in its unit; `gain` is its reduction of the criterion.

    `also` are terms that would do nearly as well in its place.
    """

    term: ForceTerm
    value: float
    sd: float
    gain: float
    also: tuple[str, ...]


@dataclass(frozen=True, slots=True)
class Law:
    """The terms of the missing force, the most informative first; empty if nothing is missing.

    `explained` is the explained fraction of its variance [1], `left` the standard deviation of the rest [m/s^2], and
    `worth` the effective number of independent samples in the record.
    """

    terms: tuple[FoundTerm, ...]
    explained: float
    left: float
    worth: float

    @property
    def effects(self) -> tuple[str, ...]:
        """Names of the effects it indicates."""
        return tuple(found.term.effect for found in self.terms if found.term.effect)


def missing_force(track: ClimbTrack, rocket: RocketInputs, guard: float = 0.0) -> Missing:
    """Measured minus modeled push at every sample of the climb, with the clock aligned to the thrust curve.

    Samples within `guard` [s] of burnout are left out: if acceleration was computed from heights, smoothing has mixed
    thrust and drag there.
    """
    time = track.time_from_liftoff
    burnout = float(time[track.burning].max(initial=-np.inf))
    flown = (track.speed > MIN_SPEED) & (np.abs(time - burnout) >= guard)
    return beside_model(_on_time(track.part(flown), rocket), rocket)


def _on_time(track: ClimbTrack, rocket: RocketInputs) -> ClimbTrack:
    """A copy with its clock shifted to match the start and end of thrust, because lift-off is detected late or
    early."""
    if track.burning.sum() < 4:
        return track
    terms = library()

    def left(shift: float) -> float:
        moved = replace(track, time_from_liftoff=track.time_from_liftoff + shift)
        whole = regression(beside_model(moved, rocket), terms)
        rest = whole.left(list(whole.columns))
        return float(rest @ rest)

    return replace(track, time_from_liftoff=track.time_from_liftoff + min(SHIFTS, key=left))


def law(missing: Missing, free: Collection[str] = ()) -> Law:
    """The fewest terms that explain the missing force; `free` as in `regression`."""
    known = {term.name: term for term in library()}
    whole = regression(missing, list(known.values()), free)

    def gain(chosen: list[str], name: str) -> float:
        return whole.cost(chosen) - whole.cost([*chosen, name]) - price(len(chosen), len(whole.columns))

    chosen = forward(whole.columns, gain)
    names = [one.name for one in chosen]
    values, sds = whole.solve(names)
    left = whole.left(names)
    found = tuple(
        FoundTerm(known[one.name], float(value), float(sd), one.gain, one.also)
        for one, value, sd in zip(chosen, values, sds, strict=True)
    )
    explained = 1 - float(left @ left) / float(whole.wanted @ whole.wanted)
    return Law(found, explained, float(np.sqrt(np.mean((left * missing.track.push_sd) ** 2))), whole.worth)
