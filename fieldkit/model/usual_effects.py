"""The effects that every rocket has, with the priors of their usual strengths."""

import numpy as np

from fieldkit.model.rocket_model import Model, Term, strength_term
from fieldkit.model.term_names import TermName
from fieldkit.physics.effect import effects


def usual_terms(model: Model) -> list[Term]:
    """The terms of effects that every rocket has, on all flights; the learned hyperprior has them in its random
    effects."""
    if model.hyperprior.kind != "certified" and not model.hyperprior.documents:
        return []
    every = np.ones(len(model.flights))
    return [
        strength_term(TermName(name, "usual"), effect, every, effect.background)
        for name, effect in effects().items()
        if effect.background is not None
    ]
