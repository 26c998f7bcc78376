"""Combine several motors into one: a cluster, whose thrusts add up and which may include air starts, or stages, all but
the last of which drop.

The result is an ordinary motor, so the same physics simulates it. Written as `3 x C6-5`, `K550W + 2 x I211W@1.5` (lit
1.5 s after the first), or, lower stage first, `D12-0/C6-7`.
"""

import re
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from fieldkit.errors import BadValue, UnknownMotor
from fieldkit.flight import Flight
from fieldkit.flight.plan import STAGED_TAG
from fieldkit.integrals import running_integral
from fieldkit.motors.motor import BURN_THRUST_FRACTION, PLUGGED_DELAY, Motor
from fieldkit.motors.names import MAX_NAME, count_first, is_cluster
from fieldkit.motors.search import Found
from fieldkit.shapes import Array

ONE_UNLIT = "with one of three unlit the flight is 29 to 46% lower"
"""`fieldkit simulate` of three C6-5 and of two in rockets of 120 g, 42 mm and of 300 g, 66 mm, with a Cd of 0.6."""
CLUSTER_NOTE = (
    "a cluster: thrusts are added as if every motor lights; the delay counts from the end of the last burn; changes in "
    f"drag and failed ignitions are not modeled: {ONE_UNLIT}"
)
STAGES_NOTE = (
    "stages: a booster drops at its burnout, and the next motor lights at once; the Cd is that of the top stage, and "
    "of the rocket with its boosters too unless --booster-cd states another, so boosters that drag more fly lower, "
    "with a tenth more Cd by 0.1 to 0.4%; the descent of boosters is not modeled"
)
DROP_TIME = 1e-3
"""Time within which a booster drops. [s]"""
_COUNT = r"(?:(\d{1,2})\s*[x×*]?\s+|(\d{1,2})\s*[x×*]\s*)?"
_MAKER_FIRST = re.compile(r"^\s*([^\W\d_][^\d/@+]*?)\s+(\d{1,2}\s*[x×*])\s*(?=\w)", re.IGNORECASE)
"""A cluster named as printed, `Estes 3 x C6`: maker, count."""
_GROUP = re.compile(_COUNT + r"([^@]+?)(?:\s*@\s*(\d+(?:\.\d+)?)\s*s?)?", re.IGNORECASE)
_FRACTION = "\N{FRACTION SLASH}"
"""Replaces the slash of a class such as 1/2A while stages are split."""
MAX_MOTORS = 20
"""Maximum number of motors in a cluster. [1]"""
MAX_STAGES = 3
"""Maximum number of stages, the largest number checked against other programs. [1]"""


_SEVERAL_MARKS = re.compile(rf"^\s*\d{{1,2}}\s*[x×*]\s*\w|{_MAKER_FIRST.pattern}|\s\+\s|@\s*\d", re.IGNORECASE)


def names_several(text: str) -> bool:
    """Whether a text names several motors, including makers and air starts."""
    return is_cluster(text) or (len(text) <= MAX_NAME and _SEVERAL_MARKS.search(text) is not None)


def names_stages(text: str) -> bool:
    """Whether a text names several stages, as in `D12-0/C6-7`."""
    return len(_stages(text)) > 1


def tag_of_several(motor: str) -> str:
    """The tag of a flight on several motors by the text of its motor; empty for a single one."""
    if not names_several(motor):
        return ""
    return STAGED_TAG if names_stages(motor) else "cluster"


def tagged(flight: Flight) -> Flight:
    """A flight with a tag for a cluster or stages, if its motor field names several."""
    tag = tag_of_several(flight.motor)
    if not tag:
        return flight
    return flight.with_changes(tags=tuple(dict.fromkeys((*flight.tags, tag))))


def _stages(text: str) -> list[str]:
    """The stages in a text, lowest first, each as its motors; the slash of 1/2A does not split stages."""
    if len(text) > MAX_NAME:
        return [text]
    halves = re.sub(r"\b1/(?=[248]A)", f"1{_FRACTION}", text.strip())
    return [part.strip().replace(_FRACTION, "/") for part in halves.split("/") if part.strip()]


SOONEST_CHARGE = 0.1
"""Least delay of a cluster whose first charge fires before the last motor is burned out: 0 means no charge. [s]"""


@dataclass(frozen=True, slots=True)
class Booster:
    """A lower stage without its motor: its mass [kg], and the ratio of the rocket's drag with it to that of the
    uppermost stage [1].
    """

    mass: float
    drag: float = 1.0


