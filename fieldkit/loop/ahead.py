"""The choice made forward in time: each flight forecast by the model that the flights before it would have chosen.

At every flight the evidence, the flights left out and the rules of the choice are taken anew from the earlier
flights alone. Some things are not repeated, for the time it would take: the point about which readouts are taken as
linear is that of the whole history, places that all flights together make hopeless are not tried, nor second effects.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from fieldkit.loop.choice import ODDS, Ranked, choose, choose_in_folds, rank, stands
from fieldkit.loop.diagnose import Diagnosis
from fieldkit.loop.left_out import leave_one_out
from fieldkit.loop.model import Data
from fieldkit.loop.posterior import Growing
from fieldkit.loop.score import Forecasts, forecasts_of, score
from fieldkit.loop.trial import Trial, by_effect
from fieldkit.shapes import Array, Flags

FEWEST = 4
"""Earlier clean flights from which on a choice is made."""
NEGLIGIBLE = 3.0
"""Log odds below which a place beside the best one, or an effect, is not looked at further. [nat]"""


@dataclass(frozen=True, slots=True)
class Ahead:
    """Every flight forecast from those before it, by the plain model and by the one they would have chosen.

    `seen` marks the flights that have `FEWEST` before them, `chosen` names the effect at each, empty for none.
    """

    before: Forecasts
    after: Forecasts
    seen: Flags
    chosen: tuple[str, ...]


def ahead(diagnosis: Diagnosis, tell: Callable[[str, float], None] | None = None) -> Ahead:
    """Forecasts of a diagnosed history forward in time."""
    teach = diagnosis.data.seen[:, 0]
    count = len(teach)
    known = np.concatenate([[0], np.cumsum(teach)[:-1]])
    judged = teach & (known >= FEWEST)
    past = _Past(diagnosis)
    rows = []
    for flight in range(count):
        if tell:
            tell("forward in time", flight / count)
        rows.append(past.said_of(flight) if judged[flight] else (_nothing(), _nothing(), ""))
    before, after, chosen = zip(*rows, strict=True) if rows else ((), (), ())
    return Ahead(_joined(before), _joined(after), judged, chosen)


def _nothing() -> Forecasts:
    return Forecasts(np.zeros((1, 1)), np.ones((1, 1)), np.ones((1, 1)))


class _Past:
    """Everything that was tried on a history, as it stood at each of its flights."""

    def __init__(self, diagnosis: Diagnosis) -> None:
        self._data, self._plain = diagnosis.data, diagnosis.base
        self._base = Growing(diagnosis.base.fit)
        self._trials = [(trial.candidate, Growing(trial.fit)) for item in diagnosis.ranking for trial in item.trials]

    def said_of(self, flight: int) -> tuple[Forecasts, Forecasts, str]:
        """What was to be said of a flight when it had not flown, without and with an effect, and which."""
        data = _known(self._data, flight)
        truth, seen = data.values[:, 0], data.seen[:, 0]
        fitted = self._base.before(flight, data)
        base = Trial(self._plain.candidate, fitted, leave_one_out(fitted))
        plain = forecasts_of(base.left_out)
        ranking = rank(self._tried(base, data, flight), base, truth, seen)
        chosen = choose(ranking)
        if chosen is None or not _stands(chosen, ranking, plain, truth, seen):
            return _last(plain), _last(plain), ""
        return _last(plain), _last(chosen.forecasts), chosen.effect

    def _tried(self, base: Trial, data: Data, flight: int) -> list[Trial]:
        """The trials on the flights before; what is hopeless gets the plain forecasts, and so helps nothing."""
        seen = data.seen[:flight, 0]
        acting = [
            (candidate, growing.before(flight, data))
            for candidate, growing in self._trials
            if any(term.weight[:flight][seen].any() for term in candidate.terms)
        ]
        families = by_effect([candidate for candidate, _ in acting])
        weight = {
            id(candidate): fitted.log_evidence + candidate.log_share - base.log_evidence for candidate, fitted in acting
        }
        best = {name: max(weight[id(candidate)] for candidate in family) for name, family in families.items()}
        least = float(np.log(max(len(families), 1) / ODDS)) - NEGLIGIBLE
        possible = np.logaddexp.reduce(list(weight.values())) > least
        found = []
        for candidate, fitted in acting:
            top = best[candidate.effect]
            if weight[id(candidate)] < top - NEGLIGIBLE:
                continue
            worth = possible and top > least
            found.append(Trial(candidate, fitted, leave_one_out(fitted) if worth else base.left_out))
        return found


def _stands(chosen: Ranked, ranking: Sequence[Ranked], plain: Forecasts, truth: Array, seen: Flags) -> bool:
    """Whether it is an effect, and the whole choice, made anew in every fold, forecasts well enough."""
    after, before = (score(forecasts, truth, seen) for forecasts in (choose_in_folds(ranking, plain), plain))
    return bool(chosen.effect) and stands(chosen, after, before)


def _known(data: Data, flight: int) -> Data:
    """What was known before a flight: the readouts of those before it."""
    upto = slice(flight + 1)
    seen = data.seen[upto].copy()
    seen[-1] = False
    return Data(np.where(seen, data.values[upto], 0.0), np.where(seen, data.sd[upto], 1.0), seen, data.trust[upto])


def _last(forecasts: Forecasts) -> Forecasts:
    last = slice(-1, None)
    return Forecasts(forecasts.mean[:, last], forecasts.sd[:, last], forecasts.weight[:, last])


def _joined(parts: Sequence[Forecasts]) -> Forecasts:
    """Forecasts of one flight each, side by side."""
    longest = max(len(part.mean) for part in parts)

    def column(name: str, fill: float) -> Array:
        columns = [getattr(part, name)[:, 0] for part in parts]
        return np.stack([np.pad(c, (0, longest - len(c)), constant_values=fill) for c in columns], axis=1)

    return Forecasts(column("mean", 0.0), column("sd", 1.0), column("weight", 0.0))
