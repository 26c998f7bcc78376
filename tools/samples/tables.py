"""Tables of teams and exports of simulations: one small flight, integrated with plain drag, in each format."""

from collections.abc import Callable, Iterable

import numpy as np

from fieldkit.physics.standard_atmosphere import GRAVITY
from fieldkit.units import FOOT

ZERO_WIDTH = "\u200b"


def flight(step: float, until: float) -> dict[str, np.ndarray]:
    """A 100 g rocket on a 10 N motor for 1.2 s, with a parachute half a second after apogee. [SI]"""
    t, h, v, chute = 0.0, 0.0, 0.0, None
    rows = []
    while t < until and not (t > 3 and h <= 0):
        burning = t < 1.2
        drag = (0.02 if chute and t >= chute else 0.00035) * v * abs(v)
        mass = 0.11 - 0.01 * min(t, 1.2) / 1.2
        thrust = 10.0 * burning
        a = (thrust - drag) / mass - GRAVITY
        if h <= 0 and v <= 0:
            a = max(a, 0.0)
        rows.append((t, h, v, a, thrust, drag, mass))
        v += a * step
        h = max(h + v * step, 0.0)
        t += step
        if chute is None and t > 1.5 and v < 0:
            chute = t + 0.5
    names = ("t", "h", "v", "a", "thrust", "drag", "mass")
    return dict(zip(names, np.array(rows).T, strict=True))


def pressure(height: np.ndarray, pad: float = 99_500.0) -> np.ndarray:
    """Static pressure above a pad. [Pa]"""
    return pad * (1 - height / 44330.77) ** 5.25588


def openrocket(separator: str, mark: str, names: str, *, header_mark: bool = True, encoding: str = "utf-8") -> bytes:
    """An export with events between its rows."""
    f = flight(0.02, 80.0)
    top = float(f["t"][f["h"].argmax()])
    events = [(0.0, "LAUNCH"), (0.0, "IGNITION"), (0.02, "LIFTOFF"), (0.18, "LAUNCHROD"), (1.2, "BURNOUT")]
    events += [(top, "APOGEE"), (top + 0.5, "EJECTION_CHARGE"), (top + 0.5, "RECOVERY_DEVICE_DEPLOYMENT")]
    events += [(float(f["t"][-1]), "GROUND_HIT"), (float(f["t"][-1]), "SIMULATION_END")]
    lines = [f"{mark} Swift, C6-5 (Up to date)", f"{mark} {len(f['t'])} data points written for 7 variables."]
    lines += [f"{mark} Simulation warnings:", f"{mark}   Large angle of attack encountered (12.0\u00b0)", mark]
    lines.append(f"{mark} " * header_mark + names)
    for i in range(0, len(f["t"]), 1 if len(f["t"]) < 400 else 3):
        while events and events[0][0] <= f["t"][i] + 1e-9:
            lines.append(f"{mark} Event {events[0][1]} occurred at t={events[0][0]:.3g} seconds")
            events.pop(0)
        drag = "NaN" if i == 0 else f"{f['drag'][i]:.5g}"
        cells = [f"{f['t'][i]:.5g}", f"{f['h'][i]:.5g}", f"{f['v'][i]:.5g}", f"{f['a'][i]:.5g}"]
        lines.append(separator.join([*cells, f"{f['thrust'][i]:.4g}", drag, f"{f['mass'][i] * 1000:.5g}"]))
    lines += [f"{mark} Event {name} occurred at t={time:.4g} seconds" for time, name in events]
    return ("\n".join(lines) + "\n").encode(encoding)


def rocksim() -> bytes:
    """Leading blanks in cells, an extra blank before a comma, units after the names."""
    f = flight(0.02, 80.0)
    lines = ["Time,Thrust N ,Mass Grams,Altitude Feet,Velocity Feet / Sec,Drag force N"]
    for t, h, v, thrust, drag, mass in zip(f["t"], f["h"], f["v"], f["thrust"], f["drag"], f["mass"], strict=True):
        cells = (t, thrust, mass * 1000, h / FOOT, v / FOOT, drag)
        lines.append(",".join(f" {cell:.5f}" for cell in cells))
    return ("\r\n".join(lines[:1] + lines[1::4]) + "\r\n").encode()


