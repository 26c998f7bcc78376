"""Compares the history network with the fit on simulated histories, sets of the bench and flights of a ledger."""

import json
import tempfile
import time
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from fieldkit.flight import Flight
from fieldkit.forecast.at_once import forecast_at_once
from fieldkit.forecast.predict import predict
from fieldkit.inference.history.drawn_rockets import split_motors, stock
from fieldkit.inference.history.simulated_histories import simulated_histories
from fieldkit.inference.laplace.fleet import rocket_fit, shared_prior
from fieldkit.inference.network.ensemble import Ensemble
from fieldkit.inference.network.history import load_history, quick_answer
from fieldkit.inference.validation.history import auc
from fieldkit.ledger import Ledger
from fieldkit.model.fleet_drift import period_of
from fieldkit.model.hyperprior import learned
from fieldkit.model.readout_data import observe
from fieldkit.model.rocket_model import FlownFlights
from fieldkit.motors import Found, catalogue
from fieldkit.physics.history import history_of
from fieldkit.scoring.proper_scores import crps
from fieldkit.selection.diagnose import diagnose
from fieldkit.selection.extended_model import rocket_model
from fieldkit.selection.prior import inclusion_probabilities
from fieldkit.selection.quick_candidates import quick_candidates
from fieldkit.selection.quick_look import quick_look
from fieldkit.services.imports.add_files import bring_in
from fieldkit.services.plausible_flights import followed
from tools.history_opinions import opinions, scores
from tools.markdown import MEASURED

DRAWS = 1000
"""Draws of each forecast."""
FRESH_SEED = 20_261
"""Seed of histories that training never draws."""
OTHER = "_other"
"""Suffix of the names of figures for a network that is not shipped, which no page shows."""


@dataclass(frozen=True, slots=True)
class ForecastRow:
    """Scores of both on one flight: CRPS and error of the median relative to the apogee, and whether it was in the 90%
    interval."""

    earlier: int
    fit: tuple[float, float, bool]
    network: tuple[float, float, bool]
    fit_seconds: float
    network_seconds: float


def scored(draws: np.ndarray, flown: float) -> tuple[float, float, bool]:
    """CRPS and absolute error of the median relative to the flown apogee, and whether it is in the 90% interval."""
    low, middle, high = np.quantile(draws, (0.05, 0.5, 0.95))
    return crps(draws, flown) / flown, abs(middle / flown - 1), bool(low <= flown <= high)


def summary(rows: Sequence[ForecastRow]) -> dict[str, Any]:
    """Means of both, and a 90% bootstrap interval of the ratio of their CRPS."""
    fit, network = (np.array([getattr(row, way) for row in rows], float) for way in ("fit", "network"))
    rng = np.random.default_rng(1)
    some = rng.integers(len(rows), size=(2000, len(rows)))
    ratios = network[some, 0].mean(axis=1) / fit[some, 0].mean(axis=1)
    return {
        "flights": len(rows),
        **{f"{name}_crps": float(scores[:, 0].mean()) for name, scores in (("fit", fit), ("network", network))},
        **{f"{name}_median": float(np.median(scores[:, 1])) for name, scores in (("fit", fit), ("network", network))},
        **{f"{name}_coverage90": float(scores[:, 2].mean()) for name, scores in (("fit", fit), ("network", network))},
        "ratio": float(network[:, 0].mean() / fit[:, 0].mean()),
        "ratio90": [float(x) for x in np.quantile(ratios, (0.05, 0.95))],
        "fit_seconds": float(np.median([row.fit_seconds for row in rows])),
        "network_seconds": float(np.median([row.network_seconds for row in rows])),
    }


def by_earlier(rows: Sequence[ForecastRow]) -> dict[str, Any]:
    """Scores of all rows, and by the number of earlier flights."""
    bins = {"all": (0, 999), "1-2": (1, 2), "3-5": (3, 5), "6-12": (6, 12), "13 or more": (13, 999)}
    found = {name: [row for row in rows if low <= row.earlier <= high] for name, (low, high) in bins.items()}
    return {name: summary(some) for name, some in found.items() if some}


