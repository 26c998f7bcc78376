"""The networks, the closed forms and the loop on sets of the bench and on real flights forward in time."""

import json
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from fieldkit.flight import Flight
from fieldkit.forecast.assumed import Assumed
from fieldkit.forecast.predict import predict
from fieldkit.inference.history.response import respond
from fieldkit.model.causes import NAMES
from fieldkit.model.hyperprior import START, learned
from fieldkit.model.shared_prior import SharedPrior
from fieldkit.physics.history import History, flown_and_planned
from fieldkit.shapes import Array
from studies.quick_network.inputs import closed_forms, effect_names
from studies.quick_network.network import FlightsNetwork, answers
from studies.quick_network.scores import STUDENT_DRAWS, auc, compared_with_fit, of_probabilities, scored
from studies.quick_network.tables import WorldTable, table
from studies.quick_network.world import WorldHistory
from tools.later_flights import flights_of, later_flights
from tools.quick_beside_fit import plan_again

Networks = Mapping[str, list[FlightsNetwork]]


def tabled(history: History, apogee: float, shared: SharedPrior | None, hyperprior: Any) -> WorldTable:
    """One history as a table, with the flown apogee as the truth. [m]"""
    known = closed_forms(history, respond(history), hyperprior, shared)
    one = WorldHistory(history, 0, (), False, np.zeros(history.flown, int), apogee)
    return table([(one, known)])


def on_bench(folder: Path, loops: Mapping[str, Any], networks: Networks, pools: Mapping[str, Sequence[float]]) -> Any:
    """AUC and log score of effects on all sets, of the closed forms, the networks, both pooled with the weights that
    simulated histories gave, and the loop."""
    names = effect_names()
    ways: dict[str, list[float]] = {}
    there: list[float] = []
    nothing: list[float] = []
    none: dict[str, list[float]] = {}
    for label in json.loads((folder / "labels.json").read_text()):
        if label["set"] not in loops:
            continue
        history = plan_again(flights_of(folder / f"{label['set']}.csv"))
        whole = tabled(history, 1.0, None, START)
        acts = np.flatnonzero(whole.acts[0] > 0.5)
        own = {"closed form": whole.odds[0, acts].astype(float)}
        nones = {"closed form": float(whole.column("none_odds")[0])}
        for name, some in networks.items():
            chances = answers(some, whole)[1][0]
            own[name], nones[name] = _odds(chances[acts]), float(_odds(chances[-2:-1])[0])
            weight = pools[name]
            own[f"{name} pooled"] = weight[0] * own["closed form"] + weight[1] * own[name] + weight[2]
        loop = loops[label["set"]]
        own["loop"] = _odds(np.array([loop.get(names[i], 0.0) for i in acts]))
        nones["loop"] = float(_odds(np.array([loop["none"]]))[0])
        for name, odds in own.items():
            ways.setdefault(name, []).extend(odds.tolist())
        for name, value in nones.items():
            none.setdefault(name, []).append(value)
        there += [float(names[i] in label["label"].split("+")) for i in acts]
        nothing.append(float(label["label"] == "none"))
    each = {name: np.array(odds) for name, odds in ways.items()}
    return {
        "sets": len(nothing),
        "present": int(sum(there)),
        "effects": of_probabilities(each, np.array(there)),
        "none": {name: round(auc(np.array(odds), np.array(nothing)), 3) for name, odds in none.items()},
    }


def _odds(chance: Array) -> Array:
    limited = np.clip(np.asarray(chance, float), 1e-7, 1 - 1e-7)
    return np.asarray(np.log(limited / (1 - limited)))


def forward_in_time(path: Path, networks: Networks) -> Any:
    """Scores of the fit, the linear pass and the networks on the later flights of a flyer."""
    rows: dict[str, list[tuple[float, float, float, float]]] = {}
    for one in later_flights(path):
        flight, motor = one.flown
        apogee = float(flight.apogee or np.nan)
        plan: Flight = flight.unflown()
        (made,) = predict(one.earlier, [(plan, motor)], Assumed(shared=one.shared))
        rows.setdefault("fit", []).append(scored(made.apogee, apogee))
        whole = tabled(flown_and_planned(one.earlier, [(plan, motor)]), apogee, one.shared, learned())
        mean, sd = float(whole.column("mean")[0]), float(whole.column("sd")[0])
        draws = {
            "linear": mean + sd * np.random.default_rng(0).normal(size=1000),
            "linear, calibrated width": whole.mixture[0].astype(float),
        }
        for name, some in networks.items():
            _, _, middle, width = answers(some, whole)
            draws[name] = middle[0] + width[0] * STUDENT_DRAWS
        for name, log_apogee in draws.items():
            rows.setdefault(name, []).append(scored(np.exp(np.clip(log_apogee, -5, 12)), apogee))
    return compared_with_fit(rows)


def beside_fit(lines: Sequence[Mapping[str, Any]]) -> Any:
    """The closed forms beside the fit and the loop on the same simulated histories."""
    some = [line for line in lines if line["kind"] == "simulated"]
    rows = {"fit": [line["fit"] for line in some], "linear": [line["linear"] for line in some]}
    rows["linear, calibrated width"] = [line["mixture"] for line in some]
    cause = np.array([one for line in some for one in line["causes"]])
    fit = 1 - np.array([one for line in some for one in line["fit_usual"]])
    closed = np.array([one[-1] for line in some for one in line["linear_chance"]])
    has = (cause != len(NAMES)).astype(float)
    return {
        "forecast": compared_with_fit(rows),
        "causes": {"flights": len(cause), "with": int(has.sum()), "loop": round(auc(fit, has), 3)}
        | {"closed form": round(auc(1 - closed, has), 3)},
    }
