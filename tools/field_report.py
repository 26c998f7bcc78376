"""Writes `docs/field-ensemble.md` from what was measured: `python tools/field_report.py`.

Reads the card of the shipped ensemble and the files in `docs/measured/`, each of which names the command that made it.
`python tools/field_report.py --journal LEDGER` first counts the warnings about the flights of a ledger, and saves only
the counts in `docs/measured/journal.json`.
"""

import argparse
import json
from collections import Counter
from collections.abc import Iterator
from pathlib import Path

from fieldkit.inference.network import outliers
from fieldkit.inference.network.ensemble import read_card
from fieldkit.inference.network.field_ensemble import load_field
from fieldkit.inference.network.flights import known_flights
from fieldkit.ledger import Ledger
from fieldkit.model.observations import INDEPENDENT_READOUTS, observe
from fieldkit.motors import catalogue
from fieldkit.plugins import trained_folder
from tools.markdown import MEASURED, measured, percent, prose, table

ROOT = Path(__file__).parents[1]
REPORT = ROOT / "docs" / "field-ensemble.md"


def count_warnings(ledger: str) -> None:
    """Save the number of a ledger's flights with a warning."""
    (MEASURED / "journal.json").write_text(json.dumps(_guarded(ledger), indent=2) + "\n", encoding="utf-8")


def _guarded(ledger: str) -> dict:
    with Ledger.open(ledger) as book:
        known = known_flights([flight for flight in book.flights() if flight.clean], catalogue())
    ensemble = load_field()
    observed = observe([flight for flight, _ in known], [motor for _, motor in known])
    which = outliers.misfit(ensemble, observed)
    counts = Counter(INDEPENDENT_READOUTS[number] for number in which if number >= 0)
    return {"flights": len(known), "warned": int((which >= 0).sum()), "by_readout": dict(counts)}


def report(card: dict) -> Iterator[str]:
    """The whole report, line by line."""
    yield "# Evaluation of the field ensemble"
    yield ""
    yield from prose(
        "Five small networks estimate the density of drag area and thrust scale from any set of readouts. They are",
        "trained on simulated flights only. Each figure has the command that printed it; this page is written by",
        "`python tools/field_report.py`.",
    )
    yield "```sh"
    yield card["command"].replace("fieldkit train", "fieldkit train --report")
    yield "```"
    yield ""
    yield from prose(
        f"{card['simulations']:,} flights were simulated in {card['simulation_seconds']:.0f} s; with training, the",
        f"command took {card['seconds']:.0f} s on one thread of a busy machine.",
    )
    yield from fresh(card)
    yield from calibration(card)
    yield from limits(card)
    yield from rivals()
    yield from journal()
    yield from bench()


def fresh(card: dict) -> Iterator[str]:
    titles = {
        "test": "New simulated flights",
        "test_held_out": f"Motors of {card['held_out']}, held out of training",
        "test_peers": "Motors of the same classes in the training set",
    }
    for key, title in titles.items():
        yield f"## {title}"
        yield ""
        rows = []
        for name, one in card[key].items():
            covers = [one["coverage"][parameter].values() for parameter in ("drag_area", "alpha")]
            cover = [" / ".join(f"{100 * one:.1f}" for one in shares) for shares in covers]
            figures = [f"{one['log_density']:.3f}", f"{one['cd_mae']:.4f}", f"{one['alpha_mae']:.4f}"]
            rows.append([name, *figures, *cover, percent(one["false_alarms"], 2)])
        headers = ["readouts", "log density", "MAE Cd", "MAE alpha", "coverage 50/80/90/95%: drag area", "alpha"]
        yield from table([*headers, "warned"], rows)
    worst = max(
        abs(covered - float(level))
        for one in card["test"].values()
        for parameter in one["coverage"].values()
        for level, covered in parameter.items()
    )
    yield f"The largest error of a coverage on new flights is {100 * worst:.1f} percentage points."
    yield ""
    both = card["test_held_out"], card["test_peers"]
    ratios = {name: one["cd_mae"] / both[1][name]["cd_mae"] - 1 for name, one in both[0].items()}
    changes = "; ".join(f"{name} {100 * ratio:+.1f}%" for name, ratio in ratios.items())
    yield from prose(f"Error of Cd on the held-out motors, relative to the same classes in training: {changes}.")


def calibration(card: dict) -> Iterator[str]:
    yield "## Calibration: ranks and expected coverage"
    yield ""
    yield from prose(
        "Ranks of the truth in its posterior (simulation-based calibration, 20 bins) are uniform if the posterior is",
        "right; the table has the fullest and the emptiest bin relative to a uniform one. The last columns are the",
        "fraction of flights whose truth is among the 10, 50 and 90% of the posterior nearest to a random point",
        "(TARP).",
    )
    rows = []
    for name, one in card["test"].items():
        ranks = [
            f"{100 * one['ranks'][p]['excess']:+.0f}% / {100 * one['ranks'][p]['lack']:+.0f}%"
            for p in ("drag_area", "alpha")
        ]
        curve = dict(zip(one["expected_coverage"]["at"], one["expected_coverage"]["covered"], strict=True))
        rows.append([name, *ranks, *(percent(curve[at]) for at in (0.1, 0.5, 0.9))])
    yield from table(["readouts", "ranks of drag area", "of alpha", "10%", "50%", "90%"], rows)


