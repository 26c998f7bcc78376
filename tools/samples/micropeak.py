"""MicroPeak: the data that its light transmits, and its program's table."""

from collections.abc import Iterator

import numpy as np

from fieldkit.importing.tables.checksums import crc_x25
from fieldkit.physics.standard_atmosphere import GRAVITY
from fieldkit.units import FOOT
from tools.samples.two_parachutes import PAD, Flight, air, flight
from tools.samples.writing import little, noise, text


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


MAKERS = (micropeak, micropeak_csv)
