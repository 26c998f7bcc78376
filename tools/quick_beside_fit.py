"""`python -m tools.quick_beside_fit FOLDER`: quick answers beside the fit and the loop.

Flights of `--flyers`, each forecast from the earlier ones; `--bench` sets of `python -m bench.make`, whose simulator is
another one: the forecast of the last flight and the probabilities of effects; and for some `--seconds` simulated
histories: the forecast and the causes of single flights. One JSON line each in the folder, as done. With `--page`
instead, it writes `docs/measured/quick_answers.md` from them.
"""

import argparse
import json
import time
from collections.abc import Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor
from multiprocessing import get_context
from pathlib import Path
from typing import Any

import numpy as np

from fieldkit.flight.plan import repeated
from fieldkit.forecast.assumed import Assumed
from fieldkit.forecast.one_offs import beside_others
from fieldkit.forecast.predict import predict
from fieldkit.inference.history.linear_fit import history_model, prepared_fit
from fieldkit.inference.history.quick_forecast import PreparedHistory, acting, answers, centered
from fieldkit.inference.history.response import reference, respond
from fieldkit.model.causes import NAMES
from fieldkit.model.documents import with_documents
from fieldkit.model.hyperprior import START, Hyperprior, learned
from fieldkit.model.readout_data import observe
from fieldkit.model.rocket_model import FlownFlight, FlownFlights
from fieldkit.model.shared_prior import SharedPrior
from fieldkit.physics.history import flown_and_planned, history_of
from fieldkit.selection.diagnose import diagnose
from fieldkit.selection.extended_model import rocket_model
from fieldkit.selection.prior import inclusion_probabilities
from fieldkit.selection.quick_look import quick_look
from fieldkit.shapes import Array, Float
from studies.quick_network.drawn_rockets import split_motors, stock
from studies.quick_network.inputs import ClosedForms
from studies.quick_network.scores import auc, compared_with_fit, scored
from studies.quick_network.tables import passes
from studies.quick_network.world import WorldHistory, simulated_histories
from tools.later_flights import flights_of, later_flights
from tools.markdown import MEASURED, commit, prose, table

PAGE = MEASURED / "quick_answers.md"

DRAWS = 1000


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


def quick(
    flown: FlownFlights, plan: FlownFlight, shared: SharedPrior | None, hyperprior: Hyperprior
) -> Float[Array, "draw"]:
    """The apogees of the quick answer for a plan, as `fieldkit.forecast.at_once` has them, with any hyperprior. [m]"""
    history = flown_and_planned(flown, [plan])
    fit = prepared_fit(history_model(history, with_documents(hyperprior), shared, declared=True), history.flown)
    ready = centered(PreparedHistory(history, fit, respond(history, acting(fit)), reference(fit.model)))
    return answers(ready, ready.flown)[0].apogees


def both(
    flown: FlownFlights, plan: FlownFlight, apogee: float, shared: SharedPrior | None, hyperprior: Hyperprior
) -> dict[str, Any]:
    """Scores of the fit and of the quick answer for a flight of known apogee [m], and their processor times. [s]"""
    began = time.process_time()
    (made,) = predict(flown, [plan], Assumed(shared=shared, hyperprior=hyperprior), draws=DRAWS)
    between = time.process_time()
    apogees = quick(flown, plan, shared, hyperprior)
    return {
        "fit": scored(made.apogee, apogee),
        "quick": scored(apogees, apogee),
        "fit_seconds": between - began,
        "quick_seconds": time.process_time() - between,
    }


def of_flyer(path: Path) -> Iterator[dict[str, Any]]:
    """Every later flight of a flyer's rockets, forecast from the earlier ones with the shipped hyperprior."""
    for one in later_flights(path):
        flight, motor = one.flown
        plan, apogee = (flight.unflown(), motor), float(flight.apogee or np.nan)
        yield {"kind": "flyer", "flyer": path.stem, **both(one.earlier, plan, apogee, one.shared, learned())}


