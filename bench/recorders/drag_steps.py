"""Drag that switches in the coast, from logs: `python -m bench.recorders.drag_steps --out docs/drag-steps.md`.

Rockets of five flights each, recorded by several kinds of recorders: healthy ones; air brakes that open, and perhaps
close again, on two or three flights; one flight that loses a fin, or whose streamer is out early; motors that chuff,
which must not be taken for drag. Printed are, for each recorder, the flights without a step to which one is given, the
steps found and their onsets, and how well the standard deviations of the drag of healthy coasts hold.
"""

import argparse
import sys
import zlib
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from pathlib import Path as File
from typing import Literal

import numpy as np

from bench.air import GAS, station_pressure
from bench.recorders.flights import Path, paths, sport_launch
from bench.recorders.models import RECORDERS, Recorder
from bench.recorders.record import written
from bench.vertical import climb
from bench.world import Launch
from fieldkit.analysis import measure
from fieldkit.analysis.force_profile import DragProfile, drag_profile
from fieldkit.errors import FieldkitError
from fieldkit.importing import Reading
from fieldkit.importing.recognize import open_log
from fieldkit.selection.drag_steps import LoggedDrag, drag_steps
from fieldkit.selection.logged_forces import DRAG_STEP
from fieldkit.selection.prior import log_prior_odds
from tools.markdown import commit, prose, table

Cause = Literal["healthy", "brakes", "lost fin", "streamer", "chuffing"]
CAUSES: tuple[Cause, ...] = ("healthy", "healthy", "brakes", "brakes", "lost fin", "streamer", "chuffing")
SHOWN = ("50 Hz", "accel 50 Hz", "accel 100 Hz", "clipped 4 g", "three axes")
"""Recorders of the page."""
FLIGHTS = 5
"""Flights of a rocket."""
SCATTER = 0.03
"""Standard deviation of the drag of single flights. [1]"""
NAMED = 0.5
"""Probability from which a flight has a step."""
SHORTEST_COAST = 3.0
"""Coast within which brakes have time to open. [s]"""


@dataclass(frozen=True, slots=True)
class Judged:
    """One flight: its cause, whether its drag switched, the probability of a step that was found, the errors of onset
    [s] and ratio [sd], and the error of a healthy coast's drag [sd]."""

    cause: Cause
    switched: bool
    found: float
    onset: float = np.nan
    ratio: float = np.nan
    level: float = np.nan


def rockets(name: str, count: int, seed: int) -> Iterator[Judged]:
    """The flights of some rockets on one recorder, as many of each cause."""
    recorder, rng = RECORDERS[name], np.random.default_rng([seed, zlib.crc32(name.encode())])
    for number in range(count):
        cause = CAUSES[number % len(CAUSES)]
        yield from judged(flown(cause, rng), cause, recorder, rng)


def flown(cause: Cause, rng: np.random.Generator) -> list[Launch]:
    """The launches of one rocket."""
    while True:
        first = sport_launch(rng)
        quick = climb(first)
        if quick.coast > SHORTEST_COAST and quick.top_speed < 220:
            break
    burn = first.motor.burn_time
    members = set(rng.choice(FLIGHTS, int(rng.integers(2, 4)), replace=False).tolist()) if cause == "brakes" else set()
    members |= {int(rng.integers(FLIGHTS))} if cause in ("lost fin", "streamer") else set()
    factor = {"brakes": rng.uniform(1.4, 2.5), "lost fin": rng.uniform(1.3, 1.7), "streamer": rng.uniform(2.5, 6.0)}
    begin, end = burn + quick.coast * rng.uniform(0.15, 0.4), burn + quick.coast * rng.uniform(0.6, 0.8)
    launches = []
    for number in range(FLIGHTS):
        drag = replace(first.drag, cd=first.drag.cd * float(np.exp(rng.normal(0, SCATTER))))
        if number in members:
            closes = cause == "brakes" and rng.random() < 0.3
            onset = begin + float(rng.normal(0, 0.1))
            last = end if closes else burn + quick.coast + 5.0
            drag = replace(drag, step=float(factor[cause]), step_from=onset, step_to=last)
        motor = first.motor
        if cause == "chuffing" and number % 2:
            dip = 1 - 0.7 * np.exp(-0.5 * ((motor.time / burn - 0.55) / 0.06) ** 2)
            motor = replace(motor, thrust=motor.thrust * dip)
        launches.append(replace(first, drag=drag, motor=motor, tilt=float(np.radians(abs(rng.normal(0, 4))))))
    return launches


