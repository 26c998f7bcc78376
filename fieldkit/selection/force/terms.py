"""The library of physical terms for a missing force."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from fieldkit.model.certified_prior import CERTIFIED_PRIOR
from fieldkit.physics.effect import ClimbForces, LoggedForce, effects
from fieldkit.physics.state import Force, State
from fieldkit.selection.force.climb import Missing
from fieldkit.shapes import Array, Float

TermColumn = Callable[[Missing], Float[Array, "time"]]
"""The missing force along a climb for a strength of one in the term's unit. [m/s^2]"""


@dataclass(frozen=True, slots=True)
class ForceTerm:
    """One physical term of the library: its description, its effect (empty for none), and its unit.

    `random_draw_sd` is the standard deviation of the scatter of single flights in it, in its unit.
    """

    name: str
    effect: str
    unit: str
    column: TermColumn
    random_draw_sd: float = 0.0


def library() -> list[ForceTerm]:
    """Terms that a climb could show: those below, and the effects that act as a force or appear as one in a log."""
    random_draw_sd = {name: CERTIFIED_PRIOR.sd(name, "flight") for name in ("drag", "thrust", "stretch")}
    return [
        ForceTerm("drag", "", "fraction of Cd", lambda m: -m.drag, random_draw_sd["drag"]),
        *(
            ForceTerm(
                effect.logged.name,
                name,
                effect.unit,
                _seen(effect.logged),
                random_draw_sd.get(effect.logged.scatter, 0.0),
            )
            for name, effect in effects().items()
            if effect.logged is not None
        ),
        ForceTerm("constant", "", "m/s^2", lambda m: np.ones(len(m.force))),
        ForceTerm("linear in speed", "", "1/s", lambda m: -m.track.speed),
        ForceTerm("gain of the accelerometer", "", "fraction of thrust minus drag", lambda m: m.thrust - m.drag),
        *(
            ForceTerm(effect.title, name, effect.unit, _pushed(effect.acceleration))
            for name, effect in effects().items()
            if effect.acceleration is not None
        ),
    ]


def _seen(logged: LoggedForce) -> TermColumn:
    """The missing force along a climb by an effect on the setup with a strength of one. [m/s^2]"""

    def column(at: Missing) -> Float[Array, "time"]:
        track = at.track
        return logged.per_mass(
            ClimbForces(
                track.time_from_liftoff,
                track.height,
                at.thrust,
                at.steepness,
                at.drag,
                ~at.burning,
                at.rocket.rail_length,
            )
        )

    return column


def _pushed(force: Force) -> TermColumn:
    """The missing force along a climb by an effect on the acceleration with a strength of one. [m/s^2]"""

    def column(at: Missing) -> Float[Array, "time"]:
        track, one = at.track, np.ones(len(at.force))
        phases = [
            force(State(track.height, track.speed, at.drag, burning, at.rocket.air), one) for burning in (True, False)
        ]
        return np.where(at.burning, *phases)

    return column
