"""The library of physical terms that a missing force may be made of."""

from collections.abc import Callable, Iterator
from dataclasses import dataclass

import numpy as np

from fieldkit.model.hyperprior import certified
from fieldkit.physics.effect import effects
from fieldkit.physics.state import State
from fieldkit.selection.force.climb import Missing
from fieldkit.shapes import Array, Float


@dataclass(frozen=True, slots=True)
class Term:
    """One physical term of the library: what it is, the effect it stands for (empty for none), and its unit.

    `luck` is the standard deviation by which single flights differ in it anyway, in its unit.
    """

    name: str
    effect: str
    unit: str
    column: Callable[[Missing], Float[Array, "time"]]
    luck: float = 0.0


def library() -> list[Term]:
    """Terms that a climb could show: those below, and the effects of the shelf that act as a force."""
    luck = {name: certified().sd(name, "flight") for name in ("drag", "thrust", "stretch")}
    fixed = [
        Term("drag", "", "share of Cd", lambda m: -m.drag, luck["drag"]),
        Term("thrust", "motor_thrust", "share of the thrust", lambda m: m.thrust, luck["thrust"]),
        Term(
            "longer burn",
            "thrust_curve",
            "share of the burn time",
            lambda m: -(m.thrust + m.track.time_from_liftoff * m.steepness),
            luck["stretch"],
        ),
        Term("rail", "rail_friction", "m/s^2", lambda m: np.where(m.track.height < m.rocket.rail_length, -1.0, 0.0)),
        Term("constant", "", "m/s^2", lambda m: np.ones(len(m.force))),
        Term("linear in speed", "", "1/s", lambda m: -m.track.speed),
        Term("gain of the accelerometer", "", "share of the push", lambda m: m.thrust - m.drag),
    ]
    return [*fixed, *_forces()]


def _forces() -> Iterator[Term]:
    """Effects of the shelf that bend the acceleration, at a strength of one."""
    for name, effect in effects().items():
        if effect.acceleration is None:
            continue

        def column(at: Missing, name: str = name) -> Float[Array, "time"]:
            force, track = effects()[name].acceleration, at.track
            assert force is not None
            one = np.ones(len(at.force))
            phases = [
                force(State(track.height, track.speed, at.drag, burning, at.rocket.air), one)
                for burning in (True, False)
            ]
            return np.where(at.burning, *phases)

        yield Term(effect.title, name, effect.unit, column)
