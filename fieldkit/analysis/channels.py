"""Prepare the channels of a log for measuring: one height above sea level or pad, and one acceleration, cleaned.

Cleaning removes what no rocket can have done: missing samples, several samples at one time, and spikes that leave the
neighboring samples and return. Longer disturbances are left to the fit, which is robust.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np

from fieldkit.analysis.moved_zero import on_one_zero, without_start_up, zero_moved
from fieldkit.analysis.robust_statistics import mad_sd, median_step, running_median, running_median_over, stretches
from fieldkit.flight import Series
from fieldkit.physics.standard_atmosphere import GRAVITY, pressure_height
from fieldkit.shapes import Array, Flags, Float

HEIGHTS = ("altitude", "pressure", "altitude_msl", "gps_altitude_msl", "inertial_altitude")
"""Channels with heights, best first."""
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
"""Titles of channels that are derived from pressure."""
_SENSORS = {"inertial": "accel", "acceleration": "accel", "GPS": "gps", "barometric": "baro", "pressure": "baro"}
"""Words of `CHANNEL_TITLES` and the sensor that each means. If several match, the first one here shaped the
measurement."""
MIN_SAMPLES = 12
"""Fewest samples that are measured. [1]"""
_MANY_SAMPLES, _FINE_RATE, _COARSE_RATE = 20_000, 200.0, 20.0
_CLIMB_SPEED = 8.0
"""Speed above which the movement in a log is that of a rocket. [m/s]"""
_MAX_ACCELERATION = 10_000.0
"""Accelerations beyond this are errors in the log. [m/s^2]"""
_CLIPPED_RUN, _CLIPPED_RATIO = 4, 3
"""Number of equal samples that indicate saturation, and their smallest ratio to the count of any other value. [1]"""
_MIN_FILLED, _FAR_FROM_FILL = 0.4, 20.0
"""Smallest fraction of zeros in a zero-padded channel [1], and the smallest magnitude of real samples. [m, Pa]"""
_REPEAT_TIME, _BOOST_ACCELERATION, _FIX_NOISE = 2.0, 600.0, 20.0
"""Shortest time for which a lost receiver repeats its last height [s], the acceleration of the hardest boosts
[m/s^2], and how far two heights of a receiver in the open differ [m]."""
_HELD_TIME, _HELD_SAMPLES, _HELD_JUMP = 0.25, 3, 5.0
"""Shortest time [s] and number of samples for which a barometer that failed repeats a height, and the least jump after
it, beyond what a coarse resolution or shocks show [m]."""
_STOPPED_CLIMB, _STOPPED_TIME = 10.0, 1.0
"""Climb rate [m/s] after which heights that do not change for this long [s], to the end of a log, are of a sensor that
failed: at such a rate a rocket climbs 5 m more in that time."""
_REST_PART, _MANY_RUNS = 0.1, 10
"""Largest height of a rest above the lowest heights, as a fraction of the highest, and how many times longer than any
run of one value before it a run is that is not from a coarse resolution. [1]"""
_REST_TIME, _MOST_TERRAIN = 5.0, 100.0
"""Time at the end of a log that shows where it rests [s], and the largest height of a landing above or below the pad
[m]."""
_WINDOW, _MIN_SIZE, _MAX_SIZE = 0.5, 5, 61
"""Length of the running median that reveals spikes [s], and its limits in samples. [1]"""


TYPICAL_LAG = 0.05
"""Scale of the half-Cauchy prior of a lag: half of all loggers are below it, one in six has more than 0.2 s. [s]"""


def lag_density(lags: Float[Array, "lag"]) -> Float[Array, "lag"]:
    """Prior density of the lags of barometers, up to a constant. [1/s]

    Derivation: the Cauchy distribution, of which a lag has the positive half.
    """
    return np.asarray(1 / (1 + (lags / TYPICAL_LAG) ** 2))


@dataclass(frozen=True, slots=True, eq=False)
class Heights:
    """Clean heights on one clock. `zeroed` if the logger itself subtracted the pad's height, and does not end at rest
    far from zero.

    `noise` is the standard deviation of a sample on the pad or in quiet flight [m]. `disturbed` if samples near the
    speed of sound were removed because shocks faked a fall. `lag` is the delay from a filter or small vents, which has
    been removed, and `lag_sd` the error of the delay [s]. `bend` is the time constant of a filter that they may be
    behind, whether they are corrected for it or not: it bends the end of a descent [s]. `shift` is by how much their
    times were moved for it [s]. `held` is the resolution if it hides the noise of the sensor: no number of samples
    averages what each held value is off; 0 otherwise [m].
    """

    time: Float[Array, "time"]
    height: Float[Array, "time"]
    zeroed: bool
    noise: float
    source: str
    disturbed: bool = False
    lag: float = 0.0
    lag_sd: float = 0.0
    bend: float = 0.0
    shift: float = 0.0
    held: float = 0.0

    @property
    def held_sd(self) -> float:
        """Error of a height that is anywhere within the resolution, as those of a top that stays in it are. [m]"""
        return self.held / float(np.sqrt(12))

    @property
    def top_held(self) -> float:
        """Error of the time of a top, anywhere in the free fall through the height held there. [s]"""
        return float(np.sqrt(2 * self.held / GRAVITY / 12))

    @property
    def is_barometric(self) -> bool:
        """Whether these heights are derived from pressure, which is biased in a fast airframe."""
        return self.source in BAROMETRIC


@dataclass(frozen=True, slots=True, eq=False)
class Push:
    """Acceleration along the axis on one clock, as an accelerometer feels it: one g at rest, nose up. [m/s^2]

    `vertical` if it is already the vertical acceleration with gravity added, for example from an inertial speed.
    `weighs` if the channel itself includes gravity, so that its scale is visible on the pad. `full` marks the samples
    at the end of the range, to which `missed` has been added on average based on the heights; None if the range was
    never exceeded, up to its `range_end` [m/s^2]. The resulting speed error is `missed_speed_sd`, of which
    `missed_drag_sd` is that of drag beyond the other end of the range [m/s]. `scale` is the ratio of the climb from
    heights to the climb from the accelerometer, and `scale_sd` its standard deviation; it differs from 1 because of
    calibration, tilt, or a pressure error [1].
    `blur` is the delay of a filtered channel, and so about the time over which it spreads a change of thrust [s].
    """

    time: Float[Array, "time"]
    felt: Float[Array, "time"]
    vertical: bool
    source: str
    weighs: bool = False
    full: Flags | None = None
    missed: float = 0.0
    range_end: float = np.inf
    missed_speed_sd: float = 0.0
    missed_drag_sd: float = 0.0
    scale: float = 1.0
    scale_sd: float = 0.0
    blur: float = 0.0


def heights(clocks: Sequence[Series]) -> Heights | None:
    """The best height channel of a log, or None if none has enough samples."""
    return next(all_heights(clocks), None)


def all_heights(clocks: Sequence[Series]) -> Iterator[Heights]:
    """The height channels of a log with enough samples, best first."""
    for name in HEIGHTS:
        for series in clocks:
            values = getattr(series, name)
            if values is None or np.isfinite(values).sum() < MIN_SAMPLES:
                continue
            if name == "altitude" and zero_moved(series):
                continue
            values = _as_read(_without_fill(values))
            values = _centered(values) if name == "pressure" else values
            values = on_one_zero(series.time, values) if name in ("altitude", "altitude_msl") else values
            time, values = _usable(series.time, _without_held(series.time, values, name))
            time, values = _thinned(time, values, name == "pressure")
            height = pressure_height(values) if name == "pressure" else values
            height = without_start_up(time, height, _resolution(height))
            found = _despiked(time, height, name)
            if found is not None:
                yield found


def pushes(clocks: Sequence[Series], begin: float, end: float) -> Iterator[Push]:
    """The accelerations along the axis from one time to another [s], best first."""
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
            plausible = np.abs(values) < _MAX_ACCELERATION
            time, values = time[plausible], values[plausible]
            if time.size < MIN_SAMPLES:
                continue
            weighs = name == "felt"
            felt = values if weighs else values + GRAVITY
            yield Push(time, felt, name == "inertial_speed", CHANNEL_TITLES[name], weighs)


def sensor(source: str) -> str:
    """The sensor behind a figure, one of `fieldkit.flight.SOURCES`, given the channels it was computed from."""
    return next((name for word, name in _SENSORS.items() if word in source), "stated")


def is_clipped(push: Push, begin: float, end: float) -> bool:
    """Whether an accelerometer was saturated between two times [s]: its highest value repeats many times and no other
    value does.

    A saturated converter returns one number, continuously or, if the thrust fluctuates around the limit,
    intermittently. A thrust that happens to be constant still has the sensor's noise. Low values, as at rest, repeat in
    any log.
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
    """Which samples of an accelerometer are saturated between two times [s]; None if none are."""
    inside = (push.time >= begin) & (push.time <= end)
    if not is_clipped(push, begin, end):
        return None
    return np.asarray((push.felt >= push.felt[inside].max()) & (push.time > begin - 1) & (push.time < end + 0.5))


