"""The top of a fitted ascent: when and how high, if the samples show it.

Derivation: the apogee is the maximum of the fitted curve; the difference of two independent heights has sqrt(2) times
the standard deviation of one.
"""

import numpy as np

from fieldkit.analysis.ascent import Ascent
from fieldkit.analysis.channels import CHANNEL_TITLES, Heights
from fieldkit.analysis.phases import Outline
from fieldkit.analysis.records import Event, Figure
from fieldkit.analysis.robust_statistics import lag_one, mad_sd
from fieldkit.shapes import Array, Flags, Float

_MIN_TIME_AFTER_TOP, _FALL = 0.8, 1.0
"""How long a curve must continue after its top [s] and how far it must clearly fall [m] before it counts as coming
down."""
_MAX_TAKEN = 0.8
"""The part of a variance that the mean of a short rest may have taken. [1]"""
_LEAST_GPS = 2.0
"""Error of a satellite apogee from the drift of one receiver's height within a minute. [m]"""
_MAX_HEARD_GAP = 2.0
"""Between samples that are further apart nothing is known of a top. [s]"""
_REST, _MAX_WANDER = 10.0, 20.0
"""The end of a log that is looked at for a rest [s], in which heights move by less [m]."""
_MIN_APOGEE_ERROR = 0.15
"""Of the error of any apogee: what the air and a sensor's drift do within a flight. [m]"""


def falls(ascent: Ascent) -> bool:
    """Whether the curve surely comes down at its end, though the samples that show it are few."""
    late = ascent.time[-1] - ascent.time[int(np.argmax(ascent.height))]
    return bool(
        late > _MIN_TIME_AFTER_TOP and np.quantile(ascent.heights.max(axis=1) - ascent.heights[:, -1], 0.05) > _FALL
    )


def apogee_of(ascent: Ascent, seen: Outline, track: Heights) -> tuple[Event, Figure] | None:
    """The top of the curve, or None if it is still rising when the log ends."""
    heard = _heard(ascent.time, track)
    place = int(np.argmax(np.where(heard, ascent.height, -np.inf)))
    if place >= ascent.time.size - 2 or place == 0:
        return None
    drawn = np.where(heard, ascent.heights, -np.inf)
    tops = drawn.max(axis=1)
    moments = ascent.time[np.argmax(drawn, axis=1)]
    near = np.abs(track.time - ascent.time[place]) < 1.0
    left = track.height[near] - seen.pad - np.interp(track.time[near], ascent.time, ascent.height)
    rough = mad_sd(left) / 2 if mad_sd(left) > 3 * track.noise else 0.0
    satellites = track.source == CHANNEL_TITLES["gps_altitude_msl"]
    least = max(_LEAST_GPS, drift_of_receiver(track, seen)) if satellites else _MIN_APOGEE_ERROR
    sd = float(np.sqrt(tops.std() ** 2 + seen.pad_sd**2 + rough**2 + least**2))
    spread = 1.4826 * np.median(np.abs(moments - ascent.time[place]))
    event = Event(
        float(ascent.time[place]),
        float(np.linalg.norm([spread, 0.04 if ascent.fused else 0.06, track.lag / 2])),
        track.source,
    )
    return event, Figure(float(ascent.height[place]), sd, track.source)


def _heard(time: Float[Array, "knot"], track: Heights) -> Flags:
    """Which knots of a curve lie among samples and not in a long silence, where a curve may swing as it likes."""
    after = np.clip(np.searchsorted(track.time, time), 1, track.time.size - 1)
    gap = track.time[after] - track.time[after - 1]
    heard = np.asarray(gap <= _MAX_HEARD_GAP)
    return heard if heard.any() else np.ones(time.size, bool)


def drift_of_receiver(track: Heights, seen: Outline) -> float:
    """By how much a receiver's height moves on the ground, before lift-off or after landing: the difference of two such
    heights, at the pad and at the top, is larger. [m]"""
    first, last = track.time[0], track.time[-1]
    rests = (
        track.height[(track.time < (seen.lift or first) - 0.5)],
        track.height[(track.time > max(seen.top + 5, last - _REST))],
    )
    still = [_spread(one) for one in rests if one.size >= 8 and np.ptp(one) < _MAX_WANDER]
    return float(np.sqrt(2)) * max(still, default=0.0)


def _spread(values: Float[Array, "_"]) -> float:
    """The standard deviation of what follows itself: a short rest has a mean of its own, which takes a part of it.

    With an autocorrelation p^k, of n values the mean has the variance (1 + 2 sum (1 - k/n) p^k) / n of theirs.
    """
    lag1, count = lag_one(values), values.size
    steps = np.arange(1, count)
    taken = (1 + 2 * float(((1 - steps / count) * lag1**steps).sum())) / count
    return float(values.std() / np.sqrt(1 - min(taken, _MAX_TAKEN)))
