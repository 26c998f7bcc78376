"""The flight that distinguishes two explanations: every option is the next flight."""

import numpy as np
import pytest

from fieldkit.inference.laplace.fit import fit
from fieldkit.model.readout_data import observe
from fieldkit.physics.history import history_of
from fieldkit.selection import next_experiment
from fieldkit.selection.candidates import Place
from fieldkit.selection.extended_model import rocket_model
from fieldkit.selection.next_experiment import Explanation, informative_readouts, options
from tests.selection.test_verdict import season

pytestmark = pytest.mark.fast


def test_an_option_has_the_same_evidence_at_every_position(monkeypatch: pytest.MonkeyPatch) -> None:
    model = season()
    flights = [
        flight.with_changes(apogee=250.0 * float(np.exp(-0.03 * row))) for row, flight in enumerate(model.flights)
    ]
    model = rocket_model(history_of(flights, model.found))
    data = observe(model.history.using([True] * len(flights)))
    worn = Explanation((Place("wear"),), fit(rocket_model(history_of(flights, model.found), (Place("wear"),)), data))
    plain = Explanation((), fit(model, data))
    one = next(options(model))
    monkeypatch.setattr(next_experiment, "options", lambda model: [one] * 3)
    first, second, third = informative_readouts(model, worn, plain)
    assert first.first < 0.98 * first.second
    assert first.first == pytest.approx(second.first) == pytest.approx(third.first)
    assert first.expected == pytest.approx(third.expected)
