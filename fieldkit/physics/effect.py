"""An effect: one physical process that the plain flight model lacks, with a strength that is zero if it is absent.

An effect changes the setup before the flight, the acceleration during it, or the readings after it. Effects are files
in `models/effects/`, each of which defines `EFFECT`; no other code needs to know about them.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Literal, cast

import numpy as np

from fieldkit.physics.state import Force, Setup
from fieldkit.plugins import plugins
from fieldkit.shapes import Array, Float

Family = Literal["path", "launch", "recovery", "air", "mass", "motor", "drag", "aging", "device"]
"""The category of an effect: the path through the wind, leaving the rail, the delay and parachute, the air, the mass,
the motor, the drag law, change with use, or the instrument. Prior probability is split equally between families."""
SharedBy = Literal["motor_type", "lot", "day", "site", "device", "fleet"]
"""Groups of flights of several rockets that may differ by an effect together."""
Strength = Float[Array, "*#draw"]
BendSetup = Callable[[Setup, Strength], Setup]
Readings = Mapping[str, Float[Array, "*#draw"]]
BendReading = Callable[[Readings, Strength], Readings]


@dataclass(frozen=True, slots=True)
class Prior:
    """Prior of a strength: a normal distribution truncated at its bounds. Its unit is that of the effect."""

    mean: float
    sd: float
    low: float = -np.inf
    high: float = np.inf


@dataclass(frozen=True, slots=True)
class Effect:
    """One change to the flight model.

    `family` is its category. `prior` and the strength are in `unit`; if the effect is proportional to the square of its
    strength (`squared`), the square is fitted, and the prior is of the square. `per` is the kind of group of flights
    that may have its own strength, `everywhere` whether it may also act equally on all flights, `each` whether all
    groups get their own strengths together. `needs` is the column required for the effect to act; if `declared`, it
    acts with its prior on forecasts of every flight that has that column, accepted or not. `lacks` is a column that a
    flight must not have for it to act. An effect that is a `form_of` another is one more mechanism for it: verdicts
    report the other. If it `grows`, its strength is multiplied by the number of earlier flights. If it
    `starts_anywhere`, it may act only from some flight on, as with a new lot of motors or a new altimeter; if it is not
    there `from_first`, that is the only way. `background` is the prior of the amount that every rocket has: a nuisance
    parameter in every model, not an effect to report. `starts` are the initial strengths of a fit, several if the
    effect is strongly nonlinear. `explains` describes it to a flyer; `tell_apart` says what to fly or record to confirm
    it. `measured` is the standard deviation of the fitted value from a measurement on the ground, 0 if there is none.
    An effect with `needs_delay` acts only on motors with a delay. `quantity` is the quantity of the model to whose
    logarithm the strength adds, and `shared_by` the groups of flights of several rockets on which it may act equally;
    empty for an effect of one rocket. `says` are sentences for a negative and a positive strength, in which `{where}`
    is the group or the rocket, and `{amount}` the strength; without them `explains` stands in.
    """

    title: str
    family: Family
    explains: str
    unit: str
    prior: Prior
    source: str
    tell_apart: str
    setup: BendSetup | None = None
    acceleration: Force | None = None
    reading: BendReading | None = None
    per: Literal["", "motor", "config", "site", "day"] = ""
    everywhere: bool = True
    each: bool = False
    needs: str = ""
    declared: bool = False
    lacks: str = ""
    form_of: str = ""
    grows: bool = False
    starts_anywhere: bool = False
    from_first: bool = True
    background: Prior | None = None
    starts: tuple[float, ...] = ()
    squared: bool = False
    measured: float = 0.0
    needs_delay: bool = False
    quantity: str = ""
    says: tuple[str, str] | None = None
    shared_by: tuple[SharedBy, ...] = ()

    def strength(self, fitted: Strength) -> Strength:
        """The strength that corresponds to a fitted value."""
        return np.sqrt(np.maximum(fitted, 0.0)) if self.squared else fitted

    def bend_setup(self, setup: Setup, strength: Strength) -> Setup:
        """The setup, and the forces in it, as changed by this effect at a strength."""
        if self.setup is not None:
            setup = self.setup(setup, strength)
        if self.acceleration is not None:
            setup = setup.with_changes(forces=(*setup.forces, (self.acceleration, strength)))
        return setup

    def bend_reading(self, readings: Readings, strength: Strength) -> Readings:
        """The readings as changed by this effect at a strength."""
        return readings if self.reading is None else self.reading(readings, strength)


def effects() -> Mapping[str, Effect]:
    """Every effect in the plug-in folder, by name."""
    return cast(Mapping[str, Effect], plugins("models.effects", "EFFECT"))


def _switched(setup: Setup, strength: Strength) -> Setup:
    """Drag in the coast is higher by this fraction."""
    return setup.with_changes(power_off_drag=setup.power_off_drag * np.maximum(1 + strength, LEAST_DRAG))


LEAST_DRAG = 0.1
"""Smallest ratio of switched drag to a rocket's own. [1]"""
LOGGED_EFFECTS: Mapping[str, Effect] = {
    "drag_step": Effect(
        title="drag that switches in the coast",
        family="drag",
        explains="drag switches within the coast of some flights: air brakes, a part that moves or is lost, a streamer "
        "that is out early",
        unit="fraction of Cd",
        prior=Prior(mean=0.5, sd=0.5, low=-0.9, high=6.0),
        source="the logs of the coast (fieldkit.selection.drag_steps)",
        tell_apart="look for what moved in flight; record its state with each flight in a column drag_step: yes or no",
        setup=_switched,
    )
}
"""Effects that only logs of the climb show: not plug-ins, because from readouts alone they are ordinary drag."""


def effect_named(name: str) -> Effect:
    """An effect of the plug-in folder, or one that only logs show. Raises KeyError for another name."""
    return LOGGED_EFFECTS[name] if name in LOGGED_EFFECTS else effects()[name]


def spoken(name: str) -> str:
    """The name under which verdicts report an effect: its own, or that of the effect it is a form of."""
    return effects()[name].form_of or name if name in effects() else name
