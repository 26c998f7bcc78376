"""The exact posterior of a rocket's model as a density of coordinates with a standard normal prior.

Terms, the random effects of every flight, and the two scales are all sampled, without integration or linearization, and
residuals are Student t. The simulator has the settings of forecasts, not the coarse ones.
"""

from dataclasses import dataclass, replace

import numpy as np
from scipy.special import ndtr, ndtri

from fieldkit.model.readout_data import OBSERVED_READOUTS, Data
from fieldkit.model.rocket_model import Model, Term, apogee_scatter
from fieldkit.model.scale import Scale
from fieldkit.model.simulated_readouts import bent
from fieldkit.shapes import Array, Flags, Float
from studies.reference_posterior.readouts import EJECTION, STEP_SIZES, Readouts, side_slopes, simulated

EXACT_STEP = 1e-4
"""Step of an exact force. [1] or [s]"""


@dataclass(frozen=True, slots=True)
class PosteriorPoint:
    """The parameters at given coordinates: values of the terms, scaled random effects of each flight, and the
    scales."""

    terms: Float[Array, "draw term"]
    scatter: Float[Array, "draw flight kind"]
    scatter_scale: Float[Array, "draw"]
    reading_scale: Float[Array, "draw"]
    motor_scale: Float[Array, "draw"]


