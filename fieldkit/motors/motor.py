"""A motor: its masses, its delays, and its thrust curve.

Derivation: integrals of a piecewise linear curve by the trapezoidal rule, which is exact for it.
"""

import hashlib
import math
from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np

from fieldkit.errors import BadValue
from fieldkit.messages import amount, message
from fieldkit.motors.corrections import Correction
from fieldkit.shapes import Array, Float

PLUGGED_DELAY = math.inf
"""The delay of a motor without an ejection charge. [s]"""

BURN_THRUST_FRACTION = 0.05
"""Fraction of peak thrust above which a motor counts as burning, according to NFPA 1125. [1]"""

_RAMP = 1e-4
"""Longest duration of a jump in a recorded curve. [s]"""


@dataclass(frozen=True, slots=True, eq=False)
class Motor:
    """One motor in SI units. Its thrust is linear between the knots `time`, `thrust`.

    The first knot is (0, 0), the last thrust is 0, time strictly increases, and the integral of the thrust is
    `total_impulse`. `delays` are those for sale, in seconds, including `PLUGGED_DELAY` if it is sold plugged; empty
    if not recorded. `estimated` names the fields that the source lacks and that were estimated. `certified_average`
    and `certified_peak` are the thrusts stated by the certification [N], None if unknown or only the number in the
    name; `certified_burn` is its burn time [s]. `curve` is the origin of the curve if it is not the recorded one,
    such as `recorded curve of 1.61 s reshaped to the certified burn time of 1.94 s`; `corrections` are the values
    that differ from the source, and those on which documents disagree. `parts` are the motors of the cluster or
    stages that this motor combines, empty for a single motor. For these, `spent` is the fraction of
    `propellant_mass` burned at each knot [1], None if it is proportional to the impulse, and `drag` is the ratio of
    the rocket's drag from each knot on to that of its uppermost stage [1], None if it is constant. `remarks` say
    what was corrected in a file of the user's. Two motors are equal only if they are the same object.
    """

    maker: str
    name: str
    designation: str
    impulse_class: str
    kind: str
    diameter: float
    length: float
    total_impulse: float
    propellant_mass: float
    casing_mass: float
    delays: tuple[float, ...]
    available: bool
    time: Float[Array, "knot"] = field(repr=False)
    thrust: Float[Array, "knot"] = field(repr=False)
    source: str = ""
    case: str = ""
    propellant: str = ""
    url: str = ""
    estimated: tuple[str, ...] = ()
    certified_average: float | None = None
    certified_peak: float | None = None
    certified_burn: float | None = None
    curve: str = ""
    corrections: tuple[Correction, ...] = ()
    parts: tuple["Motor", ...] = ()
    spent: Float[Array, "knot"] | None = field(default=None, repr=False)
    drag: Float[Array, "knot"] | None = field(default=None, repr=False)
    remarks: tuple[str, ...] = ()

    @property
    def burning(self) -> tuple[float, float]:
        """Times at which the thrust first reaches and last leaves 5% of its peak. [s]"""
        return burning(self.time, self.thrust)

    @property
    def burn_time(self) -> float:
        """Duration between the first and the last time at which the thrust is 5% of its peak. [s]"""
        start, end = self.burning
        return end - start

    @property
    def burnout(self) -> float:
        """Time from ignition at which the thrust last leaves 5% of its peak; the delay starts there. [s]"""
        return self.burning[1]

    @property
    def thrust_end(self) -> float:
        """Time from ignition at which the curve ends. [s]"""
        return float(self.time[-1])

    @property
    def peak_thrust(self) -> float:
        """Highest thrust. [N]"""
        return float(self.thrust.max())

    @property
    def average_thrust(self) -> float:
        """Total impulse divided by burn time. [N]"""
        return self.total_impulse / self.burn_time

    @property
    def rated_burn(self) -> float:
        """The certified burn time, else that of the curve. [s]"""
        return self.burn_time if self.certified_burn is None else self.certified_burn

    @property
    def rated_thrust(self) -> float:
        """The average thrust that rules refer to: the certified one, else impulse over `rated_burn`; never the name's.
        [N]"""
        return self.total_impulse / self.rated_burn if self.certified_average is None else self.certified_average

    @property
    def loaded_mass(self) -> float:
        """Mass on the pad. [kg]"""
        return self.propellant_mass + self.casing_mass

    @property
    def moments(self) -> tuple[float, float]:
        """Mean [s] and variance [s^2] of time, weighted by the thrust."""
        mean = _integral(self.time, self.thrust, self.time) / self.total_impulse
        return mean, _integral(self.time, self.thrust, (self.time - mean) ** 2, mean) / self.total_impulse


def burning(time: Float[Array, "knot"], thrust: Float[Array, "knot"]) -> tuple[float, float]:
    """Times at which the thrust of a curve first reaches and last leaves 5% of its peak. [s]"""
    threshold = BURN_THRUST_FRACTION * float(thrust.max())
    first, last = np.flatnonzero(thrust >= threshold)[[0, -1]]
    up, down = slice(first - 1, first + 1), slice(last, last + 2)
    return (
        float(np.interp(threshold, thrust[up], time[up])),
        float(np.interp(threshold, thrust[down][::-1], time[down][::-1])),
    )


def _integral(
    time: Float[Array, "knot"], thrust: Float[Array, "knot"], weight: Float[Array, "knot"], centre: float | None = None
) -> float:
    """Integral of thrust times a weight, t or (t - center)^2, by Simpson's rule, which is exact for this cubic."""
    middle = (time[1:] + time[:-1]) / 2
    weight_there = middle if centre is None else (middle - centre) ** 2
    thrust_there = (thrust[1:] + thrust[:-1]) / 2
    product = thrust * weight
    return float(np.sum(np.diff(time) * (product[1:] + 4 * thrust_there * weight_there + product[:-1])) / 6)


