"""Moments of a linear fit's forecasts of plans: apogees, Cd and alpha.

Derivation: the covariance of the terms and the scatter, propagated through the derivatives of the linear fit, plus the
variance of the altimeter's error.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cache
from statistics import NormalDist

import numpy as np

from fieldkit.inference.history.linear_fit import LinearFit
from fieldkit.inference.history.response import slopes
from fieldkit.inference.laplace.leave_one_out import own_reading_sd
from fieldkit.inference.laplace.posterior import term_sds
from fieldkit.model.hyperprior import FROM_LOGS
from fieldkit.model.readout_data import OBSERVED_READOUTS
from fieldkit.model.rocket_model import Term, apogee_scatter
from fieldkit.shapes import Array, Float

DRAWS = 1000
"""Equally likely apogees of an answer. [1]"""
MAX_LOG_APOGEE = float(np.log(1e5))
"""Largest apogee of an answer. [log m]"""


@dataclass(frozen=True, slots=True)
class Moments:
    """Mean and standard deviation of log Cd (on the reference area) and log alpha of plans, and their correlation.
    [1]"""

    cd: Float[Array, "plan"]
    cd_sd: Float[Array, "plan"]
    alpha: Float[Array, "plan"]
    alpha_sd: Float[Array, "plan"]
    correlation: Float[Array, "plan"]


@dataclass(frozen=True, slots=True)
class ApogeeMixture:
    """The log apogee of plans for every point of the grid of scales: its weight, the mean, the variance that more
    flights would reduce, and that of a single flight, which is Student t with `tail` degrees of freedom. [1]"""

    weight: Float[Array, "scale"]
    mean: Float[Array, "scale plan"]
    known: Float[Array, "scale plan"]
    own: Float[Array, "scale plan"]
    tail: float

    def draws(self, plan: int, count: int) -> Float[Array, "draw"]:
        """Equally likely log apogees of a plan; the same count takes the same random numbers, so that plans differ only
        by their forecasts. [log m]"""
        level = (np.arange(count) + 0.5) / count
        which = np.minimum(np.searchsorted(np.cumsum(self.weight), level), len(self.weight) - 1)
        normal, student = _standard_draws(self.tail, count)
        mean, known, own = (part[which, plan] for part in (self.mean, self.known, self.own))
        return np.asarray(mean + np.sqrt(known) * normal + np.sqrt(own) * student)

    def apogees(self, plan: int) -> Float[Array, "draw"]:
        """Equally likely apogees of a plan in ascending order. [m]"""
        return np.asarray(np.exp(np.minimum(np.sort(self.draws(plan, DRAWS)), MAX_LOG_APOGEE)))


def mixed_apogees(cases: Sequence[tuple[float, ApogeeMixture]]) -> ApogeeMixture:
    """The mixture of several with some probabilities. [1]"""
    chances, parts = zip(*cases, strict=True)
    weight = np.concatenate([chance * part.weight for chance, part in zip(chances, parts, strict=True)])
    mean, known, own = (np.concatenate([getattr(part, name) for part in parts]) for name in ("mean", "known", "own"))
    return ApogeeMixture(weight, mean, known, own, parts[0].tail)


@cache
def _standard_draws(tail: float, count: int) -> tuple[Float[Array, "draw"], Float[Array, "draw"]]:
    """Standard normal draws and Student t draws; both have one normal draw in each stratum (Latin hypercube; McKay,
    Beckman and Conover, 1979)."""
    rng = np.random.default_rng(0)
    strata = np.array([NormalDist().inv_cdf((number + 0.5) / count) for number in range(count)])
    normal, tailed = rng.permuted(np.stack([strata, strata]), axis=1)
    return normal, tailed * np.sqrt(tail / rng.chisquare(tail, count))


def apogee_mixture(linear: LinearFit) -> ApogeeMixture:
    """A linear fit's forecasts of the apogees of its plans."""
    fit, model, near, plans = linear.fit, linear.model, linear.near, slice(linear.flown, None)
    fresh_sds = term_sds(replace(model, terms=linear.fresh, shared=None))
    fresh_means = np.array([term.mean for term in linear.fresh])
    row, fresh_row = near.slope[plans, 0], slopes(linear.fresh, linear.moved)[plans, 0]
    known = ((row @ fit.covariance) * row).sum(axis=-1) + fresh_sds**2 @ fresh_row.T**2
    mean = near.values[plans, 0] + (fit.mean - near.at) @ row.T + fresh_row @ fresh_means
    return ApogeeMixture(fit.weights, mean, known, own_variance(linear), model.hyperprior.tail)


def moments(linear: LinearFit) -> Moments:
    """A linear fit's drag and thrust of the plans."""
    fit, model, weights = linear.fit, linear.model, linear.fit.weights
    plans = slice(linear.flown, None)
    fresh_sds = term_sds(replace(model, terms=linear.fresh, shared=None))
    fresh_means = np.array([term.mean for term in linear.fresh])
    middle, covariance = _mixture(fit.mean, fit.covariance, weights)
    acts = [acting(model.terms, kind, len(model.flights))[:, plans] for kind in ("drag", "thrust")]
    fresh_acts = [acting(linear.fresh, kind, len(model.flights))[:, plans] for kind in ("drag", "thrust")]
    by_parameter = [
        (middle @ act + fresh_means @ new, (act * (covariance @ act)).sum(axis=0) + weights @ fresh_sds**2 @ new**2)
        for act, new in zip(acts, fresh_acts, strict=True)
    ]
    (cd, cd_variance), (alpha, alpha_variance) = by_parameter
    cd_sd, alpha_sd = (np.sqrt(np.maximum(variance, 1e-8)) for variance in (cd_variance, alpha_variance))
    return Moments(
        cd,
        cd_sd,
        alpha,
        alpha_sd,
        (acts[0] * (covariance @ acts[1])).sum(axis=0) / (cd_sd * alpha_sd),
    )


