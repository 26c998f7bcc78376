"""Outlier readouts: each readout is predicted from the others, and the one that disagrees is named."""

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from fieldkit.flight import BY_NAME
from fieldkit.inference.network.mixture import GUARD_SHARPEST, WIDTH
from fieldkit.inference.network.vague import excess_sd, likeliest
from fieldkit.messages import message, of_column
from fieldkit.model.field_features import features, shown
from fieldkit.model.observations import INDEPENDENT_READOUTS, READOUT_NAMES, Observed
from fieldkit.shapes import Array, Flags, Float, Int

if TYPE_CHECKING:
    from fieldkit.inference.network.ensemble import Ensemble

BLOCK = 500
"""Number of flights predicted together, few enough for the processor's cache."""
FALSE_ALARMS = 0.01
"""Fraction of good flights with a false warning. [1]"""


@dataclass(frozen=True, slots=True)
class PredictedReadouts:
    """Each readout, nan if missing, and its prediction from the others, on the scale of `field_features.shown`."""

    shown: Float[Array, "flight seen"]
    mean: Float[Array, "flight seen"]
    sd: Float[Array, "flight seen"]

    @property
    def distance(self) -> Float[Array, "flight seen"]:
        """Distance from the prediction, in standard deviations; 0 if the readout is missing. [1]"""
        return np.nan_to_num(np.abs(self.shown - self.mean) / self.sd, nan=0.0)


def predict_readouts(ensemble: "Ensemble", observed: Observed) -> PredictedReadouts:
    """Each readout predicted from the others, with one run of the graph for each block of flights."""
    blocks = [slice(first, first + BLOCK) for first in range(0, max(len(observed), 1), BLOCK)]
    parts = [_predict_block(ensemble, observed.rows(block)) for block in blocks]
    return PredictedReadouts(
        *(np.concatenate([getattr(part, name) for part in parts]) for name in ("shown", "mean", "sd"))
    )


def _predict_block(ensemble: "Ensemble", observed: Observed) -> PredictedReadouts:
    flights, seen = len(observed), len(INDEPENDENT_READOUTS)
    readouts = np.repeat(observed.readouts[None], seen, axis=0)
    for number, name in enumerate(INDEPENDENT_READOUTS):
        readouts[number][:, [READOUT_NAMES.index(one) for one in derived_from(name)]] = np.nan
    every = Observed(
        np.tile(observed.motor, (seen, 1)), np.tile(observed.declared, (seen, 1)), readouts.reshape(seen * flights, -1)
    )
    parts = ensemble.members(features(every)).reshape(seen, flights, -1, WIDTH + 2 * seen)
    own = np.arange(seen)
    mean, sharp = parts[own, :, :, WIDTH + own], parts[own, :, :, WIDTH + seen + own]
    variance = np.exp(-2 * np.clip(sharp, *GUARD_SHARPEST)).mean(axis=-1) + mean.var(axis=-1)
    return PredictedReadouts(shown(observed), mean.mean(axis=-1).T, np.sqrt(variance).T)


def derived_from(name: str) -> tuple[str, ...]:
    """A readout and those derived from it, which would reveal it: average acceleration is speed over burn time."""
    return (name, "avg_accel") if name in ("top_speed", "burn_time") else (name,)


def limits(ensemble: "Ensemble", observed: Observed) -> dict[str, float]:
    """The threshold of each readout's distance with which a fraction `FALSE_ALARMS` of these flights gets a
    warning. [1]

    Derivation: bisection of the fraction that each readout alone may have, which makes the joint one `FALSE_ALARMS`.
    """
    predicted = predict_readouts(ensemble, observed)
    distance = np.where(np.isfinite(predicted.shown), predicted.distance, np.nan)
    low, high = 0.0, FALSE_ALARMS
    for _ in range(30):
        tried = 0.5 * (low + high)
        at = np.nanquantile(distance, 1 - tried, axis=0)
        alarms = float((distance > at).any(axis=1).mean())
        low, high = (tried, high) if alarms < FALSE_ALARMS else (low, tried)
    return {name: float(limit) for name, limit in zip(INDEPENDENT_READOUTS, at, strict=True)}


def misfit(ensemble: "Ensemble", observed: Observed) -> Int[Any, "flight"]:
    """The outlier, as an index into `INDEPENDENT_READOUTS`, or -1.

    Of the readouts too far from their prediction, it is the one without which the others agree best. An unusually
    uncertain readout counts as its most likely value, so it is not an outlier if its uncertainty explains its distance.
    """
    if (excess_sd(observed) > 0).any():
        predicted = predict_readouts(ensemble, observed)
        observed = likeliest(observed, predicted.mean, predicted.sd)
    limit = np.array([ensemble.card["guard"][name] for name in INDEPENDENT_READOUTS])
    far: Flags = predict_readouts(ensemble, observed).distance > limit
    outlying = far.any(axis=1)
    found = np.full(len(observed), -1)
    if outlying.any():
        some = observed.rows(outlying)
        left = [
            predict_readouts(ensemble, some.without(*derived_from(name))).distance / limit
            for name in INDEPENDENT_READOUTS
        ]
        worst = np.stack([distance.max(axis=1) for distance in left], axis=-1)
        found[outlying] = np.argmin(np.where(far[outlying], worst, np.inf), axis=1)
    return found


def without_misfits(observed: Observed, which: Int[Any, "flight"]) -> Observed:
    """The flights without their outliers."""
    readouts = observed.readouts.copy()
    for number, name in enumerate(INDEPENDENT_READOUTS):
        for one in derived_from(name):
            readouts[which == number, READOUT_NAMES.index(one)] = np.nan
    return observed.with_readouts(readouts)


def warnings(ensemble: "Ensemble", observed: Observed, which: Int[Any, "flight"]) -> list[str]:
    """A line for each flight with an outlier, an empty string for the others."""
    lines = [""] * len(observed)
    outlying = np.flatnonzero(which >= 0)
    if len(outlying):
        predicted = predict_readouts(ensemble, observed.rows(outlying))
        for row, flight in enumerate(outlying):
            seen = int(which[flight])
            name = (
                INDEPENDENT_READOUTS[seen]
                if np.isfinite(observed.readout(INDEPENDENT_READOUTS[seen])[flight])
                else "avg_accel"
            )
            ends = predicted.mean[row, seen] + np.array([-2, 2]) * predicted.sd[row, seen]
            value = float(observed.readout(name)[flight])
            lines[flight] = _line(name, value, float(predicted.shown[row, seen]), ends)
    return lines


def _line(name: str, value: float, shown_value: float, ends: Float[Array, "2"]) -> str:
    column = BY_NAME[name]
    expected = np.sinh(ends) / 2 if name == "apogee_to_eject" else value * np.exp(ends - shown_value)
    found, usual = of_column(column, value, digits=3), of_column(column, float(expected[0]), float(expected[1]), 3)
    what = f"{column.title.lower()} of {found} is inconsistent with the rest of the flight"
    return message(f"{what}, expected {usual}; left out")
