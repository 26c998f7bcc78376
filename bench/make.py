"""`python -m bench.make OUT`: flight tables with an undeclared effect in them, and the labels separately.

A set is `set_NNN.csv` (the history), `set_NNN_future.csv` (later flights with the same truth) and an entry in
`labels.json`. The same seed gives the same sets.
"""

import argparse
import csv
import json
import sys
import zlib
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from bench import fast_truth
from bench.altimeter import RESOLUTION, exact_readouts, readouts
from bench.effects import EFFECTS, Parameters
from bench.fleet import Flown, Season, draw, scattered
from bench.scenarios import SCENARIOS, Scenario
from bench.world import Launch, Track
from bench.worlds import in_world

Fly = Callable[[Sequence[Launch]], list[Track]]
SHOWN = {
    "all": tuple(RESOLUTION),
    "three": ("apogee_m", "top_speed_mps", "coast_to_apogee_s"),
    "apogee": ("apogee_m",),
}
TEXT = ("flight_id", "date_time", "rocket", "config", "dry_mass_g", "diameter_mm", "motor", "site")
TOGETHER = 12
"""Number of sets in a simulation batch."""
IMPERIAL = {"_m": ("_ft", 0.3048), "_mps": ("_mph", 0.44704)}


@dataclass(frozen=True, slots=True)
class Case:
    """A season with its effects in it, and the same season without."""

    scenario: Scenario
    level: int
    honest: Season
    bent: Season
    parameters: Parameters
    truth: Mapping[str, Mapping[str, float]]
    """What else is true of a season in a world (`bench.worlds`)."""


def case(scenario: Scenario, seed: int, number: int, world: str = "") -> Case:
    """The `number`-th season of a scenario, independent of the other sets."""
    rng = np.random.default_rng([seed, zlib.crc32(scenario.name.encode()), number])
    honest = draw(rng, scenario.needs_at(number))
    truth: Mapping[str, Mapping[str, float]] = {}
    if world:
        honest, truth = in_world(rng, honest, world)
    flights: list[Flown] = list(honest.flights)
    parameters: Parameters = {}
    for part, strength in zip(scenario.parts, scenario.strengths(number), strict=True):
        flights, found = EFFECTS[part.effect](rng, strength, flights)
        parameters |= {f"{part.effect}.{name}": value for name, value in found.items()}
    if "wind" in [part.effect for part in scenario.parts]:
        honest = replace(honest, flights=tuple(_calm(f) for f in honest.flights))
    return Case(
        scenario,
        number % len(scenario.parts[0].strengths),
        honest,
        replace(honest, flights=tuple(flights)),
        parameters,
        truth,
    )


def _calm(flown: Flown) -> Flown:
    return replace(flown, launch=replace(flown.launch, air=replace(flown.launch.air, wind=0.0)))


def rows(season: Season, tracks: Sequence[Track], rng: np.random.Generator) -> list[dict[str, str]]:
    """The flight table: the flyer's record and the altimeter's readouts."""
    table = []
    for number, (flown, track) in enumerate(zip(season.flights, tracks, strict=True), start=1):
        shown = readouts(track, flown.launch.air, replace(season.altimeter, gain=flown.gain), rng)
        row: dict[str, str | float] = {
            "flight_id": f"{season.rocket}-{number:03d}",
            "date_time": flown.when.isoformat(),
            "rocket": season.rocket,
            "config": flown.config,
            "site": flown.site,
            **flown.declared,
        }
        row |= {name: round(shown[name], 4) for name in SHOWN[season.readouts] if name in shown}
        table.append({name: _text(value) for name, value in row.items()})
    return [_imperial(row) for row in table] if season.imperial else table


def _text(value: str | float) -> str:
    return value if isinstance(value, str) else f"{value:.6g}"


def _imperial(row: dict[str, str]) -> dict[str, str]:
    """A row with the readouts as displayed: feet and miles per hour."""
    changed: dict[str, str] = {}
    for name, value in row.items():
        for suffix, (other, size) in IMPERIAL.items():
            if name in RESOLUTION and name.endswith(suffix):
                changed[name.removesuffix(suffix) + other] = str(round(float(value) / size))
                break
        else:
            changed[name] = value
    return changed


