"""The check of a quick forecast: the linear pass's own answer passes, and a different one does not."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.stats import t

from fieldkit.inference.history.check import Check, _log_forecast, check
from fieldkit.inference.history.moments import own_variance
from fieldkit.inference.history.quick_forecast import QuickAnswer, answers, prepared
from tests.inference.history.histories import history

CHECK_SHAPES = False


@pytest.fixture(scope="module")
def answer() -> QuickAnswer:
    ready = prepared(history(4))
    return answers(ready, ready.flown)[0]


@pytest.mark.usefixtures("shapes_checked")
def test_the_passs_own_answer_passes(answer: QuickAnswer) -> None:
    found = check(answer)
    assert found.agrees
    assert found.apogee_effective > 0.8


def test_the_same_seed_gives_the_same_draws(answer: QuickAnswer) -> None:
    assert check(answer) == check(answer)
    assert check(answer, seed=1) != check(answer)


def test_a_different_apogee_does_not_pass(answer: QuickAnswer) -> None:
    """A linear pass whose plan is simulated too high."""
    near, plan, effective = answer.linear.near, answer.linear.flown, []
    for off in (0.0, 0.2, 0.8):
        values = near.values.copy()
        values[plan, 0] += off
        linear = replace(answer.linear, near=replace(near, values=values))
        found = check(replace(answer, cases=((1.0, linear),), apogees=answer.apogees * np.exp(off)))
        effective.append(found.apogee_effective)
    assert effective == sorted(effective, reverse=True)
    assert not found.agrees


def test_other_parameters_do_not_pass(answer: QuickAnswer) -> None:
    """A pass whose posterior is far from the model's, or much too narrow, has unreliable weights."""
    fit = answer.linear.fit
    sds = np.sqrt(np.diagonal(fit.covariance, axis1=1, axis2=2))

    def passed(**other: object) -> QuickAnswer:
        linear = replace(answer.linear, fit=replace(fit, solution=replace(fit.solution, **other)))
        return replace(answer, cases=((1.0, linear),))

    terms, prior = fit.solution.terms, fit.solution.terms.prior
    smaller = replace(prior, variance=0.05 * prior.variance, block=0.05 * prior.block)
    moved, narrow = (
        passed(mean=fit.mean + 2 * sds),
        passed(terms=replace(terms, prior=smaller, known=0.05 * terms.known)),
    )
    own = check(answer)
    assert own.parameters_effective > 3 * check(moved).parameters_effective
    assert check(narrow).pareto_k > own.pareto_k
    assert not check(moved).agrees


def test_every_criterion_of_the_check_must_be_met() -> None:
    assert Check(0.7, 0.1, 0.5, 400).agrees
    assert not Check(0.71, 0.9, 0.9, 400).agrees
    assert not Check(0.1, 0.9, 0.49, 400).agrees
    assert not Check(np.inf, 0.0, 0.0, 400).agrees


def test_several_plans_are_refused(answer: QuickAnswer) -> None:
    two = replace(answer.linear, flown=answer.linear.flown - 1)
    with pytest.raises(ValueError, match="expected one"):
        check(replace(answer, cases=((1.0, two),)))


def test_the_forecast_is_a_mixture_of_student_t_distributions(answer: QuickAnswer) -> None:
    linear, rng = answer.linear, np.random.default_rng(3)
    sds, nu = np.sqrt(own_variance(linear)[:, 0]), linear.model.hyperprior.tail
    middle, weight = np.array([4.5, 4.7, np.nan, 5.1]), rng.dirichlet(np.ones(4 * len(sds))).reshape(4, -1)
    weight[0] = 0.0
    apogees = np.array([-900.0, 4.6, 5.0, 9.0])
    flies = [1, 3]
    density = [(weight[flies] * t.pdf(at, nu, middle[flies, None], sds)).sum() for at in apogees]
    assert _log_forecast(linear, middle, weight, apogees) == pytest.approx(np.log(density), rel=1e-12)
    assert (_log_forecast(linear, middle, np.zeros_like(weight), apogees) == -np.inf).all()