def impulse(time: Float[Array, "knot"], thrust: Float[Array, "knot"]) -> float:
    """Integral of a piecewise linear thrust curve. [N s]"""
    return float(np.trapezoid(thrust, time))


def knots(time: Sequence[float], thrust: Sequence[float]) -> tuple[Float[Array, "knot"], Float[Array, "knot"]]:
    """Convert a recorded thrust curve [s], [N] to knots that start at (0, 0), end at zero thrust and strictly increase
    in time.

    A jump (a repeated time) becomes a ramp of at most 0.1 ms; so does thrust at time 0. A curve that starts later rises
    from (0, 0), and one that ends above zero falls to zero within one more interval of the same length as its last.
    Raises BadValue for fewer than two samples, decreasing times, a negative or infinite number, or no thrust at all.
    """
    t, f = np.array(time, dtype=float), np.array(thrust, dtype=float)
    if t.size < 2 or not (np.isfinite(t).all() and np.isfinite(f).all()):
        raise BadValue("found fewer than two samples or a value that is not a number, expected a thrust curve")
    if (np.diff(t) < 0).any() or t[0] < 0 or t[-1] == 0:
        raise BadValue("found times that do not increase, expected times that increase from 0")
    if (f < 0).any() or not f.any():
        raise BadValue("found negative or no thrust, expected thrust in newtons")
    if t[0] > 0 or f[0] > 0:
        t, f = np.append(0.0, t), np.append(0.0, f)
    if f[-1] > 0:
        steps = np.diff(t)
        t, f = np.append(t, t[-1] + steps[steps > 0][-1]), np.append(f, 0.0)
    fresh = np.append(True, (np.diff(t) > 0) | (np.diff(f) != 0))
    return _spread(t[fresh]), f[fresh]


def _spread(time: Float[Array, "knot"]) -> Float[Array, "knot"]:
    """The same times, with each repeated one moved later by a small amount, never past the next."""
    distinct, place, count = np.unique(time, return_inverse=True, return_counts=True)
    room = np.append(np.minimum(np.diff(distinct) / 2, _RAMP), _RAMP)
    turn = np.arange(time.size) - (np.cumsum(count) - count)[place]
    spread: Float[Array, "knot"] = time + room[place] * turn / count[place]
    return spread


def normalised(time: Float[Array, "knot"], thrust: Float[Array, "knot"], total_impulse: float) -> Float[Array, "knot"]:
    """The thrust scaled to the certified total impulse. [N]"""
    return thrust * (total_impulse / impulse(time, thrust))


def impulse_class(total_impulse: float) -> str:
    """The impulse class for a total impulse [N s]: A up to 2.5, B up to 5, each class twice the previous one.

    Source: NFPA 1125; below A the classes are written 1/2A, 1/4A and 1/8A.
    """
    if total_impulse <= 1.25:
        return "1/8A" if total_impulse <= 0.3125 else "1/4A" if total_impulse <= 0.625 else "1/2A"
    return chr(ord("A") + max(0, math.ceil(math.log2(total_impulse / 2.5) - 1e-9)))


def delays_text(delays: Sequence[float]) -> str:
    """Delays [s] as flyers write them: `4, 7, P`; a dash if none are recorded."""
    return ", ".join("P" if delay == PLUGGED_DELAY else f"{delay:g}" for delay in delays) or "-"


def without_motor(lift_off: float, motor: Motor) -> float:
    """Dry mass of a rocket from its mass on the pad with a motor [kg]. [kg] Raises BadValue if the motor is heavier."""
    if not lift_off > motor.loaded_mass:
        alone = f"the mass of {amount(motor.loaded_mass, 'g', 1)} of {motor.maker} {motor.designation}"
        raise BadValue(message(f"found a mass of {amount(lift_off, 'g', 1)}, expected more than {alone}"))
    return lift_off - motor.loaded_mass


def digest(motors: Sequence[Motor]) -> str:
    """SHA-256 of all figures and thrust curves of motors, for simulations that are saved with them."""
    found = hashlib.sha256()
    for motor in motors:
        found.update(repr(motor).encode() + motor.time.tobytes() + motor.thrust.tobytes())
    return found.hexdigest()


def describe(motor: Motor) -> dict[str, object]:
    """A summary of a motor, with the unit in the key: ready for JSON."""
    start, end = motor.burning
    return {
        "maker": motor.maker,
        "name": motor.name,
        "designation": motor.designation,
        "class": motor.impulse_class,
        "kind": motor.kind,
        "diameter_mm": round(motor.diameter * 1e3, 3),
        "length_mm": round(motor.length * 1e3, 3),
        "total_impulse_ns": round(motor.total_impulse, 4),
        "burn_time_s": round(end - start, 4),
        "average_thrust_n": round(motor.average_thrust, 4),
        "peak_thrust_n": round(motor.peak_thrust, 4),
        "propellant_g": round(motor.propellant_mass * 1e3, 4),
        "casing_g": round(motor.casing_mass * 1e3, 4),
        "delays": ["P" if delay == PLUGGED_DELAY else delay for delay in motor.delays],
        "available": motor.available,
        "case": motor.case,
        "propellant": motor.propellant,
        "url": motor.url,
        "certified_average_thrust_n": motor.certified_average,
        "certified_peak_thrust_n": motor.certified_peak,
        "certified_burn_time_s": motor.certified_burn,
        "curve": motor.curve,
        "corrections": [one.json() for one in motor.corrections],
        "estimated": list(motor.estimated),
        "source": motor.source,
    }
