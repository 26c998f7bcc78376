"""Write the sample logs of loggers with samples: made-up flights in the form each logger gives them.

    python tools/sample_loggers.py [NAME...]

Nothing in them is copied from a real log. One small model of a flight feeds them all, so that every sample can be
checked against the same figures; the same call writes the same bytes.
"""

import sys
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from datetime import datetime, timedelta
from pathlib import Path

import numpy as np

from fieldkit.logs.checks import crc_buypass

FOLDER = Path(__file__).parent.parent / "sample_logs"
FOOT, GRAVITY, ATM = 0.3048, 9.80665, 101_325.0


@dataclass(frozen=True)
class Made:
    """A made-up flight at 200 samples a second: seconds from lift-off, m, m/s, m/s^2 felt along the axis, Pa."""

    time: np.ndarray
    height: np.ndarray
    speed: np.ndarray
    felt: np.ndarray
    pad: float
    apogee: float
    time_to_apogee: float

    def at(self, times: np.ndarray, values: np.ndarray) -> np.ndarray:
        return np.interp(times, self.time, values)

    def pressure(self, height: np.ndarray) -> np.ndarray:
        return ATM * (1 - (self.pad + height) / 44_330.77) ** 5.25588


def flight(
    thrust: float = 60.0, burn: float = 1.6, drag: float = 0.0016, descent: float = 9.0, pad: float = 310.0
) -> Made:
    """Boost, coast with drag that grows with the square of speed, and a steady descent."""
    step = 0.005
    height, speed, rows = 0.0, 0.0, []
    time, apogee, top = -2.0, 0.0, 0.0
    while time < 300:
        push = thrust if 0 <= time < burn else 0.0
        pull = drag * speed * abs(speed)
        felt = push - pull
        if time < 0 or (rows and height <= 0 and time > burn + 1):
            felt = GRAVITY
        rows.append((time, height, speed, felt if speed >= 0 or time < burn else GRAVITY))
        if time > burn + 3 and height <= 0 and time > landed_at(rows):
            break
        if time >= 0:
            if speed < 0 and time > burn:
                speed += (-descent - speed) * step / 0.4
            else:
                speed += (push - pull - GRAVITY) * step
            height = max(height + speed * step, 0.0)
            if height == 0 and time > burn:
                speed = 0.0
            if height > apogee:
                apogee, top = height, time + step
        time += step
    columns = np.array(rows).T
    return Made(*columns, pad=pad, apogee=apogee, time_to_apogee=top)


def landed_at(rows: Sequence[tuple[float, float, float, float]]) -> float:
    """Two seconds after the rocket came to rest."""
    return next((row[0] for row in reversed(rows[-420:]) if row[1] > 0), rows[-1][0] - 3) + 2.0


def table(header: str, columns: Sequence[Sequence[str]], separator: str = ",", end: str = "\n") -> bytes:
    """A text table of columns of cells."""
    rows = [separator.join(cells) for cells in zip(*columns, strict=True)]
    return (header + end + "".join(row + end for row in rows)).encode()


def cells(values: np.ndarray, form: str) -> list[str]:
    return [format(value, form) for value in values]


def clock(now: datetime) -> str:
    return f"{now:%H:%M:%S}.{now.microsecond // 1000:03d}"


def noise(seed: int, size: int, scale: float) -> np.ndarray:
    return np.random.default_rng(seed).normal(0.0, scale, size)


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


def rrc3_columns(made: Made, metric: bool, stop: float) -> list[list[str]]:
    time = np.arange(0.0, stop, 0.05)
    height = made.at(time - 1.0, made.height)
    mbar = np.round((made.pressure(height) + noise(4, len(time), 4)) / 100, 1)
    heard = 44_330.77 * (1 - (mbar * 100 / ATM) ** 0.1902632)
    unit = 1.0 if metric else FOOT
    climbed = (heard - heard[0]) / unit
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


def sentence(body: str) -> str:
    return f"${body}{sum(body.encode()) % 256};\n"


