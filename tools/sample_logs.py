"""Sample logs of PerfectFlite and Altus Metrum devices, made up from the notes on their formats.

    python tools/sample_logs.py

One vertical flight is simulated: a constant push, drag with the square of speed, a drogue at apogee, a main parachute
at 60 m, and rest on the grass. Each device then sees it through its own barometer, with its noise, its steps and its
clock, and writes it down in its own form. The same call writes the same bytes; nothing is from a real log.
"""

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from fieldkit.logs.checks import crc_x25

FOLDER = Path(__file__).parent.parent / "sample_logs"
GRAVITY, FOOT, STEP = 9.80665, 0.3048, 0.01
PAD = 240.0
"""Elevation of the field. [m]"""
SENSOR = (46372, 43981, 29059, 27842, 31553, 28165)
"""C1 to C6 of the worked example in the data sheet of the MS5607."""
WARM = 8077636
"""What that sensor counts at 20 degrees Celsius."""
PLUS, MINUS = 15545, 16067
"""What the accelerometer counts with the nose up and down."""


@dataclass(frozen=True)
class Flight:
    """A flight at 100 samples a second: seconds from lift-off, m above the pad, m/s, m/s^2, Pa, AltOS state."""

    time: np.ndarray
    height: np.ndarray
    speed: np.ndarray
    acceleration: np.ndarray
    state: np.ndarray

    @property
    def apogee(self) -> float:
        return float(self.height.max())

    @property
    def pressure(self) -> np.ndarray:
        return air(self.height + PAD)

    def between(self, start: float, stop: float, step: float) -> "Flight":
        """The flight as a slower device sees it."""
        rows = np.arange(round((start - self.time[0]) / STEP), round((stop - self.time[0]) / STEP), round(step / STEP))
        rows = rows[rows < len(self.time)]
        return Flight(*(getattr(self, name)[rows] for name in self.__dataclass_fields__))


def air(height: np.ndarray) -> np.ndarray:
    """Pressure of the standard atmosphere at a height above sea level. [Pa]"""
    return 101325.0 * (1 - 0.0065 * height / 288.15) ** 5.255877


def flight(
    push: float = 75.0, burn: float = 1.1, drag: float = 0.004, drogue: float = 15.0, main: float = 6.0
) -> Flight:
    """A flight with a drogue and a main parachute, whose speeds of descent are given. [m/s^2, s, 1/m, m/s, m/s]"""
    rows: list[tuple[float, float, float, float, int]] = []
    height = speed = 0.0
    landed = None
    for i in range(-300, 20_000):
        time = i * STEP
        under = 0 if time < 0 else 1 if time < burn else 2 if speed > 0 else 3 if height > 60 else 4
        acceleration = [0.0, push - GRAVITY - drag * speed**2, -GRAVITY - drag * speed**2, 0.0, 0.0][under]
        if under >= 3:
            acceleration = (-(drogue if under == 3 else main) - speed) / 0.4
        if landed is not None:
            acceleration, speed, height = 0.0, 0.0, 0.0
        rows.append((time, height, speed, acceleration, 8 if landed and time > landed + 1 else [2, 3, 5, 6, 7][under]))
        speed += acceleration * STEP
        height = max(height + speed * STEP, 0.0)
        if height == 0 and time > burn and landed is None:
            landed = time
        if landed and time > landed + 2:
            break
    return Flight(*np.array(rows).T)


def noise(seed: int, size: int, scale: float) -> np.ndarray:
    return np.random.default_rng(seed).normal(0.0, scale, size)


def feet(height: np.ndarray, seed: int) -> np.ndarray:
    return np.round((height + noise(seed, len(height), 0.25)) / FOOT).astype(int)


def text(lines: list[str], end: str = "\n") -> bytes:
    return "".join(line + end for line in lines).encode()


# PerfectFlite


