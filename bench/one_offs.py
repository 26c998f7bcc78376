"""`python -m bench.one_offs [--as logs rocketpy] [--processes 16] [--keep ROWS.json] [--out docs/one-offs.md]`: what
single faulty flights among healthy ones are named.

Ten flights of a rocket, one of them with a fault at one of three strengths, as the ten readouts of a device, flown by
the bench's simulator (`fast_truth`); with `--as logs` as logs of recorders (`bench.recorders`), from which the program
measures the readouts itself, and with `--as rocketpy` as such logs of flights in RocketPy. Devices and flights scatter
about as real ones do, in forms of their own: readouts have Student t noise with three degrees of freedom around a bias
of the device, thrust and drag 1.6 times the bench's usual scatter. The answer is the cause that `fieldkit loop` would
name, computed by the same function.

Beside it an exact fit knows the rocket, the device and every fault and strength exactly, and only
has to recognize them in the scatter. What it cannot decide, no program can.
"""

import argparse
import json
import multiprocessing
import subprocess
import sys
import zlib
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path as File
from typing import Any

import numpy as np

from bench import fast_truth
from bench.air import GRAVITY
from bench.altimeter import RESOLUTION, exact_readouts
from bench.fleet import Flown, Season, draw, scattered
from bench.motors import motors
from bench.recorders.flights import Path, paths
from bench.recorders.models import RECORDERS, Recorder
from bench.recorders.record import written
from bench.rockets import CLASSES, Needs
from bench.world import Launch
from fieldkit.analysis import columns, measure
from fieldkit.errors import FieldkitError
from fieldkit.flight import Flight
from fieldkit.forecast.one_offs import beside_others
from fieldkit.importing import Reading
from fieldkit.importing.recognize import open_log
from fieldkit.motors import catalogue
from fieldkit.shapes import Array, Float
from tools.markdown import prose

FLIGHTS = 10
"""Number of flights of a rocket. [1]"""
NEEDS = Needs(readouts=("all",), scatter=1.6, conditions="none")
COMPARED = ("apogee_m", "top_speed_mps", "burn_time_s", "peak_accel_g", "coast_to_apogee_s", "apogee_to_eject_s")
NOISE = (0.01, 0.04, 0.04, 0.1, 0.05, 0.4)
"""Noise of the compared readouts, relative, and of the last in seconds: about that of the open journal's device."""
DEVICE = (0.0, 0.04, 0.04, 0.1, 0.03, 0.1)
"""Bias of a device in each, as a standard deviation over devices."""
TAIL = 3
"""Degrees of freedom of the noise. [1]"""
MIN_DECIDED = 0.9
"""Probability of the true cause from which an exact fit could decide. [1]"""
HEALTHY = "healthy"
READOUTS, LOGS, ROCKETPY = "readouts", "logs", "rocketpy"
RECORDERS_FLOWN = ("20 Hz", "50 Hz", "accel 50 Hz", "accel 100 Hz", "three axes")
"""Recorders of the logs, one for each rocket in turn."""
FIELDS = ("apogee", "top_speed", "burn_time", "peak_accel", "coast_to_apogee", "apogee_to_eject")
"""The compared readouts as fields of a flight, in SI."""
WAY_DOWN = {"eject_altitude_m": "eject_altitude", "descent_speed_mps": "descent_speed", "duration_s": "duration"}
"""The readouts of the way down, which a device shows rounded, as fields of a flight. An exact fit does without them."""
Shown = dict[str, float]


@dataclass(frozen=True, slots=True)
class Fault:
    """A fault at three strengths: what it changes in the launch, or in the readouts as shown."""

    strengths: tuple[float, ...]
    launch: Callable[[Launch, float, Flown], Launch] | None = None
    readout: Callable[[Shown, float, int], Shown] | None = None


def _thrust(launch: Launch, factor: float, _: Flown) -> Launch:
    return replace(launch, motor=replace(launch.motor, thrust=launch.motor.thrust * factor))