def resolve_several(text: str, resolve: Callable[[str], Found], boosters: Sequence[Booster] = ()) -> Found:
    """Combine the motors in a text into one; `boosters` are the lower stages, lowest first.

    Raises UnknownMotor for unsupported combinations: more than three stages, or unknown boosters.
    Raises BadValue for a cluster without a motor lit at first, and for an upper motor too weak for its burnout to be
    distinguished from the booster's.
    """
    stages = _stages(text)
    if len(stages) == 1:
        return _cluster(text, resolve)
    if len(stages) > MAX_STAGES:
        raise UnknownMotor(f"{text}: found {len(stages)} stages, expected at most {MAX_STAGES}: more are not modeled")
    if len(boosters) != len(stages) - 1:
        wanted = "60g" if len(stages) == 2 else "60g/40g, lowest first"
        raise UnknownMotor(
            f"{text}: found {len(stages)} stages, expected fieldkit simulate with --booster-mass, "
            f"each booster without its motor, as in {wanted}: no other command flies them"
        )
    found = [_cluster(stage, resolve) for stage in stages]
    motor = found[-1].motor
    for one, booster in zip(found[-2::-1], reversed(boosters), strict=True):
        motor = two_stages(one.motor, motor, booster)
    notes = dict.fromkeys(note for one in found for note in one.notes)
    return Found(motor, found[-1].delay, (*notes, STAGES_NOTE))


def _cluster(text: str, resolve: Callable[[str], Found]) -> Found:
    """One motor, or a cluster. Raises UnknownMotor, BadValue."""
    lit = _lit_motors(text, resolve)
    parts = [(found.motor, start) for found, start in lit]
    delays, notes = [found.delay for found, _ in lit], [note for found, _ in lit for note in found.notes]
    if len(parts) == 1 and parts[0][1] == 0:
        return Found(parts[0][0], delays[0], tuple(notes))
    motor = clustered(parts)
    return Found(motor, _first_charge(parts, delays, motor), (*dict.fromkeys(notes), CLUSTER_NOTE))


def _lit_motors(text: str, resolve: Callable[[str], Found]) -> list[tuple[Found, float]]:
    """Every motor of one motor or cluster, with its ignition time after the first [s]. Raises UnknownMotor."""
    lit: list[tuple[Found, float]] = []
    for group in map(str.strip, text.split("+")):
        named = _GROUP.fullmatch(_MAKER_FIRST.sub(r"\2 \1 ", count_first(group)))
        if named is None:
            raise UnknownMotor(f"{text}: found {group!r}, expected motors such as 3 x C6-5")
        count = int(named[1] or named[2] or 1)
        if not 1 <= count <= MAX_MOTORS:
            raise UnknownMotor(f"{text}: found {count} motors, expected 1 to {MAX_MOTORS}")
        lit += [(resolve(named[3]), float(named[4] or 0.0))] * count
        if len(lit) > MAX_MOTORS:
            raise UnknownMotor(f"{text}: found more than {MAX_MOTORS} motors, expected 1 to {MAX_MOTORS}")
    return lit


def each_motor(text: str, resolve: Callable[[str], Found]) -> list[Found]:
    """Every motor that a text names, one motor or those of a cluster or of stages. Raises UnknownMotor."""
    return [found for stage in _stages(text) for found, _ in _lit_motors(stage, resolve)]


def _first_charge(parts: Sequence[tuple[Motor, float]], delays: Sequence[float | None], cluster: Motor) -> float | None:
    """Time from the burnout of a cluster to the first ejection charge, each of which fires its delay after the burnout
    of its own motor [s]; not before the burnout, 0 if there are only boosters, `PLUGGED_DELAY` if all are plugged, None
    if no delay is known.
    """
    timed = [(motor, start, delay) for (motor, start), delay in zip(parts, delays, strict=True) if delay is not None]
    fires = [start + motor.burnout + delay for motor, start, delay in timed if 0 < delay < PLUGGED_DELAY]
    if fires:
        return max(round(min(fires) - cluster.burnout, 3), SOONEST_CHARGE)
    return min((delay for *_, delay in timed), default=None)


def clustered(parts: Sequence[tuple[Motor, float]]) -> Motor:
    """Combine motors, each with its ignition time after the first [s]. Raises BadValue if none is lit at first."""
    if min(start for _, start in parts) > 0:
        raise BadValue("found no motor lit at the start, expected one without @")
    time, thrust = _added([(motor.time + start, motor.thrust) for motor, start in parts])
    first, motors = parts[0][0], tuple(motor for motor, _ in parts)
    together = all(start == 0 for _, start in parts)
    known = [motor.certified_average for motor in motors]
    return replace(
        first,
        maker=first.maker,
        designation=_named(parts),
        kind="cluster",
        total_impulse=sum(motor.total_impulse for motor in motors),
        propellant_mass=sum(motor.propellant_mass for motor in motors),
        casing_mass=sum(motor.casing_mass for motor in motors),
        time=time,
        thrust=thrust,
        certified_average=sum(one or 0.0 for one in known) if together and all(known) else None,
        certified_peak=None,
        certified_burn=None,
        curve="",
        corrections=(),
        parts=motors,
        spent=_spent([(motor, start) for motor, start in parts], time),
    )


