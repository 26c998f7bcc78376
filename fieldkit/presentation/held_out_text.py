"""How well a model forecasts flights that its fit did not see, as lines for a flyer."""

from collections.abc import Iterator

import numpy as np

from fieldkit.physics.effect import effects
from fieldkit.quantities import ShownUnits
from fieldkit.services.findings import Compared, Findings


def mean_misses(found: Findings, shown: ShownUnits) -> Iterator[str]:
    """The mean absolute errors of held-out flights, before and after; without a verdict what was looked for, and how
    good the plain model is."""
    if found.diagnosis.effect == "none":
        yield from _plain_model(found, shown)
        return
    for source, compared in _held_out(found):
        before, after = (shown.length(one.score.mae, 1) for one in (compared.before, compared.after))
        yield f"  mean miss {before}, {after} with the verdict; each flight forecast from {source}"


def _held_out(found: Findings) -> Iterator[tuple[str, Compared]]:
    """The errors of held-out flights, with what each was forecast from."""
    both = (("the others", found.left_out), ("earlier ones", found.forward))
    yield from (one for one in both if one[1].before.flights)


def _plain_model(found: Findings, shown: ShownUnits) -> Iterator[str]:
    """The effects that were looked for, and the errors of the plain model."""
    titles = {name: effect.title for name, effect in effects().items()}
    looked_for = dict.fromkeys(titles.get(item.effect, item.effect) for item in found.diagnosis.ranking if item.effect)
    yield f"  looked for: {', '.join(looked_for)}"
    apogee = float(np.nanmean(np.exp(found.diagnosis.data.values[:, 0])[found.diagnosis.data.seen[:, 0]]))
    for source, compared in _held_out(found):
        score, count = compared.before.score, compared.before.flights
        inside = f"{round(score.coverage90 * count)} of {count} inside the 90% interval"
        miss = f"{shown.length(score.mae, 1)} off on average ({score.mae / apogee:.0%})"
        yield f"  without a correction: {miss}, {inside}; each flight forecast from {source}"
