"""Evaluation of the field ensemble on new simulations with known truth, for each set of readouts."""

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from fieldkit.inference.network import outliers
from fieldkit.inference.network.field_ensemble import posterior
from fieldkit.inference.network.mixture import Mixture, joined
from fieldkit.model.observation_noise import SUBSETS, forget, measure
from fieldkit.model.observations import Observed
from fieldkit.model.prior_predictive import Truth, simulate, split_motors
from fieldkit.motors import Motor
from fieldkit.shapes import Array, Float

if TYPE_CHECKING:
    from fieldkit.inference.network.ensemble import Ensemble

FLIGHTS = 20_000
"""Number of new flights for each evaluation. [1]"""
COVERAGES = (0.5, 0.8, 0.9, 0.95)
"""Levels of the central intervals. [1]"""
BINS = 20
"""Number of bins of the histograms of ranks."""
DRAWS = 100
"""Number of draws from each posterior for the curve of expected coverage."""
BLOCK = 1000
"""Number of flights evaluated together, few enough for the processor's cache."""


def evaluate(ensemble: "Ensemble", rng: np.random.Generator) -> dict[str, Any]:
    """The figures of a card: on motors of the training set, of the held-out manufacturer, and of the same classes in
    the training set. Raises BadValue for an unknown effect in the card."""
    known, others = split_motors()
    classes = {motor.impulse_class for motor in others}
    peers = [motor for motor in known if motor.impulse_class in classes]
    flown = {"test": known, "test_held_out": others, "test_peers": peers}
    return {name: judge(ensemble, rng, motors, FLIGHTS, ensemble.card["effects"]) for name, motors in flown.items()}


def judge(
    ensemble: "Ensemble", rng: np.random.Generator, motors: Sequence[Motor], count: int, effects: Sequence[str] = ()
) -> dict[str, Any]:
    """The evaluation by subset of the readouts, on new flights with these motors and all conditions declared; the
    last entry is for any readouts and conditions, with gaps.

    Raises BadValue for an unknown effect.
    """
    truth = simulate(rng, motors, count, effects)
    whole = measure(rng, truth)
    verdict = {name: _verdict(rng, ensemble, truth, whole.only(*kept)) for name, kept in SUBSETS.items()}
    gaps = forget(rng, whole)
    return verdict | {"any, with gaps": _verdict(rng, ensemble, truth, gaps)}


def _verdict(rng: np.random.Generator, ensemble: "Ensemble", truth: Truth, observed: Observed) -> dict[str, Any]:
    blocks = [slice(first, first + BLOCK) for first in range(0, len(truth), BLOCK)]
    density = joined([posterior(observed.rows(block), ensemble) for block in blocks])
    found, median = score(rng, density, truth.parameters)
    area = truth.drag_area / truth.cd
    outlier_rate = float((outliers.misfit(ensemble, observed) >= 0).mean())
    cd_mae = float(np.abs(np.exp(median) / area - truth.cd).mean())
    return {"flights": len(truth), "cd_mae": cd_mae} | found | {"false_alarms": outlier_rate}


def score(
    rng: np.random.Generator, density: Mixture, truth: Float[Array, "flight 2"]
) -> tuple[dict[str, Any], Float[Array, "flight"]]:
    """Log density, errors of the median, coverage, ranks and expected coverage of posteriors with known truths.

    The first parameter is the logarithm of a drag area [log m^2], the second is alpha [1]. The medians of the first are
    returned too.
    """
    blocks = [slice(first, first + BLOCK) for first in range(0, len(truth), BLOCK)]
    figures = np.concatenate([_figures(density.rows(block), truth[block]) for block in blocks])
    ranks = dict(zip(("drag_area", "alpha"), figures[:, :2].T, strict=True))
    return {
        "alpha_mae": float(np.abs(figures[:, 3] - truth[:, 1]).mean()),
        "log_density": float(figures[:, 6].mean()),
        "log_drag_area_sd": float(figures[:, 4].mean()),
        "alpha_sd": float(figures[:, 5].mean()),
        "coverage": {name: _coverage(rank) for name, rank in ranks.items()},
        "ranks": {name: _histogram(rank) for name, rank in ranks.items()},
        "expected_coverage": _curve(
            np.concatenate([expected_coverage(rng, density.rows(block), truth[block]) for block in blocks])
        ),
    }, figures[:, 2]