def bdureau() -> dict[str, bytes]:
    made = flight(thrust=45.0, burn=1.4, descent=9.0)
    time = np.arange(0.0, made.time[-1], 0.1)
    height = np.round(made.at(time, made.height))
    pascal = np.round(made.pressure(height))
    config = "alticonfig,1,0,1,2,3,0,100,AltiMultiSTM32,2,1,0,0,0,440,5,5,0,0,38400,1,"
    long = "$start;\n" + sentence(config) + "$end;\n$start;\n"
    for i, t in enumerate(time):
        body = f"data,0,{t * 1000:.0f},{height[i]:.0f},21,{pascal[i]:.0f},742,"
        long += sentence(body).replace(";", "9;") if i == 40 else sentence(body)
        if i == 100:
            long += sentence(f"telemetry,{height[i]:.0f},1,1,230,0,-1,0,{t * 1000:.0f},1,1,-1,-1,7.42,21,5,2,100,")
    for i, t in enumerate(time[::2]):
        long += sentence(
            f"data,1,{t * 1000:.0f},{height[::2][i] // 2:.0f},20,{made.pressure(height[::2] // 2)[i]:.0f},731,"
        )
    eight = "$start;\n"
    times = np.arange(0.0, 80.0, 0.4)
    descent = np.interp(times, [0, 2, 6, 75, 80], [0, 100, 240, 0, 0])
    for t, h in zip(times, descent, strict=True):
        wrapped = int(made.pressure(np.array(h))) % 65536
        eight += sentence(f"data,0,{int(t * 1000) % 65536},{h:.0f},19,{wrapped},")
    return {
        "bdureau__two_flights_and_telemetry_between.txt": (long + "$end;\n").encode(),
        "bdureau__eight_bit_board_that_wraps.txt": (eight + "$end;\n").encode(),
    }


BLUERAVEN = (
    "Year,Month,Day,Time,Flight_Time_(s),Sync,Temperature_(F),Baro_Press_(atm),Baro_Altitude_ASL_(feet),"
    "Baro_Altitude_AGL_(feet),Batt_Volts,Velocity_Up,Velocity_DR,Velocity_CR,Inertial_Altitude,Tilt_Angle_(deg),"
    "Apo_FER_H  ex,Liftoff,Apogee,Burnout_Coast,Apo_fired,Main_fired,LT_AGL1,GT_AGL2,Reserved,LT_AGL1,GT_AGL2,Reserved"
)
LAUNCH = datetime(2026, 5, 2, 11, 4, 5, 250_000)


def blueraven_app() -> dict[str, bytes]:
    made = flight(thrust=70.0, burn=1.5, descent=12.0)
    time = np.arange(-1.92, made.time[-1], 0.12)
    height = made.at(time, made.height)
    baro = height + noise(14, len(time), 0.4)
    low = BLUERAVEN + "\n"
    for i, t in enumerate(time):
        now = LAUNCH + timedelta(seconds=round(float(t), 2))
        flags = [int(t >= when) for when in (0, made.time_to_apogee + 0.3, 1.5, made.time_to_apogee + 1.8, 999)]
        low += (
            f"2026,5,2,{clock(now)},{t:.2f},{int(t * 1000) % 250},68.4,{made.pressure(baro[i]) / ATM:.4f},"
            f"{(baro[i] + made.pad) / FOOT:.1f},{baro[i] / FOOT:.1f},4.11,"
            f"{made.at(t, made.speed) / FOOT:.2f},0.00,0.00,{height[i] * 1.03 / FOOT:.2f},"
            f"{min(max(t, 0) * 1.5, 90):.1f},8cd,{','.join(map(str, flags))},1,0,0,1,0,0\n"
        )
    fast = np.arange(-0.5, 7.5, 0.02)
    felt = made.at(fast, made.felt) / GRAVITY
    high = "Year,Month,Day,Time,Flight_Time_(s),Sync,Gyro_X,Gyro_Y,Gyro_Z,"
    high += "Accel_X,Accel_Y,Accel_Z,Quat_1,Quat_2,Quat_3,Quat_4\n"
    for t, a, side in zip(fast, felt, noise(15, len(fast), 0.02), strict=True):
        now = LAUNCH + timedelta(seconds=round(float(t), 3))
        turns = f"2026,5,2,{clock(now)},{t:.3f},{int(t * 1000) % 250},0.1,0.2,-0.1"
        high += f"{turns},{-a:.3f},{side:.3f},{-side:.3f},1,0,0,0\n"
    return {"blueraven_app__low_rate.csv": low.encode(), "blueraven_app__high_rate.csv": high.encode()}


