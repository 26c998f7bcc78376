"""The samples of a climb that count, prepared for fits on a grid, and the boundaries of the flight phases."""

from dataclasses import dataclass

import numpy as np

from fieldkit.analysis.channels import Push
from fieldkit.analysis.initial_guess import Guess, lagged
from fieldkit.analysis.records import Sightings
from fieldkit.analysis.robust_statistics import median_step
from fieldkit.analysis.smooth import Grid, SplineDesign, design
from fieldkit.physics.standard_atmosphere import GRAVITY
from fieldkit.shapes import Array, Flags, Float, Int, Integers


@dataclass(frozen=True, slots=True)
class Marks:
    """Boundaries of the flight phases [s].

    Lift-off, None if the log begins later; burnout; the earliest time a parachute may be out; and the time a charge was
    felt, infinite if none was.
    """

    lift: float | None
    burnout: float
    released: float
    charge: float


@dataclass(frozen=True, slots=True, eq=False)
class Samples:
    """Height samples above the pad that count [m], their times [s], their splines, and the noise of one [m].

    The first `own` samples are the heights of the log's main source. The rest are satellite data, heights and speeds by
    their `order`, with their `variance`, and the `static` error of the heights that they imply. The heights are delayed
    by `lag`, whose error is `lag_sd` [s]. `hidden` is the extra process noise of the acceleration if an accelerometer
    was saturated [m^2/s^5]. `is_barometric` if the main source is pressure, which is biased in a fast airframe.
    """

    time: Float[Array, "time"]
    height: Float[Array, "time"]
    splines: SplineDesign
    noise: float
    hidden: Float[Array, "interval"]
    own: int
    order: Int[Integers, "time"]
    variance: Float[Array, "time"]
    static: float = 0.0
    lag: float = 0.0
    lag_sd: float = 0.0
    is_barometric: bool = True

    @property
    def grid(self) -> Grid:
        """The knots of the splines."""
        return self.splines.grid

    def above(self, guess: Guess, lag: float = 0.0) -> Float[Array, "time"]:
        """The samples minus a guess that they show with a first-order lag [s]. [m], [m/s]"""
        first = guess.height[0] - lag * guess.speed[0] + lag**2 * guess.acceleration[0]
        shown = lagged(guess.height, float(first), self.grid.step, lag)
        height, speed = (np.interp(self.time, self.grid.time, one) for one in (shown, guess.speed))
        return np.asarray(self.height - np.where(self.order == 1, speed, height))

    @property
    def is_own(self) -> Flags:
        """Which samples are heights of the log's main source."""
        return np.arange(self.time.size) < self.own


def samples_on(
    grid: Grid,
    time: Float[Array, "time"],
    height: Float[Array, "time"],
    noise: float,
    push: Push | None = None,
    sighted: Sightings | None = None,
    lag: tuple[float, float] = (0.0, 0.0),
    *,
    is_barometric: bool = True,
) -> Samples:
    """Prepare heights above the pad for fits on a grid, with satellite data and an accelerometer that shapes the curve.

    Heights and their noise [m], times and the lag of the sensor with its standard deviation [s].
    """
    own = time.size
    order, variance, static = np.zeros(own, np.int64), np.zeros(own), 0.0
    if sighted is not None:
        near = (sighted.time > grid.time[0]) & (sighted.time < grid.time[-1])
        time, height = np.append(time, sighted.time[near]), np.append(height, sighted.value[near])
        order, variance = np.append(order, sighted.order[near]), np.append(variance, sighted.variance[near])
        static = sighted.static
    return Samples(
        time,
        height,
        design(grid, time, order),
        noise,
        _hidden(grid, push),
        own,
        order,
        variance,
        static,
        *lag,
        is_barometric,
    )


def _hidden(grid: Grid, push: Push | None) -> Float[Array, "interval"]:
    """Process noise of the acceleration around the values filled in during saturation: as large as their average, for
    as long as the saturation lasted. [m^2/s^5]"""
    if push is None or push.full is None or not push.full.any():
        return np.zeros(grid.count)
    reach = max(grid.step, median_step(push.time))
    near = np.interp(grid.middles, push.time, push.full) + sum(
        np.interp(grid.middles + away, push.time, push.full) for away in (-reach, reach)
    )
    lasts = float(push.full.sum()) * median_step(push.time)
    return np.where(near > 0, max(push.missed, GRAVITY) ** 2 / max(lasts, 2 * reach), 0.0)
