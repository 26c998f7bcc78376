"""AltOS tables: exports of Altus Metrum's program, in each of its versions."""

from collections.abc import Iterator

import numpy as np

from tools.samples.two_parachutes import PAD, Flight, air, flight
from tools.samples.writing import noise, text

STATES = ["startup", "idle", "pad", "boost", "fast", "coast", "drogue", "main", "landed"]


def altos_rows(seen: Flight, *, call: str, version: int, clock: bool) -> Iterator[tuple[str, str, np.void]]:
    """Cells of each row: up to the state, and measured values."""
    pressure = np.round(seen.pressure + noise(4, len(seen.time), 3.0))
    height = (air(np.array([PAD]))[0] - pressure) / 11.7
    for i, time in enumerate(seen.time):
        state = int(seen.state[i])
        place = f"{version}, 2417, 3,{call}{time:8.2f}," + (f"{time + 88.4:9.2f},    0,   0," if clock else "")
        yield (
            f"{place}{state},{STATES[state]:>8}",
            f"{seen.acceleration[i]:8.2f},{pressure[i]:10.2f},{height[i] + PAD:8.2f},{height[i]:8.2f}",
            seen.speed[i],
        )


def altos_csv() -> Iterator[tuple[str, bytes]]:
    whole = flight()
    seen = whole.between(-0.3, 60.0, 0.1)
    names = "version,serial,flight,time,state,state_name,pressure,altitude,height,speed,temperature,battery_voltage"
    small = [
        f"{start},{rest.split(',', 1)[1]},{v:8.2f}, 21.4, 3.91"
        for start, rest, v in altos_rows(seen, call="", version=6, clock=False)
    ]
    small[30] = small[30].replace("21.4", "2147483647.0").replace(" 3.91", " NaN")
    yield "altos_csv__a_barometer_alone.csv", text(["#" + names, *small])
    gps = (
        "connected,locked,nsat,latitude,longitude,altitude,year,month,day,hour,minute,second,pad_dist,pad_range,pad_az"
    )
    names = f"#version,serial,flight,call,time,state,state_name,acceleration,pressure,altitude,height,speed,{gps}"
    fast = whole.between(-0.3, 5.5, 0.05)
    slow = whole.between(5.5, 60.0, 0.2)
    rows = [
        *altos_rows(fast, call="N0CALL,", version=6, clock=False),
        *altos_rows(slow, call="N0CALL,", version=6, clock=False),
    ]
    fixed = [
        f"{start},{rest},{v:8.2f}, 1, {int(i % 90 < 70)}, {9 * (i % 90 < 70):2},"
        f"{47.1 + i * 1e-6:12.7f},{8.4 - i * 1e-6:13.7f},{PAD + 20 + i % 5:7.1f},"
        " 2026, 5, 1, 10, 30, 12, 3, 3, 2147483647"
        for i, (start, rest, v) in enumerate(rows)
    ]
    yield "altos_csv__with_satellites.csv", text([names, *fixed])
    yield from altos_csv_5(whole)
    yield "altos_csv__heard_by_radio.csv", altos_csv_radio(whole)


def altos_csv_5(whole: Flight) -> Iterator[tuple[str, bytes]]:
    """The two headers of version 5 that do not fit their rows, shortened to one satellite."""
    remarks = ["# Comments", "# Config version: 1.11", "# Main deploy: 250", "# Accel cal: 15545 16067"]
    remarks += ["# Product: TeleMetrum-v1.1", "# Serial number: 2417", "# Software version: 1.0.9.5"]
    start = "#version,serial,flight,call,time,clock,rssi,lqi,state,state_name,acceleration,pressure,altitude,height,"
    start += "accel_speed,baro_speed,temperature,battery_voltage,drogue_voltage,main_voltage"
    more = "accel_x,accel_y,accel_z,gyro_x,gyro_y,gyro_z,connected,locked,nsat,latitude,longitude,altitude,year,sat01"
    rows = [
        f"{first},{rest},{v + 0.2:8.2f},{v:8.2f}, 21.4, 3.91, 3.80, 3.81"
        for first, rest, v in altos_rows(whole.between(-0.3, 19.0, 0.1), call="N0CALL,", version=5, clock=True)
    ]
    rows[30:36] = [row.replace("5,   coast", "3,   boost") for row in rows[30:36]]
    fix = ", 1, 1,  9, 47.1000000,   8.4000000,   260, 2012, 33"
    yield (
        "altos_csv__version_5_with_a_comma_missing.csv",
        text([*remarks, start + more, *(row + "," + fix for row in rows)]),
    )
    wide = [f"{row}, 1, 2, 3, 4, 5, 6, 7, 8, 9{fix}" for row in rows[::2]]
    yield "altos_csv__version_5_with_cells_too_many.csv", text([*remarks, f"{start},{more}", *wide])


def altos_csv_radio(whole: Flight) -> bytes:
    """A ground station's table: packets of two kinds alternate, some are lost, and the clock wraps."""
    lines = ["serial,tick,ptype,state,state_name,acceleration,pressure,height,speed,rssi"]
    for i, row in enumerate(range(100, len(whole.time), 10)):
        if 80 < i < 92:
            continue
        tick = (64_800 + row) % 65536
        state = int(whole.state[row])
        if i % 2:
            sensed = f"{whole.pressure[row] + noise(5, 400, 3.0)[i % 400]:.0f},,"
        else:
            sensed = f",{whole.height[row]:.0f},{whole.speed[row]:.2f}"
        acceleration = "" if i % 2 else f"{whole.acceleration[row]:.2f}"
        lines.append(f"2417,{tick},{8 + (i + 1) % 2},{state},{STATES[state]},{acceleration},{sensed},-72")
    return b"\xef\xbb\xbf" + text(lines)


MAKERS = (altos_csv,)
