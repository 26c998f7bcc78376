"""The results of a bench as figures: a row per scenario, and a summary."""

from collections import Counter
from collections.abc import Callable, Iterable, Iterator, Sequence
from math import exp, pi, sqrt

import numpy as np

from bench.calibration import calibration_lines
from bench.result import NOT_NAMES, WORTH_IT, Errors, Result

NORMAL_90 = 1.6448536
"""Half width of the central 90% interval of a normal distribution, in standard deviations. [1]"""
IDEAL_INTERVAL = 40 * exp(-(NORMAL_90**2) / 2) / sqrt(2 * pi) / sqrt(2 / pi)
"""Ratio of the expected score of the 90% interval to the mean absolute error for a known normal distribution. [1]"""
SURE = (0.7, 0.8)
"""Probabilities at which names are counted. [1]"""
WORSE = 1.05
"""A forecast counts as worse than the plain model's if the ratio of their errors is above this. [1]"""


def table(results: Sequence[Result]) -> str:
    """A row per scenario and one for all, in Markdown; errors on the later flights [m]."""
    lines = [
        "| scenario | sets | named | right | decidable | right if decidable | before | after | given | ideal "
        "| coverage before | after | other verdicts |",
        "|---|---|---|---|---|---|---|---|---|---|---|---|---|",
    ]
    for scenario in [*dict.fromkeys(sorted(r.scenario for r in results)), "all"]:
        chosen = [r for r in results if scenario in (r.scenario, "all")]
        lines.append(_row(scenario, chosen, confusions=scenario != "all"))
    return "\n".join(lines)


def _row(scenario: str, results: Sequence[Result], confusions: bool) -> str:
    decidable = [r for r in results if r.decidable]
    others = Counter(r.verdict or "error" for r in results if not r.right).most_common(4) if confusions else []
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
        ", ".join(f"{name} {count}" for name, count in others),
    ]
    return f"| {' | '.join(cells)} |"


def _rate(right: Iterable[bool]) -> str:
    values = list(right)
    return f"{100 * sum(values) / len(values):.0f}%" if values else ""


def _mean(results: Sequence[Result], value: Callable[[Result], float | None]) -> str:
    values = [v for r in results if (v := value(r)) is not None]
    return f"{np.mean(values):.1f}" if values else ""


def _coverage(errors: Sequence[Errors | None]) -> str:
    found = [e for e in errors if e]
    return f"{100 * sum(e.covered for e in found) / sum(e.flights for e in found):.0f}%" if found else ""


def summary(results: Sequence[Result]) -> str:
    """The summary figures: decidable sets, false alarms, fraction of the possible gain."""
    answered = [r for r in results if not r.error]
    effect = [r for r in answered if r.label not in ("none", "unexplained")]
    decidable = [r for r in effect if r.decidable]
    nulls = [r for r in answered if r.label == "none"]
    parts = [(name in r.found) for r in effect for name in r.needed]
    lines = [
        f"right verdicts if the fit with the true effect removes at least {WORTH_IT:.0%} of the error: "
        f"{sum(r.right for r in decidable)} of {len(decidable)}, "
        f"{sum(r.right for r in decidable if '+' not in r.label)} of {sum('+' not in r.label for r in decidable)} "
        "of them with one effect",
        f"effects named if the fit with all of a history's effects removes as much of the error without this one: "
        f"{sum(parts)} of {len(parts)}",
        f"false alarms on nulls: {sum(r.verdict != 'none' for r in nulls)} of {len(nulls)}, "
        f"{sum(r.verdict == 'unexplained' for r in nulls)} of them as unexplained",
        *(_names(answered, level) for level in SURE),
        f"wrong effect named for an unknown one: "
        f"{sum(r.verdict not in ('none', 'unexplained') for r in answered if r.label == 'unexplained')} "
        f"of {sum(r.label == 'unexplained' for r in answered)}",
        f"pairs named in full: {sum(r.named for r in answered if '+' in r.label)} "
        f"of {sum('+' in r.label for r in answered)}",
    ]
    possible = sum(r.before.mae - r.given.mae for r in decidable if r.before and r.given)
    made = sum(r.before.mae - r.after.mae for r in decidable if r.before and r.after)
    if possible > 0:
        lines.append(f"fraction of the possible gain in these: {made / possible:.0%}")
    lines += _forecasts(answered)
    lines.append(f"sets with an error: {len(results) - len(answered)}")
    if answered:
        lines.append(f"loop: {np.median([r.seconds for r in answered]):.1f} s in the median")
        lines += ["", *calibration_lines(answered)]
    return "\n".join(lines)


def _names(results: Sequence[Result], level: float) -> str:
    """How many histories get a name at a probability, and how many of these have a false one."""
    named = [one for one in results if one.confidence >= level and one.verdict not in NOT_NAMES]
    false = sum(bool(one.false) for one in named)
    return (
        f"named at {level:.0%} or more: {len(named)} of {len(results)} histories, "
        f"{false} with an effect that is not there at half its stated size ({false / max(len(results), 1):.1%})"
    )


def _forecasts(results: Sequence[Result]) -> Iterator[str]:
    """Forecasts after the loop compared with the plain model's, with the truth given, and with the ideal."""
    kinds = list(dict.fromkeys(sorted(r.scenario for r in results)))
    ratios = {
        k: _geometric(r.after.mae / r.given.mae for r in results if r.scenario == k and r.after and r.given)
        for k in kinds
    }
    ratios = {kind: ratio for kind, ratio in ratios.items() if np.isfinite(ratio)}
    if ratios:
        every = _geometric(r.after.mae / r.given.mae for r in results if r.after and r.given)
        worst = max(ratios, key=lambda kind: ratios[kind])
        yield (
            f"error after relative to the fit with the true effect: {every:.2f} (geometric mean), "
            f"highest {ratios[worst]:.2f} ({worst})"
        )
    pairs = [(r.before, r.after, r.ideal) for r in results if r.before and r.after]
    yield (
        f"error after more than {WORSE - 1:.0%} above that without a correction: "
        f"{sum(after.mae > WORSE * before.mae for before, after, _ in pairs)} of {len(pairs)}"
    )
    held = {k: [r.after for r in results if r.scenario == k and r.after] for k in kinds}
    coverage = {k: sum(e.covered for e in own) / sum(e.flights for e in own) for k, own in held.items() if own}
    if coverage:
        low, high = min(coverage, key=lambda kind: coverage[kind]), max(coverage.values())
        yield f"coverage after by scenario: {coverage[low]:.0%} ({low}) to {high:.0%}"
    if np.isfinite([after.interval for _, after, _ in pairs]).any():
        before = _geometric(after.interval / before.interval for before, after, _ in pairs)
        ideal = _geometric(after.interval / (IDEAL_INTERVAL * own) for _, after, own in pairs)
        yield f"interval score after relative to before: {before:.2f}, to the ideal: {ideal:.2f} (geometric mean)"
        error = _geometric(after.mae / own for _, after, own in pairs)
        yield f"of that from the error after relative to the ideal: {error:.2f}, from intervals: {ideal / error:.2f}"


def _geometric(values: Iterable[float]) -> float:
    """The geometric mean of the finite values; nan if there are none."""
    found = np.array(list(values))
    found = found[np.isfinite(found)]
    return float(np.exp(np.log(found).mean())) if len(found) else float("nan")
