"""Tables of the page on the history network: the network and the fit on the same flights."""

from collections.abc import Iterator, Mapping
from typing import Any

from tools.history_opinions import WORLDS, compared
from tools.markdown import measured, percent, prose, table

FORECAST_COLUMNS = (
    "",
    "flights",
    "CRPS: network",
    "fit",
    "ratio (90%)",
    "median error: network",
    "fit",
    "in 90%: network",
    "fit",
)


def forecast_row(name: str, one: Mapping[str, Any]) -> tuple[str, ...]:
    """A row with the network and the fit on the same flights."""
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
    yield from ("## Comparison with the fit", "")
    yield from prose(
        "The fit is that of `predict`, the loop is `loop`; the network answers for the same flights in the same run."
    )
    if measurements := measured("history_simulated"):
        yield from (f"`{measurements['command']}`", "")
        worlds = {"selection": "certified hyperprior", "forecast": "learned hyperprior"}
        rows = [
            forecast_row(f"{title}, {name}", one)
            for key, title in worlds.items()
            for name, one in measurements.get(key, {}).get("forecast", {}).items()
        ]
        yield from table(FORECAST_COLUMNS, rows)
        for key, title in worlds.items():
            if one := measurements.get(key):
                yield from prose(
                    f"{title.capitalize()}: mean absolute error of Cd {one['network_cd_mae']:.3f} (fit",
                    f"{one['fit_cd_mae']:.3f}), of alpha {one['network_alpha_mae']:.4f}",
                    f"(fit {one['fit_alpha_mae']:.4f}).",
                )
    if measurements := measured("history_bench"):
        yield from ("`python -m bench.make SETS --sets 4 --seed 261126`,", f"`{measurements['command']}`:", "")
        yield from table(FORECAST_COLUMNS, [forecast_row("bench, later flights", measurements["forecast"])])
        yield from table(
            (
                "",
                "sets",
                "AUC of inclusion",
                "AUC of none",
                "verdict right",
                "most likely effect is present",
                "false alarms",
                "seconds per set",
            ),
            (
                (
                    f"{'loop' if way == 'fit' else 'network'}, {'all sets' if name == 'all' else 'the same sets'}",
                    f"{one['sets']}",
                    *(f"{one[way][key]:.3f}" for key in ("inclusion_auc", "none_auc")),
                    *(percent(one[way][key]) for key in ("right", "likeliest_is_there", "false_alarms")),
                    f"{one[way]['seconds']:.2f}",
                )
                for name, one in measurements["selection"].items()
                for way in ("network", "fit")
                if way in one
            ),
        )
    found = {world: (measured(f"history_{world}") or {}).get("opinions") for world in WORLDS}
    yield from prose("The probabilities of `loop --quick`, pooled, and those of which they are pooled:")
    yield from compared({world: one for world, one in found.items() if one})
    for name, title in (("journal", "The public journal"), ("reference", "The reference flights")):
        if measurements := measured(f"history_{name}"):
            yield from (f"{title}, forward in time, `{measurements['command']}`:", "")
            yield from table(
                FORECAST_COLUMNS, [forecast_row(key, one) for key, one in measurements["forecast"].items()]
            )


GOALS = {"ratio": 1.02, "auc": 0.02, "coverage": (0.87, 0.93)}
"""Requirements for a network to replace the fit: its CRPS relative to the fit's, the AUC below the loop's, and the
fraction of flights in its 90% interval. [1]"""


def use() -> Iterator[str]:
    """Whether the network is as good as the fit, and what it is used for."""
    yield from ("## Quick answers only", "")
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
        f"To replace the fit, the network would need a CRPS of at most {GOALS['ratio']:.2f} times the fit's and",
        f"{low:.0%} to {high:.0%} of flights in its 90% interval:",
    )
    yield from table(("forecasts", "CRPS relative to the fit", "in 90%", "reached"), lines)
    measurements = measured("history_bench")
    both = (measurements or {}).get("selection", {}).get("beside the loop", {})
    if "fit" in both:
        behind = both["fit"]["inclusion_auc"] - both["network"]["inclusion_auc"]
        reached = "is" if behind <= GOALS["auc"] else "is not"
        yield from prose(
            f"The AUC of inclusion {reached} within {GOALS['auc']:.2f} of the loop's",
            f"({-behind:+.3f} on {both['sets']} sets).",
        )
    yield from prose(
        "Until it meets all of these on the bench and on public flights, it gives only quick answers. `loop` and",
        "`predict` search and fit, and the ledger saves their results.",
    )


_FORECASTS = {
    "simulated": "simulated",
    "bench": "bench, later flights",
    "journal": "public journal",
    "reference": "reference flights",
}


def _of_all(name: str) -> Iterator[tuple[str, Mapping[str, Any]]]:
    """The forecasts of a measurement, all together."""
    measurements = measured(f"history_{name}") or {}
    if name == "simulated":
        for key in ("selection", "forecast"):
            if key in measurements:
                yield (
                    f", {'certified' if key == 'selection' else 'learned'} hyperprior",
                    measurements[key]["forecast"]["all"],
                )
    elif "forecast" in measurements:
        yield "", measurements["forecast"].get("all", measurements["forecast"])
