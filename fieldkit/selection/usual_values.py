"""Whether a fit needs unusual values: a check of its terms against their prior.

Readouts may contradict each other in a way that some effect fits, if drag, thrust and the effect itself are far from
anything known: the residuals are small then, and only the terms show that something else acts. With the prior
covariance V and the posterior covariance C of the terms, the posterior mean m has the covariance V - C before the
flights are seen. The distance m' V^-1 m is then a sum of squares of standard normal numbers, each times an eigenvalue
of 1 - V^-1 C, so directions that the flights do not determine do not count (a check for prior-data conflict: Evans and
Moshonov, Bayesian Analysis 1, 2006). Its distribution is approximated by a scaled chi-squared one with the same mean
and variance (Satterthwaite, Biometrics Bulletin 2, 1946).
"""

import numpy as np

from fieldkit.flight import BY_NAME
from fieldkit.inference.laplace.posterior import Fit, prior_precision
from fieldkit.model.term_names import TermName
from fieldkit.physics.effect import spoken

IN_WORDS = {"stretch": "length of the burn", "opening": "opening time of the parachute"}
"""Quantities of terms whose names are no words of a flyer."""


def unusual_terms(fit: Fit) -> tuple[float, str]:
    """The probability of terms at least as far from their prior, at the most probable scales [1], and the farthest one
    in words."""
    from scipy.special import gammaincc  # takes 0.18 s to import

    best = int(np.argmax(fit.log_weight))
    scale = best if fit.scales is None else int(fit.scales[best])
    precision = prior_precision(fit.model)[0][scale]
    offset = fit.mean[best] - np.array([term.mean for term in fit.model.terms])
    root = np.linalg.cholesky(precision)
    share = np.linalg.eigvalsh(np.eye(len(offset)) - root.T @ fit.covariance[best] @ root)
    mean, variance = share.sum(), 2 * (share**2).sum()
    p = gammaincc(mean**2 / variance, offset @ precision @ offset * mean / variance)
    names = fit.model.names
    farthest = int(np.argmax(np.abs(offset) / np.sqrt(np.diagonal(np.linalg.inv(precision)))))
    return float(p), f"an unusual {in_words(names[farthest])}"


def in_words(name: TermName) -> str:
    """What a term is about, as a flyer would say it."""
    quantity = spoken(name.quantity.split()[0])  # a smooth pattern has one term for each component
    title = BY_NAME[quantity].title.lower() if quantity in BY_NAME else IN_WORDS.get(quantity, quantity)
    words = title.replace("_", " ")
    return f"{words} of {name.group}" if name.level == "motor" else words