def of_set(flown: FlownFlights) -> dict[str, Any]:
    """A set of the bench: effects by the loop and by the quick look, and its last flight forecast from the others."""
    used = [flight.clean and flight.apogee is not None for flight, _ in flown]
    began = time.process_time()
    look = quick_look(flown[0][0].rocket, flown, used).probabilities
    looked = {"quick_effects": {**look.inclusion, "none": look.none}, "look_seconds": time.process_time() - began}
    last, motor = flown[-1]
    scores = both(flown[:-1], (last.unflown(), motor), last.apogee, None, learned()) if last.apogee and used[-1] else {}
    return {**loop_of(flown), **looked, **scores}


def beside(one: WorldHistory, own: ClosedForms) -> dict[str, Any]:
    """A simulated history by the closed forms and by the fit."""
    history, flown = one.history, flown_of(one)
    plan = (history.flights[-1], history.found[-1])
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
        **both(flown, plan, one.apogee, None, START),
        "linear": scored(np.exp(mean + sd * rng.normal(size=DRAWS)), one.apogee),
        "mixture": scored(np.exp(np.clip(own.draws(), -5, 12)), one.apogee),
        "causes": [int(one.causes[i]) for i in judged],
        "fit_usual": [1 - causes[i].probability for i in judged],
        "fit_chance": [[{c.cause: c.probability for c in causes[i].causes}.get(n, 0.0) for n in NAMES] for i in judged],
        "linear_chance": [own.causes[i].tolist() for i in judged],
    }


def _worker(
    folder: Path, flyers: list[Path], sets: list[tuple[Path, str]], seed: int, worker: int, seconds: float
) -> None:
    version = commit()
    with (folder / f"beside_fit_{worker:02d}.jsonl").open("w", encoding="utf-8") as file:
        for line in _lines(flyers, sets, seed, worker, seconds):
            file.write(json.dumps({**line, "commit": version}) + "\n")
            file.flush()


def _lines(
    flyers: list[Path], sets: list[tuple[Path, str]], seed: int, worker: int, seconds: float
) -> Iterator[dict[str, Any]]:
    for path in flyers:
        yield from of_flyer(path)
    for path, label in sets:
        yield {"kind": "bench", "set": path.stem, "label": label, **of_set(flights_of(path))}
    ends = time.time() + seconds
    rng, choice = np.random.default_rng([seed, worker, 7]), stock(split_motors()[0])
    while time.time() < ends:
        for number, (one, own) in enumerate(passes(simulated_histories(rng, choice, inclusion_probabilities(), 4))):
            if number % 3 == 0:  # one of each rocket
                yield beside(one, own)


def plan_again(flown: FlownFlights) -> Any:
    """The history of a rocket with the plan to repeat its last flight, as the quick search has it."""
    last, motor = flown[-1]
    used = [flight.clean and flight.apogee is not None for flight, _ in flown]
    return flown_and_planned(flown, [(repeated(last), motor)]).using(used)


Lines = Sequence[dict[str, Any]]


def page(lines: Lines) -> Iterator[str]:
    """The page of the comparison."""
    yield from ("# Quick answers beside the fit", "")
    yield from prose(
        "The answers of one linear pass (`predict --quick`, `loop --quick`), before any check, beside those of the fit",
        "and the loop, printed by `python -m tools.quick_beside_fit FOLDER --page` from its measurements on commit",
        f"{' and '.join(sorted({line['commit'] for line in lines}))}. Both have the same model and prior: the shipped",
        "one, which some of these flights determined, or for simulated histories the one they are drawn from. So this",
        "compares two ways of computing, and neither with reality. CRPS relative to the flown apogee, and its ratio to",
        "the fit's with a 90% interval.",
    )
    yield from ("## Forecasts", "")
    scored_lines = [line for line in lines if "fit" in line]
    groups: dict[str, list[dict[str, Any]]] = {}
    for line in scored_lines:
        name = {"simulated": "simulated histories", "bench": "bench, another simulator"}.get(line["kind"])
        groups.setdefault(name or str(line["flyer"]), []).append(line)
    heads = ("flights of", "flights", "CRPS of the fit", "of the quick answer", "ratio", "in 90%: fit", "quick", "time")
    yield from table(heads, (_forecast_row(name, some) for name, some in groups.items()))
    yield from ("## Effects and causes", "")
    yield from prose("The area under the receiver operating characteristic (AUC) of probabilities.")
    rows = (_effect_row(lines), _none_row(lines), _cause_row(lines))
    yield from table(("probability of", "cases", "there", "loop", "quick"), rows)


