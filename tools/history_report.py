"""Compares the history network with the fit, and writes its page: `python tools/history_report.py`.

`--simulated N` scores both on N new histories from the model, `--bench SETS` on sets of `python -m bench.make`, and
`--ledger LEDGER` forward in time on the flights of a ledger. Each writes only figures into `docs/measured/`. `--network
FOLDER` selects a network other than the shipped one. Without options, `docs/history-network.md` is written from these
figures and the card of the shipped network.
"""

import argparse
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

from fieldkit.inference.history.check import DRAWS as DRAWS_OF_CHECK
from fieldkit.inference.history.check import LEAST_EFFECTIVE
from fieldkit.inference.history.linear_fit import READING_NODES, SCATTER_NODES
from fieldkit.inference.history.simulated_histories import DRAWS_PER_ROCKET
from fieldkit.inference.laplace.importance import MORE_DRAWS, RELIABLE_PARETO_K
from fieldkit.inference.network.ensemble import load_folder, read_card
from fieldkit.inference.network.history import checked, load_history
from fieldkit.model.hyperprior import learned
from fieldkit.plugins import trained_folder
from tools.history_beside_fit import beside_fit, use
from tools.history_measurements import bench, journal, simulated
from tools.markdown import MEASURED, percent, prose, table

REPORT = Path(__file__).parents[1] / "docs" / "history-network.md"
SCALES = len(SCATTER_NODES) * len(READING_NODES)


def report(card: Mapping[str, Any]) -> Iterator[str]:
    """The whole page, line by line."""
    yield "# Evaluation of the history network"
    yield ""
    yield from prose(
        "`fieldkit loop --quick` uses a network that processes a rocket's whole history at once. Its features come",
        "from one linear pass over the model: the evidence for every effect in every place, the odds of every effect",
        "from all sets of at most two, the forecast of the plan, and leave-one-out residuals (score compression:",
        "Alsing, Wandelt and Feeney, Massive optimal data compression and density estimation for scalable,",
        "likelihood-free inference in cosmology, 2018). The network, trained on",
        "simulated histories only, corrects these results. The number of features does not depend on the number of",
        "flights, and one function of an effect's features and the history's features gives the probability of each",
        "effect. Differences of simulations at three drag coefficients give the derivatives, at the middle one those",
        "of effects. This page is written by `python tools/history_report.py`.",
    )
    yield from ("```sh", card["command"], "```", "")
    yield from prose(
        f"{card['simulations']:,} histories of 1 to 60 flights, {DRAWS_PER_ROCKET} of each rocket, were simulated in",
        f"{card['simulation_seconds']:.0f} s;",
        f"with training, in {card['training']['epochs']} epochs, the command took {card['seconds']:.0f} s on one",
        "thread of a busy machine. An interrupted run resumes. The five members are one graph.",
        hyperprior_of(card),
    )
    yield from prose(
        "Histories are drawn from the model of forecasts or, with the hyperprior for effects, from that of the loop:",
        "one to eight motor types, one to three configurations and sites, readouts typed or from samples, with or",
        "without standard deviations, lots, dates, conditions and diameters. Effects are drawn from their priors; drag",
        "that differs between burn and coast and near the speed of sound, a little weathercocking, unnoticed failures,",
        "other standard deviations and patterns that no effect represents go beyond the model.",
    )
    yield from asked()
    yield from on_fresh(card)
    yield from beside_fit()
    yield from use()


def hyperprior_of(card: Mapping[str, Any]) -> str:
    """How the hyperprior of the network's training differs from that of forecasts."""
    trained, current = card["forecast_prior"]["sds"], learned().sds
    new = " and ".join(name.replace(".", " by ").replace("_", " ") for name in current if name not in trained)
    changed = " and ".join(
        name.replace(".", " by ").replace("_", " ") for name, sd in current.items() if trained.get(name, sd) != sd
    )
    without = f", without the variation of {new}" if new else ""
    other = f", with other figures for {changed}" if changed else ""
    about = f"The network was trained with the hyperprior of forecasts ([priors](priors.md)){without}{other}."
    if not without and not other:
        return about
    return f"{about} The linear pass uses the current one, with which it also follows the drift of a fleet."


