"""The history network beside the fit, and the page about it: `python tools/history_report.py`.

`--simulated N` scores both on N fresh histories of the one model, `--bench SETS` on sets of `python -m bench.make`,
`--ledger LEDGER` forward in time on the flights of a ledger; each writes figures alone into `docs/measured/`, with
`--network FOLDER` those of a network that was trained again and is not shipped. Without
options `docs/history-network.md` is written from these and from the card of the shipped network.
"""

import argparse
import json
import tempfile
import textwrap
import time
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from fieldkit.flight import Flight
from fieldkit.forecast.at_once import forecast_at_once
from fieldkit.forecast.evaluation.forward_in_time import unflown
from fieldkit.forecast.predict import predict
from fieldkit.inference.history.check import DRAWS as DRAWS_OF_CHECK
from fieldkit.inference.history.check import LEAST_EFFECTIVE
from fieldkit.inference.history.drawn_rockets import stock
from fieldkit.inference.history.linear_fit import READING_NODES, SCATTER_NODES
from fieldkit.inference.history.simulated_histories import simulated_histories
from fieldkit.inference.laplace.fleet import rocket_fit, shared_prior
from fieldkit.inference.laplace.importance import MORE_DRAWS, RELIABLE_PARETO_K
from fieldkit.inference.network.ensemble import Ensemble, load_folder, read_card
from fieldkit.inference.network.history import checked, load_history, quick_answer
from fieldkit.inference.validation.history import auc
from fieldkit.ledger import Ledger
from fieldkit.model.hyperprior import learned
from fieldkit.model.prior_predictive import split_motors
from fieldkit.model.readout_data import observe
from fieldkit.motors import Found, catalogue
from fieldkit.plugins import trained_folder
from fieldkit.scoring.proper_scores import crps
from fieldkit.selection.diagnose import diagnose
from fieldkit.selection.extended_model import rocket_model
from fieldkit.selection.prior import inclusion_probabilities
from fieldkit.selection.quick_candidates import quick_candidates
from fieldkit.selection.quick_look import quick_look
from fieldkit.services.imports.add_files import bring_in
from fieldkit.services.plausible_flights import followed

ROOT = Path(__file__).parents[1]
MEASURED = ROOT / "docs" / "measured"
REPORT = ROOT / "docs" / "history-network.md"
DRAWS = 1000
SCALES = len(SCATTER_NODES) * len(READING_NODES)
AGAIN = "_again"
"""Ends the names of figures of a network that was trained again and is not shipped."""
FRESH_SEED = 20_261
"""Of histories that training never draws."""
FlownFlights = Sequence[tuple[Flight, Found]]


@dataclass(frozen=True, slots=True)
class ForecastRow:
    """One flight by both: CRPS and error of the median over the apogee, whether it lay in the 90 % interval."""

    earlier: int
    fit: tuple[float, float, bool]
    network: tuple[float, float, bool]
    fit_seconds: float
    network_seconds: float


def scored(draws: np.ndarray, flown: float) -> tuple[float, float, bool]:
    """CRPS and absolute error of the median over the apogee flown, and whether it lies in the 90 % interval."""
    low, middle, high = np.quantile(draws, (0.05, 0.5, 0.95))
    return crps(draws, flown) / flown, abs(middle / flown - 1), bool(low <= flown <= high)


def summary(rows: Sequence[ForecastRow]) -> dict[str, Any]:
    """Means of both, and a 90 % bootstrap interval of the ratio of their CRPS."""
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
    """Of all rows, and by how many flights came before."""
    bins = {"all": (0, 999), "1-2": (1, 2), "3-5": (3, 5), "6-12": (6, 12), "13 or more": (13, 999)}
    found = {name: [row for row in rows if low <= row.earlier <= high] for name, (low, high) in bins.items()}
    return {name: summary(some) for name, some in found.items() if some}


