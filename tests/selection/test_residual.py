"""Residuals: calibrated if the model is right, and informative if it is not."""

from functools import cache

import numpy as np
import pytest
from scipy.stats import kstest

from fieldkit.flight import Flight
from fieldkit.inference.laplace.leave_one_out import leave_one_out
from fieldkit.inference.laplace.linearization import Tangent
from fieldkit.inference.laplace.posterior import solve
from fieldkit.model.certified_prior import CERTIFIED_PRIOR
from fieldkit.model.readout_data import OBSERVED_READOUTS, Data
from fieldkit.model.rocket_model import Model, Term, scatter_of
from fieldkit.model.term_names import TermName
from fieldkit.motors import catalogue
from fieldkit.physics.history import history_of
from fieldkit.selection.residual import associations, holm, spread_of, standardised
from fieldkit.shapes import Array, Float

pytestmark = pytest.mark.fast

FLIGHTS = 18
SETS = 300
SCALE = 4
"""Scales of the grid: ordinary scatter, readings a little worse than expected."""
TERMS = 4
KINDS = len(scatter_of(CERTIFIED_PRIOR))


@cache
def near() -> Tangent:
    """A linear rocket: four shared terms, and the usual kinds of scatter."""
    rng = np.random.default_rng(3)
    shape = (FLIGHTS, len(OBSERVED_READOUTS))
    shared = np.tile(rng.normal(size=(len(OBSERVED_READOUTS), TERMS)), (FLIGHTS, 1, 1))
    shared[:, :, -1] *= (np.arange(FLIGHTS) % 2)[:, None]
    own = np.tile(rng.normal(size=(len(OBSERVED_READOUTS), KINDS)) * 0.3, (FLIGHTS, 1, 1))
    return Tangent(np.zeros(TERMS), np.zeros(shape), shared, own)


@cache
def null_residuals() -> Float[Array, "set flight readout"]:
    """Residuals of histories in which the model is right."""
    rng = np.random.default_rng(4)
    reading = CERTIFIED_PRIOR.scales()[1][SCALE]
    terms = tuple(Term(TermName(str(i)), "drag", 0.0, 1.0, np.ones(FLIGHTS)) for i in range(TERMS))
    model, tangent = (
        Model(history_of([Flight()] * FLIGHTS, [catalogue().resolve("F24")] * FLIGHTS), terms, CERTIFIED_PRIOR),
        near(),
    )
    sd = np.full(tangent.values.shape, 0.3)
    seen = np.ones(sd.shape, bool)
    scales = np.array([1.0, *[reading] * (len(OBSERVED_READOUTS) - 1)])
    found = []
    for _ in range(SETS):
        values = tangent.slope @ rng.normal(size=TERMS) + rng.normal(size=sd.shape) * sd * scales
        own = model.scatter_scales()[SCALE] * rng.normal(size=(FLIGHTS, 1, KINDS))
        values += (tangent.scatter_slope * own).sum(axis=-1)
        result = solve(model, Data(values, sd, seen, np.ones(seen.shape)), tangent)
        found.append(standardised(leave_one_out(result), seen))
    return np.array(found)


def test_residuals_of_a_right_model_have_no_bias_and_unit_spread() -> None:
    residual = null_residuals()
    assert np.abs(residual.mean(axis=(0, 1))).max() < 0.05
    assert residual.std() == pytest.approx(1.0, abs=0.12)


def test_p_values_of_columns_are_uniform_without_a_dependence() -> None:
    rng = np.random.default_rng(6)
    p = []
    for error in null_residuals()[:, :, 0]:
        kinds = {"site": rng.choice(["a", "b", "c"], FLIGHTS).tolist()}
        p.append([row[2] for row in associations(error, {"wind": rng.normal(size=FLIGHTS)}, kinds)])
    wind = np.array([row[0] for row in p])
    site = np.array([row[1] for row in p if len(row) > 1])
    assert kstest(wind, "uniform").pvalue > 0.01
    assert kstest(site, "uniform").pvalue > 0.01


def test_p_values_of_the_autocorrelation_are_uniform_without_one() -> None:
    p = [spread_of("apogee", error).autocorrelation_p for error in null_residuals()[:, :, 0]]
    assert kstest(p, "uniform").pvalue > 0.01


def test_an_added_autocorrelation_is_found() -> None:
    rng = np.random.default_rng(8)
    p = []
    for _ in range(60):
        drift = rng.normal(size=20)
        for flight in range(1, 20):
            drift[flight] = 0.8 * drift[flight - 1] + 0.6 * drift[flight]
        p.append(spread_of("apogee", drift).autocorrelation_p)
    assert np.mean(np.array(p) < 0.05) > 0.6


def test_an_added_bias_and_spread_are_found() -> None:
    error = np.random.default_rng(9).normal(size=20)
    assert spread_of("apogee", error).bias_p > 0.05
    assert spread_of("apogee", error + 1.5).bias_p < 0.001
    assert spread_of("apogee", 3 * error).spread_p < 0.001


def test_an_added_dependence_is_found_and_named() -> None:
    rng = np.random.default_rng(10)
    wind, hour = rng.uniform(0, 8, 20), rng.uniform(9, 17, 20)
    error = -0.6 * wind + rng.normal(size=20)
    rows = {name: p for name, _, p in associations(error, {"wind": wind, "hour": hour}, {})}
    assert rows["wind"] < 0.001 < rows["hour"]


def test_a_constant_column_is_not_tested() -> None:
    error = np.random.default_rng(11).normal(size=12)
    assert associations(error, {"wind": np.full(12, 3.0), "hour": np.full(12, np.nan)}, {"site": ["a"] * 12}) == []


def test_a_group_of_one_flight_does_not_hide_the_others() -> None:
    rng = np.random.default_rng(14)
    error = np.array([*rng.normal(0.0, 1.0, 8), *rng.normal(6.0, 1.0, 8), 0.0])
    motors = ["D12"] * 8 + ["E9"] * 8 + ["F15"]
    ((name, _, p),) = associations(error, {}, {"motor": motors})
    assert name == "motor"
    assert p < 0.001
    assert associations(error[:9], {}, {"motor": motors[:8] + motors[16:]}) == []


def test_holms_method_bounds_the_probability_of_a_false_alarm() -> None:
    rng = np.random.default_rng(12)
    alarms = [min(holm(list(rng.uniform(size=8)))) < 0.1 for _ in range(2000)]
    assert np.mean(alarms) == pytest.approx(0.1, abs=0.02)


def test_holms_method_agrees_with_the_textbook() -> None:
    assert holm([0.01, 0.04, 0.03, 0.005]) == pytest.approx([0.03, 0.06, 0.06, 0.02])
    assert holm([]) == []