def _other_motor(launch: Launch, rank: float, flown: Flown) -> Launch:
    """The motor of the rocket's size whose impulse is the nearest, second or third nearest but differs by a tenth."""
    size = next(names for names, *_ in CLASSES.values() if flown.motor in names)
    own = float(np.trapezoid(launch.motor.thrust, launch.motor.time))
    impulse = {name: float(np.trapezoid(motors()[name].thrust, motors()[name].time)) for name in size}
    others = sorted((abs(np.log(x / own)), name) for name, x in impulse.items() if abs(np.log(x / own)) > 0.1)
    return replace(launch, motor=motors()[others[min(int(rank), len(others) - 1)][1]])


def _drag(launch: Launch, factor: float, _: Flown) -> Launch:
    return replace(launch, drag=replace(launch.drag, cd=launch.drag.cd * factor))


def _arc(launch: Launch, degrees: float, _: Flown) -> Launch:
    return replace(launch, tilt=launch.tilt + float(np.radians(degrees)))


def _early(launch: Launch, fraction: float, flown: Flown) -> Launch:
    return replace(launch, delay=fraction * flown.coast)


def _late(launch: Launch, seconds: float, _: Flown) -> Launch:
    return replace(launch, delay=launch.delay + seconds)


def _mass(launch: Launch, factor: float, _: Flown) -> Launch:
    return replace(launch, dry_mass=launch.dry_mass * factor)


def _misread(shown: Shown, factor: float, which: int) -> Shown:
    name = ("apogee_m", "top_speed_mps", "burn_time_s", "coast_to_apogee_s")[which % 4]
    return shown | {name: shown[name] * factor}


FAULTS: Mapping[str, Fault] = {
    "weak_motor": Fault((0.9, 0.8, 0.65), launch=_thrust),
    "other_motor": Fault((0, 1, 2), launch=_other_motor),
    "extra_drag": Fault((1.4, 2.0, 3.5), launch=_drag),
    "arc": Fault((15.0, 25.0, 40.0), launch=_arc),
    "early_ejection": Fault((0.8, 0.6, 0.35), launch=_early),
    "late_ejection": Fault((1.5, 3.0, 6.0), launch=_late),
    "mass": Fault((1.1, 1.2, 1.4), launch=_mass),
    "misread": Fault((1.25, 1.609, 3.281), readout=_misread),
}
"""Every cause with its strengths: factor on thrust, rank of the motor, factor on drag, degrees, fraction of the coast,
seconds, factor on mass, and factor on a readout."""


@dataclass(frozen=True, slots=True)
class Case:
    """A rocket's flights as launched, one of them with a fault, and its device's biases."""

    name: str
    level: int
    number: int
    season: Season
    row: int
    launches: tuple[Launch, ...]
    bias: Float[Array, "readout"]

    @property
    def faulty(self) -> Flown:
        """The faulty flight."""
        return self.season.flights[self.row]


def case(name: str, level: int, number: int, seed: int) -> Case:
    """One case, the same for the same arguments."""
    rng = np.random.default_rng([seed, zlib.crc32(name.encode()), level, number])
    season = draw(rng, NEEDS)
    row = int(rng.integers(FLIGHTS))
    launches = [scattered(one) for one in season.flights[:FLIGHTS]]
    launches[row] = bent(name, level, launches[row], season.flights[row])
    return Case(name, level, number, season, row, tuple(launches), rng.standard_normal(len(DEVICE)) * DEVICE)


def bent(name: str, level: int, launch: Launch, flown: Flown) -> Launch:
    """A launch with a fault."""
    change = FAULTS[name].launch
    return launch if change is None else change(launch, FAULTS[name].strengths[level], flown)


def measured(launches: Sequence[Launch]) -> list[Shown]:
    """The readouts of launches without noise."""
    return [exact_readouts(track, one.air) for track, one in zip(fast_truth.fly(launches), launches, strict=True)]