@dataclass(frozen=True, slots=True, eq=False)
class Target:
    """The posterior density of a model's coordinates given data.

    Coordinates are the terms in order, the random effects flight by flight, and the logarithms of the scales of motors
    (if it is separate), scatter and readings, each transformed to a standard normal prior. `slopes` are the force's
    derivatives of the readouts with respect to every property (`kinds`), for ejection after apogee and before it,
    because readouts have a kink there. A readout that is not `seen` and usable is not compared. Unless `student`,
    residuals are normal, with the fit's outlier weights (`trust` of the data). An `exact_force` computes derivatives at
    every point instead, with seven times as many simulations.
    """

    model: Model
    data: Data
    readouts: Readouts
    seen: Flags
    kinds: tuple[str, ...]
    slopes: Float[Array, "side flight readout kind"]
    student: bool = True
    exact_force: bool = False

    @property
    def dimension(self) -> int:
        """Number of coordinates."""
        return len(self.model.terms) + len(self.model.flights) * len(self.model.scatter) + len(self._unknown)

    def point(self, at: Float[Array, "draw dimension"]) -> PosteriorPoint:
        """The parameters at these coordinates."""
        flights, kinds, terms = len(self.model.flights), len(self.model.scatter), len(self.model.terms)
        scatter, reading, motors = self._scales(at)
        values = np.stack([_value(term, at[:, i], scatter, reading) for i, term in enumerate(self.model.terms)], -1)
        if self.model.shared:
            rows = self._shared_rows()
            values[:, rows] = self.model.shared.mean + at[:, rows] @ np.linalg.cholesky(self.model.shared.covariance).T
        sds = np.array([kind.sd for kind in self.model.scatter])
        effects = at[:, terms : -len(self._unknown)].reshape(-1, flights, kinds) * sds * motors[:, None, None]
        return PosteriorPoint(values, effects, scatter, reading, motors)

    def coordinates(
        self, values: Float[Array, "term"], scatter: float = 1.0, reading: float = 1.0, motors: float = 1.0
    ) -> Float[Array, "dimension"]:
        """Coordinates of values of the terms and of the scales, without random effects of flights."""
        at = np.zeros(self.dimension)
        for i, term in enumerate(self.model.terms):
            at[i] = _coordinate(term, float(values[i]), scatter, reading)
        for i, scale, value in zip((-2, -1, -3), self._unknown, (scatter, reading, motors), strict=False):
            at[i] = np.log(value / scale.median) / scale.log_sd
        if self.model.shared:
            rows = self._shared_rows()
            root = np.linalg.cholesky(self.model.shared.covariance)
            at[rows] = np.linalg.solve(root, values[rows] - self.model.shared.mean)
        return at

    def __call__(
        self, at: Float[Array, "draw dimension"]
    ) -> tuple[Float[Array, "draw"], Float[Array, "draw dimension"]]:
        """Log density up to a constant [nat], and the force's approximate gradient."""
        point = self.point(at)
        effects = {str(kind.bends): point.scatter[..., i] for i, kind in enumerate(self.model.scatter)}
        with np.errstate(over="ignore", invalid="ignore"):  # a trajectory may diverge to a region without flights
            flown = self.readouts(point.terms, effects)
        possible = (np.isfinite(flown) | ~self.seen).all(axis=(1, 2))
        error = np.where(self.seen & np.isfinite(flown), self.data.values - flown, 0.0)
        variance = self.variance(point)
        log_likelihood, score, by_width = self._residuals(error, variance)
        log_density = log_likelihood - 0.5 * (at**2).sum(axis=1)
        force = self._pulled(at, point, score, self._bent(point, score, flown)) - at
        prior = self.model.hyperprior
        own = (point.scatter_scale[:, None] * apogee_scatter(self.model)) ** 2 / variance[..., 0]
        force[:, -2] += prior.scatter.log_sd * (by_width[..., 0] * own).sum(axis=1)
        force[:, -1] += prior.reading.log_sd * by_width[..., 1:].sum(axis=(1, 2))
        return np.where(possible, log_density, -np.inf), np.nan_to_num(force)

    @property
    def _unknown(self) -> tuple[Scale, ...]:
        return self.model.hyperprior.unknown_scales

    def _scales(self, at: Array) -> tuple[Float[Array, "draw"], Float[Array, "draw"], Float[Array, "draw"]]:
        scatter, reading, *motors = (
            scale.median * np.exp(scale.log_sd * at[:, i])
            for i, scale in zip((-2, -1, -3), self._unknown, strict=False)
        )
        return scatter, reading, motors[0] if motors else scatter

    def variance(self, point: PosteriorPoint) -> Float[Array, "draw flight readout"]:
        """Squared scale of every residual."""
        variance = point.reading_scale[:, None, None] ** 2 * self.data.sd**2
        variance[..., 0] = self.data.sd[:, 0] ** 2 + (point.scatter_scale[:, None] * apogee_scatter(self.model)) ** 2
        return np.asarray(variance if self.student else variance / self.data.trust)

    def _residuals(self, error: Array, variance: Array) -> tuple[Array, Array, Array]:
        """Log likelihood [nat], and its derivatives with respect to each readout and each log scale."""
        nu = self.model.hyperprior.tail
        square = error**2 / variance
        if self.student:
            each, weight = -0.5 * (nu + 1) * np.log1p(square / nu), (nu + 1) / (nu + square)
        else:
            each, weight = -0.5 * square, np.ones_like(square)
        total = np.where(self.seen, each - 0.5 * np.log(variance), 0.0).sum(axis=(1, 2))
        by_width = np.where(self.seen, weight * square - 1, 0.0)
        return total, weight * error / variance, by_width

    def _early(self, point: PosteriorPoint, flown: Float[Array, "draw flight readout"]) -> Flags:
        """Whether ejection is before apogee."""
        bias = bent(self.model, point.terms, OBSERVED_READOUTS[EJECTION])
        return np.asarray(np.nan_to_num(flown[..., EJECTION]) < bias)

    def _bent(
        self,
        point: PosteriorPoint,
        score: Float[Array, "draw flight readout"],
        flown: Float[Array, "draw flight readout"],
    ) -> Float[Array, "draw flight kind"]:
        """The derivative with respect to properties, by the chain rule with the slopes."""
        if self.exact_force:
            return np.asarray(np.einsum("dfo,kdfo->dfk", score, self._slopes_here(point, flown)))
        late, before = (np.einsum("dfo,fok->dfk", score, side) for side in self.slopes)
        return np.asarray(np.where(self._early(point, flown)[..., None], before, late))

    def _slopes_here(self, point: PosteriorPoint, flown: Array) -> Float[Array, "kind draw flight readout"]:
        draws, kinds = len(flown), len(self.kinds)
        effects = {str(kind.bends): point.scatter[..., i] for i, kind in enumerate(self.model.scatter)}
        rows = {}
        for number, kind in enumerate(self.kinds):
            rows[kind] = np.tile(effects.get(kind, np.zeros(flown.shape[:2])), (kinds, 1))
            rows[kind][number * draws : (number + 1) * draws] += EXACT_STEP
        with np.errstate(over="ignore", invalid="ignore"):
            moved = self.readouts(np.tile(point.terms, (kinds, 1)), rows).reshape(kinds, *flown.shape)
            return np.nan_to_num((moved - flown) / EXACT_STEP, posinf=0.0, neginf=0.0)

    def _pulled(
        self,
        at: Array,
        point: PosteriorPoint,
        score: Float[Array, "draw flight readout"],
        by_kind: Float[Array, "draw flight kind"],
    ) -> Float[Array, "draw dimension"]:
        """The derivative with respect to the coordinates, by the chain rule."""
        by_term = np.stack([self._by_term(term, by_kind, score) for term in self.model.terms], axis=-1)
        prior, terms = self.model.hyperprior, len(self.model.terms)
        out = np.empty_like(at)
        scales: dict[str, Array | float] = {"": 1.0, "scatter": point.scatter_scale, "reading": point.reading_scale}
        for i, term in enumerate(self.model.terms):
            out[:, i] = by_term[:, i] * _rate(term, at[:, i], scales[term.scaled_by])
        if self.model.shared:
            rows = self._shared_rows()
            out[:, rows] = by_term[:, rows] @ np.linalg.cholesky(self.model.shared.covariance)
        columns = [self.kinds.index(kind.bends) for kind in self.model.scatter]
        sds = np.array([kind.sd for kind in self.model.scatter])
        effects = by_kind[..., columns]
        out[:, terms : -len(self._unknown)] = (effects * sds * point.motor_scale[:, None, None]).reshape(len(at), -1)
        moved = point.terms - np.array([term.mean for term in self.model.terms])
        scaled = {by: np.array([term.scaled_by == by for term in self.model.terms]) for by in ("scatter", "reading")}
        by_scale = {by: (by_term * moved)[:, which].sum(axis=1) for by, which in scaled.items()}
        by_motors = (effects * point.scatter).sum(axis=(1, 2))
        if prior.motors:
            out[:, -3] = prior.motors.log_sd * by_motors
        else:
            by_scale["scatter"] = by_scale["scatter"] + by_motors
        out[:, -2] = prior.scatter.log_sd * by_scale["scatter"]
        out[:, -1] = prior.reading.log_sd * by_scale["reading"]
        return out

    def _by_term(self, term: Term, by_kind: Array, score: Array) -> Float[Array, "draw"]:
        if term.bends in OBSERVED_READOUTS:
            return np.asarray(score[..., OBSERVED_READOUTS.index(str(term.bends))] @ term.weight)
        return np.asarray(by_kind[..., self.kinds.index(str(term.bends))] @ term.weight)

    def _shared_rows(self) -> list[int]:
        assert self.model.shared
        return [self.model.names.index(name) for name in self.model.shared.names]

    def curvature(self, at: Float[Array, "dimension"]) -> Float[Array, "dimension dimension"]:
        """Expected negative second derivative of the log density, from the slopes (Fisher information plus the
        prior)."""
        point, flights = self.point(at[None]), len(self.model.flights)
        nu = self.model.hyperprior.tail
        certain = np.where(self.seen, (nu + 1) / (nu + 3) / self.variance(point)[0], 0.0)
        unit = np.eye(flights * len(OBSERVED_READOUTS)).reshape(-1, flights, len(OBSERVED_READOUTS))
        repeated = [np.repeat(getattr(point, name), len(unit), axis=0) for name in PosteriorPoint.__dataclass_fields__]
        effects = {str(kind.bends): point.scatter[..., i] for i, kind in enumerate(self.model.scatter)}
        flown = np.repeat(self.readouts(point.terms, effects), len(unit), axis=0)
        every = PosteriorPoint(*repeated)
        slope = self._pulled(np.repeat(at[None], len(unit), axis=0), every, unit, self._bent(every, unit, flown))
        found = slope.T @ (certain.ravel()[:, None] * slope) + np.eye(self.dimension)
        prior, seen = self.model.hyperprior, self.seen.sum(axis=0)
        own = (point.scatter_scale[:, None] * apogee_scatter(self.model)) ** 2 / self.variance(point)[..., 0]
        width = 2 * nu / (nu + 3)
        found[-2, -2] += width * prior.scatter.log_sd**2 * float((own[0] ** 2 * self.seen[:, 0]).sum())
        found[-1, -1] += width * prior.reading.log_sd**2 * float(seen[1:].sum())
        return np.asarray(found)


