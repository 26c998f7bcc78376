"""An effect: one thing the plain flight model lacks, with a strength that is zero when it is not there.

It bends the set-up before the flight, the acceleration in it, or the reading after. Effects are files in
`models/effects/`, each binding `EFFECT`; nothing else needs to know of them.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Literal, cast

import numpy as np

from fieldkit.flight import Flight
from fieldkit.physics.state import Force, Setup
from fieldkit.plugins import plugins
from fieldkit.shapes import Array, Flags, Float

Family = Literal["path", "launch", "recovery", "air", "mass", "motor", "drag", "aging", "device"]
"""What an effect is about: the path through wind, leaving the rail, the delay and parachute, the air, the mass, the
motor, the law of drag, change with use, or the instrument. Prior probability is shared equally between families."""
Strength = Float[Array, "*#draw"]
BendSetup = Callable[[Setup, Strength, Sequence[Flight]], Setup]
Readings = Mapping[str, Float[Array, "*#draw"]]
BendReading = Callable[[Readings, Strength], Readings]


@dataclass(frozen=True, slots=True)
class Prior:
    """What is believed of a strength before any flight: a normal distribution cut off at its bounds."""

    mean: float
    sd: float
    low: float = -np.inf
    high: float = np.inf


@dataclass(frozen=True, slots=True, eq=False)
class ClimbForces:
    """A climb as a log shows it, sample by sample, beside the model's forces per mass there. SI.

    Heights are above the pad, `steepness` is the rate of change of thrust per mass [m/s^3], `drag` deceleration by drag
    [m/s^2], `coasting` whether the motor is out.
    """

    time_from_liftoff: Float[Array, "time"]
    height: Float[Array, "time"]
    thrust: Float[Array, "time"]
    steepness: Float[Array, "time"]
    drag: Float[Array, "time"]
    coasting: Flags
    rail_length: float


@dataclass(frozen=True, slots=True)
class LoggedForce:
    """What an effect that bends the set-up adds to the force along a logged climb.

    `name` is that of the term, `per_mass` the force at a strength of one [m/s^2]. `scatter` says what of the set-up
    single flights differ in anyway (`SCATTER` of the model, by what it bends) that looks the same; empty for nothing.
    """

    name: str
    per_mass: Callable[[ClimbForces], Float[Array, "time"]]
    scatter: str = ""


@dataclass(frozen=True, slots=True)
class Effect:
    """One bend of the flight model.

    `family` is what it is about. `prior` and the strength are in `unit`; if what the effect does grows with the
    square of its strength (`squared`), the square is fitted, and the prior is of the square. `per` says what kind of
    group of flights may have a strength of its own, `everywhere` whether it may also act on all flights equally, `each`
    whether every group has its own at once. `needs` is the column without which the effect cannot act; if it is
    `declared`, it acts with its prior on forecasts of every flight that has that column, accepted or not. `lacks` one
    that a flight must not have for it to act. An effect that is a `form_of` another is one more way in which that one
    may come about: verdicts speak of the other. One that `grows` acts with its strength times the flights flown before;
    one that `starts_anywhere` may be there only from some flight on, as with a new lot of motors or a new altimeter;
    if it is not there `from_first`, that is the only way. `background` is the prior of what every rocket has of
    it: a nuisance in every model, not something to be named. `starts` are strengths from which a fit is started,
    several if the effect is far from linear.
    `explains` describes it to a flyer, `tell_apart`
    what to fly or write down to be sure of it; `measured` is the standard deviation with which doing so on the
    ground gives the fitted value, 0 if it cannot. One that `needs_delay` acts on motors that have a delay alone.
    `logged` is how an effect on the set-up shows in the force that a log measures, None if it does not.
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
    logged: LoggedForce | None = None

    def strength(self, fitted: Strength) -> Strength:
        """The strength that belongs to a fitted value."""
        return np.sqrt(np.maximum(fitted, 0.0)) if self.squared else fitted

    def bend_setup(self, setup: Setup, strength: Strength, flights: Sequence[Flight]) -> Setup:
        """The set-up, and the forces in it, as this effect has them at a strength."""
        if self.setup is not None:
            setup = self.setup(setup, strength, flights)
        if self.acceleration is not None:
            setup = setup.with_changes(forces=(*setup.forces, (self.acceleration, strength)))
        return setup

    def bend_reading(self, readings: Readings, strength: Strength) -> Readings:
        """The readings as this effect shows them at a strength."""
        return readings if self.reading is None else self.reading(readings, strength)


def effects() -> Mapping[str, Effect]:
    """Every effect in the plug-in folder, by name."""
    return cast(Mapping[str, Effect], plugins("models.effects", "EFFECT"))


def spoken(name: str) -> str:
    """The name by which verdicts speak of an effect: its own, or that of the one it is a form of."""
    return effects()[name].form_of or name if name in effects() else name