def simulated(count: int, network: Ensemble) -> None:
    """Scores of both on new histories: forecasts, Cd and alpha."""
    known, _ = split_motors()
    rng, choice = np.random.default_rng(FRESH_SEED), stock(known)
    rows: dict[str, list[ForecastRow]] = {"selection": [], "forecast": []}
    errors: dict[str, list[list[float]]] = {"selection": [], "forecast": []}
    judged = []
    while sum(map(len, rows.values())) < count:
        for one in simulated_histories(rng, choice, quick_candidates, inclusion_probabilities(), 10, 1):
            world = "selection" if one.selects else "forecast"
            whole = one.history
            past = [
                (flight if used else flight.with_changes(tags=("weak_launch",)), motor)
                for flight, motor, used in zip(whole.flights, whole.found, whole.used_in_fit, strict=False)
            ]
            plan = whole.flights[-1], whole.found[-1]
            began = time.process_time()
            (made,) = predict(past, [plan], shared=one.shared, draws=DRAWS)
            middle = time.process_time()
            answer = quick_answer(whole, quick_candidates, one.shared, network)
            ended = time.process_time()
            if one.selects:
                judged.append((opinions(answer, network), one.effects))
            used = sum(one.history.used_in_fit)
            rows[world].append(
                ForecastRow(
                    used,
                    scored(made.apogee, one.apogee),
                    scored(answer.apogee_draws(DRAWS), one.apogee),
                    middle - began,
                    ended - middle,
                )
            )
            errors[world].append(
                [
                    abs(float(np.median(made.cd)) - np.exp(one.cd)),
                    abs(float(np.exp(answer.log_cd[0])) - np.exp(one.cd)),
                    abs(float(np.median(made.alpha)) - np.exp(one.alpha)),
                    abs(float(np.exp(answer.log_alpha[0])) - np.exp(one.alpha)),
                ]
            )
    keys = ("fit_cd_mae", "network_cd_mae", "fit_alpha_mae", "network_alpha_mae")
    found = {
        world: {"forecast": by_earlier(some), **dict(zip(keys, np.mean(errors[world], axis=0).tolist(), strict=True))}
        for world, some in rows.items()
        if some
    }
    command = {"command": f"python tools/history_report.py --simulated {count}"}
    write("history_simulated", network, command | found | {"opinions": scores(judged)})


def flights_of(path: Path) -> FlownFlights:
    """The flights of a table, in the order flown, with their motors."""
    motors = catalogue()
    with tempfile.TemporaryDirectory() as home, Ledger.open(str(Path(home) / "ledger.db")) as ledger:
        bring_in(ledger, [path], lambda _: None, motors=motors)
        return followed(ledger.flights(), motors)


def bench(folder: Path, loops: int, first: int | None, network: Ensemble) -> None:
    """Scores of both on sets with undeclared effects: forecasts of the later flights of all sets, and the loop on the
    first `loops`."""
    labels = json.loads((folder / "labels.json").read_text())[:first]
    rows: list[ForecastRow] = []
    judged: list[dict[str, Any]] = []
    for number, label in enumerate(labels):
        history = flights_of(folder / f"{label['set']}.csv")
        later = flights_of(folder / f"{label['set']}_future.csv")
        began = time.process_time()
        made = predict(history, [(flight.unflown(), motor) for flight, motor in later], draws=DRAWS)
        each = (time.process_time() - began) / len(later)
        for (flight, motor), forecast in zip(later, made, strict=True):
            middle = time.process_time()
            answer = forecast_at_once(history, (flight.unflown(), motor), ensemble=network)
            spent = time.process_time() - middle
            apogee = float(flight.apogee or np.nan)
            both = scored(forecast.apogee, apogee), scored(answer.apogee_draws(DRAWS), apogee)
            rows.append(ForecastRow(len(history), *both, each, spent))
        used = [flight.clean and flight.apogee is not None for flight, _ in history]
        began = time.process_time()
        look = quick_look(label["rocket"], history, used, network)
        seconds = time.process_time() - began
        entry = {
            "label": label["label"],
            "network": {**look.answer.inclusion, "none": look.answer.none, "unexplained": look.answer.unexplained},
            "opinions": opinions(look.answer, network),
            "network_verdict": look.effect,
            "network_seconds": seconds,
        }
        if number < loops:
            began = time.process_time()
            model = rocket_model(history_of([flight for flight, _ in history], [motor for _, motor in history]))
            found = diagnose(model, observe(model.history.using(used)))
            entry |= {
                "fit": {**found.posterior.inclusion, "none": found.posterior.nothing},
                "fit_verdict": found.effect,
            }
            entry["fit_seconds"] = time.process_time() - began
        judged.append(entry)
    command = f"python tools/history_report.py --bench SETS --loops {loops}" + (f" --first {first}" if first else "")
    both = [entry for entry in judged if "fit" in entry]
    document = {
        "command": command,
        "sets": len(judged),
        "forecast": summary(rows),
        "selection": {"all": selection(judged, ("network",)), "beside the loop": selection(both, ("network", "fit"))},
        "opinions": scores([(entry["opinions"], entry["label"].split("+")) for entry in judged]),
    }
    write("history_bench", network, document)


