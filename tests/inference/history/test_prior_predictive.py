"""Single flights against the prior of their model: impossible readouts are named, good flights hardly ever."""

import numpy as np
import pytest

from fieldkit.flight import Flight
from fieldkit.forecast.at_once import each_at_once
from fieldkit.inference.history.linear_fit import history_model
from fieldkit.inference.history.prior_predictive import (
    FALSE_ALARMS,
    InconsistentReadout,
    _at_median_scales,
    inconsistent_readout,
    without_data,
)
from fieldkit.inference.history.quick_forecast import QuickAnswer
from fieldkit.inference.laplace.posterior import term_sds
from fieldkit.model.hyperprior import learned
from fieldkit.model.readout_data import IS_LOGARITHMIC, OBSERVED_READOUTS, reading_sd
from fieldkit.model.simulated_readouts import shown
from fieldkit.motors import catalogue
from fieldkit.physics.history import history_of

CHECK_SHAPES = False

FOUND = catalogue().resolve("D12-5")
PLAN = Flight("1", "Bertha", "A", "D12-5", dry_mass=0.12, diameter=0.041)
GOOD = PLAN.with_changes(apogee=190.0, top_speed=62.0, coast_to_apogee=4.6)
READ = ("apogee", "top_speed", "burn_time", "coast_to_apogee")


def answers(*flights: Flight) -> list[QuickAnswer]:
    return each_at_once([(flight, FOUND) for flight in flights], [None] * len(flights))


def inconsistent(*flights: Flight) -> list[InconsistentReadout | None]:
    return [inconsistent_readout(answer.linear) for answer in answers(*flights)]


@pytest.mark.parametrize(
    ("name", "value"), [("apogee", 400.0), ("apogee", 190.0 * 0.3048), ("coast_to_apogee", 1.8), ("top_speed", 139.0)]
)
def test_a_readout_that_no_such_rocket_produces_is_named(name: str, value: float) -> None:
    good, found = inconsistent(GOOD, GOOD.with_changes(**{name: value}))
    assert good is None
    assert found is not None
    assert (found.name, found.alone) == (name, False)
    assert found.value == pytest.approx(value)
    assert found.low < (GOOD.number(name) or 0.0) < found.high


def test_the_apogee_alone_is_compared_with_the_prior_of_motor_and_mass() -> None:
    low, usual, high, heavy = inconsistent(
        *(PLAN.with_changes(apogee=height) for height in (60.0, 250.0, 600.0)),
        PLAN.with_changes(apogee=190.0, dry_mass=0.9),
    )
    assert usual is None
    assert low is not None
    assert high is not None
    assert low.low < 250 < low.high
    assert high.alone
    assert heavy is not None
    assert heavy.high < 20, "far too heavy for the motor"


def test_hardly_any_flight_from_the_prior_has_an_inconsistent_readout() -> None:
    """Flights drawn from the model: every term from its prior, readouts with errors of a Student t."""
    rng, count = np.random.default_rng(3), 100
    history = history_of([PLAN, PLAN.with_changes(flight_id="2")], [FOUND, FOUND], flown=1)
    model = _at_median_scales(history_model(history, learned(), declared=True))
    prior = model.hyperprior
    values = np.array([term.mean for term in model.terms]) + term_sds(model)[0] * rng.normal(
        size=(count, len(model.terms))
    )
    spread = {
        one.bends: one.sd * scale * rng.standard_t(prior.tail, (count, 2))
        for one, scale in zip(model.scatter, model.scatter_scales()[0], strict=True)
        if one.bends != "apogee"
    }
    read = shown(model, values, spread)
    raw = np.stack([np.asarray(read[name])[:, 0] for name in OBSERVED_READOUTS if name in read], axis=-1)
    raw = np.pad(raw, ((0, 0), (0, len(OBSERVED_READOUTS) - raw.shape[1])), constant_values=np.nan)
    errors = reading_sd(raw, prior) * prior.scales()[1] * rng.standard_t(prior.tail, raw.shape)
    seen = np.where(IS_LOGARITHMIC, raw * np.exp(errors), raw + errors)
    flights = [
        PLAN.with_changes(**{name: float(row[OBSERVED_READOUTS.index(name)]) for name in READ})
        for row in seen
        if (row[:4] > 0).all()
    ]
    alarms = [found for found in inconsistent(*flights) if found]
    assert len(alarms) / len(flights) < 3 * FALSE_ALARMS


def test_an_inconsistent_readout_is_the_same_alone_and_among_others() -> None:
    odd = GOOD.with_changes(apogee=400.0)
    (alone,) = inconsistent(odd)
    *_, among = inconsistent(GOOD, PLAN.with_changes(apogee=180.0), odd)
    assert alone is not None
    assert among is not None
    assert alone.high == pytest.approx(among.high, rel=1e-6)


def test_the_prior_without_data_is_wider_than_the_posterior_and_does_not_depend_on_the_readouts() -> None:
    few, many = answers(PLAN.with_changes(apogee=190.0), GOOD)
    before = without_data(many.linear)
    assert before.cd_sd[0] > many.log_cd[1]
    assert before.cd_sd[0] == pytest.approx(without_data(few.linear).cd_sd[0])
    assert before.alpha[0] == pytest.approx(without_data(few.linear).alpha[0])
