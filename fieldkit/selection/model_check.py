"""Whether the averaged model fits: a posterior predictive check of what it leaves in the readouts.

Replicated histories are drawn from the posterior of a fit and fitted in the same way, which takes one multiplication in
a linear model. Their leave-one-out residuals show how large any pattern is if the model is right: a bias or too much
spread of a readout, a trend or persistence in the order flown, differences between motors, configurations, days and
sites, and a correlation with a recorded number. The probability of the smallest p-value of all patterns is that of the
replicates with one as small, so no pattern is found by looking at many (Rubin, Annals of Statistics 12, 1984; Westfall
and Young, Resampling-Based Multiple Testing, 1993). Beside it stands a check of whether the terms themselves are usual.
"""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from math import exp, log
from typing import Literal

import numpy as np

from fieldkit.flight import BY_NAME, CONDITIONS
from fieldkit.inference.laplace.posterior import Fit
from fieldkit.model.readout_data import OBSERVED_READOUTS
from fieldkit.model.rocket_model import Model
from fieldkit.physics.setups import recorded
from fieldkit.selection.coast_check import CoastCheck
from fieldkit.selection.hypotheses import SetPosterior
from fieldkit.selection.usual_values import unusual_terms
from fieldkit.shapes import Array, Float, Int, Integers

REPLICATES = 400
"""Number of replicated histories. [1]"""
MIN_FLIGHTS = 4
"""Minimum number of flights with a readout for its patterns. [1]"""
MAX_RESIDUAL = 2.5
"""Larger residuals count as this, because single flights may differ from the rest. [1]"""
UNLISTED = 0.05
"""Prior probability that something acts which nothing of the search describes, a round judgment. [1]"""
MIN_P = 0.05
"""p-value from which nothing counts as left. [1]"""
LEAST_P = 1e-12
"""Smaller p-values count as this. [1]"""
MIN_CHECKED = 0.05
"""Minimum probability of a hypothesis that is checked. [1]"""
SEED = 23
"""Seed of the replicates."""
Left = Literal["readouts", "forces", "order"]


@dataclass(frozen=True, slots=True)
class ModelCheck:
    """The posterior predictive p-value of what the model leaves [1], where it shows (None if it fits), and the clearest
    pattern in words."""

    p: float
    left: Left | None
    pattern: str = ""

    @property
    def unlisted(self) -> float:
        """Probability that something unlisted acts. [1]

        The Bayes factor against a fitting model is at most 1 / (-e p ln p) (Sellke, Bayarri and Berger, American
        Statistician 55, 2001), and one for a p-value above 1 / e.
        """
        p = max(self.p, LEAST_P)
        least = -exp(1) * p * log(p) if p < exp(-1) else 1.0
        return UNLISTED / (UNLISTED + (1 - UNLISTED) * least)


@dataclass(frozen=True, slots=True)
class _Pattern:
    """A pattern in the residuals of one readout, in words, and its size in the history and in every replicate; of
    equally clear ones a `vague` pattern is not the one to report."""

    left: Left
    words: str
    size: Float[Array, "history"]
    vague: bool = False


def model_check(posterior: SetPosterior, coasts: CoastCheck | None = None) -> ModelCheck:
    """The checks of residuals and of terms of all probable hypotheses, averaged over their probabilities, and that of
    the drag along logged coasts."""
    pairs = sorted(zip(posterior.probability.tolist(), posterior.hypotheses, strict=True), key=lambda pair: -pair[0])
    likely = [pair for pair in pairs if pair[0] > MIN_CHECKED] or pairs[:1]
    total = sum(chance for chance, _ in likely)

    def averaged(check: Callable[[Fit], ModelCheck]) -> ModelCheck:
        found = [check(one.fit) for _, one in likely]
        p = sum(chance * one.p for (chance, _), one in zip(likely, found, strict=True)) / total
        return replace(found[0], p=p)

    return clearest([averaged(fit_check), averaged(terms_check), *([coasts_check(coasts)] if coasts else [])])


def clearest(checks: Sequence[ModelCheck]) -> ModelCheck:
    """The clearest of independent checks, with the probability that one of them has a p-value as small (Sidak, Journal
    of the American Statistical Association 62, 1967)."""
    found = min(checks, key=lambda check: check.p)
    p = 1 - (1 - found.p) ** len(checks)
    return replace(found, p=p, left=found.left if p < MIN_P else None)


def coasts_check(coasts: CoastCheck) -> ModelCheck:
    """The check of the drag along logged coasts."""
    when = f"{coasts.time_from_liftoff:.1f} s after lift-off"
    pattern = f"the drag of flight {coasts.flight_id}, {coasts.ratio:.1f} times the rocket's own {when}"
    return ModelCheck(coasts.p, "forces" if coasts.p < MIN_P else None, pattern)


def terms_check(fit: Fit) -> ModelCheck:
    """The check of the terms that one fit needs."""
    p, words = unusual_terms(fit)
    return ModelCheck(p, "readouts" if p < MIN_P else None, words)


