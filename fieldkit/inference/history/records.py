"""A history and what is weighed beside its model: what the network of whole histories is asked about."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass

from fieldkit.flight import Flight
from fieldkit.inference.history.placed_effects import PlacedEffect
from fieldkit.model.hyperprior import Hyperprior
from fieldkit.model.rocket_model import Model
from fieldkit.model.shared_prior import SharedPrior
from fieldkit.motors import Found

Candidates = Callable[[Model, Sequence[bool]], Sequence[PlacedEffect]]
"""What is weighed beside a model whose first flights have flown; given, because selection stands above inference."""


@dataclass(frozen=True, slots=True)
class History:
    """A rocket's flights in the order flown, with what they rest on, and one planned flight after them; or several
    plans, each as if it flew next, that differ in their motors alone and of which none or all fly on motors flown
    before."""

    flights: tuple[Flight, ...]
    found: tuple[Found, ...]
    used_in_fit: tuple[bool, ...]
    selection: Hyperprior
    forecast: Hyperprior
    shared: SharedPrior | None = None
