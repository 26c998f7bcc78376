"""Fingerprints: the pattern of an effect in every readout, next to the flights' residuals.

A plain model without the effect absorbs part of it as far as its priors allow, and only the rest shows. So both sides
get the same treatment: the shift by the effect and the recorded readouts are each reduced by the plain model's fit to
them, and both residuals are compared along the flights on which the effect acts more or less.
"""

from dataclasses import dataclass
from typing import Any

import numpy as np

from fieldkit.flight import LOGGED, READOUTS
from fieldkit.inference.laplace.posterior import Fit
from fieldkit.model.readout_data import OBSERVED_READOUTS, compared
from fieldkit.model.simulated_readouts import shown
from fieldkit.selection.diagnose import Diagnosis
from fieldkit.selection.trial import Trial, with_and_without
from fieldkit.shapes import Array, Flags, Float

UNFITTED_READOUTS = ("avg_accel", "eject_altitude", "descent_speed", "duration")
"""Readouts of a simulated flight that no fit uses."""


@dataclass(frozen=True, slots=True)
class FingerprintMark:
    """One readout: the effect's shift and the observed one, both in expected standard deviations.

    `sd` is the standard deviation of the observed one. `fitted` is False for readouts that the fit does not use, which
    are compared with the plain model's simulations in units of their own scatter. nan if nothing was recorded.
    """

    readout: str
    expected: float
    found: float
    sd: float
    fitted: bool


def marks(diagnosis: Diagnosis, trial: Trial) -> list[FingerprintMark]:
    """The ten readouts, and those from logs that some flight has, under one effect at its fitted strength, with the
    sign of flights that show more of it. Raises ImpossibleFlight for a flight without a dry mass."""
    plain, seen = diagnosis.base.fit, diagnosis.data.seen
    readings = with_and_without(trial)
    shift = _shift(readings)
    expected, found = _left(plain, shift), _left(plain, _misses(plain))
    along = _along(expected, shift, seen)
    rows = {
        name: _mark(name, expected[:, i], found[:, i], along, seen[:, i], fitted=True)
        for i, name in enumerate(OBSERVED_READOUTS)
    }
    rows |= _others(diagnosis, readings, along)
    logged = [column for column in LOGGED if seen[:, OBSERVED_READOUTS.index(column.name)].any()]
    return [rows[column.name] for column in (*READOUTS, *logged) if column.name in rows]


def _shift(readings: dict[str, Float[Array, "2 flight"]]) -> Float[Array, "flight readout"]:
    """The shift of each flight's readouts by the effect, in the form that the fit compares."""
    both = compared(np.stack([readings[name] for name in OBSERVED_READOUTS], axis=-1))
    return np.asarray(np.nan_to_num(both[0] - both[1]))


def _misses(plain: Fit) -> Float[Array, "flight readout"]:
    """Readouts minus the prior expectation of the plain model."""
    near = plain.tangent
    prior = np.array([term.mean for term in plain.model.terms])
    usable = plain.data.seen & np.isfinite(near.values)
    return np.asarray(np.where(usable, plain.data.values - near.values, 0.0) + near.slope @ (near.at - prior))


def _left(plain: Fit, shift: Float[Array, "flight readout"]) -> Float[Array, "flight readout"]:
    """The part of a shift that the plain model cannot absorb, in expected standard deviations of each readout."""
    best, evidence = int(np.argmax(plain.log_weight)), plain.evidence
    usable = (plain.data.seen & np.isfinite(plain.tangent.values))[:, evidence.readouts]
    shown = np.where(usable, shift[:, evidence.readouts], 0.0)
    score = np.einsum("fot,fop,fp->t", evidence.slope, evidence.sharpness[best], shown)
    offset = plain.covariance[best] @ score
    left = np.zeros(shift.shape)
    left[:, evidence.readouts] = (shown - evidence.slope @ offset) / np.sqrt(
        np.diagonal(evidence.noise()[best], axis1=1, axis2=2)
    )
    return left


def _along(
    expected: Float[Array, "flight readout"], shift: Float[Array, "flight readout"], seen: Flags
) -> Float[Array, "flight"]:
    """How much of the effect each flight should show, in the readout that shows it most, normalized to size one."""
    strongest = int(np.argmax((np.where(seen, expected, 0.0) ** 2).sum(axis=0)))
    used_in_fit = seen.any(axis=1)
    along = np.where(used_in_fit, expected[:, strongest], 0.0)
    size = float(np.sqrt((along[used_in_fit] ** 2).mean())) if used_in_fit.any() else 0.0
    if size < 1e-3:
        return np.asarray(used_in_fit, float)
    return np.asarray(along / size * (np.sign(shift[used_in_fit, strongest].sum()) or 1.0))


def _mark(name: str, expected: Array, found: Array, along: Array, seen: Flags, *, fitted: bool) -> FingerprintMark:
    """Both projected on the flights that should show the effect; the common part is kept."""
    power = float((along[seen] ** 2).sum())
    if not power:
        nan = float("nan")
        return FingerprintMark(name, nan, nan, nan, fitted)
    return FingerprintMark(
        name,
        float((expected[seen] * along[seen]).sum() / power),
        float((found[seen] * along[seen]).sum() / power),
        float(1 / np.sqrt(power)),
        fitted,
    )


def _others(
    diagnosis: Diagnosis, readings: dict[str, Float[Array, "2 flight"]], along: Float[Array, "flight"]
) -> dict[str, FingerprintMark]:
    """The readouts that the fit does not use, on flights with and without the effect."""
    plain = diagnosis.base.fit
    shown_plain = shown(plain.model, plain.moments()[0][None], {})
    rows = {}
    for name in UNFITTED_READOUTS:
        with np.errstate(invalid="ignore", divide="ignore"):
            miss = np.log(plain.model.recorded(name) / shown_plain[name][0])
            shift = np.log(readings[name][0] / readings[name][1])
        rows[name] = _other(name, miss, shift, along, diagnosis.data.seen[:, 0])
    return rows


def _other(name: str, miss: Any, shift: Any, along: Array, used_in_fit: Flags) -> FingerprintMark:
    seen = np.isfinite(miss) & np.isfinite(shift) & used_in_fit & (along != 0)
    if seen.sum() < 4:
        nan = float("nan")
        return FingerprintMark(name, nan, nan, nan, fitted=False)
    centred = np.where(seen, miss - np.mean(miss[seen]), 0.0)
    unit = max(float(np.std(centred[seen], ddof=1)), 1e-9)
    moved = np.where(seen, shift - np.mean(shift[seen]), 0.0)
    return _mark(name, moved / unit, centred / unit, along, seen, fitted=False)