def simulated(count: int, network: Ensemble) -> None:
    """Both on fresh histories: forecasts, Cd and alpha."""
    known, _ = split_motors()
    rng, choice = np.random.default_rng(FRESH_SEED), stock(known)
    rows: dict[str, list[ForecastRow]] = {"selection": [], "forecast": []}
    errors: dict[str, list[list[float]]] = {"selection": [], "forecast": []}
    while sum(map(len, rows.values())) < count:
        for one in simulated_histories(rng, choice, quick_candidates, inclusion_probabilities(), 10, 1):
            world = "selection" if one.selects else "forecast"
            past = [
                (flight if used else flight.with_changes(tags=("weak_launch",)), motor)
                for flight, motor, used in zip(
                    one.history.flights, one.history.found, one.history.used_in_fit, strict=False
                )
            ]
            plan = one.history.flights[-1], one.history.found[-1]
            began = time.process_time()
            (made,) = predict(past, [plan], shared=one.history.shared, draws=DRAWS)
            middle = time.process_time()
            said = quick_answer(one.history, quick_candidates, network)
            ended = time.process_time()
            used = sum(one.history.used_in_fit)
            rows[world].append(
                ForecastRow(
                    used,
                    scored(made.apogee, one.apogee),
                    scored(said.apogee_draws(DRAWS), one.apogee),
                    middle - began,
                    ended - middle,
                )
            )
            errors[world].append(
                [
                    abs(float(np.median(made.cd)) - np.exp(one.cd)),
                    abs(float(np.exp(said.log_cd[0])) - np.exp(one.cd)),
                    abs(float(np.median(made.alpha)) - np.exp(one.alpha)),
                    abs(float(np.exp(said.log_alpha[0])) - np.exp(one.alpha)),
                ]
            )
    keys = ("fit_cd_mae", "network_cd_mae", "fit_alpha_mae", "network_alpha_mae")
    found = {
        world: {"forecast": by_earlier(some), **dict(zip(keys, np.mean(errors[world], axis=0).tolist(), strict=True))}
        for world, some in rows.items()
        if some
    }
    write("history_simulated", network, {"command": f"python tools/history_report.py --simulated {count}", **found})


def flights_of(path: Path) -> FlownFlights:
    """The flights of a table, in the order flown, with their motors."""
    motors = catalogue()
    with tempfile.TemporaryDirectory() as home, Ledger.open(str(Path(home) / "ledger.db")) as ledger:
        bring_in(ledger, [path], lambda _: None, motors=motors)
        return followed(ledger.flights(), motors)


def bench(folder: Path, loops: int, first: int | None, network: Ensemble) -> None:
    """Both on sets with undeclared effects: forecasts of the later flights of all; the search on the first `loops`."""
    labels = json.loads((folder / "labels.json").read_text())[:first]
    rows: list[ForecastRow] = []
    judged: list[dict[str, Any]] = []
    for number, label in enumerate(labels):
        history = flights_of(folder / f"{label['set']}.csv")
        later = flights_of(folder / f"{label['set']}_future.csv")
        began = time.process_time()
        made = predict(history, [(unflown(flight), motor) for flight, motor in later], draws=DRAWS)
        each = (time.process_time() - began) / len(later)
        for (flight, motor), forecast in zip(later, made, strict=True):
            middle = time.process_time()
            said = forecast_at_once(history, (unflown(flight), motor), ensemble=network)
            spent = time.process_time() - middle
            apogee = float(flight.apogee or np.nan)
            both = scored(forecast.apogee, apogee), scored(said.apogee_draws(DRAWS), apogee)
            rows.append(ForecastRow(len(history), *both, each, spent))
        used = [flight.clean and flight.apogee is not None for flight, _ in history]
        began = time.process_time()
        look = quick_look(label["rocket"], history, used, network)
        seconds = time.process_time() - began
        entry = {
            "label": label["label"],
            "network": {**look.answer.inclusion, "none": look.answer.none, "unexplained": look.answer.unexplained},
            "network_verdict": look.effect,
            "network_seconds": seconds,
        }
        if number < loops:
            began = time.process_time()
            model = rocket_model([flight for flight, _ in history], [motor for _, motor in history])
            found = diagnose(model, observe([flight for flight, _ in history], used))
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
    }
    write("history_bench", network, document)


