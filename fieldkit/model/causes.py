"""What may go wrong on a single flight: causes by which one flight differs from its rocket, and how each would show.

A cause is mostly absent. Its strength has a prior with a heavy tail and the sign that physics gives it: an arc only
lowers the apogee, a lost fin only adds drag. Every strength of a grid is simulated for every flight, so the change of
the readouts is not linear in it; the rest of the flight is as the rocket usually flies.

The prevalences and typical strengths are round judgments, not fitted to flights: one flight in ten has something, most
often an arc, a weak motor or extra drag.
"""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from types import MappingProxyType

import numpy as np

from fieldkit.flight.plausibility import stated_way_down
from fieldkit.model.readout_data import IS_LOGARITHMIC, OBSERVED_READOUTS, compared
from fieldkit.model.rocket_model import Model
from fieldkit.model.simulated_readouts import bent, shown
from fieldkit.shapes import Array, Flags, Float, Int, Integers
from fieldkit.units import STANDARD_GRAVITY

LOG_SD = 0.7
"""Standard deviation of the log strength of a cause: half of the strengths are 0.6 to 1.6 times the median, one in a
hundred more than five times. [1]"""
MISREAD_LOG_SD = 1.2
"""The same for an error of a readout: from one digit to feet for meters. [1]"""
OTHER_MOTOR_SD = 0.35
"""Standard deviation of the log impulse, and of the log burn time, of a motor other than the one recorded. [1]"""
OTHER_PEAK_SD = 0.35
"""Standard deviation of the log ratio of the peak accelerations of two motors with equal impulse and burn time, in one
impulse class of the catalog (a test recomputes it). [1]"""
DEGREES_OF_LAUNCH_ANGLE = 5.0
"""Launch angle of one unit of `tilt`, which is its square. [deg]"""
EJECT_ERROR = 5.0
"""Error of a misread time to ejection, relative to the log ratio of any other readout. [s]"""

LEAST_SHIFT = 1e-9
"""Largest change of a readout by which a cause does not show: two simulations of one flight differ by rounding. [1] or
[s]"""
_DESCENT_MIDDLE, _DESCENT_SCALE = 0.06, 0.06
"""Middle and scale of the Cauchy distribution of the log ratio of an apogee to the height that the way down took: the
rocket first falls, and a parachute that opens late or in stages makes the tail. Of 53 flights in one journal, half were
within 0.04 to 0.12 and nine in ten within -0.04 to 0.39. [1]"""
_LARGEST_DESCENT_RATIO = 3.0
"""Largest log ratio that counts. [1]"""


@dataclass(frozen=True, slots=True)
class CauseKind:
    """A way in which one flight may differ from its rocket.

    `prevalence` is the prior probability for one flight [1], `median` the typical strength, and `tag` marks such a
    flight as an anomaly. The `unit` is that of the strength as shown: a ratio, computed with as its logarithm, if it
    is `over` something.
    """

    title: str
    prevalence: float
    median: float
    unit: str
    tag: str = ""

    def shown(self, strength: float) -> float:
        """A strength in its unit."""
        return float(np.exp(strength)) if " over " in self.unit else strength


CAUSES: Mapping[str, CauseKind] = MappingProxyType(
    {
        "weak_motor": CauseKind("a weak motor", 0.02, 0.1, "impulse over the motor's", "weak_launch"),
        "other_motor": CauseKind("another motor", 0.005, 0.0, "impulse over the motor's", "weak_launch"),
        "extra_drag": CauseKind("extra drag", 0.02, 0.5, "drag over the rocket's", "extra_drag"),
        "arc": CauseKind("an arc", 0.025, 25.0, "deg from vertical", "off_axis"),
        "early_ejection": CauseKind("an early ejection", 0.01, 0.0, "s before apogee", "early_ejection"),
        "late_ejection": CauseKind("a late ejection", 0.005, 1.5, "s late"),
        "mass": CauseKind("another mass", 0.005, 0.15, "mass over that recorded"),
        "misread": CauseKind("a misread readout", 0.01, 0.3, "shown over expected", "altimeter_fault"),
    }
)
"""Every cause of a single flight by name. Certified motors of one type differ by up to 6.7% (NFPA 1125), so a weak one
has lost more; a fin or a streamer adds half of the drag or more; a rocket that turns into the wind or leaves the rail
slowly is often far from vertical."""
NAMES = tuple(CAUSES)
USUAL_PROBABILITY = 1.0 - sum(cause.prevalence for cause in CAUSES.values())
"""Prior probability that a flight has none. [1]"""
_STEPS = np.linspace(-1.75, 2.25, 9)
"""Log strengths on a grid, in standard deviations around the median."""
_LOG_WEIGHTS = -0.5 * _STEPS**2 - np.logaddexp.reduce(-0.5 * _STEPS**2)
"""Log of their normal weights, which add to one."""
_EJECTED_AT = np.array([0.1, 0.25, 0.4, 0.55, 0.65, 0.75, 0.83, 0.9])
"""Fractions of the coast after which an early charge fires."""
_IMPULSES, _BURNS = np.linspace(-0.8, 0.8, 7), np.linspace(-0.6, 0.6, 9)
"""Log impulse and log burn time of another motor."""