def _without_fill(values: Float[Array, "_"]) -> Float[Array, "_"]:
    """Remove zeros that a logger wrote as padding, as it does between samples of a slow sensor.

    Isolated values among zeros, far from zero, are samples. A channel that flickers around zero on a pad stays near it.
    """
    zero = values == 0
    if not _MIN_FILLED < zero.mean() < 1:
        return values
    alone = ~zero[1:-1] & zero[:-2] & zero[2:] & np.isfinite(values[1:-1])
    far = np.abs(values[1:-1]) > _FAR_FROM_FILL
    if alone.sum() < MIN_SAMPLES or (alone & far).sum() < 0.9 * (~zero[1:-1] & far).sum():
        return values
    return np.where(zero, np.nan, values) if (alone & far).sum() >= MIN_SAMPLES else values


def _centered(pressure: Float[Array, "row"]) -> Float[Array, "row"]:
    """Pressures of few digits, with powers of ten in the middle of what was rounded to them. [Pa]

    Derivation: of numbers with three digits, 1.01E5 follows 1.00E5 ten times as far as 9.99E4 precedes it, so that the
    latter stands for 99,950 to 100,500.
    """
    known = np.isfinite(pressure) & (pressure > 0)
    decade = 10.0 ** np.floor(np.log10(np.where(known, pressure, 1.0)) + 1e-9)
    for digits in _FEW_DIGITS:
        step = decade * 10.0 ** (1 - digits)
        if not (np.abs(pressure / step - np.round(pressure / step))[known] < 1e-6).all():
            continue
        at = known & np.isclose(pressure, decade)
        finer = known & (decade < decade[at].max(initial=0.0)) & (np.abs(pressure % step[at].max(initial=1.0)) > 0)
        return np.where(at, pressure + (step - step / 10) / 4, pressure) if finer.any() else pressure
    return pressure