def fit_check(fit: Fit) -> ModelCheck:
    """The check of one fit, at its most probable scales."""
    residual = np.clip(_residuals(fit), -MAX_RESIDUAL, MAX_RESIDUAL)
    seen = fit.data.seen & np.isfinite(fit.tangent.values)
    found = [
        pattern
        for column, name in enumerate(OBSERVED_READOUTS)
        if (rows := np.flatnonzero(seen[:, column])).size >= MIN_FLIGHTS
        for pattern in _patterns(fit.model, name, residual[:, rows, column], rows)
    ]
    if not found:
        return ModelCheck(1.0, None)
    sizes = np.stack([pattern.size for pattern in found])
    # among the history and the replicates, how many are as large: the history is one of them
    p = (sizes[:, None, :] >= sizes[..., None] - 1e-9).mean(axis=-1)
    smallest = p.min(axis=0)
    total = float((smallest <= smallest[0] + 1e-9).mean())
    clearness = (sizes[:, 0] - sizes[:, 1:].mean(axis=1)) / sizes[:, 1:].std(axis=1)
    vague = [pattern.vague for pattern in found]
    worst = found[int(np.lexsort((-clearness, vague, p[:, 0]))[0])]
    return ModelCheck(total, worst.left if total < MIN_P else None, worst.words)


def _residuals(fit: Fit) -> Float[Array, "history flight readout"]:
    """Standardized leave-one-out residuals of the flights, in the first row, and of replicates."""
    rng = np.random.default_rng(SEED)
    best, evidence = int(np.argmax(fit.log_weight)), fit.evidence
    slope, sharpness = evidence.slope, evidence.sharpness[best]
    noise = np.linalg.inv(sharpness)
    flights, used, terms = slope.shape
    offset = fit.mean[best] - np.array([term.mean for term in fit.model.terms])
    truth = offset + rng.normal(size=(REPLICATES, terms)) @ np.linalg.cholesky(fit.covariance[best]).T
    scatter = np.einsum("fop,rfp->rfo", np.linalg.cholesky(noise), rng.normal(size=(REPLICATES, flights, used)))
    miss = np.concatenate([evidence.miss[None], np.einsum("fot,rt->rfo", slope, truth) + scatter])
    score = np.einsum("fot,fop,rfp->rt", slope, sharpness, miss, optimize=True)
    left = miss - np.einsum("fot,rt->rfo", slope, score @ fit.covariance[best])
    known = slope @ fit.covariance[best] @ np.swapaxes(slope, 1, 2)
    gain = noise @ np.linalg.inv(noise - known)
    error = np.einsum("fop,rfp->rfo", gain, left)
    sd = np.sqrt(np.einsum("fop,fpo->fo", gain, noise))
    found = np.zeros((len(miss), flights, len(OBSERVED_READOUTS)))
    found[..., evidence.readouts] = error / sd
    return found


def _patterns(
    model: Model, name: str, residual: Float[Array, "history flight"], rows: Int[Integers, "flight"]
) -> Iterator[_Pattern]:
    """The patterns in the residuals of one readout."""
    order, readout = np.arange(len(rows), dtype=float), BY_NAME[name].title.lower()
    off = residual - residual.mean(axis=1, keepdims=True)
    power = np.maximum((off**2).sum(axis=1), 1e-12)
    yield _Pattern("readouts", f"a bias of the {readout}", np.abs(residual.mean(axis=1)))
    yield _Pattern("readouts", f"the scatter of the {readout}", (residual**2).mean(axis=1), vague=True)
    yield _Pattern("order", f"a trend of the {readout}", _correlation(residual, order))
    yield _Pattern("order", f"persistence of the {readout}", (off[:, 1:] * off[:, :-1]).sum(axis=1) / power)
    for level in ("motor", "config", "site", "day"):
        group = np.array(model.groups(level))[rows]
        kinds, count = np.unique(group, return_counts=True)
        if len(kinds) < 2 or count.max() < 2:
            continue
        means = np.stack([off[:, group == kind].mean(axis=1) for kind in kinds])
        left: Left = "order" if level == "day" else "readouts"
        yield _Pattern(left, f"the {readout} by {level}", (count[:, None] * means**2).sum(axis=0))
    for column in CONDITIONS:
        values = recorded([model.flights[row] for row in rows.tolist()], column.name)
        known = np.isfinite(values)
        if known.sum() >= MIN_FLIGHTS and len(np.unique(values[known])) > 2:
            words = f"the {readout} with {column.title.lower()}"
            yield _Pattern("readouts", words, _correlation(residual[:, known], values[known]))


def _correlation(residual: Float[Array, "history flight"], values: Float[Array, "flight"]) -> Float[Array, "history"]:
    """Size of the correlation. [1]"""
    off, along = residual - residual.mean(axis=1, keepdims=True), values - values.mean()
    sizes = np.sqrt(np.maximum((off**2).sum(axis=1) * (along**2).sum(), 1e-12))
    return np.asarray(np.abs(off @ along) / sizes)
