"""Featherweight Blue Raven: its app's tables and summary, and its records by USB."""

from datetime import datetime, timedelta

import numpy as np

from fieldkit.importing.tables.checksums import crc_buypass
from fieldkit.physics.standard_atmosphere import GRAVITY
from fieldkit.units import FOOT
from tools.samples.one_parachute import ATM, flight
from tools.samples.writing import clock, noise

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
        row = f"2026,5,2,{clock(now)},{t:.3f},{int(t * 1000) % 250},0.1,0.2,-0.1"
        high += f"{row},{-a:.3f},{side:.3f},{-side:.3f},1,0,0,0\n"
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


MAKERS = (blueraven_app, blueraven_summary, blueraven_usb)