def compared(shown: Shown) -> Float[Array, "readout"]:
    """The compared readouts, as logarithms but for the time to ejection; nan for one without a value."""
    values = np.array([shown.get(name, np.nan) for name in COMPARED])
    with np.errstate(invalid="ignore", divide="ignore"):
        return np.asarray(np.concatenate([np.log(np.where(values[:-1] > 0, values[:-1], np.nan)), values[-1:]]))


def as_shown(true: Shown, bias: Float[Array, "readout"], rng: np.random.Generator) -> Shown:
    """The compared readouts with the device's bias and noise."""
    noisy = compared(true) + bias + np.array(NOISE) * rng.standard_t(TAIL, len(NOISE)) / np.sqrt(TAIL / (TAIL - 2))
    values = [*np.exp(noisy[:-1]), noisy[-1]]
    return {name: float(x) for name, x in zip(COMPARED, values, strict=True) if np.isfinite(x)}


def rounded_way_down(true: Shown) -> Shown:
    """The readouts of the way down as a device displays them."""
    return {name: round(true[name] / RESOLUTION[name]) * RESOLUTION[name] for name in WAY_DOWN if name in true}


def as_flight(flown: Flown, shown: Shown, number: int) -> Flight:
    """The record of a flight, in SI."""
    return Flight(
        flight_id=f"{number}",
        rocket="Bench",
        config=flown.config,
        motor=str(flown.declared["motor"]),
        date_time=flown.when,
        dry_mass=float(flown.declared["dry_mass_g"]) / 1000,
        diameter=float(flown.declared["diameter_mm"]) / 1000,
    ).with_changes(**in_si(shown))


def in_si(shown: Shown) -> dict[str, float]:
    """The readouts as fields of a flight, in SI."""
    units = dict.fromkeys(COMPARED, 1.0) | {"peak_accel_g": GRAVITY}
    compared = {field: shown[name] * units[name] for field, name in zip(FIELDS, COMPARED, strict=True) if name in shown}
    return compared | {field: shown[name] for name, field in WAY_DOWN.items() if name in shown}


def in_columns(values: Mapping[str, float | None]) -> Shown:
    """The compared readouts among fields of a flight, in the units of a table."""
    units = dict.fromkeys(COMPARED, 1.0) | {"peak_accel_g": GRAVITY}
    known = ((name, values.get(field), units[name]) for field, name in zip(FIELDS, COMPARED, strict=True))
    return {name: value / unit for name, value, unit in known if value is not None}


def from_log(flight: Flight, path: Path, recorder: Recorder, rng: np.random.Generator) -> Flight:
    """A flight with the readouts that the program measures in the log that a recorder writes; without any if it refuses
    the log."""
    try:
        found = open_log(written(path, recorder, rng), "log", None).found
    except FieldkitError:
        return flight
    reading = next((item for item in found if isinstance(item, Reading) and item.clocks), None)
    if reading is None:
        return flight
    return flight.with_changes(**columns(measure(reading.clocks, reading.events), {})[0])


def oracle_launches(one: Case) -> list[Launch]:
    """What an exact fit flies: the faulty flight with the scatter of the season's flights, without any, and
    with every fault at every strength."""
    flown = one.faulty
    usual = [scattered(replace(flown, scatter=other.scatter)) for other in one.season.flights]
    return [*usual, flown.launch, *(bent(name, level, flown.launch, flown) for name in FAULTS for level in range(3))]


def oracle(
    one: Case, shown: Shown, exact: Sequence[Shown], bias: Float[Array, "readout"], noise: Float[Array, "readout"]
) -> dict[str, float]:
    """The probability of every cause, and of health, for an exact fit: normal scatter of usual flights around
    the exact readouts of every fault at every strength, all equally likely. `exact` are those of `oracle_launches`;
    bias and noise of the device are as in `compared`."""
    usual = len(one.season.flights)
    values = np.array([compared(x) for x in exact])
    flown = values[:usual][np.isfinite(values[:usual]).all(axis=1)]
    spread = np.cov(flown.T) + np.diag(np.square(noise))
    centers = {HEALTHY: [values[usual]]}
    for place, (name, level) in enumerate(((n, k) for n in FAULTS for k in range(3)), start=usual + 1):
        change = FAULTS[name].readout
        strength = FAULTS[name].strengths[level]
        some = [values[place]] if change is None else [compared(change(exact[usual], strength, k)) for k in range(4)]
        centers.setdefault(name, []).extend(some)
    seen = np.isfinite(compared(shown)) & np.isfinite(values[usual])
    log_likelihood: dict[str, float] = {}
    for name, some in centers.items():
        found = [_log_density(compared(shown) - bias - center, spread, seen) for center in some]
        log_likelihood[name] = float(np.logaddexp.reduce(found) - np.log(len(found)))
    total = np.logaddexp.reduce(list(log_likelihood.values()))
    return {name: float(np.exp(x - total)) for name, x in log_likelihood.items()}


