"""Altimeter Cloud: labels, and a table below them."""

import numpy as np

from fieldkit.physics.standard_atmosphere import GRAVITY
from tools.samples.one_parachute import flight
from tools.samples.writing import cells, noise, table


def altimetercloud() -> dict[str, bytes]:
    made = flight(thrust=60.0, burn=1.2, descent=14.0)
    time = np.arange(-1.0, made.time[-1], 0.05)
    height, felt = made.at(time, made.height) + noise(12, len(time), 0.2), made.at(time, made.felt) / GRAVITY * 1000
    sides = noise(13, len(time), 20)
    columns = [
        cells(time * 1000, ".0f"),
        cells(height, ".2f"),
        cells(made.at(time, made.speed), ".2f"),
        cells(sides, ".0f"),
        cells(-felt, ".0f"),
        cells(sides[::-1], ".0f"),
        ["2154"] * len(time),
    ]
    header = "time(ms),altitude(m),velocity_pressure(m/s),"
    header += "acceleration_x(mG),acceleration_y(mG),acceleration_z(mG),bmp_temp(x100)"
    labels = [f"Apogee (m),{made.apogee:.1f},Sample rate (Hz),20", "Serial number,N-0042,Firmware,4.2"]
    labels += [f"Setting {i},{i},Condition {i},{i}" for i in range(12)]
    newer = "\n".join(labels) + "\n\n"
    return {
        "altimetercloud__labels_before_the_table.csv": newer.encode() + table(header, columns),
        "altimetercloud__columns_first.csv": table(header, [column[: len(column) * 2 // 3] for column in columns]),
    }


MAKERS = (altimetercloud,)
