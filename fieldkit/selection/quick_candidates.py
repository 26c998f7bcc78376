"""Candidates of the quick search: every effect in every place, and patterns in drag or in mass."""

import numpy as np

from fieldkit.model.rocket_model import Model, Term
from fieldkit.model.term_names import TermName
from fieldkit.selection.candidates import Candidate, Place, effect_candidates
from fieldkit.selection.patterns import known_patterns

PATTERN_SDS = {"drag": 0.2, "mass": 0.1}
"""Prior standard deviations of a pattern's shift of log drag and of relative mass. [1]"""


def quick_candidates(model: Model) -> list[Candidate]:
    """Candidates for a model of flown flights and plans.

    Each acts on plans as if they flew next. Only the full search tries patterns with several components.
    """
    history, flown = model.history, model.history.flown
    past = np.array([*history.used_in_fit, *[False] * (len(history.flights) - flown)], bool)
    found = list(effect_candidates(model, past, min_flights=0))  # as the network was trained
    weighed = [
        {pattern: weigh(history.flights) for pattern, weigh in kind.items()}
        for kind in known_patterns(history.flights[:flown])
    ]
    simple = [{pattern: weight for pattern, weight in kind.items() if weight.ndim == 1} for kind in weighed]
    kinds = [kind for kind in simple if kind]
    for kind in kinds:
        log_prior = float(-np.log(len(kind) * len(kinds) * len(PATTERN_SDS)))
        for pattern, weight in kind.items():
            for bends, sd in PATTERN_SDS.items():
                term = Term(TermName(bends, "pattern", pattern), bends, 0.0, sd, weight)
                found.append(Candidate(Place(pattern=pattern), (term,), log_fraction=log_prior))
    return found