def _log_density(off: Array, spread: Array, seen: Array) -> float:
    known = seen & np.isfinite(off)
    if known.sum() < seen.sum():
        return -1e3  # the fault leaves a readout without a value
    part = spread[np.ix_(known, known)]
    return float(-0.5 * (off[known] @ np.linalg.solve(part, off[known]) + np.linalg.slogdet(part)[1]))


def all_judged(cases: Sequence[Case], kind: str = READOUTS) -> list[dict[str, Any]]:
    """What the program and a fit that knows the truth say about some cases, flown in one batch."""
    exact = iter(measured([launch for one in cases for launch in [*one.launches, *oracle_launches(one)]]))
    found = []
    for one in cases:
        true, some = ([next(exact) for _ in every] for every in (one.launches, oracle_launches(one)))
        rng = np.random.default_rng([one.number, one.level, zlib.crc32(one.name.encode()), 1])
        if kind == READOUTS:
            found.append({"kind": kind} | judged(one, as_typed(one, true, rng), some, one.bias, np.array(NOISE)))
            continue
        flights, noise = as_logs(one, kind, rng)
        some = [in_columns(path.readouts()) for path in paths(oracle_launches(one), rng)]
        found.append({"kind": kind} | judged(one, flights, some, np.zeros(len(COMPARED)), noise))
    return found


def as_typed(one: Case, true: Sequence[Shown], rng: np.random.Generator) -> list[Flight]:
    """The flights of a case with the readouts of a device."""
    shown = [as_shown(each, one.bias, rng) | rounded_way_down(each) for each in true]
    change = FAULTS[one.name].readout
    if change is not None:
        shown[one.row] = change(shown[one.row], FAULTS[one.name].strengths[one.level], one.number)
    each = zip(one.season.flights, shown, strict=False)
    return [as_flight(flown, readings, number) for number, (flown, readings) in enumerate(each)]


def as_logs(one: Case, kind: str, rng: np.random.Generator) -> tuple[list[Flight], Float[Array, "readout"]]:
    """The flights of a case with the readouts of their logs, and the noise of those of the faulty one, as in
    `compared`; that of a readout that is missing is never used."""
    turn = one.number + one.level + [*FAULTS].index(one.name)
    recorder = RECORDERS[RECORDERS_FLOWN[turn % len(RECORDERS_FLOWN)]]
    tracks = None
    if kind == ROCKETPY:
        from bench import truth  # RocketPy takes seconds to import, and is in the extra `bench`

        tracks = [truth.fly(launch) for launch in one.launches]
    flown = zip(one.season.flights, paths(one.launches, rng, tracks), strict=False)
    flights = [from_log(as_flight(each, {}, n), path, recorder, rng) for n, (each, path) in enumerate(flown)]
    change, faulty = FAULTS[one.name].readout, flights[one.row]
    shown = in_columns(faulty.readouts())
    if change is not None and shown:
        changed = change(shown, FAULTS[one.name].strengths[one.level], one.number)
        flights[one.row] = faulty.with_changes(**in_si(changed))
    logarithms = [*(faulty.number(name) or 1.0 for name in FIELDS[:-1]), 1.0]
    noise = [faulty.sd.get(name, 0.0) / abs(value) for name, value in zip(FIELDS, logarithms, strict=True)]
    return flights, np.array(noise)


