"""Featherweight GPS: the tracker's table and the ground station's."""

from datetime import datetime, timedelta

import numpy as np

from fieldkit.units import FOOT
from tools.samples.one_parachute import flight
from tools.samples.writing import clock


def featherweight_gps() -> dict[str, bytes]:
    made = flight(thrust=85.0, burn=1.7, descent=10.0)
    time = np.concatenate([np.arange(-1.5, 12.0, 0.1), np.arange(12.0, made.time[-1], 1.0)])
    feet = (made.at(time, made.height) + made.pad) / FOOT
    speed = made.at(time, made.speed) / FOOT
    start = datetime(2026, 5, 2, 15, 4, 5)
    rows = []
    for t, h, v in zip(time, feet, speed, strict=True):
        now = start + timedelta(seconds=round(float(t), 1))
        stamp = f"{now:%b %d %Y %H:%M:%S}.{now.microsecond // 1000:03d} UTC"
        rows.append(
            f"{stamp},{(now - datetime(1970, 1, 1)).total_seconds():.3f},{h:.0f},{47.1 + t * 1e-6:.8f},"
            f"{8.4 - t * 2e-6:.8f},14,3,2,{v:.0f},90,0x03,3,8,14,180,4.021"
        )
    late = rows.pop(30)
    tracker = (
        "UTCTIME,UNIXTIME,ALT,LAT,LON,#SATS,FIX,HORZV,VERTV,HEAD,FLAGS,>40,>32,>24,RSSI,BATT\n"
        + "\n".join([rows[9], *rows[:40], late, *rows[40:]])
        + "\n"
    )
    ground = "TRACKER,DATE,TIME,ALT,LAT,LON,VERTV,FIX\n"
    for t, h, v in zip(time[::10], feet[::10], speed[::10], strict=True):
        now = start + timedelta(seconds=round(float(t), 1))
        ground += f"FWGPS_1,2026-05-02,{clock(now)},{h:.0f},{47.1 + t * 1e-6:.7f},{8.4:.7f},{v:.0f},3\n"
    return {
        "featherweight_gps__rows_out_of_order.csv": tracker.encode(),
        "featherweight_gps__ground_station.csv": ground.encode(),
    }


MAKERS = (featherweight_gps,)
