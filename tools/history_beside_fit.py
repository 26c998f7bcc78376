"""Tables of the page on the history network: the network and the fit on the same flights."""

from collections.abc import Iterator, Mapping
from typing import Any

from tools.markdown import measured, percent, prose, table

OTHER = "_other"
"""Ends the names of figures of a network that is not shipped."""
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
        yield from ("`python -m bench.make SETS --sets 4 --seed 70707`,", f"`{said['command']}`:", "")
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


def network_before() -> Iterator[str]:
    """The shipped network and the one before it, beside the fit on the same flights."""
    rows = [
        (f"{title}{key}", *(text for one in (now, other) for text in _ratio_and_coverage(one)))
        for name, title in _FORECASTS.items()
        for (key, now), (_, other) in zip(_of_all(name), _of_all(name + OTHER), strict=False)
    ]
    if not rows:
        return
    yield from ("## The network before", "")
    yield from prose(
        "The shipped network is trained on the hyperprior that forecasts are made with (docs/priors.md), and on every",
        "effect file, each with the prior probability that the fit gives it (`fieldkit/selection/prior.py`). The one",
        "before it was trained on an earlier hyperprior, in which altimeters showed speed low as the one open device",
        "does, and on twelve effects, each as probable as any other. Both were measured with the fit of today.",
    )
    columns = ("forecasts", "shipped: CRPS over the fit's", "in 90 %", "before: CRPS over the fit's", "in 90 %")
    yield from table(columns, rows)
    now, other = (measured(f"history_bench{end}") for end in ("", OTHER))
    if now and other:
        yield from prose(
            *(
                f"Inclusion on {one['sets']} sets of the bench, {title}: AUC"
                f" {one['network']['inclusion_auc']:.3f} now and {two['network']['inclusion_auc']:.3f} before, right"
                f" verdicts {percent(one['network']['right'])} and {percent(two['network']['right'])}, false alarms"
                f" {percent(one['network']['false_alarms'])} and {percent(two['network']['false_alarms'])}."
                for key, title in (("all", "all"), ("beside the loop", "those that the loop searched"))
                for one, two in [(now["selection"][key], other["selection"][key])]
            )
        )
    yield from prose(
        "It was exchanged because a program has one hyperprior: `infer`, the page Flights and quick forecasts answer",
        "by what `predict` answers by. It forecasts real flights of the journal and simulated ones from the learned",
        "hyperprior better, and gives no false alarm on the sets without an effect; its intervals on the bench, whose",
        "rockets lack effects more often than the prior has it, hold fewer flights than before, and it finds effects a",
        "little less well, as an effect is less probable to it.",
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
    if name.removesuffix(OTHER) == "simulated":
        for key in ("selection", "forecast"):
            if key in said:
                yield f", {'certified' if key == 'selection' else 'learned'} hyperprior", said[key]["forecast"]["all"]
    elif "forecast" in said:
        yield "", said["forecast"].get("all", said["forecast"])
