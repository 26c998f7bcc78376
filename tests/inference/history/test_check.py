"""The check of the network against the model: the model's own answer passes, and a different one does not."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.stats import t

from fieldkit.inference.history.check import Check, _log_forecast, check
from fieldkit.inference.history.moments import own_variance
from fieldkit.inference.network.history import QuickAnswer, quick_answer
from fieldkit.inference.network.history_parts import STANDARD
from fieldkit.selection.quick_candidates import quick_candidates
from tests.inference.history.histories import history

CHECK_SHAPES = False


@pytest.fixture(scope="module")
def answer() -> QuickAnswer:
    return quick_answer(history(4), quick_candidates)


@pytest.fixture(scope="module")
def own(answer: QuickAnswer) -> QuickAnswer:
    """The linear fit's answer instead of the network's."""
    base = answer.summary.baseline
    return replace(
        answer,
        log_apogee=base.apogee[0] + base.apogee_sd[0] * np.array(STANDARD),
        log_cd=(float(base.cd[0]), float(base.cd_sd[0])),
        log_alpha=(float(base.alpha[0]), float(base.alpha_sd[0])),
        correlation=float(base.correlation[0]),
    )


@pytest.mark.usefixtures("shapes_checked")
def test_the_models_own_answer_passes(own: QuickAnswer) -> None:
    found = check(own)
    assert found.agrees
    assert found.apogee_effective > 0.8


def test_the_same_seed_gives_the_same_draws(own: QuickAnswer) -> None:
    assert check(own) == check(own)
    assert check(own, seed=1) != check(own)


def test_a_different_apogee_does_not_pass(own: QuickAnswer) -> None:
    sd = float(own.summary.baseline.apogee_sd[0])
    effective = [check(replace(own, log_apogee=own.log_apogee + off * sd)).apogee_effective for off in (0.0, 1.0, 3.0)]
    assert effective == sorted(effective, reverse=True)
    assert not check(replace(own, log_apogee=own.log_apogee + 3 * sd)).agrees


def test_different_parameters_do_not_pass(own: QuickAnswer) -> None:
    mean, sd = own.log_cd
    assert check(own).parameters_effective > check(replace(own, log_cd=(mean + 3 * sd, sd))).parameters_effective
    assert not check(replace(own, log_cd=(mean + 8 * sd, 0.1 * sd))).agrees


def test_a_wide_network_has_a_better_pareto_k_than_a_narrow_one(own: QuickAnswer) -> None:
    mean, sd = own.log_cd
    alpha, alpha_sd = own.log_alpha
    wide = replace(own, log_cd=(mean, 1.5 * sd), log_alpha=(alpha, 1.5 * alpha_sd))
    narrow = replace(own, log_cd=(mean, 0.2 * sd), log_alpha=(alpha, 0.2 * alpha_sd), correlation=0.0)
    assert check(wide).pareto_k < check(narrow).pareto_k


def test_every_criterion_of_the_check_must_be_met() -> None:
    assert Check(0.7, 0.1, 0.5, 400).agrees
    assert not Check(0.71, 0.9, 0.9, 400).agrees
    assert not Check(0.1, 0.9, 0.49, 400).agrees
    assert not Check(np.inf, 0.0, 0.0, 400).agrees


def test_several_plans_are_refused(answer: QuickAnswer) -> None:
    linear = answer.summary.forecast
    two = replace(linear, flown=linear.flown - 1)
    with pytest.raises(ValueError, match="expected one"):
        check(replace(answer, summary=replace(answer.summary, forecast=two)))


def test_the_forecast_is_a_mixture_of_student_t_distributions(answer: QuickAnswer) -> None:
    linear, rng = answer.summary.forecast, np.random.default_rng(3)
    sds, nu = np.sqrt(own_variance(linear)[:, 0]), linear.model.hyperprior.tail
    middle, weight = np.array([4.5, 4.7, np.nan, 5.1]), rng.dirichlet(np.ones(4 * len(sds))).reshape(4, -1)
    weight[0] = 0.0
    apogees = np.array([-900.0, 4.6, 5.0, 9.0])
    flies = [1, 3]
    density = [(weight[flies] * t.pdf(at, nu, middle[flies, None], sds)).sum() for at in apogees]
    assert _log_forecast(linear, middle, weight, apogees) == pytest.approx(np.log(density), rel=1e-12)
    assert (_log_forecast(linear, middle, np.zeros_like(weight), apogees) == -np.inf).all()