_FEW_DIGITS = (2, 3, 4)
"""Numbers of digits that a column too narrow for its numbers shows. [1]"""


def _as_read(values: Float[Array, "row"]) -> Float[Array, "row"]:
    """A channel in the rows in which its sensor was read: a table repeats a reading if it is written several times as
    often. Such values change in every k-th row or not at all; those of a coarse sensor change in any row.
    """
    known = np.flatnonzero(np.isfinite(values))
    changes = known[1:][np.diff(values[known]) != 0]
    if changes.size < MIN_SAMPLES:
        return values
    gaps = np.diff(changes)
    every = int(np.quantile(gaps, _IRREGULAR_PART, method="lower"))
    phases = np.bincount(changes % every, minlength=every) if every > 1 else np.zeros(1)
    if phases.max() < (1 - _IRREGULAR_PART) * changes.size:
        return values
    rows = np.arange(values.size)
    return np.where((rows - int(phases.argmax())) % every == 0, values, np.nan)


_IRREGULAR_PART = 0.05
"""Fraction of the changes of a channel that may be between its regular ones: of rows lost or written late. [1]"""


def _without_held(time: Float[Array, "_"], values: Float[Array, "_"], name: str) -> Float[Array, "_"]:
    """Remove the repetitions of a value that a receiver without satellites, a sensor that failed, or a radio holds.

    They end in a jump that no rocket at rest makes from one sample to the next, and after a rise or a fall that would
    have reached there, or last to the end of the log at a height where no rocket rests. The values do not show when the
    repetitions of a receiver began, whose last fix may be old.
    """
    known = np.flatnonzero(np.isfinite(values))
    when, height = time[known], values[known]
    changes = np.flatnonzero(np.diff(height) != 0)
    if not changes.size:
        return values
    height = pressure_height(height) if name == "pressure" else height
    begins = np.concatenate(([0], changes[:-1] + 1))
    lasts, step = when[changes] - when[begins], np.maximum(when[changes + 1] - when[changes], 1e-3)
    shortest, noise = (_REPEAT_TIME, _FIX_NOISE) if name == "gps_altitude_msl" else (_HELD_TIME, _HELD_JUMP)
    enough = changes - begins >= _HELD_SAMPLES
    coarse = np.maximum(_resolution(height), resolution_at(height[changes], height))
    jumps = np.abs(height[changes + 1] - height[changes]) > _BOOST_ACCELERATION * step**2 / 2 + noise + 3 * coarse
    kept = values.copy()
    for begin, end in zip(*(places[(lasts > shortest) & enough & jumps] for places in (begins, changes)), strict=True):
        kept[known[begin + 1 : end + 1]] = np.nan
    if _fails(when, height, int(changes[-1]) + 1, int((changes - begins).max()) + 1):
        kept[known[changes[-1] + 2 :]] = np.nan
    return kept