def pf2_header(model: str, apogee: str, samples: int, unit: str, *more: str, ground: int = 787) -> list[str]:
    return [
        f"PerfectFlite {model}",
        "Firmware: 1.3",
        "Software: 1.1",
        "Serial Number: 3107",
        apogee,
        f"Ground Elevation: {ground}' MSL",
        f"NumSamps: {samples}",
        "Flight Number: 12",
        *more,
        "Comments: made up",
        "",
        f"Data: (Time, Altitude, Velocity, Temperature ({unit}), Voltage)",
    ]


def pf2_rows(seen: Flight, warmth: float, volts: float) -> list[str]:
    height, speed = feet(seen.height, 1), np.round(seen.speed / FOOT + noise(2, len(seen.speed), 1.5))
    return [
        f"{i * 0.05:.2f}, {h}, {v:.0f}, {warmth + 0.01 * (i % 3):.2f}, {volts - 0.01 * (i % 7 == 0):.2f}"
        for i, (h, v) in enumerate(zip(height, speed, strict=True))
    ]


def perfectflite() -> Iterator[tuple[str, bytes]]:
    seen = flight().between(0.1, 60.0, 0.05)
    deploy = ["Main Setting: 200", "Apogee Delay: 0", "Drogue At: 5.60", "Main At: 11.95", "Max Drogue Current: 4.1"]
    apogee = f"Apogee: {round(seen.apogee / FOOT) - 4}' AGL"
    rows = pf2_rows(seen, 71.3, 8.94)
    yield (
        "perfectflite__drogue_and_main.pf2",
        text([*pf2_header("SL100", apogee, len(rows), "F", *deploy), *rows], "\r\n"),
    )
    rows = pf2_rows(flight().between(0.1, 9.0, 0.05), 14.2, 3.98)
    lost = [f"{(len(rows) + i) * 0.05:.2f}, {i % 2 * 9000}, 0, 124.00, 25.50" for i in range(60)]
    header = pf2_header("SLCF", "PWRLOSS", len(rows) + 60, "C", ground=-43)
    yield "perfectflite__power_lost_and_celsius.csv", text([*header, *rows, *lost])
    short = [",".join(row.split(",")[:3]) for row in pf2_rows(seen, 71.3, 8.94)]
    short[40] = short[40].replace(",", ", 1o", 1)
    yield (
        "perfectflite__three_cells_and_a_bad_row.pf2",
        text([*pf2_header("Pnut", apogee, len(short), "F"), *short])[:-6],
    )


def perfectflite_table() -> Iterator[tuple[str, bytes]]:
    seen = flight().between(0.1, 60.0, 0.05)
    numbers = [(f"{i * 0.05:.2f}", str(h), 14.2 + 0.1 * (i % 2)) for i, h in enumerate(feet(seen.height, 3))]
    commas = ["Time,Altitude,Temp,Voltage", *(f"{t},{h},{c:.1f}C,3.9" for t, h, c in numbers)]
    yield "perfectflite_table__commas_and_celsius.csv", b"\xef\xbb\xbf" + text(commas, "\r\n")
    warm = [(t, h, f"{c * 1.8 + 32:.1f}F") for t, h, c in numbers]
    tabs = ["\t".join((t, h, f, "9.1V")) for t, h, f in warm]
    yield "perfectflite_table__tabs.txt", text(["Time\tAltitude\tTemp.\tVoltage", *tabs], "\r\n")
    yield "perfectflite_table__tabs_without_a_header.txt", text(tabs, "\r\n")
    named = ["time_s,altitude_ft,temperature,voltage", *(f"{t},{h},{f},9.1" for t, h, f in warm)]
    yield "perfectflite_table__renamed_by_hand.csv", text(named)


# AltOS CSV

STATES = ["startup", "idle", "pad", "boost", "fast", "coast", "drogue", "main", "landed"]
SATS = ",".join(f"sat{i:02}" for i in range(1, 33))


def altos_rows(seen: Flight, *, call: str, version: int, clock: bool) -> Iterator[tuple[str, str, np.void]]:
    """The cells up to the state, and those of what was measured, of each row."""
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
    """What a ground station heard: packets of two kinds in turn, some lost, and a clock that wraps."""
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


# AltOS .eeprom and .telem


