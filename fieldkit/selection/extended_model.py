"""The model of a rocket with its accepted effects and patterns."""

from collections.abc import Sequence

from fieldkit.model.documents import SEARCH_PRIOR
from fieldkit.model.hyperprior import Hyperprior
from fieldkit.model.rocket_model import Model, base_model, usual_terms
from fieldkit.model.shared_prior import SharedPrior
from fieldkit.physics.effect import effects
from fieldkit.physics.history import History
from fieldkit.selection.candidates import Place, effect_terms
from fieldkit.selection.patterns import pattern_terms


def rocket_model(
    history: History,
    accepted: Sequence[Place] = (),
    hyperprior: Hyperprior = SEARCH_PRIOR,
    shared: SharedPrior | None = None,
) -> Model:
    """The model of a rocket with its accepted effects and patterns; other arguments as in `base_model`.

    Patterns come from the flown flights. With the certified hyperprior, the effects that
    every rocket has are terms of the model; the learned hyperprior has them in its random effects. Raises
    ImpossibleFlight for a flight without a dry mass.
    """
    model = base_model(history, hyperprior, shared)
    model = model.with_terms(*usual_terms(model))
    known = [place for place in accepted if place.effect in effects() or place.switched]
    patterns = [place for place in accepted if not place.effect]
    terms = [
        *(effect_terms(place, model) for place in known),
        *(pattern_terms(place, model) for place in patterns),
    ]
    return model.with_terms(*(term for some in terms for term in some))
