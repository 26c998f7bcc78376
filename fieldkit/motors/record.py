"""The certified record of a motor, and how far its thrust curve is from it.

A record has the total impulse, the burn time, and mostly the average and the peak thrust. Burn time is stated in two
ways: above 5% of the peak thrust (NFPA 1125), or from ignition to the end of thrust, as in most sheets of the NAR. The
second counts if the peak thrust confirms it: a curve of the same firings has their peak, and one of others does not.

Derivation: stretching the time of a curve by s and dividing its thrust by s keeps its impulse and multiplies its burn
time by s, its average and its peak thrust by 1/s.
"""

import math
from collections.abc import Iterable
from dataclasses import dataclass

from fieldkit.motors.motor import Motor, burning, impulse
from fieldkit.shapes import Array, Float

AGREEMENT = 0.05
"""Relative difference up to which a curve agrees with its record: the scatter of tests of one motor type. [1]"""


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

        The peak is not part of it: it depends on the sampling of the test stand, and no curve of a given impulse and
        burn time has just any peak.
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


def record_of(motor: Motor) -> CertifiedRecord | None:
    """The certified record of a motor; None for one without, such as a flyer's own file."""
    if motor.certified_burn is None:
        return None
    return CertifiedRecord(motor.total_impulse, motor.certified_burn, motor.certified_average, motor.certified_peak)


def checked(motors: Iterable[Motor]) -> list[tuple[Motor, CurveAgreement]]:
    """The motors with a record, and how the curve of each agrees with it; the largest deviation first."""
    found = [(one, agreement(one.time, one.thrust, record)) for one in motors if (record := record_of(one))]
    return sorted(found, key=lambda pair: -abs(pair[1].deviation))


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
        "used": used_curve(motor),
        "curve": motor.curve,
        "available": motor.available,
    }