def selection(judged: Sequence[Mapping[str, Any]], ways: Sequence[str]) -> dict[str, Any]:
    """Verdicts that are right, the AUC of inclusion over all sets and effects together, false alarms, seconds."""
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
    """Both forward in time on the flights of a ledger, each from those before it of all rockets."""
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
            fits = [
                rocket_fit(used, known)
                for some in others
                if (used := [p for p in some if p[0].clean and p[0].readouts()])
            ]
            shared = shared_prior(fits)
            plan = unflown(flight), motor
            began = time.process_time()
            (made,) = predict(own, [plan], shared=shared, draws=DRAWS)
            middle = time.process_time()
            said = forecast_at_once(own, plan, shared=shared, ensemble=network)
            ended = time.process_time()
            both = scored(made.apogee, flight.apogee), scored(said.apogee_draws(DRAWS), flight.apogee)
            rows.append(ForecastRow(sum(f.clean for f, _ in own), *both, middle - began, ended - middle))
        own.append((flight, motor))
    write(
        f"history_{name}",
        network,
        {"command": "python tools/history_report.py --ledger LEDGER", "forecast": by_earlier(rows)},
    )


def write(name: str, network: Ensemble, document: Mapping[str, Any]) -> None:
    """Keep what was measured of a network, apart where it is not the one that is shipped."""
    name += "" if network is load_history() else AGAIN
    (MEASURED / f"{name}.json").write_text(json.dumps(rounded(document), indent=1) + "\n", encoding="utf-8")


def rounded(value: Any) -> Any:
    """The same with figures to four digits."""
    if isinstance(value, Mapping):
        return {key: rounded(one) for key, one in value.items()}
    if isinstance(value, list):
        return [rounded(one) for one in value]
    return float(f"{value:.4g}") if isinstance(value, float) else value


def prose(*parts: str) -> Iterator[str]:
    """A paragraph."""
    yield textwrap.fill(" ".join(parts), 120, break_long_words=False, break_on_hyphens=False)
    yield ""


def table(headers: Sequence[str], rows: Iterable[Sequence[str]]) -> Iterator[str]:
    """A table in Markdown."""
    yield "| " + " | ".join(headers) + " |"
    yield "|" + "---|" * len(headers)
    yield from ("| " + " | ".join(row) + " |" for row in rows)
    yield ""


def measured(name: str) -> dict[str, Any] | None:
    """What was measured under a name, if it was."""
    path = MEASURED / f"{name}.json"
    return json.loads(path.read_text(encoding="utf-8")) if path.exists() else None


def percent(share: float | None) -> str:
    return "-" if share is None else f"{100 * share:.1f} %"


def report(card: Mapping[str, Any]) -> Iterator[str]:
    """The whole page, line by line."""
    yield "# The history network, judged"
    yield ""
    yield from prose(
        "`fieldkit loop --quick` is answered by a network that sees a rocket's whole history at once. It is shown what",
        "one linear pass over the one model makes of the history: the evidence for every effect in every place, the",
        "forecast of the plan, residuals of flights left out (score compression: Alsing, Wandelt and Feeney, Massive",
        "optimal data compression and density estimation for scalable, likelihood-free inference in cosmology, 2018).",
        "Trained on simulated histories alone, it corrects them. One flight or sixty make the same number of features,",
        "and each effect is judged by one function of what it shows and of what the whole history shows. This page",
        "is written",
        "by `python tools/history_report.py`.",
    )
    yield from ("```sh", card["command"], "```", "")
    shards = measured("history_shards") or {"seconds": card["simulation_seconds"]}
    yield from prose(
        f"{card['simulations']:,} histories of 1 to 60 flights, simulated in {shards['seconds']:.0f} s;",
        f"{card['training']['epochs']} epochs in {card['seconds']:.0f} s, on one thread of a busy machine.",
        "Five members in one graph. A run that was cut short goes on where it was: shards that are there are taken.",
    )
    yield from asked()
    yield from on_fresh(card)
    yield from beside_fit()
    yield from trained_again()
    yield from use()


