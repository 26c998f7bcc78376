"""Rank motors for a contest by their expected points; a change is recommended only if it is significant."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

from fieldkit.planning.contest import Season
from fieldkit.planning.contest_limits import allowed
from fieldkit.planning.descent import common_durations
from fieldkit.planning.gain import gain_json, gain_of, is_clear
from fieldkit.planning.motor_guide import MotorChoice, label
from fieldkit.planning.quantiles import named, three
from fieldkit.shapes import Array, Float


@dataclass(frozen=True, slots=True)
class MotorPoints:
    """The points of a flight on a motor, as draws. [1]"""

    choice: MotorChoice
    points: Float[Array, "draw"]

    @property
    def mean(self) -> float:
        """Expected points. [1]"""
        return float(self.points.mean())

    def json(self) -> dict[str, Any]:
        """Ready for JSON."""
        motor = self.choice.motor
        return {
            "maker": motor.maker,
            "motor": motor.designation,
            "points": {"mean": self.mean, **named(three(self.points))},
        }


@dataclass(frozen=True, slots=True)
class MotorAdvice:
    """Motors that fit and that a season allows, fewest points first, and the `current` one whether it fits or not, None
    if it was not forecast.

    `gain` is the mean improvement of the first in points per flight [1], `gain_error` its standard error, with as many
    flights as the forecast is based on; both None without a current motor.
    """

    ranked: tuple[MotorPoints, ...]
    current: MotorPoints | None
    gain: float | None
    gain_error: float | None

    @property
    def clear(self) -> bool:
        """Whether a change is worth it: the points it saves are significant."""
        if self.gain is None or self.gain_error is None:
            return False
        return is_clear(self.gain, self.gain_error)

    def json(self) -> dict[str, Any]:
        """Ready for JSON, with the unit in the key."""
        return {
            "motors": [one.json() for one in self.ranked],
            "current": self.current.choice.motor.designation if self.current else None,
            **gain_json(self.gain, self.gain_error, self.clear),
        }


def in_season(choice: MotorChoice, rule: Season) -> MotorChoice:
    """A motor held to the limits of a season and to the flyer's copy of its list of motors, if there is one.

    Raises BadValue for a damaged file of rules.
    """
    lines = allowed(rule, choice.plan, choice.prediction.found)
    return replace(choice, beyond_season=tuple(line for line in lines if line.verdict == "unsafe"))


def motor_advice(choices: Sequence[MotorChoice], rule: Season, current: str | None) -> MotorAdvice:
    """The points of motors `in_season` under its rules; `current` is the `label` of the current motor.

    All motors share the same draws, so their differences are known better than the points themselves.
    """
    ranked = sorted((MotorPoints(one, _points(one, rule)) for one in choices if one.fits), key=lambda one: one.mean)
    flown = next((one for one in choices if label(one.motor) == current), None)
    now = None if flown is None else MotorPoints(flown, _points(flown, rule))
    if now is None or not ranked:
        return MotorAdvice(tuple(ranked), now, None, None)
    saved = now.points - ranked[0].points
    return MotorAdvice(tuple(ranked), now, *gain_of(saved, now.choice.prediction.rests_on))


def _points(choice: MotorChoice, rule: Season) -> Float[Array, "draw"]:
    duration = common_durations([choice.prediction], choice.fall, seed=9)[:, 0]
    return rule.points(choice.prediction.apogee, duration)
