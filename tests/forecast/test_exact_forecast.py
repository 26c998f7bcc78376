"""The posterior of forecasts compared with exact weights from importance sampling with the simulator."""

from dataclasses import dataclass, replace

import numpy as np
import pytest

from fieldkit.forecast.assumed import forecast_model
from fieldkit.inference.laplace.fit import fit_robustly
from fieldkit.inference.laplace.posterior import Fit, term_sds
from fieldkit.model.readout_data import OBSERVED_READOUTS, compared, observe
from fieldkit.model.rocket_model import Model
from fieldkit.model.simulated_readouts import shown
from fieldkit.physics.history import history_of
from fieldkit.shapes import Array
from tests.seasons import season

DRAWS = 20000


@dataclass(frozen=True)
class Drawn:
    """Draws of the terms from the posterior, the pair of scales of each, and their exact weights."""

    terms: Array
    weight: Array


def weighed(result: Fit, rng: np.random.Generator) -> Drawn:
    """Prior times likelihood over the density of the draws; only the noise of a flight is unchanged."""
    model = result.model
    which = rng.choice(len(result.weights), size=DRAWS, p=result.weights)
    roots = np.linalg.cholesky(result.covariance)[which]
    z = rng.normal(size=(DRAWS, len(model.terms)))
    terms = result.mean[which] + np.einsum("dtu,du->dt", roots, z)
    low, high, mean = (np.array([getattr(term, name) for term in model.terms]) for name in ("low", "high", "mean"))
    inside = ((terms >= low) & (terms <= high)).all(axis=1)
    terms = np.clip(terms, low, high)
    readings = shown(model, terms, {})
    flown = compared(np.stack([readings[name] for name in OBSERVED_READOUTS], axis=-1))
    usable = result.data.seen & np.isfinite(flown) & np.isfinite(result.tangent.values)
    miss = np.where(usable, result.data.values - flown, 0.0)
    miss = miss[..., result.evidence.readouts]
    misfit = np.einsum("dfo,dfop,dfp->d", miss, result.evidence.sharpness[which], miss)
    sds = term_sds(model)[which]
    prior = -0.5 * (((terms - mean) / sds) ** 2).sum(axis=1) - np.log(sds).sum(axis=1)
    target = prior - 0.5 * (misfit + result.evidence.log_det.sum(axis=1)[which])
    target = target + model.hyperprior.scales()[2][which]
    drawn = -0.5 * (z**2).sum(axis=1) - np.log(np.diagonal(roots, axis1=1, axis2=2)).sum(axis=1)
    log_weight = np.where(inside, target - drawn - np.log(result.weights[which]), -np.inf)
    weight = np.exp(log_weight - log_weight.max())
    return Drawn(terms, weight / weight.sum())


def quantiles(values: Array, weight: Array) -> Array:
    order = np.argsort(values)
    return np.interp([0.05, 0.5, 0.95], np.cumsum(weight[order]), values[order])


@pytest.mark.parametrize(
    ("recorded", "effective", "off"),
    [(OBSERVED_READOUTS, 2500, 0.07), (("apogee", "top_speed"), 50, 0.27), (("apogee",), 100, 0.32)],
    ids=["all", "apogee and speed", "apogee"],
)
def test_a_forecast_agrees_with_exactly_weighted_draws(recorded: tuple[str, ...], effective: int, off: float) -> None:
    """The tolerance is a fraction of the width before scatter; from apogees alone drag and thrust lie on a curved
    ridge."""
    rng = np.random.default_rng(5)
    flights, found = map(list, zip(*season(rng, recorded), strict=True))
    model = replace(forecast_model(history_of(flights, found)), coarse=True)
    result = fit_robustly(model, observe(model.history.using([True] * len(flights)), model.hyperprior))
    drawn = weighed(result, rng)
    assert 1 / (drawn.weight**2).sum() > effective
    apogees = np.log(next_apogees(model, drawn.terms))
    forecast, exact = quantiles(apogees, np.full(DRAWS, 1 / DRAWS)), quantiles(apogees, drawn.weight)
    np.testing.assert_allclose(exact, forecast, atol=off * (forecast[2] - forecast[0]))


def next_apogees(model: Model, terms: Array) -> Array:
    """Apogees of repeating the first flight, without its scatter. [m]"""
    return shown(model.part(slice(0, 1)), terms, {})["apogee"][:, 0]
