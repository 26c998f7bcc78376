"""The safety lines of the descent: whether the parachute is too small or too large, and drogue and main of a rocket
with both.

Derivation: drag balances weight, so the speed is inversely proportional to the parachute's diameter.
"""

from collections.abc import Iterator

import numpy as np

from fieldkit.flight.recovery import Device, Recovery
from fieldkit.physics.descent import DescentResult
from fieldkit.planning.check import UNSAFE_RISK, SafetyCheck, Verdict, figure, length, speed
from fieldkit.planning.descent_rate import DEFAULT_DESCENT_SD, Fall
from fieldkit.planning.limits import Limits

NAME = "landing speed"
ASSUMED = f"assumed, ± {DEFAULT_DESCENT_SD:.0%}"
STILL_SLOWING = 1.2
"""Ratio of the landing speed to the speed under the open device above which it opened too low to slow the rocket, and
not because of its size. [1]"""


def landing_speed_line(
    down: DescentResult, device: Device, mass: float, density: float, fall: Fall, limits: Limits
) -> SafetyCheck:
    """The median speed under the last device of a rocket of a landing mass [kg], in air of a density at the pad
    [kg/m^3], against guidance; unknown if no flight shows it and none is entered."""
    opened, slow, most = down.ballistic < 1, limits["landing_speed_slow"], limits["landing_speed"]
    if down.ballistic.mean() >= UNSAFE_RISK:
        return SafetyCheck(NAME, "unsafe", "probably hits the ground before anything opens", most.source)
    found = float(np.median(down.landing_speed[opened]))
    bounds = f"at most {speed(most.value)}"
    if device == "parachute":
        bounds = f"usual {speed(slow.value)} to {speed(limits['landing_speed_usual'].value)}, {bounds}"
    if fall.assumed:
        text = f"{speed(found)} {ASSUMED}; enter the parachute or a descent speed; {bounds}"
        return SafetyCheck(NAME, "unknown", text, most.source)
    if slow.value <= found <= most.value:
        return SafetyCheck(NAME, "ok", f"{speed(found)}; {bounds}", most.source)
    if found > STILL_SLOWING * np.exp(fall.log_mean) * np.sqrt(mass / density):
        remedy = f": the {device} opens too low to slow it down"
    else:
        remedy = _remedy(found, limits) if device == "parachute" else ""
    text = f"{speed(found)}; {bounds}{remedy}"
    if found < slow.value:
        return SafetyCheck(NAME, "caution", text, slow.source)
    return _too_fast(text, mass * found**2 / 2, limits)


def two_device_lines(
    recovery: Recovery, mass: float, density: float, fall: Fall, limits: Limits
) -> Iterator[SafetyCheck]:
    """The speed under a drogue near the ground, and the height at which the main opens, of a rocket of a landing mass
    [kg] in air of a density at the pad [kg/m^3], against guidance; nothing for a rocket with one device."""
    if recovery.main_altitude is None or fall.drogue is None:
        return
    slow, fast = limits["drogue_speed_slow"], limits["drogue_speed"]
    found = fall.drogue.usual_speed(mass, density)
    text = f"usual {speed(slow.value)} to {speed(fast.value)}"
    if fall.drogue.assumed:
        yield SafetyCheck("drogue speed", "unknown", f"{speed(found)} {ASSUMED}; enter it; {text}", fast.source)
    else:
        why, limit = (": drifts far", slow) if found < slow.value else (": strains the main", fast)
        inside = slow.value <= found <= fast.value
        verdict: Verdict = "ok" if inside else "caution"
        yield SafetyCheck("drogue speed", verdict, f"{speed(found)}; {text}{'' if inside else why}", limit.source)
    low, high = limits["main_altitude_low"], limits["main_altitude"]
    wanted = f"usual {length(low.value)} to {length(high.value)}"
    limit, verdict = (low if recovery.main_altitude < low.value else high), "caution"
    if low.value - 1e-6 <= recovery.main_altitude <= high.value + 1e-6:
        verdict = "ok"
    yield SafetyCheck("main altitude", verdict, f"opens at {length(recovery.main_altitude)}; {wanted}", limit.source)


def _remedy(found: float, limits: Limits) -> str:
    """The width of the parachute that lands at the nearer end of the usual speeds, relative to the current one."""
    slow, usual = limits["landing_speed_slow"].value, limits["landing_speed_usual"].value
    end, more = (slow, " and drifts less") if found < slow else (usual, "")
    return f": a parachute {found / end:.2g} times as wide lands at {speed(end)}{more}"


def _too_fast(text: str, energy: float, limits: Limits) -> SafetyCheck:
    """Unsafe with too much energy [J] in all, which assumes that the rocket lands in one piece."""
    hard = limits["landing_energy"]
    if energy <= hard.value:
        return SafetyCheck(NAME, "caution", text, limits["landing_speed"].source)
    text += f"; {figure(energy, 'J')} if it lands in one piece, at most {figure(hard.value, 'J')}"
    return SafetyCheck(NAME, "unsafe", text, hard.source)
