"""The delay to buy or drill, from the distribution of coast time and the delay's own scatter."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from fieldkit.errors import ImpossibleFlight
from fieldkit.motors import Found
from fieldkit.motors.motor import PLUGGED
from fieldkit.plan.learnt import Learnt, outcomes
from fieldkit.shapes import Array, Float
from fieldkit.units import STANDARD_GRAVITY

SHARE, LEAST = 0.2, 1.5
"""How far a delay may be from what is printed: this share of it [1], and no less than this [s]. Source: NFPA 1125, as
cited in openrocket#3041; taken as two standard deviations, for makers stay within it."""


@dataclass(frozen=True, slots=True)
class Delay:
    """One delay: how far from apogee it fires [s], how fast the rocket then is [m/s], its chance to be too fast [1]."""

    delay: float
    after_apogee: tuple[float, float, float]
    speed: tuple[float, float, float]
    too_fast: float
    on_sale: bool

    def json(self) -> dict[str, Any]:
        """Ready for JSON, with the unit in the key."""
        names = ("p05", "p50", "p95")
        return {
            "delay_s": self.delay,
            "after_apogee_s": dict(zip(names, self.after_apogee, strict=True)),
            "eject_speed_mps": dict(zip(names, self.speed, strict=True)),
            "chance_too_fast": self.too_fast,
            "on_sale": self.on_sale,
        }


@dataclass(frozen=True, slots=True)
class Delays:
    """The coast from burnout to apogee [s], delays from best to worst, and what is to be said of them in words."""

    coast: tuple[float, float, float]
    delays: tuple[Delay, ...]
    words: tuple[str, ...]


def coast_time(learnt: Learnt, found: Found) -> Float[Array, "draw"]:
    """From burnout to apogee, as draws. [s] Raises ImpossibleFlight where the motor does not lift the rocket."""
    flown = outcomes(learnt, [learnt.plan.with_changes(delay=None)], [Found(found.motor, None)])
    coast = flown.of("coast_to_apogee")[:, 0] + flown.of("burn_time")[:, 0] - found.motor.burnout
    if np.isfinite(coast).mean() < 0.5:
        raise ImpossibleFlight(f"{found.motor.designation}: found too little thrust to lift the rocket, expected more")
    return np.asarray(coast[np.isfinite(coast)])


def delays(learnt: Learnt, found: Found, limit: float, step: float | None = None) -> Delays:
    """Judge the delays on sale and, with `step`, those drilled from the longest in such steps. [s]

    `limit` is the speed at ejection that is too fast [m/s]. Speed is that of free fall towards or away from
    apogee, without drag and without what the wind adds sideways. Best is the smallest mean square of it.
    """
    coast = coast_time(learnt, found)
    sold = [delay for delay in found.motor.delays if delay != PLUGGED]
    offered = list(sold)
    if step is not None and sold:
        offered += [cut for k in range(1, 50) if (cut := max(sold) - k * step) > 0 and cut not in sold]
    noise = np.random.default_rng([learnt.seed, 2]).normal(size=len(coast))
    judged = [_judged(delay, coast, noise, limit, delay in sold) for delay in offered]
    order = np.argsort([mean for mean, _ in judged])
    ranked = tuple(judged[i][1] for i in order)
    return Delays(_three(coast), ranked, tuple(_words(coast, found, sold, ranked)))


def _judged(delay: float, coast: Array, noise: Array, limit: float, on_sale: bool) -> tuple[float, Delay]:
    fires = np.maximum(delay + noise * max(SHARE * delay, LEAST) / 2, 0.0)
    after = fires - coast
    speed = STANDARD_GRAVITY * np.abs(after)
    mean = float(np.mean(speed**2))
    return mean, Delay(delay, _three(after), _three(speed), float(np.mean(speed > limit)), on_sale)


def _three(values: Array) -> tuple[float, float, float]:
    low, middle, high = np.quantile(values, (0.05, 0.5, 0.95))
    return float(low), float(middle), float(high)


def _words(coast: Array, found: Found, sold: Sequence[float], ranked: Sequence[Delay]) -> list[str]:
    """What cannot be, said in words."""
    name, middle = found.motor.designation, float(np.median(coast))
    if middle < 0:
        return [f"{name}: the rocket passes apogee {-middle:.1f} s before burnout, so no delay fits: it is too heavy."]
    if not found.motor.delays:
        return [f"{name}: no delays are on record; the best would be {middle:.1f} s."]
    if not sold:
        return [f"{name} is sold plugged alone: it has no ejection charge, the altimeter must deploy."]
    if middle < min(sold) - LEAST and ranked[0].delay == min(sold):
        return [f"{name}: coasts {middle:.1f} s, the shortest delay is {min(sold):g} s: every charge fires late."]
    if middle > max(sold) + LEAST:
        return [f"{name}: coasts {middle:.1f} s, the longest delay is {max(sold):g} s: every charge fires early."]
    return []
