"""A curve through noisy heights whose acceleration is a random walk: its posterior, its derivatives, and draws of it.

The height is a cubic spline on evenly spaced knots. Between knots its acceleration takes a random step of variance
`process_noise` × interval, which is the third-order smoothing spline in its state-space form (Wahba 1978; Kohn and
Ansley 1987); `process_noise` may change from phase to phase. Observations are heights with normal errors; Student's t
errors are handled by weights that are updated after each fit (Lange, Little and Taylor 1989). All matrices are banded,
so the cost of a fit is proportional to the number of knots.

A filter or small vents may make the samples late by a first-order lag T. They then show a height m, and the rocket has
the height h = m + T dm/dt. The spline is m, and the random walk is the acceleration of h: over an interval it gains
what the acceleration of m gains, plus T times the change of the third derivative of m.
"""

from dataclasses import dataclass

import numpy as np

from fieldkit.shapes import Array, Float, Int, Integers

_DEGREE = 3
_THIRD, _FOURTH = (-1, 3, -3, 1), (1, -4, 6, -4, 1)
"""Coefficients of the third derivative of a spline, and of its change from one interval to the next."""


@dataclass(frozen=True, slots=True, eq=False)
class Grid:
    """Evenly spaced knots over a time span. [s]"""

    start: float
    step: float
    count: int

    @property
    def time(self) -> Float[Array, "knot"]:
        """The knots. [s]"""
        return np.asarray(self.start + self.step * np.arange(self.count + 1), float)

    @property
    def middles(self) -> Float[Array, "interval"]:
        """Centers of the intervals between knots. [s]"""
        return np.asarray(self.start + self.step * (np.arange(self.count) + 0.5), float)


@dataclass(frozen=True, slots=True, eq=False)
class SplineRows:
    """The four basis splines that are nonzero at each of some times, and the index of the first."""

    first: Int[Integers, "time"]
    value: Float[Array, "time four"]


def basis(grid: Grid, time: Float[Array, "time"], order: int = 0) -> SplineRows:
    """The basis splines, or a derivative of them, at times [s] within the grid (times outside are moved to its
    ends)."""
    place = np.clip((time - grid.start) / grid.step, 0, grid.count * (1 - 1e-12))
    first = np.floor(place).astype(np.int64)
    u = place - first
    table = {
        0: [(1 - u) ** 3 / 6, (3 * u**3 - 6 * u**2 + 4) / 6, (-3 * u**3 + 3 * u**2 + 3 * u + 1) / 6, u**3 / 6],
        1: [-((1 - u) ** 2) / 2, (3 * u**2 - 4 * u) / 2, (-3 * u**2 + 2 * u + 1) / 2, u**2 / 2],
        2: [1 - u, 3 * u - 2, 1 - 3 * u, u],
        3: [np.full(u.size, float(one)) for one in _THIRD],
    }[order]
    return SplineRows(first, np.stack(table, axis=-1) / grid.step**order)


def unlagged(grid: Grid, time: Float[Array, "time"], order: int, lag: float) -> SplineRows:
    """The splines of what samples with a first-order lag [s] show: the curve, or a derivative, before the lag."""
    rows = basis(grid, time, order)
    return SplineRows(rows.first, rows.value + lag * basis(grid, time, order + 1).value) if lag else rows


def apply(rows: SplineRows, coefficients: Float[Array, "*draw knot"]) -> Float[Array, "*draw time"]:
    """The curve for one or many sets of coefficients at the times of `rows`, in their unit."""
    return np.asarray(sum(rows.value[:, k] * coefficients[..., rows.first + k] for k in range(_DEGREE + 1)))


@dataclass(frozen=True, slots=True, eq=False)
class CurvePosterior:
    """The posterior of a curve: mean coefficients, Cholesky factor of their precision, and the log evidence.

    If heights have an error in common, `shared` is the mean of its factor [1], and `moved` is how far the coefficients
    move with one standard deviation of it [m].
    """

    grid: Grid
    mean: Float[Array, "knot"]
    factor: Float[Array, "band knot"]
    evidence: float
    shared: float
    moved: Float[Array, "knot"]

    def draws(self, count: int, random: np.random.Generator) -> Float[Array, "draw knot"]:
        """Coefficients drawn from the posterior, in the unit of the curve."""
        from scipy.linalg.lapack import dtbtrs  # takes 0.18 s to import

        noise = random.standard_normal((self.mean.size, count))
        away, _ = dtbtrs(self.factor, noise, uplo="L", trans="T")
        together = random.standard_normal((count, 1)) * self.moved if self.moved.any() else 0.0
        return np.asarray(self.mean + away.T + together)


@dataclass(frozen=True, slots=True, eq=False)
class WeightedSums:
    """Sums of weights times fixed factors, each at its own index: a sparse matrix built once for all fits.

    The factors have shape (term, weight); the result has `size` entries.
    """

    places: Int[Integers, "term weight"]
    factors: Float[Array, "term weight"]
    size: int

    def of(self, weights: Float[Array, "weight"]) -> Float[Array, "place"]:
        """The sums for some weights. [1]"""
        return np.asarray(np.bincount(self.places.ravel(), (self.factors * weights).ravel(), self.size), float)


@dataclass(frozen=True, slots=True, eq=False)
class SplineDesign:
    """The splines of the samples, and the sums that turn weights into normal equations.

    `sums` adds up the samples' contribution to each coefficient, and `products` their contribution to each pair of
    neighbors in band form.
    """

    grid: Grid
    rows: SplineRows
    sums: WeightedSums
    products: WeightedSums


