"""What a forecast of a rocket assumes beside its own flights, and the model of forecasts that follows.

Everything that a flyer is shown of a flight, forecast or flown, comes from this model.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from fieldkit.flight import Flight
from fieldkit.model.documents import with_documents
from fieldkit.model.high_power import closer_to_designs
from fieldkit.model.hyperprior import Hyperprior, learned
from fieldkit.model.rocket_model import Model
from fieldkit.model.shared_prior import SharedPrior
from fieldkit.model.term_names import TermName, fleet_term
from fieldkit.physics.effect import effects
from fieldkit.physics.history import History
from fieldkit.physics.setups import differs_from_zero
from fieldkit.selection.candidates import Averaged, Place
from fieldkit.selection.extended_model import rocket_model


@dataclass(frozen=True, slots=True)
class Assumed:
    """What is assumed of a rocket beside its own flights.

    `sets` are sets of effects in their places with their probabilities, over which forecasts are averaged; empty for
    none. Recorded wind acts with the prior of its effect, in a set or not, unless `declared` is False. `cds` are the
    drag coefficients of designs by configuration, which replace the prior mean of any rocket [1]. `shared` is the
    information from the flyer's other rockets; `hyperprior` is by default the learned one.
    """

    sets: Averaged = ()
    declared: bool = True
    cds: Mapping[str, float] = field(default_factory=dict)
    shared: SharedPrior | None = None
    hyperprior: Hyperprior | None = None

    def acting(self, flights: Sequence[Flight]) -> list[tuple[float, tuple[Place, ...]]]:
        """Each set with its probability [1] and what else acts on some of the flights."""
        sets = self.sets or ((1.0, ()),)
        return [(chance, (*own, *(declared_places(flights, own) if self.declared else ()))) for chance, own in sets]

    def model(self, history: History, places: Sequence[Place]) -> Model:
        """The model of a rocket's flights with effects in their places, in one order, so that equal models have equal
        fits. Raises ImpossibleFlight for a flight without a dry mass, DamagedModel for a damaged card."""
        shared = self.shared
        designs = {one.config: self.cds[one.config] for one in history.flights if one.config in self.cds}
        if designs and shared:  # a design replaces the information from other rockets about drag
            shared = shared.only(name for name in shared.names if name != fleet_term("drag"))
        model = forecast_model(history, sorted(places, key=str), shared, self.hyperprior)
        return designed(model, designs) if designs else model


FLIGHTS_ALONE = Assumed()
"""Nothing beside the flights, and recorded wind."""


def forecast_model(
    history: History,
    accepted: Sequence[Place] = (),
    shared: SharedPrior | None = None,
    hyperprior: Hyperprior | None = None,
) -> Model:
    """The model for forecasting a rocket's next flight, by default with the learned hyperprior; arguments as in
    `rocket_model`. Raises ImpossibleFlight for a flight without a dry mass, DamagedModel for a damaged card."""
    return rocket_model(history, accepted, with_documents(hyperprior or learned()), shared)


def designed(model: Model, cds: Mapping[str, float]) -> Model:
    """The model of a rocket with designs: each configuration has the Cd of its design as prior mean, and all share the
    error of the design, so flights of one configuration inform the others. The fleet's drag then has no effect. A
    design does not measure the area of a rocket without a diameter: what that adds to the variance of drag remains.
    On high-power motors, mass, thrust and apogee vary less."""
    usual = model.hyperprior.sd("drag", "rocket")
    extra = sum(term.sd**2 - usual**2 for term in model.terms if term.name == TermName("drag"))
    sd = float(np.sqrt(model.hyperprior.design_drag**2 + extra))
    logs = {config: float(np.log(cd)) for config, cd in cds.items()}
    middle = float(np.mean(list(logs.values())))
    fleet = fleet_term("drag")
    terms = tuple(
        replace(term, mean=0.0, weight=np.zeros_like(term.weight)) if term.name == fleet else term
        for term in model.terms
    )
    model = replace(model, terms=terms).with_prior(TermName("drag"), middle, sd)
    for config, log in logs.items():
        model = model.with_prior(TermName("drag", "config", config), log - middle)
    return closer_to_designs(model, cds)


def declared_places(flights: Sequence[Flight], accepted: Sequence[Place]) -> list[Place]:
    """Effects whose column is recorded and that no accepted effect replaces."""
    known = {place.effect for place in accepted}
    return [
        Place(name)
        for name, effect in effects().items()
        if effect.declared and name not in known and differs_from_zero(flights, effect.needs)
    ]