def judged(launches: Sequence[Launch], cause: Cause, recorder: Recorder, rng: np.random.Generator) -> Iterator[Judged]:
    """The flights of one rocket, as the product reads their logs."""
    logs, flown_logs = [], []
    for number, (launch, path) in enumerate(zip(launches, paths(launches, rng), strict=True)):
        profile = _profile(path, recorder, rng)
        if profile is not None:
            logs.append(LoggedDrag(str(number), profile, profile.reference, SCATTER))
            flown_logs.append((launch, path))
    found = drag_steps(logs, log_prior_odds([DRAG_STEP]))
    if found is None:
        return
    for log, one, (launch, path) in zip(logs, found.flights, flown_logs, strict=True):
        drag, switched = launch.drag, launch.drag.step != 1
        step = one.steps[0] if one.steps and one.member > NAMED else None
        if switched:
            late = step.begin - (drag.step_from - (launch.motor.burn_time - path.burnout)) if step else np.nan
            yield Judged(cause, True, one.member, late, (step.ratio - drag.step) / step.sd if step else np.nan)
        else:
            yield Judged(cause, False, one.member, level=_level(log.profile, launch))


def _profile(path: Path, recorder: Recorder, rng: np.random.Generator) -> DragProfile | None:
    try:
        found = open_log(written(path, recorder, rng), "log", None).found
    except FieldkitError:
        return None
    reading = next((item for item in found if isinstance(item, Reading) and item.clocks), None)
    return None if reading is None else drag_profile(reading.clocks, measure(reading.clocks, reading.events))


def _level(profile: DragProfile, launch: Launch) -> float:
    """Error of the drag of a coast without a step, in its standard deviations."""
    value, sd = profile.level
    station = station_pressure(launch.air.qnh, launch.air.elevation)
    density = station / (GAS * launch.air.temperature)
    mass = launch.dry_mass + launch.motor.total_mass - launch.motor.propellant_mass
    area = np.pi / 4 * launch.airframe.diameter**2
    truth = density * launch.drag.cd * launch.drag.power_off * area / (2 * mass)
    return float((value - truth) / sd)


HEAD = [
    "# Drag that switches, from simulated logs",
    "",
    *prose(
        "Rockets of five flights each in another simulator (`bench.fast_truth`): healthy ones; brakes that open on two",
        "or three flights by a factor of 1.4 to 2.5 and close again on some; a lost fin or an early streamer on one",
        "flight; motors that chuff. *False* are flights without a step to which one is given at more than 50%. Onsets",
        "are judged on the brakes that were found, and *z* is the root mean square of the errors of the drag of",
        "flights without a step, in their standard deviations. `python -m bench.recorders.drag_steps --out",
        "docs/drag-steps.md` writes this page.",
    ),
]
HEADERS = (
    "recorder",
    "flights without a step",
    "false",
    "brakes found",
    "onset within 0.3 s",
    "fin found",
    "streamer found",
    "z",
)


def row(name: str, flights: Sequence[Judged]) -> Sequence[str]:
    """The row of a recorder."""
    quiet = [one for one in flights if not one.switched]
    brakes = [one for one in flights if one.switched and one.cause == "brakes"]
    hits = [one for one in brakes if one.found > NAMED]
    near = [one for one in hits if abs(one.onset) < 0.3]
    levels = np.array([one.level for one in quiet])
    return (
        name,
        str(len(quiet)),
        _part([one for one in quiet if one.found > NAMED], quiet),
        _part(hits, brakes),
        _part(near, hits),
        *(_part_of(flights, cause) for cause in ("lost fin", "streamer")),
        f"{np.sqrt(np.nanmean(levels**2)):.1f}" if levels.size else "-",
    )


def _part_of(flights: Sequence[Judged], cause: str) -> str:
    some = [one for one in flights if one.switched and one.cause == cause]
    return _part([one for one in some if one.found > NAMED], some)


def _part(some: Sequence[Judged], of: Sequence[Judged]) -> str:
    return f"{len(some)} of {len(of)}"


def main(arguments: list[str] | None = None) -> int:
    """Print the table, or write the page."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--recorders", nargs="+", default=list(SHOWN))
    parser.add_argument("--rockets", type=int, default=len(CAUSES))
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--out", type=File)
    chosen = parser.parse_args(arguments)
    found = {name: list(rockets(name, chosen.rockets, chosen.seed)) for name in chosen.recorders}
    rows = [row(name, flights) for name, flights in found.items()]
    rows.append(row("all", [one for flights in found.values() for one in flights]))
    lines = [*HEAD, *table(HEADERS, rows), f"Run on {commit()}."]
    if chosen.out:
        chosen.out.write_text("\n".join(lines).rstrip() + "\n", encoding="utf-8")
    else:
        sys.stdout.write("\n".join(lines) + "\n")
    return 0


if __name__ == "__main__":
    sys.exit(main())
