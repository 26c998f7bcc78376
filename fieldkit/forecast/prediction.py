"""The forecast of one planned flight: draws of what the altimeter will show, and what they rest on."""

from dataclasses import dataclass, field, replace

import numpy as np

from fieldkit.flight import Flight
from fieldkit.motors import Found
from fieldkit.shapes import Array, Float

LEVELS = np.array([0.05, 0.5, 0.95])


@dataclass(frozen=True, slots=True)
class Prediction:
    """What the altimeter will show of a planned flight, as draws of the apogee and figures drawn with it. SI.

    `coast` is from top speed to apogee, `coast_time` from burnout, `rise_time` from lift-off; `eject` is from apogee to
    the ejection charge (nan without a delay), `duration` from lift-off to landing under the parachute of the plan,
    `drift` how far downwind the apogee lies, `across` how far to the right of that, `drift_speed` and
    `across_speed` how fast it still moves there. `cd` and `alpha` are the drag coefficient and thrust factor flown
    with, `random_draws` what single flights differ by, cause by cause. `rests_on` counts the flights that were fitted
    by the model. `stretched_by` is by what the spread of `apogee` was multiplied because of how `earlier_forecasts`
    fared, 1 if there are too few of them. `left_out` has a line for each flight that was not used, and for each
    readout that is an outlier and hardly counts.
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
    random_draws: tuple[Float[Array, "draw"], ...]
    rests_on: int
    model: str
    stretched_by: float = 1.0
    earlier_forecasts: int = 0
    left_out: tuple[str, ...] = ()
    across: Float[Array, "draw"] = field(default_factory=lambda: np.zeros(1))
    drift_speed: Float[Array, "draw"] = field(default_factory=lambda: np.zeros(1))
    across_speed: Float[Array, "draw"] = field(default_factory=lambda: np.zeros(1))

    def apogee_quantiles(self) -> Float[Array, "level"]:
        """At 5, 50 and 95 %. [m]"""
        return quantiles(self.apogee, LEVELS)

    def corrected(self, factor: float | None, earlier: int) -> "Prediction":
        """The same with the spread of the apogee multiplied about its median, by ratio; None changes nothing."""
        if factor is None:
            return self
        return replace(self, apogee=spread_out(self.apogee, factor), stretched_by=factor, earlier_forecasts=earlier)

    def narrowed(self, more: float) -> float:
        """How wide the 90 % interval would be, over what it is, after so many more clean flights like the plan. [1]

        What flights differ by stays; what is common to all and not known yet falls as a normal mean's variance does
        (with q the squared width of what stays and t that of the rest, to t / (1 + n t / q) after n; Gelman et al.,
        Bayesian Data Analysis, 3rd edition, 2013, section 2.5), the logarithm of the apogee being about linear in all
        of it. Widths are those of intervals: of a variance with a Student t's tails a thousand draws say little. How
        much flights scatter is taken as known: of a new rocket it is not, and its interval narrows more.
        """
        luck, rest = self._luck_and_rest()
        stays, left = interval_width(luck) ** 2, interval_width(rest) ** 2
        if not stays + left:
            return 1.0
        shrunk = 1 / np.sqrt(1 + more * left / stays) if stays else float(more == 0)
        return float(interval_width(luck + shrunk * rest) / interval_width(luck + rest))

    def _luck_and_rest(self) -> tuple[Float[Array, "draw"], Float[Array, "draw"]]:
        """The part of the logarithm of the apogee that the random draws of single flights explain, by regression, and
        the rest of it, each about zero, over the draws that fly."""
        flown = self.apogee > 0
        logs = np.log(self.apogee[flown])
        if len(logs) <= len(self.random_draws):
            return np.zeros(0), np.zeros(0)
        causes = np.stack(self.random_draws, axis=-1)[flown]
        logs, causes = logs - logs.mean(), causes - causes.mean(axis=0)
        luck = causes @ np.linalg.lstsq(causes, logs, rcond=None)[0]
        return luck, logs - luck

    @property
    def median_eject(self) -> float | None:
        """From apogee to the ejection charge, or None without a delay. [s]"""
        return median(self.eject)


def quantiles(draws: Float[Array, "draw"], levels: Float[Array, "level"]) -> Float[Array, "level"]:
    """As np.quantile has them, which is slower and wakes numpy's masked arrays."""
    return np.interp(levels * (len(draws) - 1), np.arange(len(draws)), np.sort(draws))


def interval_width(draws: Float[Array, "draw"]) -> float:
    """From the 5 % to the 95 % quantile; 0 without draws."""
    return float(np.ptp(quantiles(draws, LEVELS))) if len(draws) else 0.0


def spread_out(apogee: Float[Array, "draw"], factor: float) -> Float[Array, "draw"]:
    """Draws of an apogee moved away from their median, by ratio; draws that stay on the pad are unchanged."""
    flown = apogee > 0
    if factor == 1.0 or not flown.any():
        return apogee
    middle = quantiles(apogee[flown], LEVELS)[1]
    return np.where(flown, middle * (np.where(flown, apogee, middle) / middle) ** factor, apogee)


def median(values: Float[Array, "draw"]) -> float | None:
    """The median of the draws that have a value, or None."""
    finite = values[np.isfinite(values)]
    return float(quantiles(finite, LEVELS)[1]) if len(finite) else None