def _fails(time: Float[Array, "_"], height: Float[Array, "_"], last: int, longest: int) -> bool:
    """Whether heights keep their last value, at a place, because the sensor failed: after a climb so fast that it would
    have gone on against gravity, or high above the ground, for much longer than the `longest` run of one value before.
    """
    before = int(np.searchsorted(time, time[last] - _HELD_TIME))
    count = time.size - last
    if last - before < _HELD_SAMPLES or count < _HELD_SAMPLES or time[-1] - time[last] < _STOPPED_TIME:
        return False
    climbs = height[last] - height[before] > _STOPPED_CLIMB * (time[last] - time[before])
    ground, top = np.quantile(height[:last], (0.01, 1.0))
    is_high = height[last] - ground > _REST_PART * (top - ground)
    return bool(climbs or (is_high and count > _MANY_RUNS * longest))


def _usable(time: Float[Array, "_"], values: Float[Array, "_"]) -> tuple[Array, Array]:
    """Times and values without missing samples; samples at the same time are averaged."""
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
    """Reduce a channel with more samples than needed, by block medians: `_FINE_RATE` per second around the climb.

    The climb is located with `_MANY_SAMPLES` blocks of the whole; outside of it `_COARSE_RATE` per second are enough.
    """
    if time.size <= 2 * _MANY_SAMPLES:
        return time, values
    coarse_time, coarse_values = _blocks(time, values, time.size // _MANY_SAMPLES + 1)
    height = pressure_height(coarse_values) if pressure else coarse_values
    usual = running_median(height, 5)
    calm = np.abs(height - usual) <= 5 * max(mad_sd(height - usual), 0.5) + 50
    moving = np.abs(np.gradient(usual[calm], coarse_time[calm])) > _CLIMB_SPEED
    if moving.any():
        lift, top = coarse_time[calm][moving][0], coarse_time[calm][int(np.argmax(usual[calm]))]
    else:
        lift, top = coarse_time[0], coarse_time[-1]
    first, last = np.searchsorted(time, (min(lift, top) - 30, top + 30))
    step = median_step(time[first:last]) if last - first > 2 else median_step(time)
    fine, coarse = max(1, int(1 / (_FINE_RATE * step))), max(1, int(1 / (_COARSE_RATE * step)))
    parts = [(slice(0, first), coarse), (slice(first, last), fine), (slice(last, None), coarse)]
    thinned = [_blocks(time[part], values[part], size) for part, size in parts]
    return np.concatenate([one[0] for one in thinned]), np.concatenate([one[1] for one in thinned])


def _blocks(time: Float[Array, "_"], values: Float[Array, "_"], size: int) -> tuple[Array, Array]:
    """Medians of blocks of samples, and the middle of their times. An incomplete last block is dropped."""
    count = time.size // size
    if size == 1 or count == 0:
        return time, values
    whole = slice(0, count * size)
    return time[whole].reshape(count, size).mean(axis=1), np.median(values[whole].reshape(count, size), axis=1)


def _despiked(time: Float[Array, "_"], height: Float[Array, "_"], name: str) -> Heights | None:
    """Heights without samples that leave the line of their neighbors and return to it (Hampel identifier).

    A sample may differ from the running median by five robust standard deviations of the samples around it plus the
    sagitta of a climb that decelerates at two g.
    """
    kept = np.isfinite(height) & (np.abs(height) < 200_000)
    time, height = time[kept], height[kept]
    if time.size < MIN_SAMPLES:
        return None
    away = np.abs(height - running_median_over(time, height, _WINDOW, _MIN_SIZE, _MAX_SIZE))
    usual = 1.4826 * running_median_over(time, away, 4 * _WINDOW, 8 * _MIN_SIZE, 4 * _MAX_SIZE)
    sensor, resolution = mad_sd(np.diff(height, 3)) / np.sqrt(20), _resolution(height)
    noise = max(sensor, resolution / np.sqrt(12), 0.02)
    line = away <= 5 * np.maximum(usual, noise) + _sagitta(time)
    if line.sum() < MIN_SAMPLES:
        return None
    zeroed, held = name in ("altitude", "inertial_altitude"), resolution if sensor < resolution / np.sqrt(12) else 0.0
    found = Heights(time[line], height[line], zeroed, noise, CHANNEL_TITLES[name], held=held)
    rest = rest_level(found)
    return replace(found, zeroed=found.zeroed and not (rest is not None and abs(rest) > _MOST_TERRAIN))


def rest_level(track: Heights) -> float | None:
    """The height at which a log ends at rest [m]; None if it does not.

    Derivation: both halves of the last seconds have one median."""
    last = track.height[track.time > track.time[-1] - _REST_TIME]
    early, late = np.array_split(last, 2)
    if last.size < 6 or abs(np.median(early) - np.median(late)) > 4 * track.noise + 0.5:
        return None
    return float(np.median(last))


def _sagitta(time: Float[Array, "_"]) -> Float[Array, "_"]:
    """By how much a climb that decelerates at two g leaves the line between the ends of the window. [m]"""
    found = np.empty(time.size)
    for part, step in stretches(time):
        found[part] = GRAVITY * (np.clip(_WINDOW, _MIN_SIZE * step, _MAX_SIZE * step) / 2) ** 2
    return found


def resolution_at(levels: Float[Array, "_"], height: Float[Array, "_"]) -> Float[Array, "_"]:
    """Resolution of recorded heights at some of them: the distance to the nearest other height of the log. [m]

    Derivation: neighbors on a coarse scale are one step apart; with few digits it grows tenfold at a power of ten.
    """
    every = np.unique(height)
    gaps = np.diff(every, prepend=-np.inf, append=np.inf)
    return np.minimum(gaps[:-1], gaps[1:])[np.searchsorted(every, levels)]


def _resolution(height: Float[Array, "_"]) -> float:
    """Resolution of the recorded heights: the median of the nonzero differences. [m]"""
    steps = np.abs(np.diff(height[: 1 << 16]))
    steps = steps[steps > 1e-6]
    return float(np.quantile(steps, 0.1)) if steps.size else 0.0
