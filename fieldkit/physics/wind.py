"""The wind profile from the wind at the pad and the wind aloft."""

from dataclasses import dataclass

import numpy as np

from fieldkit.physics.atmosphere import WIND_EXPONENT, WIND_HEIGHT, wind_at
from fieldkit.shapes import Array, Float


@dataclass(frozen=True, slots=True)
class WindProfile:
    """Wind profile: the wind at the pad [m/s] and, if known, aloft [m/s] at a height [m], turned to the right by an
    angle [rad]. Between them it follows the power law through both; above, it is constant. Without a wind aloft the
    exponent is that of open ground (e.g. Panofsky and Dutton, 1984)."""

    surface: float = 0.0
    aloft: float | None = None
    aloft_height: float | None = None
    turn: float = 0.0

    @property
    def law(self) -> tuple[float, float]:
        """Exponent of the power law through the winds at the pad and aloft [1], and the height above which the wind is
        constant [m]; the values for open ground if either is unknown or calm."""
        if not self.aloft_height or not self.aloft or self.aloft < 0 or self.surface <= 0:
            return WIND_EXPONENT, np.inf
        return float(np.log(self.aloft / self.surface) / np.log1p(self.aloft_height / WIND_HEIGHT)), self.aloft_height

    def components(self, height: Float[Array, "level"]) -> tuple[Float[Array, "level"], Float[Array, "level"]]:
        """Wind components along the wind at the pad and to its right, at heights above the pad [m]. [m/s]"""
        height = np.maximum(height, 0.0)
        if self.aloft is None or self.aloft_height is None:
            speed = wind_at(height, np.array(self.surface))
            return np.asarray(speed), np.zeros_like(speed)
        place = np.minimum(height / self.aloft_height, 1.0)
        if self.surface > 0 and self.aloft > 0:
            speed = wind_at(height, np.array(self.surface), *self.law)
        else:
            speed = self.surface + place * (self.aloft - self.surface)
        angle = self.turn * place
        return np.asarray(speed * np.cos(angle)), np.asarray(speed * np.sin(angle))
