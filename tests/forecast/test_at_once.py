"""Fast forecasts: the linear fit with the hyperprior in use."""

from dataclasses import replace

import numpy as np
import pytest

from fieldkit.forecast import at_once
from fieldkit.model.hyperprior import learned
from fieldkit.selection.quick_candidates import quick_candidates
from tests.inference.history.histories import history

CHECK_SHAPES = False


def test_the_linear_fit_is_repeated_only_with_a_newer_hyperprior(monkeypatch: pytest.MonkeyPatch) -> None:
    """It is the network's own if the network was trained with the hyperprior in use."""
    own = replace(history(3), forecast=learned())
    ready = at_once.prepared(own, quick_candidates)
    (answer,) = at_once.answer_at_once(ready, ready.flown)
    again = at_once.summarized(ready, ready.flown, ()).forecast
    same = at_once.fit_in_use(ready, answer)
    assert same is answer.summary.forecast
    assert np.array_equal(same.fit.mean, again.fit.mean)
    newer = learned().with_sds(drag__rocket=0.1)
    monkeypatch.setattr(at_once, "learned", lambda: newer)
    assert not np.allclose(at_once.fit_in_use(ready, answer).fit.mean, same.fit.mean)
