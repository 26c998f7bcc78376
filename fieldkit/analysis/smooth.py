"""A curve through noisy heights whose acceleration is a random walk: its posterior, its derivatives, and draws of it.

The height is a cubic spline on even knots. Between knots its acceleration takes a random step of variance
`process_noise` × interval, which is the third-order smoothing spline in its state-space form (Wahba 1978; Kohn and
Ansley 1987); `process_noise` may change from phase to phase. Observations are heights with normal errors; Student's t
errors are handled by weights that are updated after each fit (Lange, Little and Taylor 1989). All matrices are banded,
so a fit costs time in proportion to the number of knots.
"""

from dataclasses import dataclass

import numpy as np

from fieldkit.shapes import Array, Float, Int, Integers

_DEGREE = 3
_THIRD = (-1, 3, -3, 1)
"""The third derivative of a spline from its coefficients."""


@dataclass(frozen=True, slots=True, eq=False)
class Grid:
    """Even knots over a stretch of time. [s]"""

    start: float
    step: float
    count: int

    @property
    def time(self) -> Float[Array, "knot"]:
        """The knots. [s]"""
        return np.asarray(self.start + self.step * np.arange(self.count + 1), float)

    @property
    def middles(self) -> Float[Array, "interval"]:
        """The middles of the intervals between knots. [s]"""
        return np.asarray(self.start + self.step * (np.arange(self.count) + 0.5), float)


@dataclass(frozen=True, slots=True, eq=False)
class SplineRows:
    """Four basis splines that are not zero at each of some times, and the first one's number."""

    first: Int[Integers, "time"]
    value: Float[Array, "time four"]


def basis(grid: Grid, time: Float[Array, "time"], order: int = 0) -> SplineRows:
    """The basis splines, or a derivative of them, at times within the grid (those outside go to its ends)."""
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
    """The curve of one or many sets of coefficients at the times of `rows`, in their unit."""
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
    """Sums of weights times fixed factors, each into a place of its own: a sparse matrix, made once for every fit.

    Of the factors of shape (term, weight) each is added up at its place, of `size` in all.
    """

    places: Int[Integers, "term weight"]
    factors: Float[Array, "term weight"]
    size: int

    def of(self, weights: Float[Array, "weight"]) -> Float[Array, "place"]:
        """The sums for some weights. [1]"""
        return np.asarray(np.bincount(self.places.ravel(), (self.factors * weights).ravel(), self.size), float)


@dataclass(frozen=True, slots=True, eq=False)
class SplineDesign:
    """The samples' splines, and the sums that make normal equations of weights.

    `sums` adds up what samples say of each coefficient, `products` what they say of each pair of neighbors in band
    form, `jumps` what intervals say of the third derivative.
    """

    grid: Grid
    rows: SplineRows
    sums: WeightedSums
    products: WeightedSums
    jumps: WeightedSums


def design(grid: Grid, time: Float[Array, "time"], order: Int[Integers, "time"] | None = None) -> SplineDesign:
    """What fits on a grid need to know of the times of their samples, and of which `order` each is: 0 for a height,
    1 for a speed; None for heights alone."""
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
    """The posterior of the curve. Raises LinAlgError if samples are so wild that there is none.

    `precision` is one over the variance of each height [1/m^2], zero for one that does not count; `process_noise` the
    variance that acceleration gains in a second, for each interval [m^2/s^5].
    """
    from scipy.linalg.lapack import dpbtrf, dpbtrs

    weight = 1 / (process_noise * samples.grid.step**5)
    band = (samples.products.of(precision) + samples.jumps.of(weight)).reshape(_DEGREE + 1, -1)
    band[0] += 1e-9  # of a curve that no sample ties down
    right = samples.sums.of(precision * height)
    factor, wrong = dpbtrf(band, lower=1)
    if wrong or not np.isfinite(factor[0]).all():
        raise np.linalg.LinAlgError("no curve goes through these samples")
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