def limits(card: dict) -> Iterator[str]:
    yield "## Against exact posteriors"
    yield ""
    yield from prose(
        "An ensemble of the same kind is trained on a problem with a known posterior (from a grid): the rocket, prior",
        "and simulator of [the reference paper](reference-study.md), with noise of 3 m, 1 m/s, 3% and 0.1 s, on 500",
        "flights. In the rows *burn uncertain* the burn time varies by 5% (log-normal, at the same impulse).",
    )
    rows = []
    for key, title in (("restricted", ""), ("restricted_burn_uncertain", "burn uncertain: ")):
        for name, one in card.get(key, {}).items():
            cd, alpha = (f"{one[f'{p}_mae']:.4f} / {one[f'{p}_mae_exact']:.4f}" for p in ("cd", "alpha"))
            rows.append([title + name, cd, alpha, f"{one['kl']:.3f}"])
    yield from table(["readouts", "MAE Cd / exact", "MAE alpha / exact", "KL [nat]"], rows)
    for name, title in (("exact", "new flights"), ("exact_held_out", f"motors of {card['held_out']}")):
        found = measured(name)
        if found is None:
            continue
        option = " --held-out" if found["held_out"] else ""
        yield from prose(
            f"The full problem, with all random inputs of a simulated flight integrated out, {title}:",
            f"`python tools/exact_posterior.py OUT --flights N{option} --draws {found['draws']}`. KL is the mean",
            "difference of the log densities of the truth. Flights with fewer than 50 effective draws in the integral",
            "are left out.",
        )
        rows = []
        for key, one in found.items():
            if key == "integrals" or not isinstance(one, dict):
                continue
            pairs = [
                f"{one[p]:.4f} / {one[f'{p}_exact']:.4f} ({100 * one[f'{p}_above_limit']:+.1f} ± "
                f"{100 * one[f'{p}_above_limit_se']:.1f}%)"
                for p in ("cd", "alpha")
            ]
            count, gap = f"{one['flights']} ({one['not_found']})", f"{one['kl']:.2f} ± {one['kl_se']:.2f}"
            rows.append([key, count, *pairs, gap])
        yield from table(["readouts", "flights (left out)", "MAE Cd / exact", "MAE alpha / exact", "KL [nat]"], rows)


def rivals() -> Iterator[str]:
    found = measured("rivals")
    if found is None:
        return
    yield "## Against other estimators on the same flights"
    yield ""
    made = {name: one["made_with"] for name, one in found["rivals"].items()}
    packages = {name: value for one in made.values() for name, value in one.items()}
    by = ", ".join(f"{name} {value}" for name, value in packages.items())
    yield from prose(
        f"`python tools/rivals.py OUT --flights 20000`: {found['flights']:,} flights, log density of",
        f"{found['judged']:,} new ones; with {by}. `sbi` is NPE with default settings,",
        "`zuko` a neural spline flow in the ensemble's training loop, `mixture` the ensemble's five members at this",
        "size, and `shipped` the ensemble trained on a million flights. Seconds are processor time of training.",
    )
    names = list(found["shipped"])
    sbi = found["rivals"]["sbi"]["seconds"]
    rows = []
    for name, one in found["rivals"].items():
        cells = (f"{one['log_density'][key]:.3f}" for key in names)
        rows.append([name, *cells, f"{one['epochs']}", f"{one['seconds']:.0f}", f"{one['seconds'] / sbi:.2f}"])
    rows.append(["shipped", *(f"{found['shipped'][key]:.3f}" for key in names), "", "", ""])
    yield from table(["estimator", *names, "epochs", "seconds", "relative to sbi"], rows)


def journal() -> Iterator[str]:
    """The warnings of the guard on real flights."""
    found = measured("journal")
    if found is None:
        return
    which = ", ".join(f"{name.replace('_', ' ')} {count}" for name, count in found["by_readout"].items())
    yield "## Warnings on real flights"
    yield ""
    yield from prose(
        "In a public journal of AltimeterTwo readouts (jdsmith39/RocketLaunchJournal, without weather and diameters),",
        f"{found['warned']} of {found['flights']} clean flights get a warning about a readout ({which}). [The",
        "journal](journal.md) has the forecasts of these flights.",
    )


def bench() -> Iterator[str]:
    path = MEASURED / "bench_forward.txt"
    if not path.exists():
        return
    yield "## Corrected intervals if the model is wrong"
    yield ""
    yield from prose(
        "Histories with a hidden effect, each flight forecast from the earlier ones by the plain model. The last",
        "columns are the coverage of 90% intervals from the 21st forecast on, before and after [the",
        "correction](statistics.md#corrected-intervals); *corrected* is the number of these forecasts. `python -m",
        "bench.make SETS --sets 1 --seed 77`, `python -m bench.forward SETS --limit 9`:",
    )
    yield "```"
    yield path.read_text(encoding="utf-8").rstrip()
    yield "```"


def main() -> None:
    """Count the warnings about a ledger if requested, and write the report."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--journal", default=None, help="a ledger with the journal's flights")
    options = parser.parse_args()
    MEASURED.mkdir(exist_ok=True)
    if options.journal:
        count_warnings(options.journal)
    text = "\n".join(report(dict(read_card(trained_folder("field"))))).rstrip() + "\n"
    REPORT.write_text(text, encoding="utf-8")
    print(f"{REPORT}: {len(text.splitlines())} lines")


if __name__ == "__main__":
    main()
