"""CATS: a table for each kind of record."""

import numpy as np

from fieldkit.physics.standard_atmosphere import GRAVITY
from tools.samples.one_parachute import flight
from tools.samples.writing import cells, noise, table


def cats() -> dict[str, bytes]:
    made = flight(thrust=50.0, burn=1.2, descent=12.0)
    time = np.arange(-0.7, made.time[-1], 0.04)
    height, speed, felt = (made.at(time, v) for v in (made.height, made.speed, made.felt))
    info = table(
        "ts,height,velocity,acceleration",
        [cells(time, ".3f"), cells(height, ".4f"), cells(speed, ".4f"), cells(felt - GRAVITY, ".3f")],
    )
    noisy = height + noise(1, len(time), 0.3)
    filtered = table(
        "ts,filteredAltitudeAGL,filteredAcceleration",
        [cells(time, ".3f"), cells(noisy, ".5f"), cells(felt - GRAVITY, ".4f")],
    )
    seconds = np.arange(-0.4, made.time[-1], 0.4)
    satellites = ["193", "193", "0", *["11"] * (len(seconds) - 3)]
    gnss = table(
        "ts,latitude,longitude,satellites",
        [cells(seconds, ".3f"), cells(47.1 + seconds * 1e-5, ".7f"), cells(8.4 - seconds * 2e-5, ".7f"), satellites],
    )
    both = np.repeat(time[::4], 2)
    which = np.tile([0, 1], len(time[::4]))
    pressure = made.pressure(made.at(both, made.height)) + noise(2, len(both), 3) + which * 40
    baro = table("ts,id,T,P", [cells(both, ".3f"), cells(which, "d"), ["2150"] * len(both), cells(pressure, ".0f")])
    return {
        "cats__flight_info.csv": info,
        "cats__filtered_data_info.csv": filtered,
        "cats__positions.csv": gnss,
        "cats__two_barometers.csv": baro,
    }


MAKERS = (cats,)