def raw_pressure(pressure: np.ndarray) -> np.ndarray:
    """What an MS5607 counts at 20 degrees Celsius."""
    c1, c2, c3, c4, c5, _ = SENSOR
    dt = WARM - c5 * 256
    offset, sensitivity = c2 * 2**17 + c4 * dt / 64, c1 * 2**16 + c3 * dt / 128
    return np.round((pressure * 2**15 + offset) * 2**21 / sensitivity).astype(int)


def record(kind: str, tick: int, payload: bytes, size: int) -> bytes:
    body = (tick % 65536).to_bytes(2, "little") + payload.ljust(size - 4, b"\0")
    total = ord(kind) + sum(body) + 0x5A
    return bytes([ord(kind), -total % 256]) + body


def little(value: float, size: int) -> bytes:
    return round(value).to_bytes(size, "little", signed=value < 0)


def settings(number: int, flight_number: int = 3) -> list[str]:
    names = ("reserved", "sens", "off", "tcs", "tco", "tref", "tempsens", "crc")
    values = (5, *SENSOR, 9)
    return [
        "{",
        f'  "log_format": {number},',
        f'  "serial": 2417,\n  "flight": {flight_number},\n  "product": "made up",',
        f'  "accel_cal_plus": {PLUS},\n  "accel_cal_minus": {MINUS},\n  "accel_cal_plus_cooked": 2147483647,',
        *(f'  "ms5607_{name}": {value},' for name, value in zip(names, values, strict=True)),
        '  "software_version": "1.9.18"',
        "}",
    ]


def flash(records: list[bytes], erased: int = 64) -> list[str]:
    data = b"".join(records) + b"\xff" * erased
    return [data[i : i + 16].hex(" ") for i in range(0, len(data), 16)]


def states(seen: Flight) -> np.ndarray:
    return np.flatnonzero(np.diff(seen.state, prepend=seen.state[0] - 1))


def logged(
    seen: Flight, size: int, first: Callable[[], bytes], sample: Callable[[int], bytes], start: int
) -> list[bytes]:
    """The records of a flight: itself, its states where they change, its samples."""
    changes = set(states(seen).tolist())
    records = [record("F", start, first(), size)]
    for i, time in enumerate(seen.time):
        tick = start + round((time - seen.time[0]) / STEP)
        if i in changes:
            records.append(record("S", tick, little(seen.state[i], 2), size))
        records.append(record("A", tick - (i % 50 == 49), sample(i), size))
    return records


def altos_eeprom() -> Iterator[tuple[str, bytes]]:
    whole = flight()
    pad = air(np.array([PAD]))[0]
    seen = whole.between(-1.0, 25.0, 0.1)
    counts = raw_pressure(seen.pressure + noise(6, len(seen.time), 2.0))
    gravities = np.round(PLUS + seen.acceleration / GRAVITY * (PLUS - MINUS) / 2 + noise(7, len(seen.time), 2.0))
    metrum = logged(
        seen,
        16,
        lambda: little(3, 2) + little(PLUS + 2, 2) + little(pad, 4),
        lambda i: little(counts[i], 4) + little(WARM, 4) + little(gravities[i], 2),
        65_000,
    )
    for i in range(40, 240, 40):
        place = little(471_000_000 + i, 4) + little(84_000_000 - i, 4) + little(PAD + 20 + i, 2) + little(0, 2)
        metrum.insert(i, record("P", 65_000 + 10 * i - 30, place, 16))
    metrum[30] = metrum[30][:-1] + b"\x07"
    lines = [*settings(7), *flash(metrum)]
    lines[60] = lines[60].replace(lines[60][:2], "zz", 1)
    yield "altos_eeprom__telemetrum_2_with_damage.eeprom", text(lines)
    mini = logged(seen, 16, lambda: little(3, 2), lambda i: little(counts[i], 3) + little(WARM, 3), 100)
    yield "altos_eeprom__easymini.eeprom", text([*settings(6), *flash(mini)]) + bytes(64)
    seen = whole.between(-1.0, 20.0, 0.1)
    counts = raw_pressure(seen.pressure + noise(11, len(seen.time), 2.0))
    mega = logged(seen, 32, lambda: little(3, 2), lambda i: little(counts[i], 4) + little(WARM, 4), 9)
    yield "altos_eeprom__easymega_cut_off.eeprom", text([*settings(16), *flash(mega)])[:-211]
    words = [3, *telemini_words(whole)]
    data = b"".join(little(word, 2) for word in words).ljust(1024, b"\xff")
    rows = [data[i : i + 8].hex(" ") for i in range(0, len(data), 8)]
    yield "altos_eeprom__telemini_1.eeprom", text([*settings(2), *rows])
    yield "altos_eeprom__telemetrum_1_among_commands.eeprom", old_form(whole.between(-1.0, 25.0, 0.1))
    yield "altos_eeprom__telemetrum_2_old_form.eeprom", old_form_2(metrum)