def _forecast_row(name: str, lines: Lines) -> tuple[str, ...]:
    found = compared_with_fit({way: [line[way] for line in lines] for way in ("fit", "quick")})
    fit, own = found["fit"], found["quick"]
    shorter = sum(line["quick_seconds"] for line in lines) / sum(line["fit_seconds"] for line in lines)
    low, high = own["ratio90"]
    return (
        *(name, str(found["flights"]), f"{fit['crps']:.2%}", f"{own['crps']:.2%}"),
        *(f"{own['ratio']:.3f} ({low:.2f} to {high:.2f})", f"{fit['coverage90']:.0%}", f"{own['coverage90']:.0%}"),
        f"{shorter:.2f} of the fit's",
    )


def _effect_row(lines: Lines) -> tuple[str, ...]:
    """Every effect that both answers have a probability for, in every set of the bench."""
    cases = [
        (name in line["label"].split("+"), line["loop"][name], chance)
        for line in lines
        if line["kind"] == "bench"
        for name, chance in line["quick_effects"].items()
        if name in line["loop"] and name != "none"
    ]
    return _auc_row("effects of the bench", np.array(cases, float))


def _none_row(lines: Lines) -> tuple[str, ...]:
    cases = [
        (line["label"] == "none", line["loop"]["none"], line["quick_effects"]["none"])
        for line in lines
        if line["kind"] == "bench"
    ]
    return _auc_row("no effect in a set of the bench", np.array(cases, float))


def _cause_row(lines: Lines) -> tuple[str, ...]:
    cases = [
        (cause != len(NAMES), 1 - usual, 1 - chances[-1])
        for line in lines
        if line["kind"] == "simulated"
        for cause, usual, chances in zip(line["causes"], line["fit_usual"], line["linear_chance"], strict=True)
    ]
    return _auc_row("a cause of a simulated flight", np.array(cases, float))


def _auc_row(name: str, cases: Float[Array, "case 3"]) -> tuple[str, ...]:
    """A row from whether something was there, and its probability by the loop and by the quick answer."""
    if not len(cases):
        return name, "0", "0", "", ""
    there, loop, own = cases.T
    return name, str(len(cases)), str(int(there.sum())), f"{auc(loop, there):.3f}", f"{auc(own, there):.3f}"


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folder", type=Path)
    parser.add_argument("--bench", type=Path)
    parser.add_argument("--flyers", type=Path, nargs="*", default=[])
    parser.add_argument("--processes", type=int, default=2)
    parser.add_argument("--seconds", type=float, default=600.0)
    parser.add_argument("--seed", type=int, default=3)
    parser.add_argument("--page", action="store_true")
    given = parser.parse_args()
    if given.page:
        lines = [json.loads(line) for path in sorted(given.folder.glob("*.jsonl")) for line in path.open()]
        PAGE.write_text("\n".join(page(lines)).rstrip() + "\n", encoding="utf-8")
        return
    given.folder.mkdir(parents=True, exist_ok=True)
    labels = json.loads((given.bench / "labels.json").read_text()) if given.bench else []
    sets = [(given.bench / f"{label['set']}.csv", label["label"]) for label in labels]
    many = given.processes
    with ProcessPoolExecutor(many, get_context("spawn")) as pool:
        jobs = [
            pool.submit(_worker, given.folder, given.flyers[i::many], sets[i::many], given.seed, i, given.seconds)
            for i in range(many)
        ]
        for job in jobs:
            job.result()


if __name__ == "__main__":
    main()
