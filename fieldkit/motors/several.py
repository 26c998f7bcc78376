"""Several motors as one: a cluster, whose thrusts add, some of it lit later, and two stages, of which the first drops.

What comes out is a motor like any other, so that the same physics flies it. Written as `3 x C6-5`,
`K550W + 2 x I211W@1.5` (lit 1.5 s after the first), or, lower stage first, `D12-0/C6-7`.
"""

import re
from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np

from fieldkit.errors import BadValue, UnknownMotor
from fieldkit.motors.motor import BURN_THRUST_FRACTION, Motor
from fieldkit.motors.names import is_cluster
from fieldkit.motors.search import Found
from fieldkit.shapes import Array

CLUSTER_NOTE = (
    "a cluster: thrusts are added as if every motor lights; the delay counts from the end of the last burn; changes in "
    "drag and failed ignitions are not modeled"
)
STAGES_NOTE = (
    "two stages: the booster drops at its burnout and the upper motor lights then; both fly on one diameter and one "
    "Cd, and the descent of the booster is not modeled"
)
DROP_TIME = 1e-3
"""In which a booster is gone. [s]"""
_COUNT = r"(?:(\d{1,2})\s*[x×*]?\s+|(\d{1,2})\s*[x×*]\s*)?"
_GROUP = re.compile(_COUNT + r"([^@]+?)(?:\s*@\s*(\d+(?:\.\d+)?)\s*s?)?", re.IGNORECASE)
_FRACTION = "\N{FRACTION SLASH}"
"""Replaces the slash of a class such as 1/2A while stages are separated."""
MAX_MOTORS = 20
"""In a cluster. [1]"""


_SEVERAL_MARKS = re.compile(r"^\s*\d{1,2}\s*[x×*]\s*\w|\s\+\s|@\s*\d", re.IGNORECASE)


def names_several(text: str) -> bool:
    """Whether a text names several motors, makers and air-starts included."""
    return is_cluster(text) or _SEVERAL_MARKS.search(text) is not None


def names_stages(text: str) -> bool:
    """Whether a text names several stages, as in `D12-0/C6-7`."""
    return len(_stages(text)) > 1


def _stages(text: str) -> list[str]:
    """The stages that a text names, lowest first, each as its motors; the slash of 1/2A separates none."""
    halves = re.sub(r"\b1/(?=[248]A)", f"1{_FRACTION}", text.strip())
    return [part.strip().replace(_FRACTION, "/") for part in halves.split("/") if part.strip()]


def resolve_several(text: str, resolve: Callable[[str], Found], booster_mass: float | None = None) -> Found:
    """The motors that a text names, as one; a booster's airframe without its motor weighs `booster_mass` [kg].

    Raises UnknownMotor for what cannot be flown as one: three stages, or a booster of unknown mass.
    """
    stages = _stages(text)
    if len(stages) == 1:
        return _cluster(text, resolve)
    if len(stages) > 2:
        raise UnknownMotor(f"{text}: found {len(stages)} stages, expected at most two: more are not modeled")
    if booster_mass is None:
        raise UnknownMotor(
            f"{text}: found two stages, expected fieldkit simulate with --booster-mass, the booster without its motor, "
            "as in 60g: no other command flies them"
        )
    booster, sustainer = (_cluster(stage, resolve) for stage in stages)
    motor = two_stages(booster.motor, sustainer.motor, booster_mass)
    return Found(motor, sustainer.delay, (*booster.notes, *sustainer.notes, STAGES_NOTE))


def _cluster(text: str, resolve: Callable[[str], Found]) -> Found:
    """One motor, or several that burn together. Raises UnknownMotor."""
    parts: list[tuple[Motor, float]] = []
    delay: float | None = None
    notes: list[str] = []
    for group in re.split(r"\s*\+\s*", text.strip()):
        named = _GROUP.fullmatch(group)
        if named is None:
            raise UnknownMotor(f"{text}: found {group!r}, expected motors such as 3 x C6-5")
        found = resolve(named[3])
        notes += found.notes
        delay = found.delay if delay is None else delay
        count = int(named[1] or named[2] or 1)
        if not 1 <= count <= MAX_MOTORS:
            raise UnknownMotor(f"{text}: found {count} motors, expected 1 to {MAX_MOTORS}")
        parts += [(found.motor, float(named[4] or 0.0))] * count
    if len(parts) == 1 and parts[0][1] == 0:
        return Found(parts[0][0], delay, tuple(notes))
    return Found(clustered(parts), delay, (*dict.fromkeys(notes), CLUSTER_NOTE))


