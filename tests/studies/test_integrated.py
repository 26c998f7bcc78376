"""The exact posterior of simulated flights with all random inputs integrated out."""

import numpy as np
import pytest

from fieldkit.model.observation_noise import SUBSETS, measure
from fieldkit.model.observations import ALPHA_SD
from fieldkit.model.prior_predictive import flown_motors, simulate
from fieldkit.motors import catalogue
from studies.exact.integrated import integrate
from studies.exact.likelihood import LATENTS, Latent, log_likelihood, normals_of, parameters, problem

pytestmark = pytest.mark.fast

FLIGHTS = 6


@pytest.fixture(scope="module")
def made() -> tuple:
    motors = [motor for motor in flown_motors(catalogue().motors) if motor.maker == "Quest"]
    rng = np.random.default_rng(4)
    truth = simulate(rng, motors, FLIGHTS)
    return truth, measure(rng, truth), motors


def test_normal_inputs_and_parameters_are_inverse_functions(made: tuple) -> None:
    truth, _, _ = made
    diameter = truth.declared[:, 1]
    numbers = np.zeros((len(truth), LATENTS))
    numbers[:, :2] = normals_of(truth.parameters, diameter)
    assert np.stack(parameters(numbers, diameter), axis=-1) == pytest.approx(truth.parameters)


def test_the_substitute_for_a_generator_draws_from_the_same_distributions() -> None:
    normals = np.random.default_rng(1).normal(size=(20_000, 3))
    latent = Latent(normals)
    assert latent.normal(3.0, 2.0).std() == pytest.approx(2.0, rel=0.03)
    assert np.quantile(latent.uniform(1.0, 5.0), [0.25, 0.75]) == pytest.approx([2.0, 4.0], abs=0.06)
    assert np.quantile(latent.standard_t(4.0), 0.95) == pytest.approx(2.132, rel=0.05)


def test_a_flight_is_more_likely_with_its_true_drag_than_with_another(made: tuple) -> None:
    truth, whole, motors = made
    one = problem(truth, whole.only(*SUBSETS["apogee, speed"]), motors)
    numbers = np.zeros((len(truth), 2, LATENTS))
    numbers[:, :, :2] = normals_of(truth.parameters, truth.declared[:, 1])[:, None]
    numbers[:, 1, 1] += 3.0
    likely = log_likelihood(one, numbers)
    assert (likely[:, 0] > likely[:, 1]).mean() > 0.8


@pytest.mark.slow
def test_without_a_readout_the_posterior_is_the_prior(made: tuple) -> None:
    truth, whole, motors = made
    truth, whole = truth.rows(slice(0, 2)), whole.rows(slice(0, 2))
    one = problem(truth, whole.only(), motors)
    begin = np.zeros((len(truth), 2))
    found = integrate(np.random.default_rng(2), one, begin, 200)
    diameter = np.repeat(truth.declared[:, 1], found.normals.shape[1])
    alpha = parameters(found.normals.reshape(-1, LATENTS), diameter)[1].reshape(found.weight.shape)
    sd = np.sqrt((found.weight * (alpha - 1.0) ** 2).sum(axis=1))
    assert sd.mean() == pytest.approx(ALPHA_SD, rel=0.1)
    assert found.log_evidence == pytest.approx(np.zeros(len(truth)), abs=0.25)
