"""The forecast of one planned flight: draws of its readouts, and the data they are based on.

Derivation: figures are quantiles of the draws; a stretch acts on the log ratio of a draw to their median.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field, replace

import numpy as np

from fieldkit.flight import Flight
from fieldkit.motors import Found
from fieldkit.shapes import Array, Float

LEVELS = np.array([0.05, 0.5, 0.95])


@dataclass(frozen=True, slots=True)
class Prediction:
    """The forecast of a planned flight: draws of the apogee and of other figures. SI.

    `coast` is from top speed to apogee, `coast_time` from burnout, `rise_time` from lift-off; `eject` is from apogee to
    the ejection charge (nan without a delay), `cut_short` by how much a charge before apogee shortens the climb,
    `duration` from lift-off to landing under the parachute of the plan, `drift` and `across` are the positions of the
    apogee downwind and to the right of that, and `drift_speed` and `across_speed` the velocity there. `cd` and `alpha`
    are the drag coefficient and thrust factor, and `random_draws` the scatter of single flights by cause. `rests_on`
    counts the flights in the model's fit, and `heaviest_motor` is the largest loaded mass of a motor flown so far [kg].
    `stretched_by` is the factor on the width of both apogees from the results of `earlier_forecasts`, 1 if there are
    too few of them. `mixed_with` has the weight of each simpler method in the apogee, empty for the model alone. [1]
    `left_out` has a line for each flight that was not used, and for each outlier readout.
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
    heaviest_motor: float
    model: str
    stretched_by: float = 1.0
    earlier_forecasts: int = 0
    mixed_with: Mapping[str, float] = field(default_factory=dict)
    left_out: tuple[str, ...] = ()
    across: Float[Array, "draw"] = field(default_factory=lambda: np.zeros(1))
    cut_short: Float[Array, "draw"] = field(default_factory=lambda: np.zeros(1))
    drift_speed: Float[Array, "draw"] = field(default_factory=lambda: np.zeros(1))
    across_speed: Float[Array, "draw"] = field(default_factory=lambda: np.zeros(1))

    def apogee_quantiles(self) -> tuple[float, float, float]:
        """The 5, 50 and 95% quantiles of the apogee. [m]"""
        low, middle, high = quantiles(self.apogee, LEVELS).tolist()
        return low, middle, high

    def corrected(self, factor: float | None, earlier: int) -> "Prediction":
        """A copy with the log of the shown and of the true apogee stretched around their medians by a factor [1]; None
        changes nothing."""
        if factor is None:
            return self
        shown, true = (spread_out(draws, factor) for draws in (self.apogee, self.true_apogee))
        return replace(self, apogee=shown, true_apogee=true, stretched_by=factor, earlier_forecasts=earlier)

    def mixed(self, mixture: Float[Array, "draw"], weights: Mapping[str, float]) -> "Prediction":
        """A copy whose apogees are the draws of a mixture [m], in the order of its own, so that high draws stay high in
        every figure; the true apogee changes by the same factor. `weights` are those of the simpler methods. [1]"""
        rank = np.argsort(np.argsort(self.apogee, kind="stable"))
        shown = np.sort(mixture)[rank]
        factor = np.divide(shown, self.apogee, out=np.ones_like(shown), where=self.apogee > 0)
        return replace(self, apogee=shown, true_apogee=self.true_apogee * factor, mixed_with=weights)

    def narrowed(self, more: float) -> float:
        """The expected ratio of the 90% interval's width after this number of further clean flights like the plan to
        its present width. [1]

        The scatter of flights stays; the uncertainty of common terms falls like the variance of a normal mean: with the
        squared width q of the scatter and t of the rest, to t / (1 + n t / q) after n flights (Gelman et al., Bayesian
        Data Analysis, 3rd edition, 2013, section 2.5). The logarithm of the apogee is taken as linear in all terms, and
        the squared widths of independent parts add; so the ratio is at most one, whatever the draws. Widths are those
        of intervals, because a thousand draws determine the variance of a Student t poorly. The size
        of the scatter is taken as known; for a new rocket it is not, and the interval narrows more.
        """
        scatter, rest = self._scatter_and_rest()
        stays, left = interval_width(scatter) ** 2, interval_width(rest) ** 2
        if not stays + left:
            return 1.0
        shrunk = 1 / (1 + more * left / stays) if stays else float(more == 0)
        return float(np.sqrt((stays + shrunk * left) / (stays + left)))

    def _scatter_and_rest(self) -> tuple[Float[Array, "draw"], Float[Array, "draw"]]:
        """The part of the log apogee that the scatter of single flights explains, by regression, and the rest, both
        centered, over the draws that leave the pad."""
        flown = self.apogee > 0
        logs = np.log(self.apogee[flown])
        if len(logs) <= len(self.random_draws):
            return np.zeros(0), np.zeros(0)
        causes = np.stack(self.random_draws, axis=-1)[flown]
        logs, causes = logs - logs.mean(), causes - causes.mean(axis=0)
        scatter = causes @ np.linalg.lstsq(causes, logs, rcond=None)[0]
        return scatter, logs - scatter

    @property
    def after_apogee(self) -> Float[Array, "draw"]:
        """Time from the apogee that is reached without a charge to the charge; nan without a delay. [s]"""
        return self.eject - self.cut_short

    @property
    def median_eject(self) -> float | None:
        """Median of `after_apogee`; None without a delay. [s]"""
        return median(self.after_apogee)

    @property
    def stays_on_rail(self) -> bool:
        """Whether in most draws the rocket does not leave the rail."""
        return not np.median(np.nan_to_num(self.rail_speed)) > 0

    @property
    def grounded(self) -> float:
        """Probability that the rocket flies and hits the ground before its charge fires. [1]"""
        return float(np.mean(~np.isfinite(self.eject_speed) & (self.true_apogee > 0)))


def model_in_words(name: str) -> str:
    """The model of a forecast by its name, `field` or `field+wind`: `without a correction`, `the model with wind`."""
    added = name.split("+")[1:]
    return f"the model with {' and '.join(added)}" if added else "without a correction"


def quantiles(draws: Float[Array, "draw"], levels: Float[Array, "level"]) -> Float[Array, "level"]:
    """The same as np.quantile, in the unit of the values; np.quantile is slower and imports masked arrays."""
    return np.interp(levels * (len(draws) - 1), np.arange(len(draws)), np.sort(draws))


def interval_width(draws: Float[Array, "draw"]) -> float:
    """Distance from the 5% to the 95% quantile, in the unit of the draws; 0 without draws."""
    return float(np.ptp(quantiles(draws, LEVELS))) if len(draws) else 0.0


def spread_out(apogee: Float[Array, "draw"], factor: float) -> Float[Array, "draw"]:
    """Draws of an apogee stretched around their median in the logarithm; draws that stay on the pad do not change.
    [m]"""
    flown = apogee > 0
    if factor == 1.0 or not flown.any():
        return apogee
    middle = quantiles(apogee[flown], LEVELS)[1]
    return np.where(flown, middle * (np.where(flown, apogee, middle) / middle) ** factor, apogee)


def median(values: Float[Array, "draw"]) -> float | None:
    """The median of the draws with a value, in their unit; None if there are none."""
    finite = values[np.isfinite(values)]
    return float(quantiles(finite, LEVELS)[1]) if len(finite) else None
