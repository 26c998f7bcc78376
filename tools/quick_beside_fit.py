"""`python -m tools.quick_beside_fit FOLDER [--bench SETS]`: the closed forms beside the fit and the loop.

Simulated histories, and with `--bench` sets of `python -m bench.make`, whose simulator is another one: the forecast of
`predict` and the causes of `loop` on the first, the probabilities of `loop` on the others. One JSON line each, as done.
"""

import argparse
import json
import tempfile
import time
from collections.abc import Iterator
from concurrent.futures import ProcessPoolExecutor
from multiprocessing import get_context
from pathlib import Path
from typing import Any

import numpy as np

from fieldkit.flight.plan import repeated
from fieldkit.forecast.assumed import Assumed
from fieldkit.forecast.one_offs import beside_others
from fieldkit.forecast.predict import predict
from fieldkit.ledger import Ledger
from fieldkit.model.causes import NAMES
from fieldkit.model.hyperprior import START
from fieldkit.model.readout_data import observe
from fieldkit.model.rocket_model import FlownFlights
from fieldkit.motors import catalogue
from fieldkit.physics.history import flown_and_planned, history_of
from fieldkit.selection.diagnose import diagnose
from fieldkit.selection.extended_model import rocket_model
from fieldkit.selection.prior import inclusion_probabilities
from fieldkit.services.imports.add_files import bring_in
from fieldkit.services.plausible_flights import followed
from studies.quick_network.drawn_rockets import split_motors, stock
from studies.quick_network.inputs import ClosedForms
from studies.quick_network.scores import scored
from studies.quick_network.tables import passes
from studies.quick_network.world import WorldHistory, simulated_histories

DRAWS = 1000


def flights_of(path: Path) -> FlownFlights:
    """The flights of a table, in the order flown, with their motors."""
    motors = catalogue()
    with tempfile.TemporaryDirectory() as home, Ledger.open(str(Path(home) / "ledger.db")) as ledger:
        bring_in(ledger, [path], lambda _: None, motors=motors)
        return followed(ledger.flights(), motors)


def flown_of(one: WorldHistory) -> FlownFlights:
    """The flights of a history, those that the fit does not use with a tag."""
    history = one.history
    return [
        (flight if used else flight.with_changes(tags=("weak_launch",)), motor)
        for flight, motor, used in zip(history.flights, history.found, history.used_in_fit, strict=False)
    ]


def loop_of(flown: FlownFlights) -> dict[str, Any]:
    """The probabilities and the verdict of the loop, and its processor time. [s]"""
    began = time.process_time()
    model = rocket_model(history_of([flight for flight, _ in flown], [motor for _, motor in flown]))
    used = [flight.clean and flight.apogee is not None for flight, _ in flown]
    found = diagnose(model, observe(model.history.using(used)))
    chances = {**found.posterior.inclusion, "none": found.posterior.nothing}
    return {"loop": chances, "verdict": found.effect, "loop_seconds": time.process_time() - began}


def beside(one: WorldHistory, own: ClosedForms) -> dict[str, Any]:
    """A simulated history by the closed forms and by the fit."""
    history, flown = one.history, flown_of(one)
    began = time.process_time()
    (made,) = predict(flown, [(history.flights[-1], history.found[-1])], Assumed(hyperprior=START), draws=DRAWS)
    seconds = time.process_time() - began
    causes = beside_others(flown, Assumed(hyperprior=START))
    judged = [
        i
        for i, (flight, used) in enumerate(zip(history.flights, history.used_in_fit, strict=False))
        if used and flight.apogee is not None and i < history.flown
    ]
    mean, sd = own.moments()
    rng = np.random.default_rng(0)
    return {
        "kind": "simulated",
        "flights": history.flown,
        "effects": one.effects,
        "unexplained": one.unexplained,
        "fit": scored(made.apogee, one.apogee),
        "fit_seconds": seconds,
        "linear": scored(np.exp(mean + sd * rng.normal(size=DRAWS)), one.apogee),
        "mixture": scored(np.exp(np.clip(own.draws(), -5, 12)), one.apogee),
        "causes": [int(one.causes[i]) for i in judged],
        "fit_usual": [1 - causes[i].probability for i in judged],
        "fit_chance": [[{c.cause: c.probability for c in causes[i].causes}.get(n, 0.0) for n in NAMES] for i in judged],
        "linear_chance": [own.causes[i].tolist() for i in judged],
    }


def _worker(folder: Path, sets: list[tuple[str, str]], bench: Path | None, seed: int, worker: int, ends: float) -> None:
    with (folder / f"beside_fit_{worker:02d}.jsonl").open("w", encoding="utf-8") as file:
        for line in _lines(sets, bench, seed, worker):
            file.write(json.dumps(line) + "\n")
            file.flush()
            if time.time() > ends:
                return


def _lines(sets: list[tuple[str, str]], bench: Path | None, seed: int, worker: int) -> Iterator[dict[str, Any]]:
    for name, label in sets:
        assert bench is not None
        yield {"kind": "bench", "set": name, "label": label, **loop_of(flights_of(bench / f"{name}.csv"))}
    rng, choice = np.random.default_rng([seed, worker, 7]), stock(split_motors()[0])
    while True:
        for number, (one, own) in enumerate(passes(simulated_histories(rng, choice, inclusion_probabilities(), 4))):
            if number % 3 == 0:  # one of each rocket
                yield beside(one, own)


def plan_again(flown: FlownFlights) -> Any:
    """The history of a rocket with the plan to repeat its last flight, as the quick search has it."""
    last, motor = flown[-1]
    used = [flight.clean and flight.apogee is not None for flight, _ in flown]
    return flown_and_planned(flown, [(repeated(last), motor)]).using(used)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("folder", type=Path)
    parser.add_argument("--bench", type=Path)
    parser.add_argument("--processes", type=int, default=2)
    parser.add_argument("--seconds", type=float, default=600.0)
    parser.add_argument("--seed", type=int, default=3)
    given = parser.parse_args()
    given.folder.mkdir(parents=True, exist_ok=True)
    labels = json.loads((given.bench / "labels.json").read_text()) if given.bench else []
    sets = [(label["set"], label["label"]) for label in labels]
    ends, many = time.time() + given.seconds, given.processes
    with ProcessPoolExecutor(many, get_context("spawn")) as pool:
        jobs = [
            pool.submit(_worker, given.folder, sets[i::many], given.bench, given.seed, i, ends) for i in range(many)
        ]
        for job in jobs:
            job.result()


if __name__ == "__main__":
    main()
