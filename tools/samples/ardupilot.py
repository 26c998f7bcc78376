"""ArduPilot: lines of each kind of sensor after lines that name their columns."""

import numpy as np

from tools.samples.one_parachute import flight
from tools.samples.writing import noise, text

FORMATS = """\
FMT, 128, 89, FMT, BBnNZ, Type,Length,Name,Format,Columns
FMT, 129, 31, PARM, QNff, TimeUS,Name,Value,Default
FMT, 163, 37, BARO, QBffcf, TimeUS,I,Alt,Press,Temp,CRt
FMT, 136, 45, IMU, QBffffff, TimeUS,I,GyrX,GyrY,GyrZ,AccX,AccY,AccZ
FMT, 141, 50, GPS, QBBIHBcLLefffB, TimeUS,I,Status,GMS,GWk,NSats,HDop,Lat,Lng,Alt,Spd,GCrs,VZ,U
PARM, 1000, LOG_DISARMED, 1, 0"""
START = 41.0
"""Time of the controller's clock at lift-off. [s]"""


def ardupilot() -> dict[str, bytes]:
    made = flight(thrust=60.0, burn=1.4, descent=8.0)
    rows: list[tuple[float, str]] = []
    slow = np.arange(-3.0, made.time[-1], 0.1)
    height = made.at(slow, made.height)
    pressure = made.pressure(height) + noise(1, len(slow), 4)
    for sensor in (0, 1):
        for time, high, air in zip(slow, height, pressure + 60 * sensor, strict=True):
            rows.append((time, f"BARO, {_us(time)}, {sensor}, {1.05 * high:.2f}, {air:.1f}, 31.2, {0.0}"))
    fast = np.arange(-3.0, made.time[-1], 0.04)
    felt = made.at(fast, made.felt) + noise(2, len(fast), 0.3)
    across = noise(3, len(fast), 0.3)
    for time, along, other in zip(fast, felt, across, strict=True):
        rows.append((time, f"IMU, {_us(time)}, 0, 0.01, 0.02, 0.01, {along:.3f}, {other:.3f}, {-other:.3f}"))
    seconds = np.arange(-3.0, made.time[-1], 0.2)
    climb = made.at(seconds, made.speed)
    high = made.at(seconds, made.height) + 417.0 + noise(4, len(seconds), 0.8)
    for time, speed, sea in zip(seconds, climb, high, strict=True):
        place = "47.1000000, 8.4000000"
        rows.append((time, f"GPS, {_us(time)}, 0, 3, 0, 2300, 11, 0.8, {place}, {sea:.2f}, 0.1, 0, {-speed:.2f}, 1"))
    lines = [line for _, line in sorted(rows, key=lambda one: one[0])]
    return {"ardupilot__two_barometers_and_satellites.log": text([*FORMATS.split("\n"), *lines])}


def _us(time: float) -> int:
    return round((time + START) * 1e6)


MAKERS = (ardupilot,)