def clustered(parts: Sequence[tuple[Motor, float]]) -> Motor:
    """Motors that burn together, each lit so long after the first [s]. Raises BadValue if none is lit at first."""
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
        corrections=(),
        parts=motors,
        spent=_spent([(motor, start) for motor, start in parts], time),
    )


def two_stages(booster: Motor, sustainer: Motor, booster_mass: float, gap: float = 0.0) -> Motor:
    """A booster below a sustainer, which is lit so long after the booster's end [s], when its airframe [kg], without
    its motor, and its casing are dropped. What counts as propellant is all that is gone at the end.

    Raises BadValue for an upper motor too weak for its end to be distinguished from that of the lower.
    """
    end = booster.thrust_end
    if sustainer.peak_thrust < 2 * BURN_THRUST_FRACTION * booster.peak_thrust:
        raise BadValue(f"{sustainer.designation}: found too little thrust over {booster.designation} for two stages")
    start = end + max(gap, DROP_TIME)
    time, thrust = _added([(booster.time, booster.thrust), (sustainer.time + start, sustainer.thrust)], [end, start])
    dropped = booster_mass + booster.casing_mass
    gone = booster.propellant_mass + dropped + sustainer.propellant_mass
    burnt = np.interp(time, *_burnt(booster, 0.0)) * booster.propellant_mass
    burnt += np.interp(time, *_burnt(sustainer, start)) * sustainer.propellant_mass
    burnt += np.interp(time, [end, end + DROP_TIME], [0.0, dropped])
    return replace(
        sustainer,
        designation=f"{booster.designation}/{sustainer.designation}",
        kind="two stages",
        total_impulse=booster.total_impulse + sustainer.total_impulse,
        propellant_mass=gone,
        time=time,
        thrust=thrust,
        certified_average=booster.certified_average,
        certified_peak=None,
        corrections=(),
        parts=((booster.parts or (booster,)) + (sustainer.parts or (sustainer,))),
        spent=np.asarray(burnt / gone),
    )


def _added(curves: Sequence[tuple[Array, Array]], more: Sequence[float] = ()) -> tuple[Array, Array]:
    """Curves of thrust as one, its knots those of all, beginning at (0, 0)."""
    knots = np.unique(np.round(np.concatenate([[0.0], *(time for time, _ in curves), np.array(more)]), 9))
    thrust = sum(np.interp(knots, time, push, left=0.0, right=0.0) for time, push in curves)
    return knots, np.asarray(thrust)


def _burnt(motor: Motor, start: float) -> tuple[Array, Array]:
    """The fraction of a motor's propellant that is burned, against time from the first ignition."""
    fine = np.unique(np.concatenate([motor.time, np.linspace(0.0, motor.thrust_end, 200)]))
    push = np.interp(fine, motor.time, motor.thrust)
    done = np.concatenate([[0.0], np.cumsum(0.5 * np.diff(fine) * (push[1:] + push[:-1]))])
    return fine + start, done / done[-1]


def _spent(parts: Sequence[tuple[Motor, float]], time: Array) -> Array:
    """The fraction of all propellant that is burned at some times."""
    total = sum(motor.propellant_mass for motor, _ in parts)
    return np.asarray(
        sum(np.interp(time, *_burnt(motor, start)) * motor.propellant_mass for motor, start in parts) / total
    )


def _named(parts: Sequence[tuple[Motor, float]]) -> str:
    counted: dict[tuple[str, float], int] = {}
    for motor, start in parts:
        counted[motor.designation, start] = counted.get((motor.designation, start), 0) + 1
    names = [
        f"{f'{count} x ' if count > 1 else ''}{name}{f'@{start:g}' if start else ''}"
        for (name, start), count in counted.items()
    ]
    return " + ".join(names)
