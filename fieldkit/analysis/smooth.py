"""A curve through noisy heights whose acceleration is a random walk: its posterior, its derivatives, and draws of it.

The height is a cubic spline on evenly spaced knots. Between knots its acceleration takes a random step of variance
`process_noise` × interval, which is the third-order smoothing spline in its state-space form (Wahba 1978; Kohn and
Ansley 1987); `process_noise` may change from phase to phase. Observations are heights with normal errors; Student's t
errors are handled by weights that are updated after each fit (Lange, Little and Taylor 1989). All matrices are banded,
so the cost of a fit is proportional to the number of knots.
"""

from dataclasses import dataclass

import numpy as np

from fieldkit.shapes import Array, Float, Int, Integers

_DEGREE = 3
_THIRD = (-1, 3, -3, 1)
"""Coefficients of the third derivative of a spline."""


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
    """The basis splines, or a derivative of them, at times within the grid (times outside are moved to its ends)."""
    place = np.clip((time - grid.start) / grid.step, 0, grid.count * (1 - 1e-12))
    first = np.floor(place).astype(np.int64)
    u = place - first
    table = {
        0: [(1 - u) ** 3 / 6, (3 * u**3 - 6 * u**2 + 4) / 6, (-3 * u**3 + 3 * u**2 + 3 * u + 1) / 6, u**3 / 6],
        1: [-((1 - u) ** 2) / 2, (3 * u**2 - 4 * u) / 2, (-3 * u**2 + 2 * u + 1) / 2, u**2 / 2],
        2: [1 - u, 3 * u - 2, 1 - 3 * u, u],
    }[order]
    return SplineRows(first, np.stack(table, axis=-1) / grid.step**order)


def apply(rows: SplineRows, coefficients: Float[Array, "*draw knot"]) -> Float[Array, "*draw time"]:
    """The curve for one or many sets of coefficients at the times of `rows`, in their unit."""
    return np.asarray(sum(rows.value[:, k] * coefficients[..., rows.first + k] for k in range(_DEGREE + 1)))


@dataclass(frozen=True, slots=True, eq=False)
class CurvePosterior:
    """The posterior of a curve: mean coefficients, Cholesky factor of their precision, and the log evidence."""

    grid: Grid
    mean: Float[Array, "knot"]
    factor: Float[Array, "band knot"]
    evidence: float

    def draws(self, count: int, random: np.random.Generator) -> Float[Array, "draw knot"]:
        """Coefficients drawn from the posterior, in the unit of the curve."""
        from scipy.linalg.lapack import dtbtrs

        noise = random.standard_normal((self.mean.size, count))
        away, _ = dtbtrs(self.factor, noise, uplo="L", trans="T")
        return np.asarray(self.mean + away.T)


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

    `sums` adds up the samples' contribution to each coefficient, `products` their contribution to each pair of
    neighbors in band form, and `jumps` the intervals' contribution to the third derivative.
    """

    grid: Grid
    rows: SplineRows
    sums: WeightedSums
    products: WeightedSums
    jumps: WeightedSums


def design(grid: Grid, time: Float[Array, "time"], order: Int[Integers, "time"] | None = None) -> SplineDesign:
    """Prepare fits on a grid from the sample times and the `order` of each sample: 0 for a height, 1 for a speed.

    `order` None means that all are heights.
    """
    rows = basis(grid, time)
    if order is not None and order.any():
        rows = SplineRows(rows.first, np.where(order[:, None] == 1, basis(grid, time, 1).value, rows.value))
    size, interval = grid.count + _DEGREE, np.arange(grid.count)
    pairs = [(j, k) for j in range(_DEGREE + 1) for k in range(j + 1)]
    band = (_DEGREE + 1) * size
    values = rows.value.T
    bend = np.array([[float(_THIRD[j] * _THIRD[k])] for j, k in pairs])
    return SplineDesign(
        grid,
        rows,
        WeightedSums(rows.first + np.arange(_DEGREE + 1)[:, None], values, size),
        WeightedSums(
            np.stack([(j - k) * size + rows.first + k for j, k in pairs]),
            np.stack([values[j] * values[k] for j, k in pairs]),
            band,
        ),
        WeightedSums(np.stack([(j - k) * size + interval + k for j, k in pairs]), bend, band),
    )


def fit(
    samples: SplineDesign,
    height: Float[Array, "time"],
    precision: Float[Array, "time"],
    process_noise: Float[Array, "interval"],
) -> CurvePosterior:
    """The posterior of the curve. Raises LinAlgError if the samples are too noisy for one to exist.

    `precision` is one over the variance of each height [1/m^2], zero for a sample that does not count; `process_noise`
    is the variance that acceleration gains per second in each interval [m^2/s^5].
    """
    from scipy.linalg.lapack import dpbtrf, dpbtrs

    weight = 1 / (process_noise * samples.grid.step**5)
    band = (samples.products.of(precision) + samples.jumps.of(weight)).reshape(_DEGREE + 1, -1)
    band[0] += 1e-9  # for parts of the curve without samples
    right = samples.sums.of(precision * height)
    factor, wrong = dpbtrf(band, lower=1)
    if wrong or not np.isfinite(factor[0]).all():
        raise np.linalg.LinAlgError("no curve can be fitted to these samples")
    mean, _ = dpbtrs(factor, right, lower=1)
    counted = precision > 0
    evidence = 0.5 * (
        np.log(precision[counted]).sum()
        + np.log(weight).sum()
        - 2 * np.log(factor[0]).sum()
        - (precision * height**2).sum()
        + mean @ right
    )
    return CurvePosterior(samples.grid, mean, factor, float(evidence))
