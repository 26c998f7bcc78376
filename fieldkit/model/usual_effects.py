"""The effects that every rocket has, with the priors of their usual strengths."""

import numpy as np

from fieldkit.model.rocket_model import Model, Term
from fieldkit.physics.effect import effects


def usual_terms(model: Model) -> list[Term]:
    """The terms of effects that every rocket has, on all flights; the learned hyperprior has them in its random
    effects."""
    if model.hyperprior.kind != "certified":
        return []
    every = np.ones(len(model.flights))
    usual = {name: (effect, effect.background) for name, effect in effects().items()}
    return [
        Term(f"usual {name}", effect, own.mean, own.sd, every, own.low, own.high)
        for name, (effect, own) in usual.items()
        if own is not None
    ]