def analogue(pressure: np.ndarray) -> np.ndarray:
    """What the converter of a TeleMetrum 1 counts, in its steps of four."""
    return np.round((pressure / 1000 * 0.009 - 0.095) * 16 * 2047 / 4).astype(int) * 4


def telemini_words(whole: Flight) -> Iterator[int]:
    """Pressures ten times a second, once a second below the drogue; a word before them where the state changes."""
    counts, row, state = analogue(whole.pressure), 200, -1
    while row < len(whole.time):
        if int(whole.state[row]) != state:
            state = int(whole.state[row])
            yield 0x8000 | state
        yield int(counts[row])
        row += 100 if state >= 6 else 10


def old_form(seen: Flight) -> bytes:
    """Format 1: what a terminal shows, two numbers of each record."""
    counts = analogue(seen.pressure + noise(8, len(seen.time), 6.0))
    gravities = np.round(PLUS + seen.acceleration / GRAVITY * (PLUS - MINUS) / 2).astype(int)
    lines = ["~", "> E 0", "Config version: 1.11", "Main deploy: 250", f"Accel cal +1g: {PLUS} -1g: {MINUS}"]
    lines += [
        "product TeleMetrum-v1.1",
        "serial-number 209",
        "software-version 1.1.1",
        "> l",
        "flight 13 start 0 end 100",
        "done",
    ]
    lines.append(f"F 0010 {PLUS:04x} {13:04x}")
    changes = set(states(seen).tolist())
    for i in range(len(seen.time)):
        tick = 0x10 + 10 * i
        lines += [f"S {tick:04x} {int(seen.state[i]):04x} 0000"] if i in changes else []
        lines.append(f"A {tick:04x} {gravities[i]:04x} {counts[i]:04x}")
    return text([*lines, f"A {tick + 10:04x} 3c"])[:-1] + bytes(16)


def old_form_2(records: list[bytes]) -> bytes:
    """Format 7 in the old form: the letter, the clock, and the bytes that follow it."""
    names = ("sens", "off", "tcs", "tco", "tref", "tempsens")
    lines = ["Config version: 1.15", f"Accel cal +1g: {PLUS} -1g: {MINUS}", "log-format 7", "product TeleMetrum-v2.0"]
    lines += ["serial-number 2417", "software-version 1.3.2"]
    lines += [f"ms5607 {name}: {value}" for name, value in zip(names, SENSOR, strict=True)]
    whole = [one for one in records if (sum(one) + 0x5A) % 256 == 0]
    return text([*lines, *(f"{chr(r[0])} {r[3]:02x}{r[2]:02x} {r[4:].hex(' ')}" for r in whole)])