def _figures(density: Mixture, truth: Float[Array, "flight 2"]) -> Float[Array, "flight 7"]:
    """Ranks, medians, standard deviations of both parameters, and the log density."""
    margins = [density.margin(axis) for axis in (0, 1)]
    ranks = [margin.rank(truth[:, axis]) for axis, margin in enumerate(margins)]
    medians = [margin.quantiles(np.array([0.5]))[:, 0] for margin in margins]
    return np.stack([*ranks, *medians, *(margin.moments()[1] for margin in margins), density.log_density(truth)], -1)


def _coverage(rank: Float[Array, "flight"]) -> dict[str, float]:
    return {f"{level:g}": float((np.abs(rank - 0.5) < level / 2).mean()) for level in COVERAGES}


def _histogram(rank: Float[Array, "flight"]) -> dict[str, Any]:
    """Ranks of the truth in its posterior, uniform if the posterior is right (Talts et al., 2018).

    `excess` is the count of the largest bin relative to a uniform one, minus 1; `lack` is the same for the smallest.
    """
    counts = np.histogram(rank, BINS, (0.0, 1.0))[0]
    excess = counts * BINS / len(rank) - 1
    return {"counts": counts.tolist(), "excess": float(excess.max()), "lack": float(excess.min())}


def expected_coverage(
    rng: np.random.Generator, density: Mixture, truth: Float[Array, "flight 2"]
) -> Float[Array, "flight"]:
    """Fraction of each posterior nearer to a random point than the truth; uniform if the posterior is right. [1]

    Source: Lemos, Coogan, Hezaveh and Perreault-Levasseur, "Sampling-based accuracy testing of posterior
    estimators for general inference", 2023 (TARP).
    """
    width = density.high - density.low
    reference = density.low + width * rng.uniform(size=truth.shape)
    far = (((density.draws(rng, DRAWS) - reference) / width) ** 2).sum(axis=-1)
    own = (((truth - reference) / width) ** 2).sum(axis=-1)
    return np.asarray((far < own).mean(axis=0))


def _curve(fraction: Float[Array, "flight"]) -> dict[str, Any]:
    levels = np.linspace(0.1, 0.9, 9)
    covered = [round(float((fraction < level).mean()), 4) for level in levels]
    return {"at": [round(float(level), 1) for level in levels], "covered": covered}


def table(card: Mapping[str, Any]) -> list[str]:
    """The evaluation in a card as lines of text."""
    lines = []
    titles = {
        "test": "fresh flights",
        "test_held_out": f"motors of {card['held_out']}, never seen",
        "test_peers": "motors of the same classes, seen",
    }
    for key, title in titles.items():
        lines.append(title)
        lines.append(
            f"{'readouts':22s} {'log p':>7s} {'Cd MAE':>7s} {'al MAE':>7s}  coverage at 50/80/90/95%: drag area, alpha"
        )
        for name, one in card[key].items():
            cover = ["/".join(f"{100 * c:.1f}" for c in one["coverage"][p].values()) for p in ("drag_area", "alpha")]
            lines.append(
                f"{name:22s} {one['log_density']:7.3f} {one['cd_mae']:7.4f} {one['alpha_mae']:7.4f}  "
                f"{cover[0]}  {cover[1]}  alarms {100 * one['false_alarms']:.2f}%"
            )
    restricted = {"restricted": "the paper's prior", "restricted_burn_uncertain": "the same, burn time 5% uncertain"}
    for key, title in restricted.items():
        for name, one in card.get(key, {}).items():
            lines.append(
                f"{title}, {name}: Cd MAE {one['cd_mae']:.4f} (exact {one['cd_mae_exact']:.4f}), alpha MAE "
                f"{one['alpha_mae']:.4f} (exact {one['alpha_mae_exact']:.4f}), KL {one['kl']:.3f} nats"
            )
    return lines
