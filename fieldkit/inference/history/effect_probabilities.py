"""The probabilities of effects from one linear pass: closed-form evidence of every effect in every place, alone and
beside each other, with the model and the prior of the loop.

Derivation: Bayes' theorem, in `fieldkit.inference.evidence`, and here over the sets of at most two effects, with
independent prior odds; the evidence of two effects is the product of their own, times that of one beside the other
relative to that alone.
"""

from collections.abc import Collection, Mapping
from dataclasses import dataclass, replace
from itertools import combinations

import numpy as np

from fieldkit.inference.history.evidence import Trials, conditional, weigh_placed
from fieldkit.inference.history.linear_fit import (
    LinearFit,
    history_model,
    linear_fit,
    on_one_new_motor,
    prepared_fit,
    robust,
)
from fieldkit.inference.history.placed_effects import Candidates, PlacedEffect, directions
from fieldkit.inference.history.response import FlightResponse, respond
from fieldkit.inference.laplace.leave_one_out import LeaveOneOut, leave_one_out
from fieldkit.model.documents import SEARCH_PRIOR
from fieldkit.model.readout_data import Data, as_compared, readings
from fieldkit.physics.effect import Effect
from fieldkit.physics.history import History
from fieldkit.shapes import Array, Float


@dataclass(frozen=True, slots=True)
class EffectProbabilities:
    """What a linear pass says of a rocket's effects.

    `inclusion` is the probability of each effect that these flights can show, `none` the probability that nothing is
    missing, and `unexplained` that of a pattern that no effect represents; effects do not exclude each other. [1]
    `linear` is the fit of the model without effects, with normal residuals, and `left_out` are its leave-one-out
    forecasts; in the evidence of `trials` outliers have smaller weights.
    """

    inclusion: Mapping[str, float]
    none: float
    unexplained: float
    linear: LinearFit
    trials: Trials
    candidates: tuple[PlacedEffect, ...]
    data: Data
    left_out: LeaveOneOut
    response: FlightResponse


def effect_probabilities(
    history: History,
    candidates_of: Candidates,
    inclusion: Mapping[str, float],
    unexplained: str,
    also: Collection[str] = (),
) -> EffectProbabilities:
    """The probabilities of a history's effects; `inclusion` has their prior probabilities, that of a pattern under the
    name `unexplained`. `also` names effects whose response is simulated in the same batch for other uses.

    Raises ImpossibleFlight for a flight without a dry mass.
    """
    model = history_model(history, SEARCH_PRIOR, declared=False)
    # an effect of a motor is equally probable for each new one
    candidates = tuple(candidates_of(replace(model, history=on_one_new_motor(history))))
    terms = [*model.terms, *(term for candidate in candidates for term in candidate.terms)]
    response = respond(history, {*also, *(term.name.quantity for term in terms if isinstance(term.bends, Effect))})
    read = readings(history.flights[: history.flown], history.found[: history.flown])
    data = as_compared(read, history.used_in_fit, model.hyperprior)
    plain = linear_fit(prepared_fit(model, history.flown), data, response)
    trials = weigh_placed(robust(plain), directions(candidates))
    odds, none = odds_of(trials, {**inclusion, "": inclusion[unexplained]})
    chances = {name: _probability(own) for name, own in odds.items()}
    return EffectProbabilities(
        {name: chance for name, chance in chances.items() if name},
        _probability(none),
        chances.get("", 0.0),
        plain,
        trials,
        candidates,
        data,
        leave_one_out(plain.fit),
        response,
    )


def odds_of(trials: Trials, inclusion: Mapping[str, float]) -> tuple[dict[str, float], float]:
    """The log odds of each family of trials, by its name, and of none, from sets of at most two [nat]; `inclusion` are
    the prior probabilities of the families."""
    groups = families(trials)
    weight = trials.weight
    leaders = [max(rows, key=lambda row: float(weight[row])) for rows in groups.values()]
    bayes = np.array([np.logaddexp.reduce(weight[rows]) for rows in groups.values()])
    chance = np.array([inclusion[name] for name in groups])
    prior = np.log(chance) - np.log1p(-chance)
    each, none = log_odds(prior, bayes, conditional(trials, leaders) if leaders else np.empty((0, 0)))
    return dict(zip(groups, each.tolist(), strict=True)), none


def families(trials: Trials) -> dict[str, list[int]]:
    """Rows of trials by the name in a verdict; patterns have an empty name."""
    found: dict[str, list[int]] = {}
    for row, name in enumerate(trials.family):
        found.setdefault(name, []).append(row)
    return found


def _probability(odds: float) -> float:
    return float(1 / (1 + np.exp(-np.clip(odds, -500.0, 500.0))))


def log_odds(
    log_prior_odds: Float[Array, "effect"], log_bayes: Float[Array, "effect"], beside: Float[Array, "effect effect"]
) -> tuple[Float[Array, "effect"], float]:
    """The log odds that each effect is present, and that none is. [nat]

    `log_prior_odds` are those of each effect before the flights, `log_bayes` is its log Bayes factor, and `beside` that
    of each beside each other, alone on the diagonal.
    """
    count = len(log_bayes)
    if not count:
        return np.zeros(0), 0.0
    own = log_prior_odds + log_bayes
    pairs = np.array(list(combinations(range(count), 2)), int).reshape(-1, 2)
    first, second = pairs.T
    weights = np.r_[0.0, own, own[first] + own[second] + beside[first, second] - beside[first, first]]
    has = np.zeros((len(weights), count), bool)
    has[1 : count + 1] = np.eye(count, dtype=bool)
    has[np.arange(count + 1, len(weights)), first] = has[np.arange(count + 1, len(weights)), second] = True
    there = np.logaddexp.reduce(np.where(has, weights[:, None], -np.inf), axis=0)
    absent = np.logaddexp.reduce(np.where(has, -np.inf, weights[:, None]), axis=0)
    return there - absent, float(-np.logaddexp.reduce(weights[1:]))