def altos_telem() -> Iterator[tuple[str, bytes]]:
    seen = flight().between(-2.0, 60.0, 0.1)
    lines = ["VERSION 1 CALL made-up", "CRC INVALID RSSI -80"]
    for i, time in enumerate(seen.time):
        tick = (65_400 + round(time / STEP)) % 65536
        body = little(2417, 2) + little(tick, 2)
        if i % 10 == 9:
            body += (
                bytes([5, 0x19])
                + little(PAD + 20 + seen.height[i], 2)
                + little(471_000_000, 4)
                + little(84_000_000 - i, 4)
            )
        else:
            body += bytes([10, int(seen.state[i])]) + little(PLUS, 2)
            body += little(seen.pressure[i] + noise(9, 700, 3.0)[i], 4) + little(2140, 2)
            body += little(16 * seen.acceleration[i], 2) + little(16 * seen.speed[i], 2) + little(seen.height[i], 2)
        lines.append(heard(body, good=i % 37 != 5))
    lines[40] = lines[40][:20] + "00" + lines[40][22:]
    yield "altos_telem__telemetrum_2_with_gaps.telem", text(lines)[:-9]
    seen = flight().between(-2.0, 60.0, 0.2)
    old = []
    for i, time in enumerate(seen.time):
        body = little(209, 2) + little(500 + round(time / STEP), 2) + bytes([1, int(seen.state[i])]) + little(PLUS, 2)
        body += little(analogue(seen.pressure[i : i + 1])[0], 2) + bytes(8)
        body += little(16 * seen.acceleration[i], 2) + little(16 * seen.speed[i], 2) + little(seen.height[i], 2)
        old.append(heard(body))
    yield "altos_telem__telemetrum_1.telem", text(old)


def heard(body: bytes, *, good: bool = True) -> str:
    """A packet as a ground station writes it down."""
    frame = body.ljust(32, b"\0") + bytes([30, 0x80 * good | 0x30])
    return f"TELEM {(bytes([len(frame)]) + frame + bytes([(0x5A + sum(frame)) % 256])).hex()}"


# MicroPeak


def micropeak() -> Iterator[tuple[str, bytes]]:
    yield "micropeak__a_small_flight.mpd", blinked(flight(push=60.0, burn=1.0), 0, 0.192)
    yield "micropeak__micropeak_2_cut_off.mpd", blinked(flight(), 2, 0.1)[:-300]


def blinked(whole: Flight, model: int, step: float) -> bytes:
    times = np.arange(1.0, whole.time[-1], step)[: 251 if model == 0 else None]
    pressure = np.interp(times, whole.time, whole.pressure)
    ground = round(air(np.array([PAD]))[0])
    samples = np.round(pressure + noise(10, len(times), 3.0)).astype(int)
    data = little(ground, 4) + little(pressure.min(), 4) + little(model << 12 | (len(times) & 0xFFF), 2)
    data += little(len(times) >> 12, 2) if model == 2 else b""
    data += b"".join(little(sample % 65536, 2) for sample in samples)
    rows = "".join("\r\n" + data[i : i + 16].hex() for i in range(0, len(data), 16))
    return f"~~ MP{rows}\r\n{crc_x25(data):04x}\r\n".encode()


def micropeak_csv() -> Iterator[tuple[str, bytes]]:
    seen = flight(push=60.0, burn=1.0).between(0.2, 30.0, 0.19)
    names = " Time, Press(Pa), Height(m), Height(f), Speed(m/s), Speed(mph), Speed(mach), "
    names += "Accel(m/s²), Accel(ft/s²),  Accel(g)"
    rows = [
        f"{i * 0.192:6.3f},{p:10.0f},{h:10.1f},{h / FOOT:10.1f},{v:11.2f},{v / 0.44704:11.2f},{v / 340:12.4f},"
        f"{a:12.2f},{a / FOOT:13.2f},{a / GRAVITY:10.4f}"
        for i, (p, h, v, a) in enumerate(zip(seen.pressure, seen.height, seen.speed, seen.acceleration, strict=True))
    ]
    yield "micropeak_csv__as_its_program_writes_it.csv", text([names, *rows])


MAKERS = (perfectflite, perfectflite_table, altos_csv, altos_eeprom, altos_telem, micropeak, micropeak_csv)


def main() -> None:
    for make in MAKERS:
        for name, content in make():
            (FOLDER / name).write_bytes(content)
            print(f"{len(content):7} {name}")


if __name__ == "__main__":
    main()
