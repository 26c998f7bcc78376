"""Tables of the page on the history network: the network and the fit on the same flights."""

from collections.abc import Iterator, Mapping
from typing import Any

from tools.markdown import measured, percent, prose, table

AGAIN = "_again"
"""Ends the names of figures of a network that was trained again and is not shipped."""
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
        "draws each by the prior that the fit has (`fieldkit/selection/prior.py`), from the hyperprior of then, with",
        "forecasts trained mostly on rockets from the learned one. It simulated 27,834 histories of 14,000 rockets in",
        "2331 s and trained in 55 s. The shipped network's figures beside the fit are from the fit, hyperprior and",
        "catalog of that time; devices were taken to show speed low, as the one open device does. A blank elevation,",
        "a heavier recovery and a lot that burns longer came later and are in neither network.",
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