@dataclass(frozen=True, slots=True)
class Signatures:
    """The change of every flight's readouts under every strength of every cause.

    `cause` indexes `NAMES`; `strength` is the logarithm of a ratio of the flight to what is expected, or in the unit of
    the cause. `shift` is the change of the readouts as compared, and `spread` its standard deviation
    within the interval of strengths that a point of the grid stands for [1] or [s]. `log_prior` is the log prior
    probability of the cause with this strength, minus infinity on flights that cannot have or show it. [nat]
    """

    cause: Int[Integers, "strength"]
    strength: Float[Array, "strength flight"]
    shift: Float[Array, "strength flight readout"]
    spread: Float[Array, "strength flight readout"]
    log_prior: Float[Array, "strength flight"]


def signatures(
    model: Model, at: Float[Array, "term"], values: Float[Array, "flight readout"], seen: Flags
) -> Signatures:
    """The signatures of all causes at a point of a model's terms, where its readouts as compared are `values` [1] or
    [s]; `seen` marks the readouts that flights have. Terms are in their units.

    Raises ImpossibleFlight for a flight without a dry mass.
    """
    usable = seen & np.isfinite(values)
    found = [*_simulated(model, at, values), *_ejections(model, at, values), *_misread(model, usable)]
    every = Signatures(*(np.concatenate([getattr(one, name) for one in found]) for name in Signatures.__slots__))
    shift, spread = (np.where(usable, part, 0.0) for part in (every.shift, every.spread))
    flies = np.isfinite(shift).all(axis=-1) & (np.abs(shift) > LEAST_SHIFT).any(axis=-1)
    log_prior = np.where(flies, every.log_prior, -np.inf)
    shift, spread = (np.where(np.isfinite(part), part, 0.0) for part in (shift, spread))
    return replace(every, shift=shift, spread=spread, log_prior=log_prior)


def _simulated(model: Model, at: Float[Array, "term"], values: Float[Array, "flight readout"]) -> list[Signatures]:
    """The causes that change a property of the flight, simulated in one batch."""

    def strengths(name: str) -> Float[Array, "strength"]:
        return np.asarray(CAUSES[name].median * np.exp(LOG_SD * _STEPS))

    weak, drag, arc, mass = (strengths(name) for name in ("weak_motor", "extra_drag", "arc", "mass"))
    usual = -0.5 * _STEPS**2
    rows: list[tuple[str, Array, dict[str, Array], Array]] = [
        ("weak_motor", -weak, {"thrust": -weak}, usual),
        ("extra_drag", drag, {"drag": drag}, usual),
        ("arc", arc, {"tilt": (arc / DEGREES_OF_LAUNCH_ANGLE) ** 2}, usual),
        *(("mass", side * mass, {"mass": side * mass}, usual) for side in (1, -1)),
    ]
    for stretch in _BURNS.tolist():
        bends = {"thrust": _IMPULSES, "stretch": np.full(len(_IMPULSES), stretch)}
        rows.append(("other_motor", _IMPULSES, bends, -0.5 * (_IMPULSES**2 + stretch**2) / OTHER_MOTOR_SD**2))
    ends = np.cumsum([len(strength) for _, strength, *_ in rows])
    scatter = {kind: np.zeros((ends[-1], len(model.flights))) for kind in ("thrust", "drag", "tilt", "mass", "stretch")}
    for end, (_, strength, own, _) in zip(ends.tolist(), rows, strict=True):
        for kind, amount in own.items():
            scatter[kind][end - len(strength) : end] = amount[:, None]
    shifts = np.split(_shift(model, at, values, scatter), ends[:-1])
    peak = np.where(np.array(OBSERVED_READOUTS) == "peak_accel", OTHER_PEAK_SD, 0.0)
    whole = {name: np.logaddexp.reduce(np.concatenate([w for own, *_, w in rows if own == name])) for name, *_ in rows}
    return [
        _row(name, strength[:, None], shift, (weight - whole[name])[:, None], peak * (name == "other_motor"))
        for (name, strength, _, weight), shift in zip(rows, shifts, strict=True)
    ]


