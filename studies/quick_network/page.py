"""The page of the ablation, from the saved measurements."""

from collections.abc import Iterator, Mapping
from textwrap import fill
from typing import Any

WIDTH = 118
"""Characters of a line of prose."""
Measured = Mapping[str, Any]
WAYS = ("linear", "linear, calibrated width", "raw", "whole", "fit")
TITLES = {
    "linear": "(a) linear pass, normal",
    "linear, calibrated width": "(b) linear pass, calibrated width",
    "raw": "(c) network without closed forms",
    "whole": "(d) whole network",
    "fit": "fit",
    "closed form": "closed form",
    "closed form, weighted": "closed form, weighted",
    "raw pooled": "(c) pooled with the closed form",
    "whole pooled": "(d) pooled with the closed form",
    "loop": "loop",
}
FLYERS = {
    "journal": "journal",
    "contest": "contest teams",
    "reference": "reference flights",
}


def percent(value: float) -> str:
    return f"{100 * value:.1f}%"


def rows(headers: tuple[str, ...], lines: Iterator[tuple[str, ...]]) -> Iterator[str]:
    yield f"| {' | '.join(headers)} |"
    yield "|" + "---|" * len(headers)
    yield from (f"| {' | '.join(line)} |" for line in lines)
    yield ""


def _prose(text: str, **figures: Any) -> Iterator[str]:
    for paragraph in text.format(**figures).split("\n\n"):
        yield from (fill(" ".join(paragraph.split()), WIDTH), "")


def forecasts(found: Measured) -> Iterator[tuple[str, ...]]:
    """A row for each way: on each set of flights its CRPS, relative to the fit's with the 90% interval of the ratio."""
    sets = [found["held_out"]["forecast"], *(found["real"][key] for key in FLYERS)]
    for way in WAYS:
        yield (TITLES[way], *(_crps(one[way]) if way in one else "" for one in sets))


def _crps(one: Measured) -> str:
    ratio = f"; {one['ratio']:.2f} ({one['ratio90'][0]:.2f} to {one['ratio90'][1]:.2f})" if "ratio90" in one else ""
    return f"{percent(one['crps'])}, {percent(one['coverage90'])}{ratio}"


def probabilities(found: Measured) -> Iterator[tuple[str, ...]]:
    """A row for each way: AUC and log score on effects of held-out histories, of the bench, and on causes."""
    sets = (found["held_out"]["effects"], found["bench"]["effects"], found["held_out"]["causes"])
    for way, title in TITLES.items():
        if any(way in one for one in sets):
            scores = (f"{one[way]['auc']:.3f}, {one[way]['log_score']:.3f}" if way in one else "" for one in sets)
            yield (title, *scores)


CRPS_THAT_PAYS, AUC_THAT_PAYS = 0.02, 0.02
"""Gains for which a network would be shipped: within these an answer counts as good as another. [1]"""


def decision(held_out: Measured, bench: Measured) -> Iterator[str]:
    """What the figures say of the networks, and what follows."""
    forecast, effects, causes = held_out["forecast"], held_out["effects"], held_out["causes"]
    better = 1 - forecast["whole"]["crps"] / forecast["linear, calibrated width"]["crps"]
    gains = {
        "of effects": effects["whole"]["auc"] - effects["closed form"]["auc"],
        "of effects on the bench": bench["effects"]["whole"]["auc"] - bench["effects"]["closed form"]["auc"],
        "of causes": causes["whole"]["auc"] - causes["closed form"]["auc"],
    }
    ships = better > CRPS_THAT_PAYS or max(gains.values()) > AUC_THAT_PAYS
    yield fill(
        f"A network would be shipped for a CRPS {CRPS_THAT_PAYS:.0%} better than that of (b), or an AUC "
        f"{AUC_THAT_PAYS} better than that of the closed form. The whole network has a CRPS {100 * better:.1f}% better "
        "on held-out histories, and AUC "
        + ", ".join(f"{name} {gain:+.3f}" for name, gain in gains.items())
        + f": it {'is' if ships else 'is not'} shipped. Its probabilities have the better log score where the closed "
        "form is too sure.",
        WIDTH,
    )
    yield ""
    behind = bench["effects"]["loop"]["auc"] - bench["effects"]["closed form"]["auc"]
    yield f"On the bench the AUC of the loop is {behind:.3f} higher than the closed form's."
    yield ""


def page(found: Measured) -> Iterator[str]:
    """The page, line by line."""
    held_out, fit, bench = found["held_out"], found["beside_fit"], found["bench"]
    yield "# Why no network gives quick answers"
    yield ""
    yield from _prose(
        TEXT,
        histories=found["training"]["histories"],
        seconds=found["training"]["seconds"],
        device=found["training"]["device"],
        held_out=held_out["histories"],
    )
    yield from decision(held_out, bench)
    flights = (f"{FLYERS[key]} ({found['real'][key]['flights']})" for key in FLYERS)
    yield "## Forecasts"
    yield ""
    yield from _prose(SCORES)
    yield from rows(("", f"held-out histories ({held_out['histories']:,})", *flights), forecasts(found))
    yield from _prose(IN_SAMPLE)
    yield "## Effects and causes"
    yield ""
    yield "AUC and log score [nat]:"
    yield ""
    effects = f"effects of held-out histories ({held_out['effects']['present']})"
    causes = f"causes of single flights ({held_out['causes']['with']:,} of {held_out['causes']['flights']:,})"
    titles = ("", effects, f"effects of the bench, another simulator ({bench['present']})", causes)
    yield from rows(titles, probabilities(found))
    one = fit["causes"]
    yield from _prose(
        POOLING,
        flights=one["flights"],
        present=one["with"],
        loop=one["loop"],
        closed=one["closed form"],
        **{name: ", ".join(f"{x:.2f}" for x in held_out["pooling_weights"][name]) for name in ("raw", "whole")},
    )


TEXT = """[Quick answers](../quick-answers.md) came from a network before. This page is the comparison that retired it,
printed by `python -m tools.quick_network` on commit 58540097, from measurements that it repeats with networks of
`python -m studies.quick_network`; since then the shipped pass has changed. Networks of three layers of attention
over the flights were trained on {histories:,} simulated histories ({seconds} s on {device}). The whole network sees
the closed forms and corrects them; the other sees only flights, simulations and conditions. CRPS and widths are
relative to the flown apogee. Probabilities are judged on {held_out:,} histories that no training used.
"""
IN_SAMPLE = """The shipped hyperprior was learned from the flights of the journal and of the contest teams, so these are
in-sample for the fit and the linear pass. The networks were trained with a prior that no flight has changed; the
whole one has lower scores than (b) in each table, on so few flights that the intervals overlap.
"""
SCORES = """CRPS and flights in the 90% interval; after the semicolon, the CRPS relative to the fit's with a 90%
interval. Real flights are forecast forward in time.
"""
POOLING = """Pooled log odds have weights learned from the other half of the held-out histories (closed form, network,
level): {raw} for (c), {whole} for (d). On {flights:,} flights, {present} with a cause, the AUC of the loop is
{loop:.3f}, that of the closed form {closed:.3f}. [Every figure](quick_network.json).
"""
