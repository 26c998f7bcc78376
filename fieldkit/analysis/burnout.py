"""Burnout from heights alone: the time at which a jump of the acceleration makes them most likely.

Derivation: the marginal likelihood of the smoother in `fieldkit.analysis.smooth`, for each lag that the heights may
have.
"""

from dataclasses import dataclass, replace

import numpy as np

from fieldkit.analysis.ballistic import Coast
from fieldkit.analysis.height_lag import Lag
from fieldkit.analysis.initial_guess import Guess, first_guess
from fieldkit.analysis.process_noise import FittedCurve
from fieldkit.analysis.samples import Marks, Samples

_BURNOUTS = 21
"""Number of burnout times to try for each lag. [1]"""
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
    """Burnout for one lag [s]: the marks with it, its standard deviation [s], and the log evidence of the lag."""

    marks: Marks
    sd: float
    lag: float
    evidence: float


def likeliest_burnout(start: FitStart, found: FittedCurve, marks: Marks, lag: Lag, static: float) -> Burnout:
    """Burnout time that maximizes the likelihood of the heights for one lag.

    Acceleration jumps at burnout. `static` is the standard deviation of the airframe's pressure error, as a fraction of
    the dynamic pressure. [1]
    """
    lift = lag.lift.time if lag.lift is not None else marks.lift
    marks = replace(marks, lift=lift, released=marks.released - lag.lag)
    begin = lift if lift is not None else start.samples.grid.start
    reach = max(0.4, 0.25 * (marks.burnout - begin))
    first = max(begin + 0.1, marks.burnout - reach - _PEAK_DELAY * lag.lag)
    every = np.linspace(first, max(min(marks.burnout + reach, marks.released - 0.1), first + 0.1), _BURNOUTS)
    evidence = np.empty(_BURNOUTS)
    for place, burnout in enumerate(every.tolist()):
        guess = guess_for(start, replace(marks, burnout=burnout), lag.lag)
        evidence[place] = found.evidence(start.samples, guess, replace(marks, burnout=burnout), lag.lag, static)
    if not np.isfinite(evidence.max()):
        return Burnout(marks, 0.0, lag.lag, -np.inf)
    probability = np.exp(evidence - evidence.max())
    total = float(evidence.max() + np.log(probability.sum() * (every[1] - every[0]) * lag.prior))
    probability /= probability.sum()
    mean = float(probability @ every)
    return Burnout(replace(marks, burnout=mean), float(np.sqrt(probability @ (every - mean) ** 2)), lag.lag, total)


def guess_for(start: FitStart, marks: Marks, lag: float) -> Guess:
    """Initial guess from the coast, without the lag by which the samples are late. [s]"""
    coast = None if start.coast is None else replace(start.coast, time=start.coast.time - lag)
    return first_guess(start.samples.grid, coast, None, marks.lift, marks.burnout, marks.released)[0]