def asked() -> Iterator[str]:
    """Where the network answers, and what is checked."""
    yield from ("## Where it answers", "")
    yield from prose(
        "`loop --quick`: the probability of every effect. `predict --quick`: the next apogee, Cd and alpha. In",
        "Add: Cd, alpha and the next apogee move with each readout that is typed; what the flights would show is",
        "kept between readouts, and simulated again for another set-up alone. Many motors are forecast in one",
        "batch (`forecasts_at_once`). How long each takes beside the fit is in [speed](speed.md), from `python",
        "tools/benchmarks.py history`.",
    )
    yield from prose(
        f"A quick forecast says *checked by the fit* where importance sampling bears it out. {DRAWS_OF_CHECK}",
        "draws of log Cd and log alpha come from the network's normal distribution, the model's other unknowns",
        "from the linear fit given those, their covariance inflated by 15 %. The readouts of each draw are",
        "simulated; its weight is the prior times the likelihood of the one model (each flight's noise a",
        f"multivariate Student t, summed over a grid of {SCALES} scales of scatter and reading) over the density",
        "that it was drawn from. A generalized Pareto distribution is fitted to the largest weights; its shape k",
        f"must be at most {RELIABLE_PARETO_K} (Vehtari, Simpson, Gelman, Yao and Gabry, Pareto smoothed importance",
        f"sampling, Journal of Machine Learning Research 25, 2024), after {MORE_DRAWS} times as many draws where",
        "the first do not reach it. The weighted draws are the model's forecast of the plan's apogee, and the",
        "effective fraction of the network's own draws of it, weighted by that, must be at least",
        f"{LEAST_EFFECTIVE}, which is a judgment: most of them count. Else the fit answers. What is printed is the",
        "network's forecast as it is, not the weighted one. Effects that the loop accepted are in the fit's",
        "forecast alone.",
    )
    yield from prose(
        "Weights are float32. Rounding them to float16 would halve the file and moves no quantile by a thousandth",
        "of a standard deviation, but a processor without half precision converts them back at every start: at",
        "less than a megabyte it gains nothing, and it is not done.",
    )


def on_fresh(card: Mapping[str, Any]) -> Iterator[str]:
    """What training says of the network."""
    for title, key in (("Histories it never saw", "test"), ("Motors of Quest, which it never saw", "test_held_out")):
        test = card[key]
        yield from (f"## {title}", "")
        yield from prose(
            f"{test['histories']:,} histories. CRPS and errors of the median are fractions of the apogee; in brackets",
            "the linear pass that the network starts from.",
        )
        groups = {"all": test["forecast"]} | {f"{name} flights": x for name, x in test["by_flights"].items()}
        groups |= {f"{name} kinds of readouts": x for name, x in test["by_readouts"].items()}
        yield from table(
            (
                "histories",
                "count",
                "coverage 40 %",
                "80 %",
                "90 %",
                "CRPS",
                "median error",
                "fullest / emptiest tenth of ranks",
            ),
            (
                (
                    name,
                    f"{one['histories']}",
                    *(
                        f"{percent(one[k])} ({percent(one['linear_' + k])})"
                        for k in ("coverage40", "coverage80", "coverage90")
                    ),
                    f"{percent(one['crps'])} ({percent(one['linear_crps'])})",
                    f"{percent(one['median_error'])} ({percent(one['linear_median_error'])})",
                    f"{max(one['ranks']):.2f} / {min(one['ranks']):.2f}",
                )
                for name, one in groups.items()
                if one["histories"] >= 20
            ),
        )
        p = test["parameters"]
        yield from prose(
            f"Mean absolute error of Cd {p['cd_mae']:.3f} ({p['linear_cd_mae']:.3f}), of alpha {p['alpha_mae']:.4f}",
            f"({p['linear_alpha_mae']:.4f}); in their 90 % intervals {percent(p['cd_coverage90'])}",
            f"({percent(p['linear_cd_coverage90'])}) and {percent(p['alpha_coverage90'])}",
            f"({percent(p['linear_alpha_coverage90'])}).",
        )
    yield from ("### Inclusion", "")
    yield from prose(
        "Histories of eight flights and more from the hyperprior that effects are judged with, strengths from the",
        "effects' own priors, many too weak to be seen. AUC is the probability that a history with the effect is given",
        "a higher probability than one without; log score is above that of the base rate.",
    )
    yield from table(
        ("", "with it", "without", "AUC", "of the linear evidence", "log score [nat]", "calibration error"),
        (
            (
                name,
                f"{one['present']:.0f}",
                f"{one['histories'] - one['present']:.0f}",
                f"{one['auc']:.3f}",
                f"{one['linear_auc']:.3f}",
                f"{one['gain']:+.3f}",
                f"{one['calibration_error']:.3f}",
            )
            for name, one in card["test"]["inclusion"].items()
            if "auc" in one
        ),
    )


FORECAST_COLUMNS = (
    "",
    "flights",
    "CRPS: network",
    "fit",
    "ratio (90 %)",
    "median error: network",
    "fit",
    "in 90 %: network",
    "fit",
)


