"""Burnout from heights alone: the time at which a jump of the acceleration makes them most likely.

An accelerometer that was saturated, or has another scale, still shows when thrust and weight were equal.

Derivation: the marginal likelihood of the smoother in `fieldkit.analysis.smooth`, for each lag that the heights may
have.
"""

from dataclasses import dataclass, replace

import numpy as np

from fieldkit.analysis.ballistic import Coast
from fieldkit.analysis.channels import MIN_SAMPLES, Push
from fieldkit.analysis.height_lag import Lag
from fieldkit.analysis.initial_guess import Guess, first_guess, levelled
from fieldkit.analysis.phases import Outline
from fieldkit.analysis.process_noise import FittedCurve
from fieldkit.analysis.records import Event
from fieldkit.analysis.robust_statistics import median_step
from fieldkit.analysis.samples import Marks, Samples
from fieldkit.analysis.smooth import apply, unlagged
from fieldkit.physics.standard_atmosphere import GRAVITY

_LEAST_PRIOR = 1e-12
"""Smallest prior probability of a lag. [1]"""
_BURNOUTS = 21
"""Number of burnout times to try for each lag. [1]"""
_ENDS_FOR, _LASTS_FOR, _LATEST_END = 0.3, 0.1, 0.7
"""Shortest time without thrust that is a coast, and with thrust that is a boost [s]; latest end of a boost, as a
fraction of the climb [1]."""
_REACH = 0.4
"""Smallest difference of burnout from the fastest climb of the heights that is tried, if their samples are no farther
apart. [s]"""
_MOST_SDS = 3.0
"""Largest error of ports that explains heights, in its prior standard deviations, and largest distance of the highest
speed of a curve from its burnout, in those of the burnout. [1]"""
_PEAK_DELAY = 2.5
"""Delay of the fastest climb of lagged heights, in lags: ln((a + d) / d) for a thrust a ten times the drag d. [1]"""


@dataclass(frozen=True, slots=True, eq=False)
class FitStart:
    """Input of a fit: the samples that count, the coast that they suggest, and an initial guess.

    `fused` if the guess comes from an accelerometer.
    """

    samples: Samples
    coast: Coast | None
    guess: Guess
    fused: bool


@dataclass(frozen=True, slots=True)
class Burnout:
    """Burnout for one lag [s]: the marks with it, its standard deviation [s], and the log evidence of the lag; the top
    speed and its standard deviation [m/s], which does not include that of lift-off [s], and the error of the ports in
    its own prior standard deviations [1]."""

    marks: Marks
    sd: float
    lag: float
    evidence: float
    speed: float = 0.0
    speed_sd: float = 0.0
    ports: float = np.inf
    lift_sd: float = 0.0

    def is_of(self, fastest: float, resolution: float, climbs: float) -> bool:
        """Whether a curve that is fastest at a time, averages over a `resolution` [s] and then climbs this far [m],
        shows this burnout: it is near, ports explain the heights (if only an error that none has does, something else
        disturbs them), and the speed suffices for the climb, v² >= 2 g h, up to its standard deviation."""
        near = abs(fastest - self.marks.burnout) < _MOST_SDS * self.sd + resolution
        suffices = (self.speed + self.speed_sd) ** 2 >= 2 * GRAVITY * max(climbs, 0.0)
        return near and suffices and abs(self.ports) < _MOST_SDS


def felt_burnout(push: Push, lift: float, seen: Outline) -> Event | None:
    """When an accelerometer stopped feeling thrust greater than the weight, by its clock alone; None if it does not
    show that.

    Of several boosts it is the one that ends closest to the fastest climb. `lift` is the time of lift-off [s].
    """
    net = levelled(push, lift)
    near = (push.time > lift) & (push.time < lift + _LATEST_END * (seen.top - lift))
    if net is None or near.sum() < MIN_SAMPLES:
        return None
    time, net = push.time[near], net[near]
    step = median_step(time)
    edges = np.flatnonzero(np.diff((net > 0).astype(np.int8)))
    bounds = np.concatenate(([time[0]], (time[edges] + time[edges + 1]) / 2, [time[-1]]))
    begins, ends = bounds[:-1], bounds[1:]
    pushed = np.concatenate(([net[0] > 0], net[edges + 1] > 0))
    long = (ends - begins > np.where(pushed, _LASTS_FOR, _ENDS_FOR)) | (begins == time[0])
    begins, pushed = begins[long], pushed[long]
    over = begins[1:][pushed[:-1] & ~pushed[1:]]
    if not over.size:
        return None
    moment = float(over[np.argmin(np.abs(over - seen.fastest))])
    return Event(moment, float(np.hypot(step / 2, 0.02)), push.source)