def write_table(path: Path, table: Sequence[dict[str, str]]) -> None:
    """Write rows as a CSV, with columns in the order of their first occurrence."""
    names = list(dict.fromkeys([*TEXT, *(name for row in table for name in row)]))
    with path.open("w", newline="", encoding="utf-8") as file:
        writer = csv.DictWriter(file, names, restval="")
        writer.writeheader()
        writer.writerows(table)


def _apogees(season: Season, tracks: Sequence[Track]) -> np.ndarray[tuple[int], np.dtype[np.float64]]:
    return np.array(
        [exact_readouts(t, f.launch.air, f.gain)["apogee_m"] for f, t in zip(season.flights, tracks, strict=True)]
    )


def reach(found: Case, tracks: Mapping[str, Sequence[Track]]) -> dict[str, float]:
    """The effect's part of the apogees, and the errors of predictors with and without it.

    `shift_*`: apogee with the effect minus without it, with common random numbers. `blind_mae_m`: error of the
    effect-free simulation without scatter, scaled by one number fitted to the flights; `ideal_mae_m`: the same with the
    effect; `naive_mae_m`: error of the effect-free simulation without scaling. All are relative to apogees without the
    altimeter's noise, over all flights and over the later ones.
    """
    now, twin = _apogees(found.bent, tracks["true"]), _apogees(found.honest, tracks["twin"])
    errors = {"naive_mae_m": float(np.abs(now - _apogees(found.honest, tracks["blind"])).mean())}
    for name, season in (("blind", found.honest), ("ideal", found.bent)):
        expected = _apogees(season, tracks[name])
        error = np.abs(now - float(np.median(now / expected)) * expected)
        errors |= {f"{name}_mae_m": float(error.mean()), f"{name}_future_mae_m": float(error[-season.future :].mean())}
    return {
        "apogee_mean_m": float(now.mean()),
        "shift_mean_m": float((now - twin).mean()),
        "shift_sd_m": float((now - twin).std()),
        **errors,
    }


def flown(cases: Sequence[Case], fly: Fly) -> list[dict[str, list[Track]]]:
    """The tracks of every case from `fly`: true, without the effect, without scatter, without both."""
    plans: list[dict[str, list[Launch]]] = [
        {
            "true": [scattered(f) for f in c.bent.flights],
            "twin": [scattered(f) for f in c.honest.flights],
            "blind": [f.launch for f in c.honest.flights],
            "ideal": [f.launch for f in c.bent.flights],
        }
        for c in cases
    ]
    true = iter(fly([launch for plan in plans for launch in plan["true"]]))
    rest = iter(fast_truth.fly([x for plan in plans for kind, part in plan.items() if kind != "true" for x in part]))
    return [
        {kind: [next(true if kind == "true" else rest) for _ in part] for kind, part in plan.items()} for plan in plans
    ]


def write_set(
    folder: Path, name: str, found: Case, tracks: Mapping[str, Sequence[Track]], seed: int
) -> dict[str, object]:
    """Write one set and return its label."""
    rng = np.random.default_rng([seed, zlib.crc32(name.encode())])
    table = rows(found.bent, tracks["true"], rng)
    history = len(table) - found.bent.future
    write_table(folder / f"{name}.csv", table[:history])
    write_table(folder / f"{name}_future.csv", table[history:])
    deviations = {**found.truth, **_at_launch(found.bent, tracks["true"])} if found.truth else {}
    return {
        "set": name,
        "scenario": found.scenario.name,
        "label": found.scenario.label,
        "level": found.level,
        "parameters": found.parameters,
        "deviations": deviations,
        "rocket": found.bent.rocket,
        "n_flights": history,
        "n_future": found.bent.future,
        "readouts": found.bent.readouts,
        "conditions": found.bent.conditions,
        "true": _hidden(found.bent),
        "seed": seed,
        **{key: round(value, 3) for key, value in reach(found, tracks).items()},
    }


