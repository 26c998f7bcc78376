"""AltOS flash: the records in the memory of Altus Metrum's loggers."""

from collections.abc import Callable, Iterator

import numpy as np

from fieldkit.physics.standard_atmosphere import GRAVITY
from tools.samples.two_parachutes import PAD, STEP, Flight, air, flight
from tools.samples.writing import little, noise, text

SENSOR = (46372, 43981, 29059, 27842, 31553, 28165)
"""C1 to C6 of the worked example in the data sheet of the MS5607."""


WARM = 8077636
"""Counts of that sensor at 20 degrees Celsius."""


PLUS, MINUS = 15545, 16067
"""Counts of the accelerometer with the nose up and down."""


def raw_pressure(pressure: np.ndarray) -> np.ndarray:
    """Counts of an MS5607 at 20 degrees Celsius."""
    c1, c2, c3, c4, c5, _ = SENSOR
    dt = WARM - c5 * 256
    offset, sensitivity = c2 * 2**17 + c4 * dt / 64, c1 * 2**16 + c3 * dt / 128
    return np.round((pressure * 2**15 + offset) * 2**21 / sensitivity).astype(int)


def record(kind: str, tick: int, payload: bytes, size: int) -> bytes:
    body = (tick % 65536).to_bytes(2, "little") + payload.ljust(size - 4, b"\0")
    total = ord(kind) + sum(body) + 0x5A
    return bytes([ord(kind), -total % 256]) + body


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
    """The records of a flight: the flight, its changes of state, its samples."""
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
    mega = logged(
        seen,
        32,
        lambda: little(3, 2) + little(PLUS + 2, 2) + little(pad, 4),
        lambda i: little(counts[i], 4) + little(WARM, 4) + bytes(18) + little(gravities[i], 2),
        9,
    )
    yield "altos_eeprom__easymega_cut_off.eeprom", text([*settings(16), *flash(mega)])[:-211]
    words = [3, *telemini_words(whole)]
    data = b"".join(little(word, 2) for word in words).ljust(1024, b"\xff")
    rows = [data[i : i + 8].hex(" ") for i in range(0, len(data), 8)]
    yield "altos_eeprom__telemini_1.eeprom", text([*settings(2), *rows])
    yield "altos_eeprom__telemetrum_1_among_commands.eeprom", old_form(whole.between(-1.0, 25.0, 0.1))
    yield "altos_eeprom__telemetrum_2_old_form.eeprom", old_form_2(metrum)


def analogue(pressure: np.ndarray) -> np.ndarray:
    """Counts of the converter of a TeleMetrum 1, in its steps of four."""
    return np.round((pressure / 1000 * 0.009 - 0.095) * 16 * 2047 / 4).astype(int) * 4


def telemini_words(whole: Flight) -> Iterator[int]:
    """Pressures ten times a second, once a second below the drogue, with a word before them at each change of state."""
    counts, row, state = analogue(whole.pressure), 200, -1
    while row < len(whole.time):
        if int(whole.state[row]) != state:
            state = int(whole.state[row])
            yield 0x8000 | state
        yield int(counts[row])
        row += 100 if state >= 6 else 10


def old_form(seen: Flight) -> bytes:
    """Format 1 as shown in a terminal, two numbers per record."""
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


MAKERS = (altos_eeprom,)
