"""The certified record of a motor, and how far its thrust curve is from it.

A record has the total impulse, the burn time, and mostly the average and the peak thrust. Burn time is stated in two
ways: above 5% of the peak thrust (NFPA 1125), or from ignition to the end of thrust, as in most sheets of the NAR. The
second counts if the peak thrust confirms it: a curve of the same firings has their peak, and one of others does not.

Derivation: stretching the time of a curve by s and dividing its thrust by s keeps its impulse and multiplies its burn
time by s, its average and its peak thrust by 1/s. A certified peak is the largest sample of a test, and a recorded
curve has some 25 points: a peak that it misses is shorter than their spacing. It is set on the highest point, for a
few milliseconds, and the rest scaled to keep the impulse: heights, times and the mean thrust on the rail hardly change.
A peak above the certified one is cut there, and the rest scaled up.
"""

import math
from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np

from fieldkit.motors.motor import Motor, burning, impulse
from fieldkit.shapes import Array, Float

AGREEMENT = 0.05
"""Relative difference up to which a curve agrees with its record: the scatter of tests of one motor type. [1]"""
MISSED_PEAK = 0.005
"""Time within which the thrust rises to a peak that a recorded curve misses, and falls from it: some samples of a test
stand. [s]"""
MOST_MOVED = 0.1
"""Largest fraction of the impulse that may move to other times for a certified peak: beyond it, the curve and the
record are of different burns. [1]"""


@dataclass(frozen=True, slots=True)
class CertifiedRecord:
    """Total impulse [N s], burn time [s], average and peak thrust [N] as certified; None if not stated."""

    impulse: float
    burn: float
    average: float | None = None
    peak: float | None = None


@dataclass(frozen=True, slots=True)
class CurveAgreement:
    """A thrust curve beside its record: its impulse [N s]; its burn time [s] and average thrust [N] in the way of
    stating them that is nearer to the record; its peak thrust [N]."""

    impulse: float
    burn: float
    average: float
    peak: float
    record: CertifiedRecord

    @property
    def deviation(self) -> float:
        """The largest relative deviation of impulse, burn time and average thrust from the record. [1]

        The peak is apart: no curve of a given impulse and burn time has just any peak.
        """
        pairs = (
            (self.impulse, self.record.impulse),
            (self.burn, self.record.burn),
            (self.average, self.record.average),
        )
        return max((found / stated - 1 for found, stated in pairs if stated), key=abs)

    @property
    def peak_deviation(self) -> float | None:
        """Relative deviation of the peak thrust from the record; None if the record has none. [1]"""
        return self.peak / self.record.peak - 1 if self.record.peak else None

    @property
    def largest(self) -> float:
        """The largest relative deviation of impulse, burn time, average and peak thrust, without its sign. [1]"""
        return max(abs(self.deviation), abs(self.peak_deviation or 0.0))

    @property
    def why(self) -> str:
        """Why the peak is not that of the record; empty if it is."""
        if self.record.peak is None or abs(self.peak_deviation or 0.0) <= AGREEMENT:
            return ""
        average = self.record.impulse / self.record.burn
        if self.record.peak < average:
            return (
                f"the record cannot be true: its peak, {self.record.peak:.4g} N, is below its impulse over its burn "
                f"time, {average:.4g} N"
            )
        shape = self.peak * self.burn / self.impulse
        return (
            f"its peak is {self.record.peak / average:.2f} times its impulse over its burn time, and that of its curve "
            f"{shape:.2f} times"
        )


def agreement(time: Float[Array, "knot"], thrust: Float[Array, "knot"], record: CertifiedRecord) -> CurveAgreement:
    """How a thrust curve [s], [N] agrees with a record."""
    above, whole = _burns(time, thrust)
    burns = (above, whole) if states_whole_burn(time, thrust, record) else (above,)
    total, burn = impulse(time, thrust), _nearest(burns, record.burn)
    averages = [total / one for one in burns]
    average = _nearest(averages, record.average) if record.average else total / burn
    return CurveAgreement(total, burn, average, float(thrust.max()), record)


def states_whole_burn(time: Float[Array, "knot"], thrust: Float[Array, "knot"], record: CertifiedRecord) -> bool:
    """Whether a record may state the burn time from ignition to the end of thrust: without a certified peak, or if the
    curve [s], [N] has a peak nearer to it when stretched to that burn time than when stretched to the one above 5%."""
    if not record.peak:
        return True
    peaks = [thrust.max() * burn / record.burn for burn in _burns(time, thrust)]
    return bool(_nearest(peaks, record.peak) == peaks[1])


def _burns(time: Float[Array, "knot"], thrust: Float[Array, "knot"]) -> tuple[float, float]:
    """Burn time above 5% of the peak thrust, and from ignition to the end of thrust. [s]"""
    start, end = burning(time, thrust)
    return end - start, float(time[-1])


