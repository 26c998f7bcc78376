"""Simple motors and setups for the laws of flight."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from fieldkit.physics.atmosphere import Air, pad_air
from fieldkit.physics.state import Setup
from fieldkit.physics.thrust_steps import STEPS, Curve, burns

DENSITY = 1.225
"""Air density at the pad in these setups. [kg/m^3]"""
EVEN_AIR = Air(np.asarray(DENSITY), np.asarray(288.15), 1e15)
"""Air with constant density."""
STANDARD_AIR = pad_air(*(np.asarray(np.nan) for _ in range(4)))


@dataclass(frozen=True)
class Push:
    """A motor with thrust linear between its knots."""

    time: Any
    thrust: Any
    propellant_mass: float = 0.0
    casing_mass: float = 0.0

    @property
    def burnout(self) -> float:
        return float(self.time[-1])


CONSTANT = Push((0.0, 1.5), (30.0, 30.0))
"""Constant thrust and negligible propellant."""
NOISY = Push((0.0, 0.1, 0.4, 1.5, 1.6), (0.0, 45.0, 30.0, 22.0, 0.0), 0.03, 0.02)
"""A thrust curve with a rise, a peak, a sag and a tail."""
LONG = Push((0.0, 0.2, 0.5, 4.0, 4.2), (0.0, 30.0, 14.0, 12.0, 0.0), 0.04, 0.03)


def rocket(motors: Curve | Sequence[Curve], steps: int = STEPS, **changes: Any) -> Setup:
    """A rocket of 0.4 kg and 20 cm^2 in standard air, with changes."""
    listed = motors if isinstance(motors, Sequence) else [motors]
    plain: dict[str, Any] = {"air": STANDARD_AIR, "dry_mass": 0.4, "drag_area": 0.002} | changes
    arrays = {k: np.asarray(v) if k not in ("air", "forces", "gravity", "pad_holds") else v for k, v in plain.items()}
    return Setup(burns=burns(listed, steps=steps), **arrays)
