"""The force along a climb in the published logs: `python tools/real_forces.py LOGS OUT.md`.

LOGS is the folder of recordings with their SOURCES.md. For each log with a climb: the source of its acceleration, what
is known of rocket and motor, and whether a missing force can be computed. If mass and motor are known: the law from
this flight alone, with a free drag. For every coast: drag area over mass, which needs neither.
"""

import argparse
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from fieldkit.analysis import Forces, Recorded, measure
from fieldkit.errors import FieldkitError
from fieldkit.flight import Flight
from fieldkit.importing.read import read_recordings
from fieldkit.motors import catalogue
from fieldkit.selection.force.flights import FlightForce, flight_force, rocket_of
from tools.markdown import prose


@dataclass(frozen=True)
class Known:
    """Information about the rocket of a log from SOURCES.md or the file of conditions, and objections to using it."""

    motor: str = ""
    dry_mass: float | None = None
    diameter: float | None = None
    caveat: str = ""


KNOWN = {
    "raven_fip_variant__ndrt_2020": Known("Cesaroni L1395", 18.998, None, "the mass may include the motor case"),
    "generic__ncsu_firm_jackpot_launch_1": Known("AeroTech L1390G", 16.848, 0.1524, "air brakes opened in the coast"),
    "featherweight_gps__adventurer": Known("J510W"),
    "altos_csv__2012-05-28": Known(caveat="it shows a second boost after the coast"),
    "entacore_aim_xtra": Known("E190 / H148R", None, None, "two stages"),
}
"""By the start of a file's name."""
CD = 0.5
"""The starting value of Cd; each flight has a free drag. [1]"""
GUESSED_DIAMETER = 0.15
"""Starting value of an unknown diameter. [m]"""
SLOW, FAST = 0.3, 0.7
"""Range of Mach numbers for comparing coasts. [1]"""
SOUND = 335.0
"""Speed of sound for Mach numbers. [m/s]"""
NOISY = 0.1
"""Unexplained residuals above this fraction of the drag could hide a term. [1]"""


def main() -> None:
    """Write the page."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("logs", type=Path)
    parser.add_argument("out", type=Path)
    arguments = parser.parse_args()
    rows, laws = [], []
    for path in sorted(arguments.logs.iterdir()):
        log = recorded(path)
        if log is None:
            continue
        known = next((one for start, one in KNOWN.items() if path.name.startswith(start)), Known())
        shown = judged(path.stem, log, known)
        why = shown if isinstance(shown, str) else "usable" + (f", but {known.caveat}" if known.caveat else "")
        source, area = (log.forces.source, drag_area(log.forces)) if log.forces else ("none", "")
        mass = f"{known.dry_mass:.3f} kg" if known.dry_mass else "unknown"
        rows.append(f"| {path.stem} | {source} | {known.motor or 'unknown'} | {mass} | {area} | {why} |")
        if isinstance(shown, FlightForce):
            laws += ["", *section(shown)]
    arguments.out.write_text("\n".join([*HEAD, *rows, *laws, ""]), encoding="utf-8")


HEAD = [
    "# The force along real climbs",
    "",
    *prose(
        "The *missing force* is the measured acceleration along the climb minus that of the model's thrust and drag at",
        "the measured speed and height ([the loop](loop.md) looks for terms in it that recur from flight to flight).",
        "This page has what published recordings show of it. It requires the motor and the mass of the rocket, which",
        "few of them state. The drag area over mass in the coast requires neither; the table has its median and",
        "central 80% between Mach 0.3 and 0.7, or above 30 m/s for slower coasts.",
    ),
    *prose(
        "A law requires two flights of one rocket, and these are all of different rockets; `top_shot` and `juno3` are",
        "single flights recorded by two loggers, `hedy` is the raw and the filtered file of one logger. If only",
        "heights were recorded, the acceleration is their second derivative, and the spread is that of the smoothing.",
        "`python tools/real_forces.py LOGS docs/real-forces.md` writes this page from a folder LOGS of the recordings.",
    ),
    "| log | acceleration from | motor | mass without motor | Cd·A/m [cm²/kg] | missing force |",
    "|---|---|---|---|---|---|",
]


def recorded(path: Path) -> Recorded | None:
    """The flight in a log, or None if the file is not a log of heights over time."""
    try:
        readings = [one for one in read_recordings(path.read_bytes(), path.name) if one.describes == "flight"]
    except FieldkitError:
        return None
    return measure(readings[0].clocks, readings[0].events) if readings else None


def judged(name: str, recording: Recorded, known: Known) -> FlightForce | str:
    """The missing force of a log, or the reason there is none."""
    if recording.forces is None:
        return "; ".join(recording.notes) or "no climb from lift-off"
    lacking = [what for what, there in (("motor", known.motor), ("mass", known.dry_mass)) if not there]
    if lacking:
        return f"{' and '.join(lacking)} unknown" + (f"; {known.caveat}" if known.caveat else "")
    flight = Flight(name, "", "", known.motor, dry_mass=known.dry_mass)
    area = CD * np.pi / 4 * (known.diameter or GUESSED_DIAMETER) ** 2
    return flight_force(name, recording, rocket_of(flight, catalogue().resolve(known.motor).motor, area))


def drag_area(forces: Forces) -> str:
    """Drag area over mass in the coast. [cm^2/kg]"""
    coast = np.isfinite(forces.drag_area)
    mach = forces.speed / SOUND
    rows = coast & (mach > SLOW) & (mach < FAST)
    rows = rows if rows.sum() >= 5 else coast & (forces.speed > 30)
    if rows.sum() < 5:
        return "coast too short"
    low, middle, high = 1e4 * np.quantile(forces.drag_area[rows], (0.1, 0.5, 0.9))
    return f"{middle:.2f} ({low:.2f} to {high:.2f})"


def section(one: FlightForce) -> list[str]:
    """The law from one flight, and its points."""
    terms = [
        f"{found.term.name} {found.value:+.3f} ± {found.sd:.3f} {found.term.unit}"
        + (f" (or {', '.join(found.also)})" if found.also else "")
        for found in one.law.terms
    ]
    result = "; ".join(terms) or nothing(one)
    lines = [f"## {one.flight_id}", "", f"One flight is not conclusive. Result: {result}."]
    lines += ["", "| phase | time from lift-off [s] | speed [m/s] | missing [m/s²] | ± |", "|---|---|---|---|---|"]
    return lines + [
        f"| {phase} | {p.time_from_liftoff:.2f} | {p.speed:.1f} | {p.force:+.2f} | {p.sd:.2f} |"
        for p in one.points
        for phase in ["boost" if p.burning else "coast"]
    ]


def nothing(one: FlightForce) -> str:
    """The meaning of a law without terms: nothing is missing, or scatter would hide it."""
    left, drag = one.law.left, float(one.missing.drag.max())
    if left > NOISY * drag:
        return f"none, because the residual, {left:.2g} m/s², is above {NOISY:.0%} of the largest drag, {drag:.2g} m/s²"
    return f"nothing is missing; the residual is {left:.2g} m/s², the largest drag {drag:.2g} m/s²"


if __name__ == "__main__":
    main()
