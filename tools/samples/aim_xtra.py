"""AIM XTRA: groups of columns, each with a separate clock."""

import numpy as np

from fieldkit.physics.standard_atmosphere import GRAVITY
from tools.samples.one_parachute import flight
from tools.samples.writing import cells, noise


def aim_xtra() -> dict[str, bytes]:
    made = flight(thrust=75.0, burn=1.3, descent=12.0)
    gyro = np.arange(-4.0, made.time[-1], 0.1)
    baro = np.arange(-3.9, made.time[-1] - 1, 0.2)
    flags = np.arange(-3.6, made.time[-1] - 2, 0.3)
    height = made.at(baro, made.height) + noise(8, len(baro), 0.3)
    groups = [
        (
            ["time", "Gyro X", "Gyro Y", "Gyro Z"],
            [cells(gyro, ".6g"), *[cells(noise(k, len(gyro), 1.0), ".2f") for k in (9, 10, 11)]],
        ),
        (
            ["time", "pressure", "Pressure MSL", "Pressure AGL"],
            [
                cells(baro, ".6g"),
                cells(made.pressure(height), ".0f"),
                cells(height + made.pad, ".6g"),
                cells(height, ".6g"),
            ],
        ),
        (["time", "acceleration"], [cells(gyro + 0.02, ".6g"), cells(made.at(gyro, made.felt) / GRAVITY, ".5f")]),
        (["time", "comp. bat. voltage"], [cells(flags[::10], ".6g"), ["4.14001"] * len(flags[::10])]),
        (
            ["time", "launch detect", "apogee detect", "A cont.", "A on.", " B on"],
            [
                cells(flags, ".6g"),
                *[
                    [str(int(t > when)) for t in flags]
                    for when in (0, made.time_to_apogee, -10, made.time_to_apogee, 14.0)
                ],
            ],
        ),
    ]
    text = ",".join(name for names, _ in groups for name in names) + "\r\n"
    for i in range(len(gyro)):
        row = [column[i] if i < len(column) else "" for _, columns in groups for column in columns]
        text += ",".join(row) + "\r\n"
    return {"aim_xtra__groups_that_end_early.csv": text.encode()}


MAKERS = (aim_xtra,)