def mixed_moments(cases: Sequence[tuple[float, Moments]]) -> Moments:
    """The moments of a mixture: the mean of the variances plus the variance of the means."""
    chances, parts = zip(*cases, strict=True)
    chance = np.array(chances)
    each = {name: np.stack([getattr(part, name) for part in parts]) for name in Moments.__slots__}
    cd, alpha = chance @ each["cd"], chance @ each["alpha"]

    cd_sd = np.sqrt(chance @ (each["cd_sd"] ** 2 + (each["cd"] - cd) ** 2))
    alpha_sd = np.sqrt(chance @ (each["alpha_sd"] ** 2 + (each["alpha"] - alpha) ** 2))
    within = each["correlation"] * each["cd_sd"] * each["alpha_sd"]
    together = chance @ (within + (each["cd"] - cd) * (each["alpha"] - alpha))
    return Moments(cd, cd_sd, alpha, alpha_sd, together / (cd_sd * alpha_sd))


FORECAST_READOUTS = tuple(name for name in OBSERVED_READOUTS if name not in ("apogee", *FROM_LOGS))
"""Readouts of a plan that are forecast in addition to its apogee."""


@dataclass(frozen=True, slots=True)
class ReadoutMoments:
    """A linear fit's forecast of the other readouts of plans, without reading errors: mean and standard deviation of
    each of `FORECAST_READOUTS` in the form that is compared. [1] or [s]"""

    mean: Float[Array, "plan readout"]
    sd: Float[Array, "plan readout"]


def readout_moments(linear: LinearFit) -> ReadoutMoments:
    """A linear fit's forecast of the other readouts of plans."""
    fit, model, near, weights = linear.fit, linear.model, linear.near, linear.fit.weights
    plans = slice(linear.flown, None)
    columns = [OBSERVED_READOUTS.index(name) for name in FORECAST_READOUTS]
    terms = (*model.terms, *linear.fresh)
    fresh_sds = term_sds(replace(model, terms=linear.fresh, shared=None))
    fresh_means = np.array([term.mean for term in linear.fresh])
    middle, covariance = _mixture(fit.mean, fit.covariance, weights)
    slope = np.concatenate([near.slope, slopes(linear.fresh, linear.moved)], axis=-1)[plans][:, columns]
    whole = np.zeros((len(terms), len(terms)))
    whole[: len(middle), : len(middle)] = covariance
    whole[len(middle) :, len(middle) :] = np.diag(weights @ fresh_sds**2)
    away = np.concatenate([middle - near.at, fresh_means])
    spread = slope @ whole
    values = near.values[plans][:, columns]
    return ReadoutMoments(
        values + slope @ away,
        np.sqrt((spread * slope).sum(axis=-1) + np.tensordot(weights, _scatter_of_readouts(linear, columns), 1)),
    )


def mixed_readouts(cases: Sequence[tuple[float, ReadoutMoments]]) -> ReadoutMoments:
    """The moments of a mixture: the mean of the variances plus the variance of the means."""
    chances, parts = zip(*cases, strict=True)
    chance, means = np.array(chances), np.stack([part.mean for part in parts])
    mean = np.tensordot(chance, means, 1)
    variance = np.stack([part.sd**2 for part in parts]) + (means - mean) ** 2
    return ReadoutMoments(mean, np.sqrt(np.tensordot(chance, variance, 1)))


def _scatter_of_readouts(linear: LinearFit, columns: Sequence[int]) -> Float[Array, "scale plan readout"]:
    """Variance of single flights given the terms."""
    squares = linear.near.scatter_slope[linear.flown :, columns] ** 2
    return np.moveaxis(squares @ linear.model.scatter_scales().T ** 2, -1, 0)


def own_variance(linear: LinearFit) -> Float[Array, "scale plan"]:
    """Variance of each plan's log apogee given the terms: scatter and reading. [1]"""
    model, near, plans = linear.model, linear.near, slice(linear.flown, None)
    scatter = model.hyperprior.scales()[0][:, None]
    reading = own_reading_sd(np.exp(near.values[plans, 0]), model.hyperprior)
    spread = model.scatter_scales() ** 2 @ near.scatter_slope[plans, 0].T ** 2
    return np.asarray(spread + (scatter * apogee_scatter(model)[plans]) ** 2 + reading**2)


def _mixture(
    mean: Float[Array, "scale term"], covariance: Float[Array, "scale term term"], weights: Float[Array, "scale"]
) -> tuple[Float[Array, "term"], Float[Array, "term term"]]:
    middle, terms = weights @ mean, mean.shape[-1]
    off = mean - middle
    within = (weights @ covariance.reshape(len(weights), -1)).reshape(terms, terms)
    return middle, within + (off * weights[:, None]).T @ off


def acting(terms: Sequence[Term], bends: str, flights: int) -> Float[Array, "term flight"]:
    """The weight of each term on one property of each flight, zero if it acts on another. [1]"""
    acting = [term.weight * (term.bends == bends) for term in terms]
    return np.array(acting, float).reshape(len(terms), flights)
