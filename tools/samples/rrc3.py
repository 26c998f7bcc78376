"""Missile Works RRC3: its program's tables, in feet and in meters."""

import numpy as np

from fieldkit.units import FOOT
from tools.samples.one_parachute import ATM, Made, flight
from tools.samples.writing import noise


def rrc3_columns(made: Made, metric: bool, stop: float) -> list[list[str]]:
    time = np.arange(0.0, stop, 0.05)
    height = made.at(time - 1.0, made.height)
    mbar = np.round((made.pressure(height) + noise(4, len(time), 4)) / 100, 1)
    altitude = 44_330.77 * (1 - (mbar * 100 / ATM) ** 0.1902632)
    unit = 1.0 if metric else FOOT
    climbed = (altitude - altitude[0]) / unit
    speed = made.at(time - 1.0, made.speed) / unit
    warm = "21.5" if metric else "70.7"
    events = [" -"] * len(time)
    drogue = int(np.searchsorted(time, made.time_to_apogee + 1.0 + 0.1))
    if drogue < len(events):
        events[drogue] = " Drogue"
    rows = []
    for i, cell in enumerate(events):
        rest = [warm, cell, "9.21"] if i % 20 == 0 and i != drogue else [cell, "", ""]
        rows.append([f"{time[i]:.2f}", f"{climbed[i]:.7g}", f"{mbar[i]:.2f}", f"{speed[i]:.7g}", *rest])
    return rows


def rrc3() -> dict[str, bytes]:
    made = flight(thrust=70.0, burn=1.8, descent=15.0)
    header = ["Time", "Altitude", "Pressure", "Velocity", "Temperature", "Events", "Voltages"]
    feet = rrc3_columns(made, metric=False, stop=made.time[-1])
    american = "\r\n".join(",".join(row) for row in [header, *feet]) + "\r\n"
    metric = rrc3_columns(made, metric=True, stop=made.time_to_apogee + 4)
    metric.append([metric[-1][0][:-1] + "9", "-2490.543", "1158.70", "-5345.959", " -", "", ""])
    european = "\r\n".join(";".join(cell.replace(".", ",") for cell in row) for row in [header, *metric]) + "\r\n"
    utf16 = "\r\n".join("\t".join(row) for row in [[h.lower() for h in header], *feet[:330]]) + "\r\n"
    return {
        "rrc3__feet_and_commas.csv": american.encode("utf-8-sig"),
        "rrc3__metres_with_a_last_row_of_garbage.csv": european.encode(),
        "rrc3__utf16_with_tabs.txt": utf16.encode("utf-16"),
    }


MAKERS = (rrc3,)
