"""Eggtimer loggers: a console's text and two tables."""

from collections.abc import Callable

import numpy as np

from fieldkit.units import FOOT
from tools.samples.one_parachute import flight
from tools.samples.writing import cells, noise, table


def eggtimer() -> dict[str, bytes]:
    made = flight(thrust=55.0, burn=1.5, descent=8.0)
    up = np.arange(0.0, made.time_to_apogee + 1, 0.05)
    time = np.concatenate([up, np.arange(up[-1] + 0.5, made.time[-1], 0.5)])

    def rows(unit: float, form: Callable[[float], str], separator: str, order: str) -> str:
        height = (made.at(time, made.height) + noise(5, len(time), 0.15)) / unit
        speed = made.at(time, made.speed) / unit
        top = int(np.argmax(made.at(time, made.height)))
        main = int(np.flatnonzero((height * unit < 60) & (time > made.time_to_apogee))[0])
        moments = {"LDA": 6, "Apogee": top, "N-O": top + 10, "Drogue": top + 12, "Main": main, "LowV": -1}
        text = order.replace(",", separator) + "\r\n"
        for i, now in enumerate(time):
            marks = [f"{height[i]:.0f}" if moments[name] == i else "0" for name in order.split(",")[6:]]
            text += (
                separator.join(
                    [
                        form(now),
                        f"{height[i]:.0f}",
                        f"{speed[i]:.0f}",
                        f"{height[i]:.0f}",
                        f"{speed[i]:.0f}",
                        f"{speed[i]:.0f}",
                        *marks,
                    ]
                )
                + "\r\n"
            )
        return text

    order = "T,Alt,Veloc,FAlt,FVeloc,FVeloc2,LDA,LowV,Apogee,N-O,Drogue,Main"
    summary = f"ASL Alt: 1017\r\nBase Temp: 68\r\nLast Flight Phase: 9\r\nApogee: {made.apogee / FOOT:.0f}\r\n"
    trs = summary + "\r\n" + rows(FOOT, lambda t: f"{t * 1000:.0f}", ",", order)
    metric = rows(1.0, lambda t: f"{t:.2f}".replace(".", ","), ";", order)
    slow = np.arange(0.0, made.time[-1], 0.1)
    feet = made.at(slow, made.height) / FOOT
    speed = made.at(slow, made.speed) / FOOT
    classic = table(
        "T,Alt,VRaw,VFilt",
        [
            cells(slow * 1000, ".0f"),
            cells(feet, ".0f"),
            cells(speed + noise(6, len(slow), 15), ".0f"),
            cells(speed, ".0f"),
        ],
    )
    return {
        "eggtimer__trs_console_in_feet.txt": trs.encode(),
        "eggtimer__semicolons_in_metres.csv": metric.encode(),
        "eggtimer__classic.csv": classic,
    }


MAKERS = (eggtimer,)