def target(
    model: Model, data: Data, at: Float[Array, "term"], readouts: Readouts | None = None, *, student: bool = True
) -> Target:
    """The posterior of a model without effects; `at` is the point of the force's linearization.

    `readouts` are by default the simulator's. A seen readout that the simulator does not give there is not compared, as
    in the fit. Raises ValueError for a model with a launch angle or with effects.
    """
    kinds = tuple(STEP_SIZES)
    if any(term.bends not in (*kinds, *OBSERVED_READOUTS) for term in model.terms) or any(
        kind.bends not in kinds for kind in model.scatter
    ):
        raise ValueError(f"found terms that bend something else, expected {', '.join(kinds)} and readouts alone")
    exact, at = simulated(replace(model, coarse=False)), np.asarray(at, float)
    flown = exact(at[None], {})[0]
    return Target(
        model, data, readouts or exact, data.seen & np.isfinite(flown), kinds, side_slopes(model, exact, at), student
    )


def _ends(term: Term) -> tuple[float, float]:
    """Prior probability below each bound of a term."""
    low, high = ndtr((np.array([term.low, term.high]) - term.mean) / term.sd)
    return float(low), float(high)


def _bounded(term: Term) -> bool:
    return bool(np.isfinite(term.low) or np.isfinite(term.high))


