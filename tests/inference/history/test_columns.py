"""The columns of evidence, compared with sums over one effect at a time."""

import numpy as np
import pytest

from fieldkit.inference.history.columns import (
    PER_EFFECT,
    families,
    odds_of,
    of_effects,
    of_evidence,
    ranked,
    shown_evidence,
)
from fieldkit.inference.history.evidence import Trials, weigh
from fieldkit.inference.network.history import quick_answer
from fieldkit.selection.quick_candidates import quick_candidates
from tests.inference.history.histories import history

CHECK_SHAPES = False


@pytest.fixture(scope="module")
def trials() -> Trials:
    summary = quick_answer(history(8, wear=0.04), quick_candidates).summary
    return weigh(summary.selection, summary.candidates)


def test_the_shift_of_a_forecast_is_averaged_over_effects_and_their_places(trials: Trials) -> None:
    by_effect = {name: np.array(rows) for name, rows in families(trials).items() if name}
    bayes = {name: np.logaddexp.reduce(trials.weight[rows]) for name, rows in by_effect.items()}
    odds = {name: value - np.log(2 * len(by_effect)) for name, value in bayes.items()}
    total = np.logaddexp.reduce([0.0, *odds.values()])
    shift = square = 0.0
    for name, rows in by_effect.items():
        place = np.exp(trials.weight[rows] - bayes[name])
        gain = trials.forecast_gain[0, rows]
        shift += np.exp(odds[name] - total) * (place @ (gain * trials.mean[rows]))
        square += np.exp(odds[name] - total) * (place @ (gain**2 * (trials.mean[rows] ** 2 + trials.sd[rows] ** 2)))
    first = by_effect[max(odds, key=lambda name: odds[name])]
    leader = first[np.argmax(trials.weight[first])]
    by_evidence = ranked(trials)
    found = of_evidence(by_evidence, trials, odds_of(by_evidence))
    assert found["shift"] == pytest.approx(shift, rel=1e-9)
    assert found["shift_sd"] == pytest.approx(np.sqrt(square - shift**2), rel=1e-9)
    assert found["shift_of_first"] == pytest.approx(trials.forecast_gain[0, leader] * trials.mean[leader], rel=1e-12)


def test_evidence_of_an_effect_is_summed_over_its_places(trials: Trials) -> None:
    names = ("wear", "no effect", "mass_offset")
    by_evidence = ranked(trials)
    found = of_effects(by_evidence, trials, odds_of(by_evidence), names)
    for name, row in zip(names, found, strict=True):
        rows = families(trials).get(name, [])
        columns = dict(zip(PER_EFFECT, row.tolist(), strict=True))
        if not rows:
            assert not row.any()
            continue
        for column, which in (("log_bayes", "log_bayes"), ("robust", "robust"), ("by_forecast_fit", "log_bayes")):
            whole = np.logaddexp.reduce(getattr(trials, which)[rows] + trials.log_fraction[rows])
            assert columns[column] == pytest.approx(float(shown_evidence(whole)), rel=1e-12)
        assert columns["places"] == pytest.approx(np.log(len(rows)))
