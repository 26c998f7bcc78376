"""Drag and thrust of any flight from whichever readouts it has."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from fieldkit.errors import DamagedModel
from fieldkit.flight import Flight
from fieldkit.inference.network import outliers
from fieldkit.inference.network.ensemble import load
from fieldkit.inference.network.mixture import Margin, Mixture, mixture
from fieldkit.inference.network.vague import DRAWS, excess_sd, plausible
from fieldkit.messages import message, of_unit
from fieldkit.model.field_features import FEATURES, features
from fieldkit.model.observations import (
    ALPHA_RANGE,
    ALPHA_SD,
    CD_RANGE,
    INDEPENDENT_READOUTS,
    READOUT_NAMES,
    Observed,
    diameter_range,
    disc,
    drag_area_range,
    observe,
)
from fieldkit.motors import Found
from fieldkit.shapes import Array, Flags, Float

if TYPE_CHECKING:
    from fieldkit.inference.network.ensemble import Ensemble

UNINFORMATIVE_SD_RATIO = 0.8
"""If posterior over prior standard deviation is above this, the flight barely constrains the parameter. [1]"""
INTERVALS = {"cd": list(CD_RANGE), "alpha": list(ALPHA_RANGE)}
"""Bounds of Cd and alpha, as in a card. [1]"""
STRATA = 1024
"""Number of draws of an unknown diameter."""
GOLDEN = 0.6180339887498949
"""Multiples of this, modulo 1, fill an interval evenly."""
_WORDS = {
    "log_thrust_to_weight": ("thrust to weight of", ""),
    "log_impulse": ("total impulse of", "N s"),
    "log_burn_time": ("burn time of the motor of", "s"),
    "log_mass": ("lift-off mass of", "kg"),
    "log_drag_area": ("drag area around", "m²"),
    "mach": ("top speed around Mach", ""),
}


@dataclass(frozen=True, slots=True)
class FieldPosterior:
    """Drag and thrust of flights, one entry per flight; drag area [m^2], Cd and alpha [1].

    Without a diameter, Cd covers every body that the motor and the mass allow; the drag area is not affected. `fits` is
    false if a readout was an outlier and was left out: such a flight should be checked before it is used in a fit.
    `density` is over the logarithm of the drag area and alpha.
    """

    drag_area: Float[Array, "flight"]
    cd: Float[Array, "flight"]
    cd_sd: Float[Array, "flight"]
    alpha: Float[Array, "flight"]
    alpha_sd: Float[Array, "flight"]
    fits: Flags
    warnings: tuple[tuple[str, ...], ...]
    model: str
    density: Mixture

    def draws(
        self, rng: np.random.Generator, count: int
    ) -> tuple[Float[Array, "draw flight"], Float[Array, "draw flight"]]:
        """Draws of drag area [m^2] and alpha [1]."""
        drawn = self.density.draws(rng, count)
        return np.exp(drawn[..., 0]), drawn[..., 1]


def infer_field(
    flights: Sequence[Flight], found: Sequence[Found], ensemble: "Ensemble | None" = None
) -> FieldPosterior:
    """Drag and thrust of flights from any of their readouts, by default with the shipped ensemble.

    Raises ImpossibleFlight for a flight without a dry mass, DamagedModel if the ensemble cannot be loaded.
    """
    return infer_observed(observe(flights, found), ensemble or load_field())


def load_field() -> "Ensemble":
    """The shipped ensemble. Raises DamagedModel if it was trained on other features or another prior."""
    ensemble = load("field")
    known = {"features": list(FEATURES), "intervals": INTERVALS}
    for name, right in known.items():
        if ensemble.card.get(name) != right:
            raise DamagedModel(
                f"field: its card has different {name} from this version of fieldkit; install this version's own"
            )
    return ensemble


def infer_observed(observed: Observed, ensemble: "Ensemble") -> FieldPosterior:
    """As `infer_field`, from arrays."""
    which = outliers.misfit(ensemble, observed)
    misfits = outliers.warnings(ensemble, observed, which)
    observed = outliers.without_misfits(observed, which)
    density = posterior(observed, ensemble)
    alpha = density.margin(1)
    area = density.margin(0)
    drag_area, drag_area_sd = area.moments_of(np.exp(area.values))
    reference = disc(observed.given("diameter"))
    cd, cd_sd = drag_area / reference, drag_area_sd / reference
    bare = np.isnan(reference)
    if bare.any():
        cd[bare], cd_sd[bare] = _any_diameter(observed.rows(bare), area.rows(bare))
    alpha_mean, alpha_sd = alpha.moments()
    return FieldPosterior(
        drag_area,
        cd,
        cd_sd,
        alpha_mean,
        alpha_sd,
        which < 0,
        _warnings(ensemble, observed, misfits, area.moments()[1], alpha_sd),
        ensemble.name,
        density,
    )


def posterior(observed: Observed, ensemble: "Ensemble") -> Mixture:
    """The density of the logarithm of drag area and alpha, without checks.

    For a flight with an unusually uncertain readout it is averaged over the possible values of that readout.
    """
    outputs = ensemble.members(features(observed))
    vague = (excess_sd(observed) > 0).any(axis=1)
    if vague.any():
        some = observed.rows(vague)
        predicted = outliers.predict_readouts(ensemble, replace(some, sd=None))
        drawn = [ensemble.members(features(one)) for one in plausible(some, predicted.mean, predicted.sd)]
        outputs = np.tile(outputs, (1, DRAWS, 1))
        outputs[vague] = np.concatenate(drawn, axis=1)
    return mixture(outputs, *intervals(observed))


def intervals(observed: Observed) -> tuple[Float[Array, "flight 2"], Float[Array, "flight 2"]]:
    """Bounds of the prior of the logarithm of drag area [log m^2] and of alpha [1]."""
    low, high = drag_area_range(observed)
    return tuple(
        np.stack([bound, np.full(len(observed), end)], axis=-1)
        for bound, end in zip((low, high), ALPHA_RANGE, strict=True)
    )  # type: ignore[return-value]


def _any_diameter(observed: Observed, area: Margin) -> tuple[Array, Array]:
    """Means and standard deviations of Cd if only the drag area is known.

    The priors of Cd and diameter are uniform in their logarithms, so given a drag area the logarithm of Cd is uniform
    over the possible range of both.
    """
    slim, wide = diameter_range(observed.figure("diameter"), observed.given("dry_mass"))
    number = np.arange(STRATA)
    drag_area = area.quantiles((number + 0.5) / STRATA)
    low = np.maximum(np.log(CD_RANGE[0]), drag_area - np.log(disc(wide))[:, None])
    high = np.minimum(np.log(CD_RANGE[1]), drag_area - np.log(disc(slim))[:, None])
    cd = np.exp(low + (number * GOLDEN % 1.0) * (high - low))
    return cd.mean(axis=1), cd.std(axis=1)


def _prior_sd(observed: Observed) -> tuple[Array, float]:
    """Prior standard deviation of the logarithm of drag area and of alpha."""
    low, high = drag_area_range(observed)
    cd_span = np.log(CD_RANGE[1] / CD_RANGE[0])
    return np.sqrt((cd_span**2 + (high - low - cd_span) ** 2) / 12), ALPHA_SD


def _warnings(
    ensemble: "Ensemble", observed: Observed, misfits: Sequence[str], area_sd: Array, alpha_sd: Array
) -> tuple[tuple[str, ...], ...]:
    """Warnings about the posterior of each flight."""
    area_before, alpha_before = _prior_sd(observed)
    columns = features(observed)
    lines: list[tuple[str, ...]] = []
    for row in range(len(observed)):
        there = [name for name, value in zip(READOUT_NAMES, observed.readouts[row], strict=True) if np.isfinite(value)]
        remarks = [misfits[row], *_beyond(ensemble, columns[row])]
        remarks.append(_hardly(there, area_sd[row] / area_before[row], alpha_sd[row] / alpha_before))
        if np.isnan(observed.given("diameter")[row]):
            remarks.append("no diameter: Cd is a guess over every body that fits the motor; the drag area is inferred")
        lines.append(tuple(line for line in remarks if line))
    return tuple(lines)


def _beyond(ensemble: "Ensemble", columns: Float[Array, "feature"]) -> list[str]:
    """A line for each condition outside the ensemble's training range."""
    lines: list[str] = []
    for name, (low, high) in ensemble.card["reach"].items():
        value = columns[FEATURES.index(name)]
        if not low <= value <= high:
            found, least, most = (float(one if name == "mach" else np.exp(one)) for one in (value, low, high))
            words, unit = _WORDS[name]
            shown, usual = of_unit(found, unit, digits=3), of_unit(least, unit, most, digits=3)
            lines.append(message(f"{words} {shown} is outside the training range ({usual})"))
    return lines


def _hardly(there: Sequence[str], area: float, alpha: float) -> str:
    """A line if the flight hardly constrains drag or thrust, empty otherwise; `area` and `alpha` are the ratios of
    posterior to prior standard deviation. [1]"""
    seen = [name for name in there if name in INDEPENDENT_READOUTS]
    if not seen:
        return "no readout: this flight does not constrain Cd and alpha"
    unknown = [name for name, ratio in (("drag", area), ("thrust", alpha)) if ratio > UNINFORMATIVE_SD_RATIO]
    if not unknown:
        return ""
    reason = "apogee alone cannot separate drag from thrust here: " if seen == ["apogee"] else ""
    return f"{reason}this flight barely constrains {' and '.join(unknown)}"
