"""Featherweight Raven: channels next to each other, each with a separate clock."""

import numpy as np

from fieldkit.physics.standard_atmosphere import GRAVITY
from fieldkit.units import FOOT
from tools.samples.one_parachute import ATM, flight
from tools.samples.writing import noise


def raven_fip() -> dict[str, bytes]:
    made = flight(thrust=80.0, burn=1.5, descent=11.0)
    fast = np.arange(0.0, 12.0, 0.0125)
    slow = np.arange(0.0, made.time[-1], 0.25)
    burnout, top = 1.5, made.time_to_apogee

    def flags(time: float) -> str:
        return "b" + "".join(str(int(time >= when)) for when in (0.1, 0.2, burnout, top))

    ends = np.arange(0.04, top, 0.25)
    height = made.at(slow, made.height) + noise(7, len(slow), 0.2)
    channels = [
        ("Axial Accel (Gs)", fast, made.at(fast, made.felt) / GRAVITY, ".2f"),
        ("Baro (Atm)", slow + 0.04375, made.pressure(height) / ATM, ".5f"),
        ("Velocity (Accel-Ft/Sec)", ends, made.at(ends, made.speed) / FOOT, ".1f"),
        ("Volts Battery (V)", slow + 0.03375, np.full(len(slow), 4.06), ".2f"),
        ("[Altitude (Baro-Ft-AGL)]", slow + 0.04375, height / FOOT, ".6g"),
    ]
    text = ",".join(f"Time@{name},{name},bILBA" for name, *_ in channels) + "\r\n"
    for i in range(max(len(c[1]) for c in channels)):
        row = [f"{t[i]:.6g},{v[i]:{form}},{flags(t[i])}" if i < len(t) else "," for _, t, v, form in channels]
        text += ",".join(row) + "\r\n"
    regular = np.arange(0.0, made.time[-1], 0.1)
    lines = ["Time-Axial Accel (Gs), Axial Accel (Gs), bILBA, Time (s), Altitude (Ft-AGL), bILBA"]
    felt, feet = made.at(regular * 0.2, made.felt) / GRAVITY, made.at(regular, made.height) / FOOT
    lines += [
        f"{t * 0.2:.5g},{a:.2f},{flags(t * 0.2)},{t + 0.045:.6g},{h:.6g},{flags(t)}"
        for t, a, h in zip(regular, felt, feet, strict=True)
    ]
    return {
        "raven_fip__channels_that_end_early.csv": text.encode(),
        "raven_fip__edited_by_hand.csv": ("\n".join(lines) + "\n").encode(),
    }


MAKERS = (raven_fip,)
