"""The probabilities of effects in a quick answer before and after they are pooled: the network's, the closed-form
ones, and the pool."""

from collections.abc import Collection, Iterator, Mapping, Sequence
from typing import Any

import numpy as np

from fieldkit.inference.history.columns import ODDS
from fieldkit.inference.history.features import feature_names
from fieldkit.inference.network.ensemble import Ensemble
from fieldkit.inference.network.history import QuickAnswer
from fieldkit.inference.network.history_parts import answer
from fieldkit.inference.validation.history import auc
from tools.markdown import table

Opinions = Mapping[str, Mapping[str, float]]
"""The probability of each effect, by its source. [1]"""
WORLDS = {"simulated": "simulated, certified hyperprior", "bench": "bench"}


def opinions(found: QuickAnswer, network: Ensemble) -> Opinions:
    """The probabilities of a quick answer by their sources."""
    names = tuple(network.card["effects"])
    features = found.summary.features[:1]
    alone = answer(network.members(features), len(names)).inclusion[0]
    columns = feature_names(names)
    odds = {name: float(features[0, columns.index(f"{name}.{ODDS}")]) for name in found.inclusion}
    return {
        "pool": found.inclusion,
        "network alone": {name: float(alone[names.index(name)]) for name in found.inclusion},
        "closed form alone": {name: 1 / (1 + float(np.exp(-own))) for name, own in odds.items()},
    }


def scores(judged: Sequence[tuple[Opinions, Collection[str]]]) -> dict[str, dict[str, float]]:
    """AUC [1] and mean log score [nat] of each source over all effects of all histories, with those present."""
    found: dict[str, dict[str, float]] = {}
    for way in judged[0][0] if judged else ():
        pairs = [(chance, name in present) for some, present in judged for name, chance in some[way].items()]
        chance, there = np.array([pair[0] for pair in pairs]), np.array([pair[1] for pair in pairs], float)
        limited = np.clip(chance, 1e-9, 1 - 1e-9)
        log_score = np.where(there > 0, np.log(limited), np.log1p(-limited)).mean()
        found[way] = {"auc": auc(chance, there), "log_score": float(log_score), "effects": float(there.sum())}
    return found


def compared(measurements: Mapping[str, Mapping[str, Any]]) -> Iterator[str]:
    """A table of the sources, by the name of their histories."""
    yield from table(
        ("probabilities", "histories", "effects present", "AUC", "log score [nat]"),
        (
            (way, WORLDS[world], f"{one['effects']:.0f}", f"{one['auc']:.3f}", f"{one['log_score']:.4f}")
            for world, found in measurements.items()
            for way, one in found.items()
        ),
    )