def design(grid: Grid, time: Float[Array, "time"], order: Int[Integers, "time"] | None = None) -> SplineDesign:
    """Prepare fits on a grid from the sample times [s] and the `order` of each sample: 0 for a height, 1 for a speed.

    `order` None means that all are heights.
    """
    rows = basis(grid, time)
    if order is not None and order.any():
        rows = SplineRows(rows.first, np.where(order[:, None] == 1, basis(grid, time, 1).value, rows.value))
    size = grid.count + _DEGREE
    pairs = [(j, k) for j in range(_DEGREE + 1) for k in range(j + 1)]
    values = rows.value.T
    return SplineDesign(
        grid,
        rows,
        WeightedSums(rows.first + np.arange(_DEGREE + 1)[:, None], values, size),
        WeightedSums(
            np.stack([(j - k) * size + rows.first + k for j, k in pairs]),
            np.stack([values[j] * values[k] for j, k in pairs]),
            (_DEGREE + 2) * size,
        ),
    )


def _windows() -> Float[Array, "part band first"]:
    """Products of the coefficients of an interval's window, by diagonal: for the powers 0, 1 and 2 of the lag."""
    still, change = np.array((0, *_THIRD), float), np.array(_FOURTH, float)
    mixed = np.outer(still, change)
    every = (np.outer(still, still), mixed + mixed.T, np.outer(change, change))
    return np.array([[np.pad(np.diag(one, offset), (0, offset)) for offset in range(still.size)] for one in every])


_WINDOWS = _windows()


def _walk(weight: Float[Array, "interval"], lag: Float[Array, "interval"]) -> Float[Array, "band knot"]:
    """Precision of the coefficients, in band form, if the acceleration is a random walk; `lag` in intervals.

    A window of five coefficients begins one before each interval. In the first one, which lacks that, no lag counts.
    """
    lag = np.concatenate(([0.0], lag[1:]))
    powers = np.arange(len(_WINDOWS) if lag.any() else 1)
    terms = np.tensordot(_WINDOWS[powers], weight * lag ** powers[:, None], (0, 0))
    band = np.zeros((len(terms), weight.size + len(terms) - 1))
    for first in range(len(terms)):
        band[:, first : first + weight.size] += terms[:, first]
    return band[:, 1:]


@dataclass(frozen=True, slots=True, eq=False)
class _Misfit:
    """Deviations of a curve from samples and from the process, and their weights."""

    samples: SplineDesign
    precision: Float[Array, "time"]
    weight: Float[Array, "interval"]
    lag: Float[Array, "interval"]

    def deviations(
        self, height: Float[Array, "time"], curve: Float[Array, "knot"]
    ) -> tuple[Float[Array, "time"], Float[Array, "interval"]]:
        """Of heights from a curve [m], and steps of its acceleration, as third differences [m]."""
        steps = np.diff(curve, 3)
        steps[1:] += self.lag[1:] * np.diff(steps)
        return height - apply(self.samples.rows, curve), steps

    def product(
        self,
        one: tuple[Float[Array, "time"], Float[Array, "interval"]],
        other: tuple[Float[Array, "time"], Float[Array, "interval"]],
    ) -> float:
        """Weighted product of two such deviations; differences of large sums would be inaccurate. [1]"""
        return float(self.precision @ (one[0] * other[0]) + self.weight @ (one[1] * other[1]))


def fit(
    samples: SplineDesign,
    height: Float[Array, "time"],
    precision: Float[Array, "time"],
    process_noise: Float[Array, "interval"],
    lag: Float[Array, "interval"] | None = None,
    error: Float[Array, "time"] | None = None,
) -> CurvePosterior:
    """The posterior of the curve. Raises LinAlgError if the samples are too noisy for one to exist.

    `precision` is one over the variance of each height [1/m^2], zero for a sample that does not count; `process_noise`
    is the variance that acceleration gains per second in each interval [m^2/s^5]; `lag` is the time constant by which
    the acceleration that is a random walk is ahead of that of the curve [s]; `error` is an error that heights have in
    common, times an unknown standard normal factor [m].
    """
    from scipy.linalg.lapack import dpbtrf, dpbtrs  # takes 0.18 s to import

    weight = 1 / (process_noise * samples.grid.step**5)
    intervals = np.zeros(weight.size) if lag is None else lag / samples.grid.step
    band = samples.products.of(precision).reshape(_DEGREE + 2, -1) + _walk(weight, intervals)
    band[0] += 1e-9  # for parts of the curve without samples
    factor, wrong = dpbtrf(band, lower=1)
    if wrong or not np.isfinite(factor[0]).all():
        raise np.linalg.LinAlgError("no curve can be fitted to these samples")
    mean, _ = dpbtrs(factor, samples.sums.of(precision * height), lower=1)
    counted, misfit = precision > 0, _Misfit(samples, precision, weight, intervals)
    left = misfit.deviations(height, mean)
    evidence = 0.5 * (
        np.log(precision[counted]).sum()
        + np.log(weight).sum()
        + 2 * np.log1p(intervals[1:]).sum()
        - 2 * np.log(factor[0]).sum()
        - misfit.product(left, left)
    )
    if error is None:
        return CurvePosterior(samples.grid, mean, factor, float(evidence), 0.0, np.zeros(mean.size))
    follows, _ = dpbtrs(factor, samples.sums.of(precision * error), lower=1)
    shared = misfit.deviations(error, follows)  # the misfit is quadratic in the factor
    bend, slope = misfit.product(shared, shared), misfit.product(shared, left)
    evidence += 0.5 * (slope**2 / (1 + bend) - np.log1p(bend))
    value = slope / (1 + bend)
    return CurvePosterior(
        samples.grid, mean - value * follows, factor, float(evidence), value, follows / np.sqrt(1 + bend)
    )