def likeliest_burnout(start: FitStart, found: FittedCurve, marks: Marks, lag: Lag, static: float) -> Burnout:
    """Burnout time that maximizes the likelihood of the heights for one lag.

    Acceleration jumps at burnout. `static` is the standard deviation of the airframe's pressure error, as a fraction of
    the dynamic pressure. [1]

    The coast shows the middle between lift-off and burnout, so where shocks, ports or few samples hide the corner at
    burnout, an error of lift-off is also one of burnout.

    The speed is the mean over burnout times and the ports' error, given the heights. If ports lower heights by s v²/2g,
    the coast after a boost is faster by s v a/g and later by s v/2g, and burnout, twice as far from lift-off as that
    middle, later by s v/g. The coast loses a there, so both errors of the speed nearly cancel.
    """
    lift = lag.lift.time if lag.lift is not None else marks.lift
    marks = replace(marks, lift=lift, released=marks.released - lag.lag)
    begin = lift if lift is not None else start.samples.grid.start
    reach = max(_REACH, 0.25 * (marks.burnout - begin), _spacing(start.samples, marks.burnout))
    first = max(begin + 0.1, marks.burnout - reach - _PEAK_DELAY * lag.lag)
    every = np.linspace(first, max(min(marks.burnout + reach, marks.released - 0.1), first + 0.1), _BURNOUTS)
    tried = [_tried(start, found, replace(marks, burnout=burnout), lag.lag, static) for burnout in every.tolist()]
    evidence, speeds, moved, ports = np.array(tried).T
    if not np.isfinite(evidence.max()):
        return Burnout(marks, 0.0, lag.lag, -np.inf)
    probability = np.exp(evidence - evidence.max())
    likelihood = float(evidence.max() + np.log(probability.sum() * (every[1] - every[0])))
    total = lag.counts * likelihood + float(np.log(max(lag.prior, _LEAST_PRIOR)))
    probability /= probability.sum()
    mean, speed = float(probability @ every), float(probability @ speeds)
    sd = float(np.sqrt(probability @ (every - mean) ** 2))
    speed_sd = float(np.sqrt(probability @ ((speeds - speed) ** 2 + moved**2)))
    if lag.lift is not None:
        sd = float(np.hypot(sd, lag.lift.sd))
    lift_sd = lag.lift.sd if lag.lift is not None else 0.0
    off = float(probability @ ports)
    return Burnout(replace(marks, burnout=mean), sd, lag.lag, total, speed, speed_sd, off, lift_sd)


def _tried(
    start: FitStart, found: FittedCurve, marks: Marks, lag: float, static: float
) -> tuple[float, float, float, float]:
    """Log evidence of a burnout [1], the highest speed until then, and how far one standard deviation of the ports'
    error moves it [m/s], and that error in its prior standard deviations [1]; an evidence of -inf if no curve fits."""
    guess, samples = guess_for(start, marks, lag), start.samples
    try:
        curve = found.with_ports(samples, guess, marks, lag, static)
    except np.linalg.LinAlgError:
        return -np.inf, 0.0, 0.0, 0.0
    before = samples.grid.time[(samples.grid.time > marks.burnout - _REACH) & (samples.grid.time < marks.burnout)]
    moments = np.append(before, marks.burnout)
    slope = unlagged(samples.grid, moments, 1, lag)
    speeds = np.interp(moments, samples.grid.time, guess.speed) + apply(slope, curve.mean)
    fastest = int(np.argmax(speeds))
    return found.prior + curve.evidence, float(speeds[fastest]), float(apply(slope, curve.moved)[fastest]), curve.shared


def _spacing(samples: Samples, moment: float) -> float:
    """Time between heights around a moment, to which they show when the climb was fastest. [s]"""
    time = samples.time[samples.is_own]
    after = int(np.clip(np.searchsorted(time, moment), 1, time.size - 1))
    return float(time[after] - time[after - 1])


def guess_for(start: FitStart, marks: Marks, lag: float) -> Guess:
    """Initial guess from the coast, without the lag by which the samples are late. [s]"""
    coast = None if start.coast is None else replace(start.coast, time=start.coast.time - lag)
    return first_guess(start.samples.grid, coast, None, marks.lift, marks.burnout, marks.released)[0]
