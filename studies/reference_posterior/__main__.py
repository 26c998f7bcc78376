"""Sample the exact posteriors of the cases, and compare the fit with them: python -m studies.reference_posterior.

`--store FILE` keeps the references for the tests; `--table FILE` writes the comparison.
"""

import argparse
import sys
import time
from pathlib import Path

import numpy as np

from fieldkit.model.hyperprior import learned
from fieldkit.shapes import Array
from studies.reference_posterior.cases import SEED, cases
from studies.reference_posterior.sampler import FIGURES, fitted, next_flight, quantiles, said_by_fit, sampled, target_of
from studies.reference_posterior.summaries import excess_crps, off, stored, summarized, write
from studies.reference_posterior.target import linear


def main(arguments: list[str] | None = None) -> None:
    """Read the command line, sample, print a line a case, keep what is asked for."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--store", type=Path, metavar="FILE")
    parser.add_argument("--table", type=Path, metavar="FILE")
    parser.add_argument("--only", type=int, nargs="*", metavar="NUMBER", help="some of the cases, from 0")
    asked = parser.parse_args(arguments)
    lines, kept, gaps, steps, crps = [HEAD], [], [], [], []
    sys.stdout.write(HEAD + "\n")
    for number, (name, drawn) in enumerate(cases(learned())):
        if asked.only is not None and number not in asked.only:
            continue
        begun, case = time.perf_counter(), stored(drawn)
        result = fitted(case)
        by_linear = target_of(case, result, linear(result.model, result.tangent))
        found = [
            sampled(case, result, density, np.random.default_rng([SEED, number, turn]))
            for turn, density in enumerate((target_of(case, result), by_linear))
        ]
        reference = summarized(name, case, found[0], found[1], number)
        said = said_by_fit(case, len(found[0].terms), number)
        gaps.append(off(quantiles(said), reference.quantiles))
        steps.append(off(reference.linear, reference.quantiles))
        exact = next_flight(case, found[0].terms, found[0].scales, number)
        crps.append(excess_crps(np.exp(said[:, 0]), np.exp(exact[:, 0])))
        kept.append(reference)
        seconds = time.perf_counter() - begun
        lines.append(
            f"{name:58s} {_percent(gaps[-1])} {100 * crps[-1]:6.2f} {_percent(steps[-1])}  "
            f"{reference.r_hat:5.3f} {reference.effective:6.0f} {found[0].acceptance:4.2f}"
        )
        sys.stdout.write(f"{lines[-1]} {seconds:5.0f} s\n")
        sys.stdout.flush()
    lines += ["", *_summary("fit", np.abs(gaps), crps), *_summary("linear model, sampled", np.abs(steps), [])]
    sys.stdout.write("\n".join(lines[len(kept) + 1 :]) + "\n")
    if asked.store:
        write(asked.store, kept, {"command": "python -m studies.reference_posterior --store FILE", "seed": SEED})
    if asked.table:
        asked.table.write_text("\n".join(lines) + "\n", encoding="utf-8")


HEAD = (
    "Differences of the 5, 50 and 95 % quantiles from the exact posterior's, in percent of its 90 % interval, for the\n"
    "log apogee of the next flight, log Cd and log alpha; excess CRPS of the apogee in percent; then the same "
    "differences\nof the linear model with nothing else approximated; split R-hat, effective draws and acceptance of "
    "the sampler.\n\n"
    f"{'case':58s} {'apogee':>14s} {'log Cd':>14s} {'log alpha':>14s}   CRPS {'apogee':>14s} {'log Cd':>14s}"
    f" {'log alpha':>14s}  R-hat  draws  acc"
)


def _percent(gap: Array) -> str:
    return " ".join("{:+4.0f} {:+4.0f} {:+4.0f}".format(*(100 * gap[:, i])) for i in range(gap.shape[1]))


def _summary(name: str, gaps: Array, crps: list[float]) -> list[str]:
    """Median, nine tenths and largest difference of each figure over the cases, and of the CRPS."""
    lines = []
    for i, figure in enumerate(FIGURES):
        low, middle, high = np.quantile(gaps[..., i], (0.5, 0.9, 1.0), axis=0).T * 100
        ends = "; ".join(
            f"{level} %: {one[0]:.1f}, {one[1]:.1f}, {one[2]:.1f}"
            for level, one in zip((5, 50, 95), (low, middle, high), strict=True)
        )
        lines.append(f"{name}, {figure}: median, 9 in 10, largest difference at {ends}")
    if crps:
        middle, most, worst = np.quantile(crps, (0.5, 0.9, 1.0)) * 100
        lines.append(
            f"{name}, excess CRPS of the apogee: median {middle:.2f} %, 9 in 10 {most:.2f} %, largest {worst:.2f} %"
        )
    return lines


if __name__ == "__main__":
    main()