def _ejections(model: Model, at: Float[Array, "term"], values: Float[Array, "flight readout"]) -> list[Signatures]:
    """Ejection at any time of the coast before the usual one, all equally likely, and after the usual one; a flight
    without a known delay ejects at apogee otherwise."""
    coast = np.exp(values[:, OBSERVED_READOUTS.index("coast_to_apogee")])
    known = model.history.delays
    delay = np.where(np.isnan(known), np.maximum(np.nan_to_num(coast), 0.1), known)
    timed = replace(model, history=model.history.with_delays(delay.tolist()))
    ratio = bent(model, at[None], "delay")[0]
    usual = delay * np.exp(ratio)
    late = CAUSES["late_ejection"].median * np.exp(LOG_SD * _STEPS)
    times = np.concatenate([_EJECTED_AT[:, None] * coast, usual + late[:, None]])
    shift = _shift(timed, at, values, {"delay": np.log(times / delay) - ratio})
    early = np.where(times[: len(_EJECTED_AT)] < usual, -np.log(len(_EJECTED_AT)), -np.inf)
    after = np.where(np.isnan(known), -np.inf, _LOG_WEIGHTS[:, None])
    return [
        _row("early_ejection", (1 - _EJECTED_AT[:, None]) * coast, shift[: len(_EJECTED_AT)], early),
        _row("late_ejection", late[:, None], shift[len(_EJECTED_AT) :], after),
    ]


def _misread(model: Model, usable: Flags) -> list[Signatures]:
    """A misread readout, any of those that the flight has. With the right one the way down took the height that the
    flight reached, so what it says of each error is a part of the prior: no other cause changes it."""
    found = []
    share = -np.log(np.maximum(usable.sum(axis=1), 1))
    known = {name: model.history.column(name) for name in _WAY_DOWN}
    known["descent_speed"] = np.where(
        [stated_way_down(flight) for flight in model.flights], known["descent_speed"], np.nan
    )
    as_read = _log_descent(known)
    for column, (name, logarithmic) in enumerate(zip(OBSERVED_READOUTS, IS_LOGARITHMIC.tolist(), strict=True)):
        for side in (1, -1):
            error = side * CAUSES["misread"].median * np.exp(MISREAD_LOG_SD * _STEPS)
            error = error if logarithmic else error * EJECT_ERROR
            log_prior = _LOG_WEIGHTS[:, None] + share - np.log(2)
            if name in known:
                by, shown = error[:, None], known[name]
                log_prior = (
                    log_prior
                    + _log_descent(known | {name: shown / np.exp(by) if logarithmic else shown - by})
                    - as_read
                )
            found.append(_row("misread", error[:, None], _one_readout(column, error, usable), log_prior))
    return found


_WAY_DOWN = ("apogee", "burn_time", "coast_to_apogee", "apogee_to_eject", "descent_speed", "duration")


def _log_descent(known: Mapping[str, Array]) -> Array:
    """Log density of the height that the way down took, beside the apogee, up to a constant; 0 for flights without one
    of the readouts of `_WAY_DOWN`.

    The way down is free fall from apogee to ejection, then descent at the speed that the device averages. A charge
    without a recorded time fires at apogee. [nat]
    """
    apogee, burn, coast, eject, speed, duration = (known[name] for name in _WAY_DOWN)
    after = np.nan_to_num(eject)
    sinking = speed * np.maximum(duration - burn - coast - after, 0.0)
    with np.errstate(divide="ignore"):
        ratio = np.log(apogee / (sinking + STANDARD_GRAVITY / 2 * np.maximum(after, 0.0) ** 2))
    off = (np.clip(ratio, -_LARGEST_DESCENT_RATIO, _LARGEST_DESCENT_RATIO) - _DESCENT_MIDDLE) / _DESCENT_SCALE
    return np.nan_to_num(-np.log1p(off**2))


def _one_readout(
    column: int, error: Float[Array, "strength"], usable: Flags
) -> Float[Array, "strength flight readout"]:
    shift = np.zeros((len(error), *usable.shape))
    shift[..., column] = error[:, None]
    return shift


def _shift(
    model: Model, at: Float[Array, "term"], values: Float[Array, "flight readout"], scatter: Mapping[str, Array]
) -> Float[Array, "strength flight readout"]:
    """The change of the readouts by properties of single flights; nan on a flight that stays on the pad."""
    count = len(next(iter(scatter.values())))
    readings = shown(model, np.broadcast_to(at, (count, len(at))), scatter)
    with np.errstate(invalid="ignore"):
        return np.asarray(compared(np.stack([readings[name] for name in OBSERVED_READOUTS], axis=-1)) - values)


def _row(
    name: str,
    strength: Float[Array, "strength #flight"],
    shift: Float[Array, "strength flight readout"],
    log_fraction: Float[Array, "strength #flight"],
    spread: Float[Array, "readout"] | float = 0.0,
) -> Signatures:
    """Strengths of a cause that follow each other, with the log fraction of the cause's prior that each has, and the
    `spread` of the readouts under each [1] or [s].

    A point of the grid stands for the interval to the middle of its neighbors, in which the readouts are linear: the
    standard deviation of a uniform distribution is its width over the square root of twelve.
    """
    with np.errstate(invalid="ignore"):
        within = np.hypot(np.gradient(shift, axis=0) / np.sqrt(12.0), spread)
    flights = shift.shape[1]
    return Signatures(
        np.full(len(shift), NAMES.index(name)),
        np.broadcast_to(strength, (len(shift), flights)),
        shift,
        within,
        np.broadcast_to(log_fraction + np.log(CAUSES[name].prevalence), (len(shift), flights)),
    )