def two_stages(lower: Motor, upper: Motor, booster: Booster) -> Motor:
    """Combine a booster and an upper motor, which may itself have stages and lights as soon as the booster's airframe
    and casing have dropped, at the end of its thrust curve. Everything dropped or burned by the end counts as
    propellant.

    Raises BadValue for an upper motor too weak for its burnout to be distinguished from the booster's.
    """
    end = lower.thrust_end
    if upper.peak_thrust < 2 * BURN_THRUST_FRACTION * lower.peak_thrust:
        raise BadValue(f"{upper.designation}: found too little thrust over {lower.designation} for two stages")
    start = end + DROP_TIME
    time, thrust = _added([(lower.time, lower.thrust), (upper.time + start, upper.thrust)], [end, start])
    dropped = booster.mass + lower.casing_mass
    gone = lower.propellant_mass + dropped + upper.propellant_mass
    burnt = np.interp(time, *_burnt(lower, 0.0)) * lower.propellant_mass
    burnt += np.interp(time, *_burnt(upper, start)) * upper.propellant_mass
    burnt += np.interp(time, [end, end + DROP_TIME], [0.0, dropped])
    return replace(
        upper,
        designation=f"{lower.designation}/{upper.designation}",
        kind="stages",
        total_impulse=lower.total_impulse + upper.total_impulse,
        propellant_mass=gone,
        time=time,
        thrust=thrust,
        certified_average=lower.certified_average,
        certified_peak=None,
        certified_burn=None,
        curve="",
        corrections=(),
        parts=((lower.parts or (lower,)) + (upper.parts or (upper,))),
        spent=np.asarray(burnt / gone),
        drag=_drag(time, start, booster.drag, upper),
    )


def _drag(time: Array, start: float, below: float, upper: Motor) -> Array | None:
    """Ratio of the drag from each knot on to that of the uppermost stage [1], `below` until the upper motor lights [s];
    None if it is constant."""
    if below == 1 and upper.drag is None:
        return None
    later = np.ones(len(time))
    if upper.drag is not None:
        later = upper.drag[np.clip(np.searchsorted(upper.time, time - start + 1e-9, side="right") - 1, 0, None)]
    return np.where(time < start - 1e-9, below, later)


def _added(curves: Sequence[tuple[Array, Array]], more: Sequence[float] = ()) -> tuple[Array, Array]:
    """Sum of thrust curves, on all their knots, starting at (0, 0)."""
    knots = np.unique(np.round(np.concatenate([[0.0], *(time for time, _ in curves), np.array(more)]), 9))
    thrust = sum(np.interp(knots, time, push, left=0.0, right=0.0) for time, push in curves)
    return knots, np.asarray(thrust)


def _burnt(motor: Motor, start: float) -> tuple[Array, Array]:
    """Fraction of a motor's propellant burned, against time from the first ignition."""
    if motor.spent is not None:
        return motor.time + start, motor.spent
    fine = np.unique(np.concatenate([motor.time, np.linspace(0.0, motor.thrust_end, 200)]))
    push = np.interp(fine, motor.time, motor.thrust)
    done = running_integral(push, fine)
    return fine + start, done / done[-1]


def _spent(parts: Sequence[tuple[Motor, float]], time: Array) -> Array:
    """Fraction of all propellant burned at given times."""
    total = sum(motor.propellant_mass for motor, _ in parts)
    return np.asarray(
        sum(np.interp(time, *_burnt(motor, start)) * motor.propellant_mass for motor, start in parts) / total
    )


def _named(parts: Sequence[tuple[Motor, float]]) -> str:
    """The motors of a cluster as they can be typed after the first one's maker: `C6 + 2 x Quest B6@1.5`."""
    counted: dict[tuple[str, str, float], int] = {}
    for motor, start in parts:
        key = motor.maker, motor.designation, start
        counted[key] = counted.get(key, 0) + 1
    first = parts[0][0].maker
    names: list[str] = []
    for (maker, name, start), count in counted.items():
        own = "" if not names and maker == first else f"{maker} "
        names.append(f"{f'{count} x ' if count > 1 else ''}{own}{name}{f'@{start:g}' if start else ''}")
    return " + ".join(names)
