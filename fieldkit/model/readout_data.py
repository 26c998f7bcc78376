"""Altimeter readouts in the form that a fit compares, log ratios, with the expected error of each.

Derivation: to first order the error of a logarithm is the relative error of the readout, and the variances of
independent errors add.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from fieldkit.flight import Flight
from fieldkit.flight.plausibility import not_measured
from fieldkit.model.documents import SEARCH_PRIOR
from fieldkit.model.hyperprior import READOUTS, Hyperprior
from fieldkit.motors import Found
from fieldkit.physics.history import History
from fieldkit.physics.setups import recorded
from fieldkit.shapes import Array, Flags, Float

OBSERVED_READOUTS = READOUTS
IS_LOGARITHMIC = np.array([name != "apogee_to_eject" for name in OBSERVED_READOUTS])
"""Whether each readout is compared by ratio rather than by difference."""
MAX_SD = 1e3
"""Largest expected error of a readout as compared; a readout with a larger one does not constrain the model, and
the square of the error may overflow. [1] or [s]"""


@dataclass(frozen=True, slots=True)
class Data:
    """The observations in the form that the fit compares: log ratios for readouts that are `IS_LOGARITHMIC`.

    `sd` is the expected or recorded error of each readout [1] or [s]; `seen` marks readouts recorded on flights used in
    the fit. `trust` is the expected precision of each residual relative to an ordinary one: less than 1 for an outlier.
    `normal` is the probability that each flight is one of its rocket's usual ones, by default 1: the power of its
    likelihood. [1]
    """

    values: Float[Array, "flight readout"]
    sd: Float[Array, "flight readout"]
    seen: Flags
    trust: Float[Array, "flight readout"]
    normal: Float[Array, "flight"] | None = None


def observe(history: History, hyperprior: Hyperprior = SEARCH_PRIOR) -> Data:
    """The observed readouts of the flown flights; those of flights used in the fit are seen, except those that cannot
    be measurements (`not_measured`). Without flown flights, the first plan is a placeholder that is not seen."""
    count = max(history.flown, 1)
    used = history.used_in_fit or (False,)
    return as_compared(readings(history.flights[:count], history.found[:count]), used, hyperprior)


@dataclass(frozen=True, slots=True)
class ReadingsOfFlights:
    """Readouts of flights [SI], without those that cannot be measurements, and their recorded standard deviations as
    compared [1] or [s]; nan for those that were not recorded."""

    values: Float[Array, "flight readout"]
    sd: Float[Array, "flight readout"]

    def changed(self, rows: Sequence[int], now: "ReadingsOfFlights") -> "ReadingsOfFlights":
        """The same with other readouts of some flights."""
        values, sd = self.values.copy(), self.sd.copy()
        values[rows], sd[rows] = now.values, now.sd
        return ReadingsOfFlights(values, sd)


def readings(flights: Sequence[Flight], found: Sequence[Found]) -> ReadingsOfFlights:
    """The part of `observe` that does not depend on the hyperprior."""
    flights = [_measured(flight, one) for flight, one in zip(flights, found, strict=True)]
    with np.errstate(invalid="ignore", divide="ignore"):
        raw = np.stack([recorded(flights, name) for name in OBSERVED_READOUTS], axis=-1)
        own = own_sd(flights, raw)
        return ReadingsOfFlights(_speed_from_average(raw, recorded(flights, "avg_accel")), own)


def as_compared(found: ReadingsOfFlights, used_in_fit: Sequence[bool], hyperprior: Hyperprior) -> Data:
    """The part of `observe` that depends on the hyperprior: readouts without a recorded standard deviation get its."""
    raw = found.values
    with np.errstate(invalid="ignore", divide="ignore"):
        sd = np.where(np.isfinite(found.sd), found.sd, reading_sd(raw, hyperprior))
        seen = np.isfinite(raw) & (~IS_LOGARITHMIC | (raw > 0)) & (sd < MAX_SD)
        seen &= np.asarray(used_in_fit, bool)[:, None]
        values = np.where(seen, compared(raw), 0.0)
    return Data(values, np.where(seen, sd, 1.0), seen, np.ones(seen.shape))


def _measured(flight: Flight, found: Found) -> Flight:
    """A flight without the readouts that cannot be measurements."""
    gone = not_measured(flight, found.motor)
    return flight.with_changes(**dict.fromkeys(gone)) if gone else flight


def compared(raw: Float[Array, "*batch readout"]) -> Float[Array, "*batch readout"]:
    """Readouts, given in SI, in the form that the fit compares."""
    with np.errstate(invalid="ignore", divide="ignore"):
        result: Float[Array, "*batch readout"] = np.where(IS_LOGARITHMIC, np.log(raw), raw)
    return result


def reading_sd(
    raw: Float[Array, "*draw flight readout"], hyperprior: Hyperprior = SEARCH_PRIOR
) -> Float[Array, "*draw flight readout"]:
    """Expected error of each readout as compared: a constant part and a part proportional to the readout. [1] or [s]"""
    fixed, ratio = np.array(hyperprior.fixed), np.array(hyperprior.ratio)
    safe = np.where(np.isfinite(raw) & (raw > 0), raw, 1.0)
    return np.where(IS_LOGARITHMIC, np.hypot(fixed / safe, ratio), fixed)


def own_sd(flights: Sequence[Flight], raw: Float[Array, "flight readout"]) -> Float[Array, "flight readout"]:
    """The recorded standard deviation of each readout, as compared; nan if none above zero is recorded. [1] or [s]

    `raw` are the readouts in SI. For a readout compared by its logarithm it is the relative standard deviation.
    """
    found = np.stack(
        [np.array([f.sd.get(name, np.nan) for f in flights], float) for name in OBSERVED_READOUTS], axis=-1
    )
    with np.errstate(invalid="ignore", divide="ignore"):
        found = np.where(found > 0, found, np.nan)  # no readout is exact
        relative = found / np.where(raw > 0, raw, np.nan)
    return np.where(IS_LOGARITHMIC, relative, found)


def _speed_from_average(raw: Array, acceleration: Float[Array, "flight"]) -> Array:
    """Top speed from average acceleration [m/s^2] and burn time, if only those were recorded."""
    speed, burn = OBSERVED_READOUTS.index("top_speed"), OBSERVED_READOUTS.index("burn_time")
    derived = acceleration * raw[:, burn]
    raw = raw.copy()
    raw[:, speed] = np.where(np.isnan(raw[:, speed]), derived, raw[:, speed])
    return raw
