"""Steps from the paper's physics to certified motors in real air, and the change of the errors by each step.

The estimator is the same in all steps: the exact posterior mean of Cd and alpha under the paper's prior, given the
apogee alone. So only the physics changes the errors.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from fieldkit.motors import catalogue
from fieldkit.physics import paper
from fieldkit.physics.flight import apogees
from fieldkit.physics.history import field_setup
from fieldkit.physics.setups import delays
from fieldkit.physics.state import Setup
from fieldkit.physics.thrust_steps import Burns
from fieldkit.reference.exact import exact_means, lowest_in
from fieldkit.reference.flights import Reference, certified, normalised
from fieldkit.reference.report import carry_over, leave_one_out
from fieldkit.shapes import Array, Float

Each = Float[Array, "*draw flight"]
SetupOf = Callable[[Reference, Each, Each], Setup]
"""Builds a setup of the flights, each with a separate Cd and alpha."""


@dataclass(frozen=True, slots=True)
class World:
    """Physics assumptions for the reference flights; the title states the change from the previous ones."""

    key: str
    title: str
    build: SetupOf

    def heights(self, flights: Reference, cd: Each, alpha: Each) -> Each:
        """Apogees, each flight with a separate Cd and alpha. [m]"""
        return apogees(self.build(flights, cd, alpha))


@dataclass(frozen=True, slots=True)
class AssumptionStep:
    """The flights under one set of assumptions: apogees reconstructed from their own, and forecast from the others'.
    [m]"""

    world: World
    rebuilt: Float[Array, "flight"]
    left_out: Float[Array, "flight"]
    below: int
    """Number of flights below the lowest apogee that the prior can produce."""


def worlds() -> list[World]:
    """The steps, the paper's own physics first."""
    published, scaled = paper.paper_burns(), normalised()
    return [
        World("published", "as published", _paper(published)),
        World("E35", "profile of the E35 scaled to its certified impulse", _paper(_mixed(published, scaled, (0,)))),
        World("F24", "profile of the F24 scaled too", _paper(_mixed(published, scaled, (0, 1)))),
        World("F39", "profile of the F39 scaled too", _paper(scaled)),
        World("certified", "certified thrust curves", _paper(certified())),
        World("casing", "the motor's casing weighed too", _paper(certified(casing=True))),
        World("ejection", "ejection by the delay in the motor's name", _paper(certified(casing=True), delay=True)),
        World("field", "standard air, its pressure gradient, standard gravity, a rail", _field),
    ]


def step(world: World, flights: Reference) -> AssumptionStep:
    """The flights reconstructed and forecast under one set of assumptions."""

    def fly(cd: Each, alpha: Each) -> Each:
        return world.heights(flights, cd, alpha)

    cd, alpha = exact_means(flights, fly)
    forecast = carry_over(cd, alpha, world.heights)
    return AssumptionStep(
        world,
        fly(cd, alpha),
        leave_one_out(flights, forecast, np.arange(len(flights))),
        int((flights.apogee < lowest_in(flights, fly)).sum()),
    )


def _mixed(one: Burns, other: Burns, motors: tuple[int, ...]) -> Burns:
    """The first curves, with those of some motors from the second, on the same time steps."""
    mixed = {}
    for name in one.__dataclass_fields__:
        values, others = getattr(one, name), getattr(other, name)
        if values is None:  # none of these motors changes the drag
            continue
        chosen = values.copy()
        chosen[..., list(motors)] = others[..., list(motors)]
        mixed[name] = chosen
    return replace(one, **mixed)


def _paper(curves: Burns, *, delay: bool = False) -> SetupOf:
    def build(flights: Reference, cd: Each, alpha: Each) -> Setup:
        setup = paper.paper_setup(flights.motor, flights.dry_mass, cd, alpha, curves=curves)
        return setup.with_changes(delay=named_delays(flights)) if delay else setup

    return build


def _field(flights: Reference, cd: Each, alpha: Each) -> Setup:
    found = [catalogue().resolve(flight.motor) for flight in flights.flights]
    return field_setup(flights.flights, found, np.pi / 4 * paper.DIAMETER**2 * cd, alpha)


def named_delays(flights: Reference) -> Float[Array, "flight"]:
    """Delay from burnout to ejection in the motor's name; nan if there is none. [s]"""
    return delays(flights.flights, [catalogue().resolve(flight.motor) for flight in flights.flights])
