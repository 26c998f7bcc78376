"""Sample exact posteriors, and compare the fit with them: python -m studies.reference_posterior.

`--store FILE` saves the references for the tests. `--cases FILE` uses the histories and the hyperprior of such a file
instead of new ones; `--only NUMBER ...` samples these cases and keeps the others as they are; without a number it keeps
all. `--table FILE` saves the comparison.
"""

import argparse
import sys
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from fieldkit.model.hyperprior import learned
from fieldkit.shapes import Array
from studies.reference_posterior.cases import SEED, cases
from studies.reference_posterior.readouts import linear
from studies.reference_posterior.sampler import FIGURES, Case, fitted, quantiles, sampled, summary_of_fit, target_of
from studies.reference_posterior.summaries import ReferencePosterior, off, read, stored, summarized, write

DRAWS = 40_000
"""Number of draws of the fit's forecast."""


def main(arguments: list[str] | None = None) -> None:
    """Read the command line, sample, print the comparison, save the requested files."""
    parser = argparse.ArgumentParser(description=__doc__)
    for name in ("--store", "--cases", "--table"):
        parser.add_argument(name, type=Path, metavar="FILE")
    parser.add_argument("--only", type=int, nargs="*", metavar="NUMBER", help="some of the cases, from 0")
    asked = parser.parse_args(arguments)
    known = read(asked.cases) if asked.cases else []
    drawn = [(one.name, one.case) for one in known] or [(name, stored(case)) for name, case in cases(learned())]
    found = []
    for number, (name, case) in enumerate(drawn):
        if asked.only is None or number in asked.only:
            found.append(reference(number, name, case))
            sys.stdout.write(f"{name}: R-hat {found[-1].r_hat:.3f}, {found[-1].effective:.0f} effective draws\n")
            sys.stdout.flush()
        elif known:
            found.append(known[number])
    text = "\n".join(table(found)) + "\n"
    sys.stdout.write(text)
    if asked.store:
        write(asked.store, found, {"command": COMMAND, "seed": SEED})
    if asked.table:
        asked.table.write_text(text, encoding="utf-8")


COMMAND = "python -m studies.reference_posterior --cases FILE --store FILE"


def reference(number: int, name: str, case: Case) -> ReferencePosterior:
    """Samples of the exact posterior of a case and of its linear model; the number determines the seed."""
    result = fitted(case)
    readouts = (None, linear(result.model, result.tangent))
    exact, by_linear = (
        sampled(case, result, target_of(case, result, one), np.random.default_rng([SEED, number, turn]))
        for turn, one in enumerate(readouts)
    )
    return summarized(name, case, exact, by_linear, number)


HEAD = (
    "Differences of the 5, 50 and 95% quantiles from the exact posterior's, in percent of its 90% interval, for the\n"
    "log apogee of the next flight, log Cd and log alpha; excess CRPS of the apogee in percent; then the same "
    "differences\nof the linear model with nothing else approximated; split R-hat and effective draws of the "
    "sampler.\n\n"
    f"{'case':52s} {'apogee':>14s} {'log Cd':>14s} {'log alpha':>14s}   CRPS {'apogee':>14s} {'log Cd':>14s}"
    f" {'log alpha':>14s}  R-hat  draws"
)


def table(found: Sequence[ReferencePosterior]) -> list[str]:
    """The current fit compared with stored references: one line per case, and the differences of quantiles over all."""
    by_fit = np.array([off(quantiles(summary_of_fit(one.case, DRAWS, 0)), one.quantiles) for one in found])
    by_linear = np.array([off(one.linear, one.quantiles) for one in found])
    lines = [
        f"{one.name:52s} {_percent(fit)} {100 * one.excess_crps:6.2f} {_percent(line)}  "
        f"{one.r_hat:5.3f} {one.effective:6.0f}"
        for one, fit, line in zip(found, by_fit, by_linear, strict=True)
    ]
    middle, most, worst = np.quantile([one.excess_crps for one in found], (0.5, 0.9, 1.0)) * 100
    score = f"fit, excess CRPS of the apogee: median {middle:.2f}%, 9 in 10 {most:.2f}%, largest {worst:.2f}%"
    return [HEAD, *lines, "", *_summary("fit", by_fit), score, *_summary("linear model, sampled", by_linear)]


def _percent(gap: Array) -> str:
    return " ".join("{:+4.0f} {:+4.0f} {:+4.0f}".format(*(100 * gap[:, i])) for i in range(gap.shape[1]))


def _summary(name: str, gaps: Array) -> list[str]:
    """Median, 90% quantile and maximum difference of each figure over the cases."""
    lines = []
    for i, figure in enumerate(FIGURES):
        ends = np.quantile(np.abs(gaps[..., i]), (0.5, 0.9, 1.0), axis=0).T * 100
        parts = [
            "{}%: {:.1f}, {:.1f}, {:.1f}".format(level, *one) for level, one in zip((5, 50, 95), ends, strict=True)
        ]
        lines.append(f"{name}, {figure}: median, 9 in 10 and largest difference at {'; '.join(parts)}")
    return lines


if __name__ == "__main__":
    main()
