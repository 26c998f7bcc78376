"""The results of a bench as figures: a row per scenario, and the lines that decide."""

from collections import Counter
from collections.abc import Callable, Iterable, Sequence

import numpy as np

from bench.calibration import calibration_lines
from bench.result import WORTH_IT, Errors, Result


def table(results: Sequence[Result]) -> str:
    """A row per scenario and one for all, in Markdown; errors in meters over the future flights."""
    lines = [
        "| scenario | sets | named | right | decidable | right there | before | after | given | ideal "
        "| coverage before | after | said instead |",
        "|---|---|---|---|---|---|---|---|---|---|---|---|---|",
    ]
    for scenario in [*dict.fromkeys(sorted(r.scenario for r in results)), "all"]:
        chosen = [r for r in results if scenario in (r.scenario, "all")]
        lines.append(_row(scenario, chosen, confusions=scenario != "all"))
    return "\n".join(lines)


def _row(scenario: str, results: Sequence[Result], confusions: bool) -> str:
    decidable = [r for r in results if r.decidable]
    said = Counter(r.verdict or "error" for r in results if not r.right).most_common(4) if confusions else []
    cells = [
        scenario,
        str(len(results)),
        _rate(r.named for r in results),
        _rate(r.right for r in results),
        str(len(decidable)),
        _rate(r.right for r in decidable),
        _mean(results, lambda r: r.before.mae if r.before else None),
        _mean(results, lambda r: r.after.mae if r.after else None),
        _mean(results, lambda r: r.given.mae if r.given else None),
        _mean(results, lambda r: r.ideal),
        _coverage([r.before for r in results]),
        _coverage([r.after for r in results]),
        ", ".join(f"{name} {count}" for name, count in said),
    ]
    return f"| {' | '.join(cells)} |"


def _rate(right: Iterable[bool]) -> str:
    values = list(right)
    return f"{100 * sum(values) / len(values):.0f} %" if values else ""


def _mean(results: Sequence[Result], value: Callable[[Result], float | None]) -> str:
    values = [v for r in results if (v := value(r)) is not None]
    return f"{np.mean(values):.1f}" if values else ""


def _coverage(errors: Sequence[Errors | None]) -> str:
    found = [e for e in errors if e]
    return f"{100 * sum(e.covered for e in found) / sum(e.flights for e in found):.0f} %" if found else ""


def summary(results: Sequence[Result]) -> str:
    """The figures that decide: decidable sets, false alarms, part of the possible gain."""
    said = [r for r in results if r.before and r.after]
    effect = [r for r in said if r.label not in ("none", "unexplained")]
    decidable = [r for r in effect if r.decidable]
    nulls = [r for r in said if r.label == "none"]
    lines = [
        f"right verdicts where the fit of the true effect takes away at least {WORTH_IT:.0%} of the error: "
        f"{sum(r.right for r in decidable)} of {len(decidable)}, "
        f"{sum(r.right for r in decidable if '+' not in r.label)} of {sum('+' not in r.label for r in decidable)} "
        "of them with one effect",
        f"false alarms on nulls: {sum(r.verdict != 'none' for r in nulls)} of {len(nulls)}, "
        f"{sum(r.verdict == 'unexplained' for r in nulls)} of them as unexplained",
        f"wrong effect named where nobody's effect was: "
        f"{sum(r.verdict not in ('none', 'unexplained') for r in said if r.label == 'unexplained')} "
        f"of {sum(r.label == 'unexplained' for r in said)}",
    ]
    possible = sum(r.before.mae - r.given.mae for r in decidable if r.before and r.given)
    made = sum(r.before.mae - r.after.mae for r in decidable if r.before and r.after)
    if possible > 0:
        lines.append(f"part of the possible gain made there: {made / possible:.0%}")
    given = [r.after.mae / r.given.mae for r in effect if r.after and r.given]
    if given:
        lines.append(
            f"error after over error with the true effect given: {np.exp(np.mean(np.log(given))):.2f} (geometric)"
        )
    scores = [r.after.interval / r.before.interval for r in said if r.after and r.before]
    if np.isfinite(scores).any():
        lines.append(f"interval score after over before: {np.exp(np.nanmean(np.log(scores))):.2f} (geometric)")
    lines.append(f"sets with an error: {len(results) - len(said)}")
    if said:
        lines.append(f"loop: {np.median([r.seconds for r in said]):.1f} s in the median")
        lines += ["", *calibration_lines(said)]
    return "\n".join(lines)
