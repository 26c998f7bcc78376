"""AltOS telemetry: packets as saved by a ground station."""

from collections.abc import Iterator

from tools.samples.altos_eeprom import PLUS, analogue
from tools.samples.two_parachutes import PAD, STEP, flight
from tools.samples.writing import little, noise, text


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
    """A packet as saved by a ground station."""
    frame = body.ljust(32, b"\0") + bytes([30, 0x80 * good | 0x30])
    return f"TELEM {(bytes([len(frame)]) + frame + bytes([(0x5A + sum(frame)) % 256])).hex()}"


MAKERS = (altos_telem,)