def judged(
    one: Case,
    flights: Sequence[Flight],
    oracle_exact: Sequence[Shown],
    bias: Float[Array, "readout"],
    noise: Float[Array, "readout"],
) -> dict[str, Any]:
    """What the program and a fit that knows the truth say about the flights of a case."""
    found = beside_others([(flight, catalogue().resolve(flight.motor)) for flight in flights])
    named = found[one.row]
    return {
        "cause": one.name,
        "level": one.level,
        "number": one.number,
        "probability": named.probability,
        "named": [[cause.cause, cause.probability] for cause in named.causes],
        "healthy": [
            [other.probability, other.causes[0].cause]
            for row, other in enumerate(found)
            if row != one.row and other.departures
        ],
        "oracle": oracle(one, in_columns(flights[one.row].readouts()), oracle_exact, bias, noise),
    }


def table(rows: Sequence[Mapping[str, Any]]) -> str:
    """The results as a table in Markdown."""
    lines = [
        "| cause | strength | flights | singled out | named first | among three | an exact fit could decide | "
        "named first of these | among three of these |",
        "|---|---|---|---|---|---|---|---|---|",
    ]
    for name, fault in [*FAULTS.items(), ("all", Fault((0.0,)))]:
        for level, strength in enumerate(fault.strengths):
            some = [r for r in rows if name == "all" or (r["cause"], r["level"]) == (name, level)]
            if not some:
                continue
            decidable = [r for r in some if r["oracle"][r["cause"]] > MIN_DECIDED]
            cells = [
                name,
                f"{strength:g}" if name != "all" else "",
                str(len(some)),
                _share(some, lambda r: r["probability"] > 0.5),
                _share(some, lambda r: _rank(r) < 1),
                _share(some, lambda r: _rank(r) < 3),
                str(len(decidable)),
                _share(decidable, lambda r: _rank(r) < 1),
                _share(decidable, lambda r: _rank(r) < 3),
            ]
            lines.append(f"| {' | '.join(cells)} |")
    healthy = [p for r in rows for p, _ in r["healthy"]]
    flagged = sum(p > 0.5 for p in healthy)
    lines += [
        "",
        f"Healthy flights beside them: {len(healthy)}, singled out: {flagged} ({flagged / len(healthy):.1%}).",
    ]
    return "\n".join(lines)


def _rounded(value: Any) -> Any:
    """A result with probabilities to four digits."""
    if isinstance(value, dict):
        return {key: _rounded(part) for key, part in value.items()}
    if isinstance(value, list):
        return [_rounded(part) for part in value]
    return round(value, 4) if isinstance(value, float) else value


def _rank(row: Mapping[str, Any]) -> int:
    names = [name for name, _ in row["named"]]
    return names.index(row["cause"]) if row["cause"] in names else len(names)


def _share(rows: Sequence[Mapping[str, Any]], right: Callable[[Mapping[str, Any]], bool]) -> str:
    return f"{np.mean([right(row) for row in rows]):.0%}" if rows else ""


FLOWN_AS = {
    READOUTS: (
        "as the readouts of an altimeter with Student t noise (3 degrees of freedom: speed and burn time 4%, peak 10%, "
        "coast 5%, ejection 0.4 s) and biases of its own; those of the way down are rounded"
    ),
    LOGS: f"as logs of recorders ({', '.join(RECORDERS_FLOWN)}), from which the program measures the readouts",
    ROCKETPY: "as logs of recorders of flights in RocketPy; what an exact fit could decide is that of `fast_truth`",
}
"""How the flights of a table were recorded."""