def forecast_row(name: str, one: Mapping[str, Any]) -> tuple[str, ...]:
    """Both on the same flights."""
    low, high = one["ratio90"]
    return (
        name,
        f"{one['flights']}",
        percent(one["network_crps"]),
        percent(one["fit_crps"]),
        f"{one['ratio']:.3f} ({low:.3f} to {high:.3f})",
        percent(one["network_median"]),
        percent(one["fit_median"]),
        percent(one["network_coverage90"]),
        percent(one["fit_coverage90"]),
    )


def beside_fit() -> Iterator[str]:
    """The network and the fit on the same flights."""
    yield from ("## Beside the fit", "")
    yield from prose("The fit is `predict` and the search is `loop`, on the same flights in the same run.")
    if said := measured("history_simulated"):
        yield from (f"`{said['command']}`", "")
        worlds = {"selection": "certified hyperprior", "forecast": "learned hyperprior"}
        rows = [
            forecast_row(f"{title}, {name}", one)
            for key, title in worlds.items()
            for name, one in said.get(key, {}).get("forecast", {}).items()
        ]
        yield from table(FORECAST_COLUMNS, rows)
        for key, title in worlds.items():
            if one := said.get(key):
                yield from prose(
                    f"{title.capitalize()}: mean absolute error of Cd {one['network_cd_mae']:.3f} (fit",
                    f"{one['fit_cd_mae']:.3f}), of alpha {one['network_alpha_mae']:.4f}",
                    f"(fit {one['fit_alpha_mae']:.4f}).",
                )
    if said := measured("history_bench"):
        yield from ("`python -m bench.make SETS --sets 3 --seed 91`,", f"`{said['command']}`:", "")
        yield from table(FORECAST_COLUMNS, [forecast_row("bench, later flights", said["forecast"])])
        yield from table(
            (
                "",
                "sets",
                "AUC of inclusion",
                "AUC of none",
                "verdict right",
                "likeliest effect is there",
                "false alarms",
                "seconds a set",
            ),
            (
                (
                    f"{'loop' if way == 'fit' else 'network'}, {'all sets' if name == 'all' else 'the same sets'}",
                    f"{one['sets']}",
                    *(f"{one[way][key]:.3f}" for key in ("inclusion_auc", "none_auc")),
                    *(percent(one[way][key]) for key in ("right", "likeliest_is_there", "false_alarms")),
                    f"{one[way]['seconds']:.2f}",
                )
                for name, one in said["selection"].items()
                for way in ("network", "fit")
                if way in one
            ),
        )
    for name, title in (("journal", "The open journal"), ("reference", "The reference flights")):
        if said := measured(f"history_{name}"):
            yield from (f"{title}, forward in time, `{said['command']}`:", "")
            yield from table(FORECAST_COLUMNS, [forecast_row(key, one) for key, one in said["forecast"].items()])


def trained_again() -> Iterator[str]:
    """The shipped network and the one that the same command makes now, beside the fit on the same flights."""
    rows = [
        (f"{title}{key}", *(text for one in (now, again) for text in _ratio_and_coverage(one)))
        for name, title in _FORECASTS.items()
        for (key, now), (_, again) in zip(_of_all(name), _of_all(name + AGAIN), strict=False)
    ]
    if not rows:
        return
    yield from ("## Trained again", "")
    yield from prose(
        "The shipped network was trained (at commit 03ef634) before altimeters that correct for temperature, tip-off,",
        "flutter and delays short by seconds were effects, each effect as probable as any other. The same command now",
        "draws each by the prior that the fit has (`fieldkit/selection/prior.py`), from the present hyperprior, with",
        "forecasts trained mostly on rockets from the learned one. It simulated 27,834 histories of 14,000 rockets in",
        "2331 s and trained in 55 s. The shipped network's figures beside the fit are from the present fit and",
        "catalogue.",
    )
    columns = ("forecasts", "shipped: CRPS over the fit's", "in 90 %", "again: CRPS over the fit's", "in 90 %")
    yield from table(columns, rows)
    now, again = (measured(f"history_bench{end}") for end in ("", AGAIN))
    if now and again:
        yield from prose(
            *(
                f"Inclusion on {one['sets']} sets of the bench, {title}: AUC"
                f" {one['network']['inclusion_auc']:.3f} shipped,"
                f" {other['network']['inclusion_auc']:.3f} again; right verdicts {percent(one['network']['right'])} and"
                f" {percent(other['network']['right'])}."
                for key, title in (("all", "all"), ("beside the loop", "those that the loop searched"))
                for one, other in [(now["selection"][key], again["selection"][key])]
            )
        )
    yield from prose(
        "It forecasts the open journal better and the bench worse, with too few flights in its intervals, and finds",
        "effects less well; of the effects that share the probability of one family it saw fewer each. A network",
        "replaces the shipped one where it is no worse on the same flights, so this one does not; until then",
        "`loop --quick` names the effects that its network was not trained with.",
    )