def _nearest(values: Iterable[float], stated: float) -> float:
    """The value that is nearest to a stated one in ratio."""
    return min(values, key=lambda value: abs(math.log(value / stated)))


def reshaped(
    time: Float[Array, "knot"], thrust: Float[Array, "knot"], record: CertifiedRecord, *, whole: bool
) -> tuple[Float[Array, "knot"], Float[Array, "knot"]]:
    """A thrust curve [s], [N] with the record's impulse and burn time: `whole`, or above 5% of its peak thrust."""
    stretched = time * (record.burn / _burns(time, thrust)[whole])
    return stretched, thrust * (record.impulse / impulse(stretched, thrust))


def with_peak(
    time: Float[Array, "knot"], thrust: Float[Array, "knot"], record: CertifiedRecord
) -> tuple[Float[Array, "point"], Float[Array, "point"]] | None:
    """A thrust curve [s], [N] with the record's impulse and peak thrust; None if the record has no peak, or if that
    takes more than `MOST_MOVED` of the impulse to other times."""
    if not record.peak:
        return None
    thrust = thrust * (record.impulse / impulse(time, thrust))
    change = _raised if thrust.max() < record.peak else _cut
    times, thrusts = change(time, thrust, record.impulse, record.peak)
    moved = impulse(times, np.abs(thrusts - np.interp(times, time, thrust))) / record.impulse / 2
    kept = abs(impulse(times, thrusts) / record.impulse - 1) < 1e-6
    return (times, thrusts) if kept and moved <= MOST_MOVED else None


def _raised(
    time: Float[Array, "knot"], thrust: Float[Array, "knot"], total: float, peak: float
) -> tuple[Float[Array, "point"], Float[Array, "point"]]:
    """A curve with its highest point at a higher peak, for `MISSED_PEAK` on each side or to the next point, and the
    rest scaled to the impulse left."""
    top = int(thrust.argmax())
    before, at, after = time[top - 1 : top + 2]
    sides = [at - MISSED_PEAK] * bool(at - before > 2 * MISSED_PEAK)
    sides += [at + MISSED_PEAK] * bool(after - at > 2 * MISSED_PEAK)
    times = np.union1d(time, sides)
    alone = np.where(times == at, 1.0, 0.0)
    rest = np.interp(times, time, thrust) * (1 - alone)
    return times, rest * ((total - peak * impulse(times, alone)) / impulse(times, rest)) + peak * alone


def _cut(
    time: Float[Array, "knot"], thrust: Float[Array, "knot"], total: float, peak: float
) -> tuple[Float[Array, "point"], Float[Array, "point"]]:
    """A curve that is cut at a peak, and scaled up to the impulse by at most 50 times, by bisection."""
    low, high = 1.0, 50.0
    for _ in range(60):
        middle = (low + high) / 2
        low, high = (low, middle) if impulse(time, np.minimum(middle * thrust, peak)) > total else (middle, high)
    return time, np.minimum(high * thrust, peak)


def record_of(motor: Motor) -> CertifiedRecord | None:
    """The certified record of a motor; None for one without, such as a flyer's own file."""
    if motor.certified_burn is None:
        return None
    return CertifiedRecord(motor.total_impulse, motor.certified_burn, motor.certified_average, motor.certified_peak)


def checked(motors: Iterable[Motor]) -> list[tuple[Motor, CurveAgreement]]:
    """The motors with a record, and how the curve of each agrees with it; the largest deviation first."""
    found = [(one, agreement(one.time, one.thrust, record)) for one in motors if (record := record_of(one))]
    return sorted(found, key=lambda pair: -pair[1].largest)


def used_curve(motor: Motor) -> str:
    """Which curve of a motor is used: the `recorded` one, it `reshaped`, `another`, or one that is `estimated`."""
    if "thrust curve" in motor.estimated:
        return "estimated"
    return "recorded" if not motor.curve else "another" if motor.curve.startswith("another") else "reshaped"


def document(motor: Motor, found: CurveAgreement) -> dict[str, object]:
    """A motor beside its record, ready for JSON."""
    return {
        "motor": f"{motor.maker} {motor.designation}",
        "impulse_ns": found.impulse,
        "burn_s": found.burn,
        "average_n": found.average,
        "peak_n": found.peak,
        "certified": {
            "impulse_ns": found.record.impulse,
            "burn_s": found.record.burn,
            "average_n": found.record.average,
            "peak_n": found.record.peak,
        },
        "deviation": found.deviation,
        "peak_deviation": found.peak_deviation,
        "why": found.why,
        "used": used_curve(motor),
        "curve": motor.curve,
        "available": motor.available,
    }
