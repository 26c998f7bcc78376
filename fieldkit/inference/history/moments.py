"""Moments of what a linear fit says of a plan: its apogee, and the Cd and alpha that it flies with."""

from dataclasses import dataclass

import numpy as np

from fieldkit.inference.history.linear_fit import LinearFit
from fieldkit.inference.laplace.leave_one_out import own_reading_sd
from fieldkit.model.rocket_model import Model, apogee_scatter
from fieldkit.shapes import Array, Float


@dataclass(frozen=True, slots=True)
class Moments:
    """Mean and standard deviation of the log apogee of a plan, and of log Cd and log alpha that it flies with.

    `cd` is over the reference area. `reference` is the logarithm of the apogee that the means of the model give. [1]
    """

    apogee: float
    apogee_sd: float
    parameter_sd: float
    cd: float
    cd_sd: float
    alpha: float
    alpha_sd: float
    correlation: float


def moments(linear: LinearFit) -> Moments:
    """The forecast of the first plan by a linear fit, and the drag and thrust it flies with."""
    fit, model, plan = linear.fit, linear.model, linear.flown
    near, weights = linear.near, fit.weights
    scatter = model.hyperprior.scales()[0]
    row = near.slope[plan, 0]
    known = np.einsum("t,stu,u->s", row, fit.covariance, row)
    reading = float(own_reading_sd(np.exp(near.values[plan, :1]), model.hyperprior)[0])
    own = scatter**2 * ((near.scatter_slope[plan, 0] ** 2).sum() + apogee_scatter(model)[plan] ** 2) + reading**2
    means = near.values[plan, 0] + (fit.mean - near.at) @ row
    mean = float(weights @ means)
    between = weights @ (means - mean) ** 2
    middle, covariance = _mixture(fit.mean, fit.covariance, weights)
    drag, thrust = (_acting(model, kind, plan) for kind in ("drag", "thrust"))
    cd_sd, alpha_sd = (float(np.sqrt(np.maximum(which @ covariance @ which, 1e-8))) for which in (drag, thrust))
    return Moments(
        mean,
        float(np.sqrt(weights @ (known + own) + between)),
        float(np.sqrt(max(weights @ known + between, 1e-8))),
        float(drag @ middle),
        cd_sd,
        float(thrust @ middle),
        alpha_sd,
        float(drag @ covariance @ thrust / (cd_sd * alpha_sd)),
    )


def _mixture(mean: Array, covariance: Array, weights: Array) -> tuple[Array, Array]:
    middle = weights @ mean
    return middle, np.einsum("s,stu->tu", weights, covariance) + np.einsum(
        "s,st,su->tu", weights, mean - middle, mean - middle
    )


def _acting(model: Model, bends: str, flight: int) -> Float[Array, "term"]:
    """How strongly each term bends one property of one flight."""
    return np.array([term.weight[flight] if term.bends == bends else 0.0 for term in model.terms])
