"""The expected error of a readout is the recorded one, if it can be."""

import numpy as np
import pytest

from fieldkit.flight import Flight
from fieldkit.model.readout_data import OBSERVED_READOUTS, observe
from fieldkit.motors import catalogue
from fieldkit.physics.history import history_of

MOTOR = [catalogue().resolve("F24-4W")]
TIMES = ("top_speed", "apogee_to_eject")


@pytest.mark.parametrize("sd", [0.0, -1.0, float("nan")])
def test_no_recorded_readout_is_exact(sd: float) -> None:
    plain = Flight(apogee=150.0, top_speed=60.0, apogee_to_eject=1.0)
    exact = plain.with_changes(sd=dict.fromkeys(("apogee", *TIMES), sd))
    whole, stated = (
        observe(history_of([plain], MOTOR, used_in_fit=[True])),
        observe(history_of([exact], MOTOR, used_in_fit=[True])),
    )
    np.testing.assert_allclose(stated.sd, whole.sd)
    assert (stated.sd[0][[OBSERVED_READOUTS.index(name) for name in TIMES]] > 0).all()


def test_a_recorded_error_is_relative_for_readouts_compared_by_ratio() -> None:
    flight = Flight(apogee=150.0, apogee_to_eject=2.0, sd={"apogee": 3.0, "apogee_to_eject": 0.4})
    sd = observe(history_of([flight], MOTOR, used_in_fit=[True])).sd[0]
    assert sd[OBSERVED_READOUTS.index("apogee")] == pytest.approx(0.02)
    assert sd[OBSERVED_READOUTS.index("apogee_to_eject")] == pytest.approx(0.4)
