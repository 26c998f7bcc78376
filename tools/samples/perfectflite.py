"""PerfectFlite's loggers: the files of their program, and its tables."""

from collections.abc import Iterator

import numpy as np

from fieldkit.units import FOOT
from tools.samples.two_parachutes import Flight, flight
from tools.samples.writing import feet, noise, text


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


def pf2_rows(seen: Flight, temperature: float, volts: float) -> list[str]:
    height, speed = feet(seen.height, 1), np.round(seen.speed / FOOT + noise(2, len(seen.speed), 1.5))
    return [
        f"{i * 0.05:.2f}, {h}, {v:.0f}, {temperature + 0.01 * (i % 3):.2f}, {volts - 0.01 * (i % 7 == 0):.2f}"
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


MAKERS = (perfectflite, perfectflite_table)
