"""The forecast of one planned flight: draws of what the altimeter will show, and what they rest on."""

from dataclasses import dataclass, replace

import numpy as np

from fieldkit.flight import Flight
from fieldkit.motors import Found
from fieldkit.shapes import Array, Float

LEVELS = np.array([0.05, 0.5, 0.95])


@dataclass(frozen=True, slots=True)
class Prediction:
    """What the altimeter will show of a planned flight, as draws of the apogee and figures drawn with it. SI.

    `coast` is from top speed to apogee, `coast_time` from burnout, `rise_time` from lift-off; `eject` is from
    apogee to the ejection charge (nan without a delay), `duration` from lift-off to landing under the parachute of
    the plan, `drift` how far downwind the apogee lies. `cd` and `alpha` are the drag coefficient and thrust factor
    flown with. `rests_on` counts the flights that taught the model. `stretched_by` is by what the spread of
    `apogee` was multiplied because of how `earlier_forecasts` fared, 1 where there are too few of them. `left_out` has
    a line for each readout that does not fit the rest of its flight and taught nothing.
    """

    plan: Flight
    found: Found
    apogee: Float[Array, "draw"]
    true_apogee: Float[Array, "draw"]
    eject: Float[Array, "draw"]
    coast: Float[Array, "draw"]
    top_speed: Float[Array, "draw"]
    rail_speed: Float[Array, "draw"]
    eject_speed: Float[Array, "draw"]
    coast_time: Float[Array, "draw"]
    rise_time: Float[Array, "draw"]
    duration: Float[Array, "draw"]
    drift: Float[Array, "draw"]
    cd: Float[Array, "draw"]
    alpha: Float[Array, "draw"]
    rests_on: int
    model: str
    stretched_by: float = 1.0
    earlier_forecasts: int = 0
    left_out: tuple[str, ...] = ()

    def apogee_quantiles(self) -> Float[Array, "level"]:
        """At 5, 50 and 95 %. [m]"""
        return quantiles(self.apogee, LEVELS)

    def widened(self, factor: float) -> "Prediction":
        """The same with draws of the apogee that lie further from their median, by ratio."""
        return replace(self, apogee=apart(self.apogee, factor), true_apogee=apart(self.true_apogee, factor))

    def corrected(self, factor: float | None, earlier: int) -> "Prediction":
        """The same with the spread of the apogee multiplied about its median, by ratio; None changes nothing."""
        if factor is None:
            return self
        return replace(self, apogee=apart(self.apogee, factor), stretched_by=factor, earlier_forecasts=earlier)

    @property
    def median_eject(self) -> float | None:
        """From apogee to the ejection charge, or None without a delay. [s]"""
        return median(self.eject)


def quantiles(draws: Float[Array, "draw"], levels: Float[Array, "level"]) -> Float[Array, "level"]:
    """As np.quantile has them, which is slower and wakes numpy's masked arrays."""
    return np.interp(levels * (len(draws) - 1), np.arange(len(draws)), np.sort(draws))


def apart(apogee: Float[Array, "draw"], factor: float) -> Float[Array, "draw"]:
    """Draws of an apogee further from their median, by ratio; those that stay on the pad are left there."""
    flown = apogee > 0
    if factor == 1.0 or not flown.any():
        return apogee
    middle = quantiles(apogee[flown], LEVELS)[1]
    return np.where(flown, middle * (np.where(flown, apogee, middle) / middle) ** factor, apogee)


def median(values: Float[Array, "draw"]) -> float | None:
    """The median of the draws that have a value, or None."""
    finite = values[np.isfinite(values)]
    return float(quantiles(finite, LEVELS)[1]) if len(finite) else None