def _value(term: Term, at: Array, scatter: Array, reading: Array) -> Float[Array, "draw"]:
    if _bounded(term):
        low, high = _ends(term)
        return np.asarray(np.clip(term.mean + term.sd * ndtri(low + (high - low) * ndtr(at)), term.low, term.high))
    scales: dict[str, Array | float] = {"": 1.0, "scatter": scatter, "reading": reading}
    scale = scales[term.scaled_by]
    return np.asarray(term.mean + term.sd * scale * at)


def _rate(term: Term, at: Array, scale: Array | float) -> Float[Array, "draw"] | float:
    """Derivative of a term with respect to its coordinate."""
    if not _bounded(term):
        return term.sd * scale
    low, high = _ends(term)
    normal = ndtri(low + (high - low) * ndtr(at))
    return np.asarray(term.sd * (high - low) * np.exp(0.5 * (normal**2 - at**2)))


def _coordinate(term: Term, value: float, scatter: float, reading: float) -> float:
    if _bounded(term):
        low, high = _ends(term)
        inside = (ndtr((value - term.mean) / term.sd) - low) / (high - low)
        return float(ndtri(np.clip(inside, 1e-3, 1 - 1e-3)))
    return (value - term.mean) / (term.sd * {"": 1.0, "scatter": scatter, "reading": reading}[term.scaled_by])