def rasaero() -> bytes:
    """The known columns of RASAero II, every fourth of its rows."""
    f = flight(0.01, 80.0)
    lines = ["Time (sec),Stage,Stage Time (sec),Mach Number,Thrust (lb),Drag (lb),Vel-V (ft/sec),Altitude (ft)"]
    for i in range(0, len(f["t"]), 8):
        forces = f["thrust"][i] / 4.4482216, f["drag"][i] / 4.4482216
        cells = (f["t"][i], f["t"][i], abs(f["v"][i]) / 340, *forces, f["v"][i] / FOOT, f["h"][i] / FOOT)
        lines.append(f"{cells[0]:.2f},S,{cells[1]:.2f}," + ",".join(f"{cell:.4f}" for cell in cells[2:]))
    return ("\n".join(lines) + "\n").encode()


def rocketpy() -> bytes:
    """RocketPy's export of a height above the sea, a vertical speed and the attitude."""
    f = flight(0.01, 80.0)
    lines = ["# Time (s),Z (m),Vz (m/s),E0,E3"]
    lines += [
        f"{f['t'][i]:.6f},{f['h'][i] + 310:.6f},{f['v'][i]:.6f},1.000000,0.000000" for i in range(0, len(f["t"]), 8)
    ]
    return ("\n".join(lines) + "\n").encode()


def table(header: Iterable[str], row: Callable[[float, float, float, float], str], step: float, wait: float) -> bytes:
    """A team's table: `wait` seconds on the pad, then the flight, with noise of 0.1 m."""
    random = np.random.default_rng(7)
    f = flight(step, 80.0)
    pad = int(wait / step)
    t = np.arange(pad + len(f["t"])) * step
    h = np.concatenate([np.zeros(pad), f["h"]]) + random.normal(0, 0.1, pad + len(f["t"]))
    felt = np.concatenate([np.full(pad, GRAVITY), f["a"] + GRAVITY]) + random.normal(0, 0.05, len(t))
    return (
        "\n".join([*header, *(row(*cells, p) for *cells, p in zip(t, h, felt, pressure(h), strict=True))]) + "\n"
    ).encode()


def tables() -> dict[str, bytes]:
    """Every sample of this file."""
    english = (
        "Time (s),Altitude (m),Vertical velocity (m/s),Vertical acceleration (m/s²),Thrust (N),Drag force (N),Mass (g)"
    )
    german = (
        "Zeit (s);Höhe (m);Vertikale Geschwindigkeit (m/s);Vertikale Beschleunigung (m/s²);Schub (N);Cd ({});Masse (g)"
    )
    return {
        "openrocket__as_it_comes.csv": openrocket(",", "#", english),
        "openrocket__semicolons_and_german_names.csv": openrocket(";", "%", german.format(ZERO_WIDTH)),
        "openrocket__latin_1_and_the_header_mark_taken_off.csv": openrocket(
            "\t", "#", english.replace(",", "\t"), header_mark=False, encoding="latin-1"
        ),
        "rocksim__a_small_flight.csv": rocksim(),
        "rasaero__a_small_flight.csv": rasaero(),
        "rocketpy__heights_above_the_sea.csv": rocketpy(),
        "mapped_table__milliseconds_and_no_unit_of_height.csv": table(
            ["Team Alpha,firmware 3", "time_ms,alt,press,state"],
            lambda t, h, felt, p: f"{t * 1000:.0f},{h / FOOT:.1f},{p / 100:.2f},{'PAD' if t < 5 else 'FLY'}",
            0.05,
            5.0,
        ),
        "mapped_table__unix_time_and_three_axes.csv": table(
            ["timestamp_seconds,pressure_pascals,raw_acceleration_x_gs,raw_acceleration_y_gs,raw_acceleration_z_gs"],
            lambda t, h, felt, p: f"{1.7e9 + t:.3f},{p:.1f},{0.05:.3f},{-0.02:.3f},{felt / GRAVITY:.4f}",
            0.1,
            20.0,
        ),
        "mapped_table__time_three_axes_total_and_feet.csv": table(
            ["Time (s),Accel X (g),Accel Y (g),Accel Z (g),Total Accel (g),Altitude (ft)"],
            lambda t, h, felt, p: f"{t:.2f},0.05,{felt / GRAVITY:.3f},-0.02,{abs(felt / GRAVITY):.3f},{h / FOOT:.1f}",
            0.1,
            0.0,
        ),
    }


MAKERS = (tables,)
