"""Channels of a log made fit for measuring: one height above sea level or pad, and one acceleration, cleaned.

What is cleaned away here is what no rocket can have done: samples that are missing, stand at one time twice, or jump
out of their neighbours' line and back. Shocks that last longer are left to the fit, which is robust.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from fieldkit.analysis.robust_statistics import mad_sd, median_step, running_median
from fieldkit.flight import Series
from fieldkit.physics.standard_atmosphere import GRAVITY, pressure_height
from fieldkit.shapes import Array, Flags, Float

HEIGHTS = ("altitude", "pressure", "altitude_msl", "gps_altitude_msl", "inertial_altitude")
"""Channels that hold heights, the best first."""
CHANNEL_TITLES = {
    "altitude": "barometric altitude",
    "pressure": "pressure",
    "altitude_msl": "barometric altitude",
    "gps_altitude_msl": "GPS altitude",
    "inertial_altitude": "inertial altitude",
    "felt": "acceleration",
    "acceleration": "acceleration",
    "inertial_speed": "inertial speed",
}
BAROMETRIC = ("barometric altitude", "pressure")
"""Titles of channels that are made of pressures."""
_SENSORS = {"inertial": "accel", "acceleration": "accel", "GPS": "gps", "barometric": "baro", "pressure": "baro"}
"""Words of `CHANNEL_TITLES` and the sensor that each means; of two sensors the first of these shaped what was
measured."""
MIN_SAMPLES = 12
"""Samples below which nothing is measured. [1]"""
_MANY_SAMPLES, _FINE_RATE, _COARSE_RATE = 20_000, 200.0, 20.0
_CLIMB_SPEED = 8.0
"""Speed at which something in a log moves as a rocket does. [m/s]"""
_MAX_ACCELERATION = 10_000.0
"""Accelerations beyond this are faults of the log. [m/s^2]"""
_CLIPPED_RUN, _CLIPPED_RATIO = 4, 3
"""Samples of one value that make an end of range, and how many times more than of any other value. [1]"""
_MIN_FILLED, _FAR_FROM_FILL = 0.4, 20.0
"""Fraction of samples that are zero in a channel padded with zeros [1], and the least size of the others. [m, Pa]"""
_WINDOW = 0.5
"""Length of the running median that shows up spikes. [s]"""


@dataclass(frozen=True, slots=True, eq=False)
class Heights:
    """Clean heights on one clock; `zeroed` if the logger itself took the pad's off.

    `noise` is the standard deviation of a sample on the pad or in quiet flight [m]. `disturbed` if samples near the
    speed of sound were left out, for shocks had faked a fall in them. `lag` is by how much they came late, behind a
    filter or small vents, which has been taken off. [s]
    """

    time: Float[Array, "time"]
    height: Float[Array, "time"]
    zeroed: bool
    noise: float
    source: str
    disturbed: bool = False
    lag: float = 0.0

    @property
    def pressed(self) -> bool:
        """Whether these heights are made of pressures, which are off in a fast airframe."""
        return self.source in BAROMETRIC


@dataclass(frozen=True, slots=True, eq=False)
class Push:
    """Acceleration along the axis on one clock, as an accelerometer feels it: one g at rest, nose up. [m/s^2]

    `vertical` if it is the vertical one already, gravity added, as from an inertial speed; `weighs` if the
    channel itself has gravity in it, so that its scale shows on the pad. `full` are the samples at the end of its
    range, to which `missed` has been added, by the heights; None if it never was there. That makes a speed off by
    `missed_speed_sd` [m/s]. `scale` is the ratio of the climb by the heights to the climb by the accelerometer: it
    differs from 1 because of calibration, tilt, or a pressure error. [1]
    """

    time: Float[Array, "time"]
    felt: Float[Array, "time"]
    vertical: bool
    source: str
    weighs: bool = False
    full: Flags | None = None
    missed: float = 0.0
    missed_speed_sd: float = 0.0
    scale: float = 1.0


def heights(clocks: Sequence[Series]) -> Heights | None:
    """The best height channel of a log, or None if none has enough samples."""
    for name in HEIGHTS:
        for series in clocks:
            values = getattr(series, name)
            if values is None or np.isfinite(values).sum() < MIN_SAMPLES:
                continue
            time, values = _thinned(*_usable(series.time, _without_fill(values)), name == "pressure")
            height = pressure_height(values) if name == "pressure" else values
            found = _despiked(time, height, name)
            if found is not None:
                return found
    return None


def pushes(clocks: Sequence[Series], begin: float, end: float) -> Push | None:
    """The best acceleration along the axis from one time to another, or None."""
    for name in ("felt", "acceleration", "inertial_speed"):
        for series in clocks:
            values = getattr(series, name)
            if values is None:
                continue
            near = slice(*np.searchsorted(series.time, (begin, end)))
            time, values = _usable(series.time[near], values[near])
            if time.size < MIN_SAMPLES or np.ptp(values) == 0:
                continue
            if name == "inertial_speed":
                values = np.gradient(values, time)
            believed = np.abs(values) < _MAX_ACCELERATION
            time, values = time[believed], values[believed]
            if time.size < MIN_SAMPLES:
                continue
            weighs = name == "felt"
            felt = values if weighs else values + GRAVITY
            return Push(time, felt, name == "inertial_speed", CHANNEL_TITLES[name], weighs)
    return None


def sensor(source: str) -> str:
    """The sensor that a figure rests on, one of `fieldkit.flight.SOURCES`, by the channels it was made from."""
    return next((name for word, name in _SENSORS.items() if word in source), "stated")


def is_clipped(push: Push, begin: float, end: float) -> bool:
    """Whether an accelerometer was saturated: its highest value is repeated many times, and no other is.

    A converter that is full gives one number, in a row or, if the thrust plays about the end, now and again; a
    thrust that only happens to be even has the sensor's noise. Low values, as of a rest, come again in any log.
    """
    felt = push.felt[(push.time >= begin) & (push.time <= end)]
    if felt.size < _CLIPPED_RUN:
        return False
    edges = np.flatnonzero(np.concatenate(([True], np.diff(felt) != 0, [True])))
    lengths, values = np.diff(edges), felt[edges[:-1]]
    full, high = values >= felt.max(), values > felt.max() / 2
    in_a_row = lengths[full].max() >= max(_CLIPPED_RUN, _CLIPPED_RATIO * int(lengths[high & ~full].max(initial=1)))
    _, counts = np.unique(felt[felt > felt.max() / 2], return_counts=True)
    in_all = counts.size and counts[-1] >= max(_CLIPPED_RUN, _CLIPPED_RATIO * int(counts[:-1].max(initial=1)))
    return bool(not push.vertical and (in_a_row or in_all))


def at_its_end(push: Push, begin: float, end: float) -> Flags | None:
    """Which samples of an accelerometer are saturated from one time to another; None if none are."""
    inside = (push.time >= begin) & (push.time <= end)
    if not is_clipped(push, begin, end):
        return None
    return np.asarray((push.felt >= push.felt[inside].max()) & (push.time > begin - 1) & (push.time < end + 0.5))


def _without_fill(values: Float[Array, "_"]) -> Float[Array, "_"]:
    """Samples of which those are missing for which a logger wrote zero, as it does between two of a slow sensor.

    Values that stand alone among zeros, far from these, are samples; what flickers about zero on a pad is near it.
    """
    zero = values == 0
    if not _MIN_FILLED < zero.mean() < 1:
        return values
    alone = ~zero[1:-1] & zero[:-2] & zero[2:] & np.isfinite(values[1:-1])
    far = np.abs(values[1:-1]) > _FAR_FROM_FILL
    if alone.sum() < MIN_SAMPLES or (alone & far).sum() < 0.9 * (~zero[1:-1] & far).sum():
        return values
    return np.where(zero, np.nan, values) if (alone & far).sum() >= MIN_SAMPLES else values


def _usable(time: Float[Array, "_"], values: Float[Array, "_"]) -> tuple[Array, Array]:
    """Times and values without missing samples; of several at one time, their mean."""
    kept = np.isfinite(values) & np.isfinite(time)
    if not kept.all():
        time, values = time[kept], values[kept]
    again = np.diff(time) <= 0
    if again.any():
        start = np.flatnonzero(np.concatenate(([True], ~again)))
        values = np.add.reduceat(values, start) / np.diff(np.append(start, values.size))
        time = time[start]
    return time, values


def _thinned(time: Float[Array, "_"], values: Float[Array, "_"], pressure: bool) -> tuple[Array, Array]:
    """A channel with too many samples to need them all, by medians of blocks: `_FINE_RATE` a second about the climb.

    Where the climb is shows in `_MANY_SAMPLES` blocks of the whole; away from it `_COARSE_RATE` a second are enough.
    """
    if time.size <= 2 * _MANY_SAMPLES:
        return time, values
    rough_time, rough = _blocks(time, values, time.size // _MANY_SAMPLES + 1)
    height = pressure_height(rough) if pressure else rough
    usual = running_median(height, 5)
    calm = np.abs(height - usual) <= 5 * max(mad_sd(height - usual), 0.5) + 50
    moving = np.abs(np.gradient(usual[calm], rough_time[calm])) > _CLIMB_SPEED
    if moving.any():
        lift, top = rough_time[calm][moving][0], rough_time[calm][int(np.argmax(usual[calm]))]
    else:
        lift, top = rough_time[0], rough_time[-1]
    first, last = np.searchsorted(time, (min(lift, top) - 30, top + 30))
    step = median_step(time[first:last]) if last - first > 2 else median_step(time)
    fine, coarse = max(1, int(1 / (_FINE_RATE * step))), max(1, int(1 / (_COARSE_RATE * step)))
    parts = [(slice(0, first), coarse), (slice(first, last), fine), (slice(last, None), coarse)]
    thin = [_blocks(time[part], values[part], size) for part, size in parts]
    return np.concatenate([one[0] for one in thin]), np.concatenate([one[1] for one in thin])


def _blocks(time: Float[Array, "_"], values: Float[Array, "_"], size: int) -> tuple[Array, Array]:
    """Medians over blocks of samples, and the middles of their times; a rest shorter than a block is left out."""
    count = time.size // size
    if size == 1 or count == 0:
        return time, values
    whole = slice(0, count * size)
    return time[whole].reshape(count, size).mean(axis=1), np.median(values[whole].reshape(count, size), axis=1)


def _despiked(time: Float[Array, "_"], height: Float[Array, "_"], name: str) -> Heights | None:
    """Heights without samples that leave their neighbours' line and come back to it (Hampel's identifier).

    What a sample may differ from the running median is five robust standard deviations of what the samples
    around it do, and the sagitta of a climb that brakes with two g.
    """
    kept = np.isfinite(height) & (np.abs(height) < 200_000)
    time, height = time[kept], height[kept]
    if time.size < MIN_SAMPLES:
        return None
    step = median_step(time)
    size = int(np.clip(_WINDOW / step, 5, 61)) | 1
    middle = running_median(height, size)
    away = np.abs(height - middle)
    usual = 1.4826 * running_median(away, int(np.clip(4 * size, 41, 241)) | 1)
    noise = max(mad_sd(np.diff(height, 3)) / np.sqrt(20), _resolution(height) / np.sqrt(12), 0.02)
    sagitta = GRAVITY * (size / 2 * step) ** 2
    line = away <= 5 * np.maximum(usual, noise) + sagitta
    if line.sum() < MIN_SAMPLES:
        return None
    return Heights(time[line], height[line], name in ("altitude", "inertial_altitude"), noise, CHANNEL_TITLES[name])


def _resolution(height: Float[Array, "_"]) -> float:
    """The step in which heights are written, as the median of those that differ at all. [m]"""
    steps = np.abs(np.diff(height[: 1 << 16]))
    steps = steps[steps > 1e-6]
    return float(np.quantile(steps, 0.1)) if steps.size else 0.0
