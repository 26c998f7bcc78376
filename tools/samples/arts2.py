"""ARTS2: the interpreted table of its program."""

import numpy as np

from fieldkit.physics.standard_atmosphere import GRAVITY
from fieldkit.units import FOOT
from tools.samples.one_parachute import flight
from tools.samples.writing import cells, noise, table


def arts2() -> dict[str, bytes]:
    made = flight(thrust=90.0, burn=1.4)
    time = np.arange(-1.0, made.time[-1], 0.06)
    height, speed, felt = (made.at(time, v) for v in (made.height, made.speed, made.felt))
    baro = height + noise(3, len(time), 0.5)
    columns = [
        cells(time + 1, ".2f"),
        cells(felt / GRAVITY, ".3f"),
        cells(speed / FOOT, ".1f"),
        cells(height * 1.02 / FOOT, ".1f"),
        cells(baro / FOOT, ".1f"),
    ]
    return {"arts2__interpreted.csv": table("# MET Acc Vel iAlt pAlt", columns, " ")}


MAKERS = (arts2,)