def _at_launch(season: Season, tracks: Sequence[Track]) -> dict[str, dict[str, float]]:
    """By how many degrees flights leave the vertical, and by which part of its delay each motor's charge is early."""
    early: dict[str, list[float]] = {}
    for flown, track in zip(season.flights, tracks, strict=True):
        after = exact_readouts(track, flown.launch.air).get("apogee_to_eject_s", 0.0)
        early.setdefault(flown.motor, []).append(max(0.0, -after) / flown.launch.delay)
    tilts = [scattered(one).tilt for one in season.flights]
    return {
        "launch_angle": {"all": float(np.degrees(np.sqrt(np.mean(np.square(tilts)))))},
        "early_ejection": {motor: float(np.mean(parts)) for motor, parts in early.items()},
    }


def _hidden(season: Season) -> dict[str, object]:
    """The true properties of the rocket."""
    first = season.flights[0].launch
    return {
        "cd": round(first.drag.cd, 4),
        "config_mass_g": {f.config: round(f.launch.dry_mass * 1000, 1) for f in season.flights},
        "delay_s": {f"{f.motor}/{f.config}": round(f.launch.delay, 2) for f in season.flights},
    }


def make(
    folder: Path, names: Iterable[str], per_scenario: int, seed: int, truth: str, first: int = 0, world: str = ""
) -> list[dict[str, object]]:
    """Write sets of the named scenarios into a folder, in shuffled order, and return their labels.

    With RocketPy, scenarios that it cannot simulate are left out. The first set of each scenario has the strength level
    `first`; the next ones cycle through the levels.
    """
    folder.mkdir(parents=True, exist_ok=True)
    labels: list[dict[str, object]] = []
    cases = [case(SCENARIOS[name], seed, k, world) for name in names for k in range(first, first + per_scenario)]
    if truth == "rocketpy":
        cases = _within_rocketpy(cases)
    order = [int(i) for i in np.random.default_rng(seed).permutation(len(cases))]
    for start in range(0, len(order), TOGETHER):
        part = [cases[i] for i in order[start : start + TOGETHER]]
        for number, (found, tracks) in enumerate(zip(part, flown(part, _flier(truth)), strict=True), start + 1):
            labels.append(
                write_set(folder, f"set_{number:03d}", found, tracks, seed) | {"truth": truth, "world": world}
            )
        (folder / "labels.json").write_text(json.dumps(labels, indent=1) + "\n")
        sys.stderr.write(f"{len(labels)}/{len(cases)} sets\n")
    return labels


def _within_rocketpy(cases: Sequence[Case]) -> list[Case]:
    """The cases that RocketPy can simulate; the scenarios of the others are named on stderr."""
    beyond = [any(f.launch.beyond_rocketpy for f in c.bent.flights) for c in cases]
    names = dict.fromkeys(c.scenario.name for c, out in zip(cases, beyond, strict=True) if out)
    if names:
        sys.stderr.write(f"left out, for RocketPy is not asked for it: {', '.join(names)}\n")
    return [c for c, out in zip(cases, beyond, strict=True) if not out]


def _flier(truth: str) -> Fly:
    if truth == "fast":
        return fast_truth.fly
    from bench import truth as rocketpy_truth

    return lambda launches: [rocketpy_truth.fly(launch) for launch in launches]


def main() -> None:
    """Read the command line and make the sets."""
    parser = argparse.ArgumentParser(prog="python -m bench.make", description=__doc__)
    parser.add_argument("out", type=Path)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--sets", type=int, default=10, help="sets per scenario")
    parser.add_argument("--first", type=int, default=0, help="the level at which the strengths start")
    parser.add_argument("--scenario", nargs="*", choices=list(SCENARIOS), default=list(SCENARIOS))
    parser.add_argument("--world", choices=["start", "learned"], default="", help="real deviations and scatter")
    parser.add_argument("--truth", choices=["fast", "rocketpy"], default="fast")
    given = parser.parse_args()
    make(given.out, given.scenario, given.sets, given.seed, given.truth, given.first, given.world)


if __name__ == "__main__":
    main()
