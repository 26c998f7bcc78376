"""A history and the candidates for its model: the input of the history network."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass

from fieldkit.flight import Flight
from fieldkit.inference.history.placed_effects import PlacedEffect
from fieldkit.model.hyperprior import Hyperprior
from fieldkit.model.rocket_model import Model
from fieldkit.model.shared_prior import SharedPrior
from fieldkit.motors import Found

Candidates = Callable[[Model, Sequence[bool]], Sequence[PlacedEffect]]
"""A function that returns the candidates for a model with some flown flights; a parameter, because selection is a layer
above inference."""


@dataclass(frozen=True, slots=True)
class History:
    """A rocket's flights in the order flown, with their hyperpriors, and one planned flight after them, or several
    alternative plans that differ only in their motors. Either all or none of the plans use motors flown before.
    `shared` is the information from the flyer's other rockets, None if it is not used."""

    flights: tuple[Flight, ...]
    found: tuple[Found, ...]
    used_in_fit: tuple[bool, ...]
    selection: Hyperprior
    forecast: Hyperprior
    shared: SharedPrior | None = None