def page(rows: Sequence[Mapping[str, Any]], code: str, command: str) -> list[str]:
    """The page in Markdown, a table for each way of recording; `code` is the revision that gave the rows."""
    lines = [
        "# Single flights that differ" + ("" if rows[0]["kind"] == READOUTS else ", from logs"),
        "",
        *prose(
            f"`{command}` writes this page; the figures are of revision {code or 'unknown'}. Rockets fly",
            "ten times each in another simulator, `fast_truth` unless stated otherwise, and one flight of each has a",
            "fault at one of three strengths; thrust and drag scatter by 4 and 3%. The answer is that of `fieldkit",
            "loop` before any flight is tagged.",
        ),
        *prose(
            "*Singled out*: the flight is probably a one-off (above 50%). *Named first* and *among three*: the",
            "place of the true cause among the causes, whether singled out or not. *An exact fit* knows rocket,",
            "device, causes and strengths exactly and only has to recognize them in the scatter; it could decide",
            "if the true cause has more than 90% there.",
        ),
    ]
    for kind in dict.fromkeys(row["kind"] for row in rows):
        some = [row for row in rows if row["kind"] == kind]
        lines += [*prose(f"{len(some)} rockets, {FLOWN_AS[kind]}:"), table(some), ""]
    lines += prose(
        "**What it misses.** A mass that is wrong on one flight looks like a weak motor. An ejection that is",
        "late by up to three seconds is within the scatter of delays. A readout in feet that was taken for",
        "meters is often impossible, so that it is left out before the comparison, and the flight looks usual",
        "without it; `show` says which it is and what unit would explain it. The prevalences and typical",
        "strengths of the causes are round judgments",
        "(`fieldkit/model/causes.py`); of these, the strength of weak motors was lowered from 20% to 10% of",
        "the impulse, by what certification allows, after the first look at the open journal's flights.",
    )
    return lines


def revision() -> str:
    """The revision of the code that runs, empty if it is not in version control."""
    asked = ["git", "describe", "--always", "--dirty", "--exclude=*"]
    try:
        found = subprocess.run(asked, cwd=File(__file__).parent, capture_output=True, text=True, check=False)
    except OSError:
        return ""
    return found.stdout.strip()


def _round(arguments: tuple[str, int, int]) -> list[dict[str, Any]]:
    """One case of every cause and strength."""
    kind, number, seed = arguments
    return all_judged([case(name, level, number, seed) for name in FAULTS for level in range(3)], kind)


def main() -> None:
    """Run the bench, or print what a file contains."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    parser.add_argument("--cases", type=int, default=16, help="cases for each cause and strength")
    parser.add_argument("--as", dest="kinds", nargs="+", choices=FLOWN_AS, default=[READOUTS], help="how recorded")
    parser.add_argument("--seed", type=int, default=31)
    parser.add_argument("--processes", type=int, default=1)
    parser.add_argument("--keep", type=File, help="a file of results, to resume and to print again")
    parser.add_argument("--out", type=File, help="the page")
    options = parser.parse_args()
    kept = json.loads(options.keep.read_text()) if options.keep and options.keep.exists() else {}
    rows: list[dict[str, Any]] = kept.get("rows", [])
    code: str = kept.get("code") or revision()
    done = {(row["kind"], row["number"]) for row in rows}
    every = [(kind, number) for kind in options.kinds for number in range(options.cases)]
    missing = [(*one, options.seed) for one in every if one not in done]
    with multiprocessing.get_context("spawn").Pool(options.processes) as pool:
        for found in pool.imap_unordered(_round, missing):
            rows += found
            if options.keep:
                lines = ",\n".join(json.dumps(_rounded(row)) for row in rows)
                options.keep.write_text(f'{{"code": "{code}", "rows": [\n{lines}\n]}}\n')
            sys.stderr.write(f"{len(rows)} of {24 * len(every)}\n")
    rows.sort(key=lambda row: (options.kinds.index(row["kind"]), int(row["number"])))
    named = "" if options.kinds == [READOUTS] else f" --as {' '.join(options.kinds)} --cases {options.cases}"
    seeded = "" if options.seed == parser.get_default("seed") else f" --seed {options.seed}"
    command = f"python -m bench.one_offs{named}{seeded} --out {options.out or 'PAGE'}"
    text = "\n".join(page(rows, code, command)).rstrip() + "\n"
    if options.out:
        options.out.write_text(text, encoding="utf-8")
    else:
        sys.stdout.write(text)


if __name__ == "__main__":
    main()
