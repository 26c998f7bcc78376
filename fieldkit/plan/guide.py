"""The motor guide: every motor that fits a rocket, flown on what its flights taught, nearest to a target first."""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from fieldkit.errors import UnknownMotor
from fieldkit.motors import Catalogue, Found
from fieldkit.motors.motor import PLUGGED, Motor
from fieldkit.plan.learnt import Learnt, Outcomes, outcomes
from fieldkit.plan.limits import Limits
from fieldkit.plan.safety import Line, safety_lines, thrust_to_weight

SAME = 0.0006
"""By how much two diameters of one mount may differ. [m]"""


@dataclass(frozen=True, slots=True)
class Wanted:
    """What a motor must be. Lengths in m, impulse in N s, `classes` first and last letter."""

    mount: float
    length: float = math.inf
    impulse: float = math.inf
    classes: tuple[str, str] | None = None
    retired: bool = False
    adapter: bool = False

    def fits(self, motor: Motor) -> bool:
        """Whether a motor is all of it."""
        wide = motor.diameter - self.mount
        return (
            (wide < SAME if self.adapter else abs(wide) < SAME)
            and motor.length <= self.length + SAME
            and motor.total_impulse <= self.impulse
            and (self.retired or motor.available)
            and (self.classes is None or self.classes[0] <= _letter(motor) <= self.classes[1])
        )


def _letter(motor: Motor) -> str:
    return "A" if "/" in motor.impulse_class else motor.impulse_class


@dataclass(frozen=True, slots=True)
class Choice:
    """A motor of the guide: quantiles at 5, 50 and 95 % in SI, delays with when they fire after apogee [s]."""

    motor: Motor
    apogee: tuple[float, float, float]
    true_apogee: tuple[float, float, float]
    rail_speed: float
    top_speed: float
    first_thrust: float
    average_thrust: float
    ejections: dict[float, float]
    flown: bool
    lines: tuple[Line, ...]

    @property
    def failed(self) -> list[Line]:
        """The safety lines that are not well, and known."""
        return [line for line in self.lines if line.verdict in ("caution", "unsafe")]

    def json(self) -> dict[str, Any]:
        """Ready for JSON, with the unit in the key."""
        names = ("p05", "p50", "p95")
        return {
            "maker": self.motor.maker,
            "motor": self.motor.designation,
            "class": self.motor.impulse_class,
            "apogee_m": dict(zip(names, self.apogee, strict=True)),
            "true_apogee_m": dict(zip(names, self.true_apogee, strict=True)),
            "rail_speed_mps": self.rail_speed,
            "top_speed_mps": self.top_speed,
            "thrust_to_weight": {"first_half_second": self.first_thrust, "average": self.average_thrust},
            "apogee_to_eject_s": [{"delay_s": d, "after_apogee_s": after} for d, after in self.ejections.items()],
            "flown": self.flown,
            "safety": [line.json() for line in self.lines],
        }


def mount_of(found: Sequence[Found]) -> float:
    """The mount of a rocket, known from the widest motor it flew. [m] Raises UnknownMotor without any."""
    if not found:
        raise UnknownMotor("found no flights to know the motor mount from, expected --mount such as 29mm")
    return max(item.motor.diameter for item in found)


def fitting(catalogue: Catalogue, wanted: Wanted) -> list[Motor]:
    """The motors that fit, from the catalogue and the flyer's own. Raises UnknownMotor where none does."""
    near = [
        listing
        for listings in catalogue.shelf.values()
        for listing in listings
        if listing.diameter < wanted.mount + SAME and (wanted.retired or listing.available)
    ]
    motors = [motor for listing in near if wanted.fits(motor := listing.motor())]
    if not motors:
        raise UnknownMotor(
            f"found no motor for a {wanted.mount * 1e3:g} mm mount within these limits, expected wider ones"
        )
    return motors


def guide(
    learnt: Learnt, motors: Sequence[Motor], limits: Limits, target: float | None = None, waiver: float | None = None
) -> list[Choice]:
    """All of these motors flown in one batch, nearest to the target first, else highest first.

    Each flies with the delay that fires nearest to apogee for its safety lines.
    """
    plain = learnt.plan.with_changes(delay=None)
    found = [Found(motor, None) for motor in motors]
    first = outcomes(learnt, [plain] * len(found), found)
    burnouts = [motor.burnout for motor in motors]
    starts = first.of("coast_to_apogee") + first.of("burn_time")
    choices = [_choice(learnt, first, i, starts[:, i] - burnouts[i], limits, waiver) for i in range(len(found))]
    if target is None:
        return sorted(choices, key=lambda choice: -choice.apogee[1])
    return sorted(choices, key=lambda choice: abs(choice.apogee[1] - target))


def _choice(learnt: Learnt, flown: Outcomes, i: int, coast: Any, limits: Limits, waiver: float | None) -> Choice:
    motor = flown.found[i].motor
    column = {name: np.nan_to_num(values[:, i]) for name, values in flown.figures.items()}
    lifted = bool((column["apogee"] > 0).mean() > 0.5)
    middle = float(np.nanmedian(coast)) if lifted else math.nan
    ejections = {d: d - middle for d in motor.delays if d != PLUGGED and lifted}
    nearest = min(ejections, key=lambda d: abs(ejections[d]), default=None)
    # near apogee the rocket gathers free-fall speed either way
    speeds = np.full(len(coast), np.nan) if nearest is None else 9.80665 * np.abs(nearest - coast)
    first, average = thrust_to_weight(motor, learnt.plan.dry_mass or math.nan)
    lines = safety_lines(learnt.plan, motor, column["rail_speed"], speeds, column["true"], limits, waiver)
    return Choice(
        motor=motor,
        apogee=_three(column["apogee"]),
        true_apogee=_three(column["true"]),
        rail_speed=float(np.median(column["rail_speed"])),
        top_speed=float(np.median(column["top_speed"])),
        first_thrust=first,
        average_thrust=average,
        ejections=ejections,
        flown=id(motor) in learnt.stand_in,
        lines=tuple(lines),
    )


def _three(values: Any) -> tuple[float, float, float]:
    low, middle, high = np.quantile(values, (0.05, 0.5, 0.95))
    return float(low), float(middle), float(high)
