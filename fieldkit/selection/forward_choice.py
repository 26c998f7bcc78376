"""The choice made forward in time: each flight forecast by the model that the flights before it would have chosen.

At every flight the evidence, the flights left out and the rules of the choice are taken anew from the earlier flights
alone, second effects beside first ones included. Some things are not repeated, for the time it would take: the point
about which readouts are taken as linear is that of the whole history; what all flights together make hopeless is
not tried: places, and second effects beside a first one that is none of the likeliest; nor is a third effect.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from fieldkit.inference.laplace.leave_one_out import leave_one_out
from fieldkit.inference.laplace.posterior import Fit, Growing
from fieldkit.model.readout_data import Data
from fieldkit.progress import ReportProgress, no_op
from fieldkit.scoring.score import Forecasts, forecasts_of, score
from fieldkit.selection.candidates import Candidate
from fieldkit.selection.choice import ODDS, Ranked, choose, choose_in_folds, rank, stands
from fieldkit.selection.diagnose import MIN_LOG_ODDS_TO_NAME, Diagnosis, likely_firsts
from fieldkit.selection.trial import Trial, by_effect
from fieldkit.shapes import Array, Flags

MIN_EARLIER_FLIGHTS = 4
"""Earlier clean flights from which on effects are chosen. [1]"""
MAX_LOG_ODDS_BEHIND = 3.0
"""Log odds behind the best beyond which a level, or an effect, is not followed further. [nat]"""


@dataclass(frozen=True, slots=True)
class Ahead:
    """Every flight forecast from those before it, by the plain model and by the one they would have chosen.

    `seen` marks the flights that have `MIN_EARLIER_FLIGHTS` before them, `chosen` names the effect at each, empty for
    none.
    """

    before: Forecasts
    after: Forecasts
    seen: Flags
    chosen: tuple[str, ...]


def ahead(diagnosis: Diagnosis, on_progress: ReportProgress = no_op) -> Ahead:
    """Forecasts of a diagnosed history forward in time."""
    teach = diagnosis.data.seen[:, 0]
    count = len(teach)
    known = np.concatenate([[0], np.cumsum(teach)[:-1]])
    judged = teach & (known >= MIN_EARLIER_FLIGHTS)
    past = _Past(diagnosis)
    rows = []
    for flight in range(count):
        on_progress("forward in time", flight / count)
        rows.append(past.said_of(flight) if judged[flight] else (_nothing(), _nothing(), ""))
    before, after, chosen = zip(*rows, strict=True) if rows else ((), (), ())
    return Ahead(_joined(before), _joined(after), judged, chosen)


def _nothing() -> Forecasts:
    return Forecasts(np.zeros((1, 1)), np.ones((1, 1)), np.ones((1, 1)))


class _Tried:
    """A model and what was tried beside it, as they stood at each flight."""

    def __init__(self, base: Trial, ranking: Sequence[Ranked], hopeless: float = -np.inf) -> None:
        kept = [item for item in ranking if item.own_weight > hopeless]
        self._plain, self._base = base.candidate, Growing(base.fit)
        self._trials = [(trial.candidate, Growing(trial.fit)) for item in kept for trial in item.trials]
        self._among = sum(1 for item in ranking if item.effect) if len(kept) < len(ranking) else 0

    def __bool__(self) -> bool:
        return bool(self._trials)

    def at(self, data: Data, beside: Ranked | None = None) -> tuple[Trial, tuple[Ranked, ...]]:
        """The model and the ranking of what was tried, by the flights before the last of `data`."""
        flight = len(data.seen) - 1
        fitted = self._base.before(flight, data)
        base = Trial(self._plain, fitted, leave_one_out(fitted))
        seen = data.seen[:flight, 0]
        acting = [
            (candidate, growing.before(flight, data))
            for candidate, growing in self._trials
            if any(term.weight[:flight][seen].any() for term in candidate.terms)
        ]
        truth, taught = data.values[:, 0], data.seen[:, 0]
        return base, rank(_worth_a_look(acting, base), base, truth, taught, beside, self._among)


class _Past:
    """Everything that was tried on a history, as it stood at each of its flights."""

    def __init__(self, diagnosis: Diagnosis) -> None:
        self._data, self._singles = diagnosis.data, _Tried(diagnosis.base, diagnosis.ranking)
        beside = {one.first.effect: _Tried(one.base, one.ranking, MIN_LOG_ODDS_TO_NAME) for one in diagnosis.seconds}
        self._beside = {effect: tried for effect, tried in beside.items() if tried}

    def said_of(self, flight: int) -> tuple[Forecasts, Forecasts, str]:
        """What was to be said of a flight when it had not flown, without and with an effect, and which."""
        data = _known(self._data, flight)
        base, ranking = self._singles.at(data)
        plain = forecasts_of(base.left_out)
        options = list(ranking)
        for first in likely_firsts(ranking):
            if first.effect in self._beside:
                options += self._beside[first.effect].at(data, first)[1]
        chosen = choose(options)
        if chosen is None or not _stands(chosen, options, plain, data):
            return _last(plain), _last(plain), ""
        return _last(plain), _last(chosen.forecasts), "+".join(chosen.effects)


def _worth_a_look(acting: Sequence[tuple[Candidate, Fit]], base: Trial) -> list[Trial]:
    """The trials; what is hopeless among them gets the forecasts of the model without it, and so helps nothing."""
    families = by_effect([candidate for candidate, _ in acting])
    weight = {
        id(candidate): fitted.log_evidence + candidate.log_share - base.log_evidence for candidate, fitted in acting
    }
    best = {name: max(weight[id(candidate)] for candidate in family) for name, family in families.items()}
    least = float(np.log(max(len(families), 1) / ODDS)) - MAX_LOG_ODDS_BEHIND
    possible = np.logaddexp.reduce(list(weight.values())) > least
    found = []
    for candidate, fitted in acting:
        top = best[candidate.effect]
        if weight[id(candidate)] < top - MAX_LOG_ODDS_BEHIND:
            continue
        worth = possible and top > least
        found.append(Trial(candidate, fitted, leave_one_out(fitted) if worth else base.left_out))
    return found


def _stands(chosen: Ranked, options: Sequence[Ranked], plain: Forecasts, data: Data) -> bool:
    """Whether it is made of effects, and the whole choice, made anew in every fold, forecasts well enough."""
    truth, seen = data.values[:, 0], data.seen[:, 0]
    after, before = (score(forecasts, truth, seen) for forecasts in (choose_in_folds(options, plain), plain))
    return "" not in chosen.effects and stands(chosen, after, before)


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