def _ratio_and_coverage(one: Mapping[str, Any]) -> tuple[str, str]:
    return f"{one['ratio']:.3f}", percent(one["network_coverage90"])


GOALS = {"ratio": 1.02, "auc": 0.02, "coverage": (0.87, 0.93)}
"""What a network has to reach beside the fit to take its place: CRPS over the fit's, AUC below the loop's, and the
fraction of flights in its 90 % interval. [1]"""


def use() -> Iterator[str]:
    """Where the network reaches the fit, and what it is used for."""
    yield from ("## What it is used for", "")
    low, high = GOALS["coverage"]
    lines = []
    for name, title in _FORECASTS.items():
        for key, one in _of_all(name):
            reached = one["ratio"] <= GOALS["ratio"] and low <= one["network_coverage90"] <= high
            lines.append(
                (
                    f"{title}{key}",
                    f"{one['ratio']:.3f}",
                    percent(one["network_coverage90"]),
                    "yes" if reached else "no",
                )
            )
    yield from prose(
        f"To take the fit's place it would need a CRPS of at most {GOALS['ratio']:.2f} of the fit's and",
        f"{low:.0%} to {high:.0%} of flights in its 90 % interval:",
    )
    yield from table(("forecasts", "CRPS over the fit's", "in 90 %", "reached"), lines)
    said = measured("history_bench")
    both = (said or {}).get("selection", {}).get("beside the loop", {})
    if "fit" in both:
        behind = both["fit"]["inclusion_auc"] - both["network"]["inclusion_auc"]
        reached = "is" if behind <= GOALS["auc"] else "is not"
        yield from prose(
            f"The AUC of inclusion {reached} within {GOALS['auc']:.2f} of the loop's",
            f"({-behind:+.3f} on {both['sets']} sets).",
        )
    yield from prose(
        "Until all of it is reached on flights of the bench and on open flights it is the quick answer alone: `loop`",
        "and `predict` search and fit, and what they find is what a ledger keeps.",
    )


_FORECASTS = {
    "simulated": "simulated",
    "bench": "bench, later flights",
    "journal": "open journal",
    "reference": "reference flights",
}


def _of_all(name: str) -> Iterator[tuple[str, Mapping[str, Any]]]:
    """The forecasts of a measurement, all together."""
    said = measured(f"history_{name}") or {}
    if name.removesuffix(AGAIN) == "simulated":
        for key in ("selection", "forecast"):
            if key in said:
                yield f", {'certified' if key == 'selection' else 'learned'} hyperprior", said[key]["forecast"]["all"]
    elif "forecast" in said:
        yield "", said["forecast"].get("all", said["forecast"])


def main() -> int:
    """Measure what is asked for, else write the page."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--simulated", type=int)
    parser.add_argument("--bench", type=Path)
    parser.add_argument("--loops", type=int, default=0, help="sets that are searched too")
    parser.add_argument("--first", type=int, help="only the first so many sets")
    parser.add_argument("--ledger")
    parser.add_argument("--name", default="journal", help="what the figures of a ledger are kept under")
    parser.add_argument("--network", type=Path, help="a folder with a network other than the shipped one")
    given = parser.parse_args()
    MEASURED.mkdir(exist_ok=True)
    network = checked(load_folder(given.network)) if given.network else load_history()
    if given.simulated:
        simulated(given.simulated, network)
    elif given.bench:
        bench(given.bench, given.loops, given.first, network)
    elif given.ledger:
        journal(given.name, given.ledger, network)
    else:
        REPORT.write_text("\n".join(report(read_card(trained_folder("history")))).rstrip() + "\n", encoding="utf-8")
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