def selection(judged: Sequence[Mapping[str, Any]], ways: Sequence[str]) -> dict[str, Any]:
    """Right verdicts, the AUC of inclusion over all sets and effects, false alarms, seconds."""
    found: dict[str, Any] = {"sets": len(judged)}
    for way in ways if judged else ():
        pairs = [
            (chance, name in entry["label"].split("+"))
            for entry in judged
            for name, chance in entry[way].items()
            if name not in ("none", "unexplained")
        ]
        score, there = np.array([pair[0] for pair in pairs]), np.array([pair[1] for pair in pairs], float)
        none = np.array([entry[way].get("none", 0.0) for entry in judged])
        empty = np.array([entry["label"] == "none" for entry in judged], float)
        verdicts = [entry[f"{way}_verdict"] for entry in judged]
        hidden = [entry for entry in judged if entry["label"] not in ("none", "unexplained")]
        first = [
            max((name for name in entry[way] if name not in ("none", "unexplained")), key=entry[way].__getitem__)
            in entry["label"].split("+")
            for entry in hidden
        ]
        found[way] = {
            "inclusion_auc": auc(score, there),
            "none_auc": auc(none, empty),
            "right": float(
                np.mean(
                    [set(v.split("+")) == set(e["label"].split("+")) for v, e in zip(verdicts, judged, strict=True)]
                )
            ),
            "likeliest_is_there": float(np.mean(first)) if first else None,
            "false_alarms": float(
                np.mean([v != "none" for v, e in zip(verdicts, judged, strict=True) if e["label"] == "none"])
            )
            if empty.any()
            else None,
            "seconds": float(np.median([entry[f"{way}_seconds"] for entry in judged])),
        }
    return found


def journal(name: str, ledger: str, network: Ensemble) -> None:
    """Scores of both forward in time on the flights of a ledger, each from all rockets' earlier flights."""
    motors = catalogue()
    with Ledger.open(ledger) as book:
        flown = followed(book.flights(), motors)
    known = learned()
    past: dict[str, list[tuple[Flight, Found]]] = {}
    rows: list[ForecastRow] = []
    for flight, motor in flown:
        own = past.setdefault(flight.rocket, [])
        if own and flight.clean and flight.apogee is not None and any(f.clean and f.apogee for f, _ in own):
            others = [some for rocket, some in past.items() if rocket != flight.rocket]
            period = period_of(flight for some in past.values() for flight, _ in some)
            fits = [
                rocket_fit(used, known, period)
                for some in others
                if (used := [p for p in some if p[0].clean and p[0].readouts()])
            ]
            shared = shared_prior(fits, period)
            plan = flight.unflown(), motor
            began = time.process_time()
            (made,) = predict(own, [plan], shared=shared, draws=DRAWS)
            middle = time.process_time()
            answer = forecast_at_once(own, plan, shared=shared, ensemble=network)
            ended = time.process_time()
            both = scored(made.apogee, flight.apogee), scored(answer.apogee_draws(DRAWS), flight.apogee)
            rows.append(ForecastRow(sum(f.clean for f, _ in own), *both, middle - began, ended - middle))
        own.append((flight, motor))
    write(
        f"history_{name}",
        network,
        {"command": "python tools/history_report.py --ledger LEDGER", "forecast": by_earlier(rows)},
    )


def write(name: str, network: Ensemble, document: Mapping[str, Any]) -> None:
    """Save the measurements of a network, under another name if it is not the shipped one."""
    name += "" if network is load_history() else OTHER
    (MEASURED / f"{name}.json").write_text(json.dumps(rounded(document), indent=1) + "\n", encoding="utf-8")


def rounded(value: Any) -> Any:
    """A copy with figures rounded to four digits."""
    if isinstance(value, Mapping):
        return {key: rounded(one) for key, one in value.items()}
    if isinstance(value, list):
        return [rounded(one) for one in value]
    return float(f"{value:.4g}") if isinstance(value, float) else value
