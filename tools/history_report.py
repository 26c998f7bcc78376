"""The history network beside the fit, and the page about it: `python tools/history_report.py`.

`--simulated N` scores both on N fresh histories of the one model, `--bench SETS` on sets of `python -m bench.make`,
`--ledger LEDGER` forward in time on the flights of a ledger; each writes figures alone into `docs/measured/`, with
`--network FOLDER` those of a network that is not shipped. Without
options `docs/history-network.md` is written from these and from the card of the shipped network.
"""

import argparse
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

from fieldkit.inference.history.check import DRAWS as DRAWS_OF_CHECK
from fieldkit.inference.history.check import LEAST_EFFECTIVE
from fieldkit.inference.history.linear_fit import READING_NODES, SCATTER_NODES
from fieldkit.inference.laplace.importance import MORE_DRAWS, RELIABLE_PARETO_K
from fieldkit.inference.network.ensemble import load_folder, read_card
from fieldkit.inference.network.history import checked, load_history
from fieldkit.plugins import trained_folder
from tools.history_beside_fit import beside_fit, network_before, use
from tools.history_measurements import bench, journal, simulated
from tools.markdown import MEASURED, measured, percent, prose, table

REPORT = Path(__file__).parents[1] / "docs" / "history-network.md"
SCALES = len(SCATTER_NODES) * len(READING_NODES)


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
        "Five members in one graph. An interrupted run resumes: existing shards are reused.",
    )
    yield from asked()
    yield from on_fresh(card)
    yield from beside_fit()
    yield from network_before()
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
        f"A quick forecast says *checked by the fit* if importance sampling confirms it. {DRAWS_OF_CHECK}",
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