def asked() -> Iterator[str]:
    """Uses of the network, and the check of its forecasts."""
    yield from ("## Uses", "")
    yield from prose(
        "`loop --quick` gives the probability of every effect. Its odds are the geometric mean of the network's and of",
        "those of all sets of at most two effects in closed form (the logarithmic opinion pool: Genest and Zidek,",
        "Combining Probability Distributions, Statistical Science 1, 1986), because a network knows only",
        "histories like those of its training. `predict --quick` gives the next apogee, Cd and alpha. On",
        "the Add page, Cd, alpha and the next apogee follow each readout as it is typed; flights are simulated again",
        "only if the setup changes. The motor guide forecasts all motors in one batch: the Next page shows these quick",
        "answers, marked ≈, until the fit of each motor replaces them, and `motors --fit ROCKET --quick` prints them.",
        "[Speed](speed.md) compares the run times with the fit's (`python tools/benchmarks.py history`).",
    )
    yield from prose(
        f"A quick forecast says *checked by the fit* if importance sampling confirms it. {DRAWS_OF_CHECK}",
        "draws of log Cd and log alpha come from the network's normal distribution, and the other parameters of the",
        "model from the linear fit given those, with their covariance inflated by 15%. The readouts of each draw are",
        "simulated. Its weight is the prior times the likelihood of the model (multivariate Student t noise for each",
        f"flight, summed over a grid of {SCALES} scales of scatter and reading), divided by the density it was drawn",
        "from. A generalized Pareto distribution is fitted to the largest weights; its shape k",
        f"must be at most {RELIABLE_PARETO_K} (Vehtari, Simpson, Gelman, Yao and Gabry, Pareto smoothed importance",
        f"sampling, Journal of Machine Learning Research 25, 2024), after {MORE_DRAWS} times as many draws if",
        "necessary. The weighted draws are the model's forecast of the plan's apogee. The network's draws of the",
        f"apogee are weighted by that forecast, and their effective fraction must be at least {LEAST_EFFECTIVE}, a",
        "judgment. If either check fails, the fit answers instead, and also if flights show drag and impulse from",
        "logs, which the network does not use. The printed forecast is the network's, without the weights. It does not",
        "include effects accepted in the loop; those of the fit do.",
    )


def _kinds(span: str) -> str:
    """Numbers of readouts in words: `2-3 kinds of readouts`, `one kind of readout` for `1-1`."""
    return "one kind of readout" if span == "1-1" else f"{span} kinds of readouts"


def on_fresh(card: Mapping[str, Any]) -> Iterator[str]:
    """The evaluation in the network's card."""
    for title, key in (("Held-out histories", "test"), ("Motors of Quest, held out of training", "test_held_out")):
        test = card[key]
        yield from (f"## {title}", "")
        yield from prose(
            f"{test['histories']:,} histories. CRPS and errors of the median are relative to the apogee; in",
            "parentheses the result of the linear pass.",
        )
        groups = {"all": test["forecast"]} | {f"{name} flights": x for name, x in test["by_flights"].items()}
        groups |= {_kinds(name): x for name, x in test["by_readouts"].items()}
        yield from table(
            (
                "histories",
                "count",
                "coverage 40%",
                "80%",
                "90%",
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
            f"({p['linear_alpha_mae']:.4f}); in their 90% intervals {percent(p['cd_coverage90'])}",
            f"({percent(p['linear_cd_coverage90'])}) and {percent(p['alpha_coverage90'])}",
            f"({percent(p['linear_alpha_coverage90'])}).",
        )
    yield from ("### Inclusion", "")
    yield from prose(
        "Histories with eight or more flights, from the hyperprior for effects, with strengths from the effects'",
        "priors, many of them too weak to detect. AUC is the probability that a history with the effect gets a higher",
        "probability than one without. The log score is relative to the base rate.",
    )
    yield from table(
        ("", "with it", "without", "AUC", "AUC of the linear evidence", "log score [nat]", "calibration error"),
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
    """Run the requested measurement, or write the page."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--simulated", type=int)
    parser.add_argument("--bench", type=Path)
    parser.add_argument("--loops", type=int, default=0, help="number of sets to search with the loop")
    parser.add_argument("--first", type=int, help="number of sets to use")
    parser.add_argument("--ledger")
    parser.add_argument("--name", default="journal", help="name for the figures of a ledger")
    parser.add_argument("--network", type=Path, help="folder of a network other than the shipped one")
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