def blueraven_summary() -> dict[str, bytes]:
    made = flight(thrust=70.0, burn=1.5, descent=12.0)
    down = LAUNCH + timedelta(seconds=round(float(made.time[-1] - 2), 1))
    figures = [
        ("Rocket Name", "BlRv_SN4242"),
        ("Firmware", "abc1234 01/02/2026 10:00:00"),
        ("Searial number", "SN4242 BlRv_SN4242"),
        ("Max Altitude", f"{made.apogee / FOOT:.2f} feet"),
        ("Max velocity", f"{made.speed.max() / FOOT:.2f} feet/sec"),
        ("Pad altitude ASL", f"{made.pad / FOOT:.2f} feet"),
        ("Launch date", "02-May-26"),
        ("Launch time", f"{LAUNCH:%H:%M:%S}.{LAUNCH.microsecond // 1000:03d}"),
        ("Time to first burnout", "1.5 sec"),
        ("Time to Apo channel fire", f"{made.time_to_apogee + 0.3:.1f} sec"),
        ("Launch rod angle", "3.1 deg"),
        ("Inertial navigation max alt", f"{made.apogee * 1.03 / FOOT:.1f} feet"),
        ("Max motor burn acceleration", "7.1 Gs"),
        ("Drogue descent rate", "-39.4 feet/sec"),
        ("Main chute descent rate", "-39.4 feet"),
        ("Landing Time", f"{down:%H:%M:%S}.{down.microsecond // 1000:03d}"),
        ("Temperature on pad", "68.4 F"),
        ("Flight number", "7"),
    ]
    return {"blueraven_summary__what_the_app_shows.csv": "".join(f"{k},{v}\n" for k, v in figures).encode()}


def blueraven_usb() -> dict[str, bytes]:
    made = flight(thrust=65.0, burn=1.3, descent=14.0)
    text = b""

    def frame(kind: str, now: datetime, rest: str) -> bytes:
        stamp = f"{now.year} {now.month} {now.day} {clock(now)} {now.microsecond // 1000 % 250}"
        size = len(f"@ {kind} 000 {stamp} {rest} CRC: 0000\r\n")
        body = f"@ {kind} {size} {stamp} {rest}".encode()
        return body + f" CRC: {crc_buypass(body):04X}\r\n".encode()

    for i, t in enumerate(np.arange(-1.0, made.time[-1], 0.14)):
        now = LAUNCH + timedelta(seconds=round(float(t), 2))
        atm = float(made.pressure(made.at(t, made.height))) / ATM
        up = float(made.at(t, made.speed)) / FOOT
        rest = f"Bo: 6840 {atm * 50_000:.0f} V: 4110 4100 4100 Vel: {up:.0f} 0 0 "
        rest += f"Pos: {float(made.at(t, made.height)) / FOOT:.0f} 0 0 "
        rest += f"ang: {min(max(t, 0) * 10, 900):.0f} 0 0 FER: 08cd 08c9"
        line = frame("LOG_LOW", now, rest)
        text += line[:-40] + b"@ LOG_LOW   " + line if i == 30 else line
    for t in np.arange(-1.0, 4.0, 0.1):
        now = LAUNCH + timedelta(seconds=round(float(t), 2))
        felt = float(made.at(t, made.felt)) / GRAVITY
        text += frame("LOG_HIR", now, f"gyro: 10 20 -10 accel: {-felt * 1000:.0f} 12 -8 quat: 30000 0 0 0")
    return {"blueraven_usb__low_and_high_rate.txt": text}


MAKERS: tuple[Callable[[], dict[str, bytes]], ...] = (
    aim_xtra,
    altimetercloud,
    arts2,
    bdureau,
    blueraven_app,
    blueraven_summary,
    blueraven_usb,
    cats,
    eggtimer,
    featherweight_gps,
    raven_fip,
    rrc3,
)


def main(names: Sequence[str]) -> None:
    for maker in MAKERS:
        if not names or maker.__name__ in names:
            for name, content in maker().items():
                (FOLDER / name).write_bytes(content)
                print(f"{name}: {len(content)} bytes")


if __name__ == "__main__":
    main(sys.argv[1:])
