"""The response of flights, the one-pass fit, and closed-form evidence, compared with the simulator and with full fits
with the effect.

Evidence agrees to 0.01 nat, because the bound of the parachute's opening time is treated for its term alone.
"""

from dataclasses import replace

import numpy as np
import pytest

from fieldkit.inference.history.evidence import conditional, weigh
from fieldkit.inference.history.linear_fit import (
    LinearFit,
    declared_terms,
    history_model,
    linear_fit,
    prepared_fit,
)
from fieldkit.inference.history.response import (
    DRAG_OFFSETS,
    REFERENCE_LOG_DRAG,
    REFERENCE_OPENING,
    FlightResponse,
    moved_at,
    part_of,
    reference,
    respond,
    tangent,
)
from fieldkit.inference.laplace.posterior import solve
from fieldkit.model.certified_prior import CERTIFIED_PRIOR
from fieldkit.model.hyperprior import learned
from fieldkit.model.readout_data import as_compared, readings
from fieldkit.model.rocket_model import Model, Term
from fieldkit.model.shared_prior import SharedPrior
from fieldkit.model.simulated_readouts import shown
from fieldkit.model.term_names import TermName
from fieldkit.motors import catalogue
from fieldkit.physics.effect import effects
from fieldkit.physics.history import history_of
from fieldkit.selection.candidates import Candidate
from fieldkit.selection.quick_candidates import quick_candidates
from tests.inference.history.histories import history

COUNT = 8
WORN = history(COUNT, wear=0.05)


@pytest.fixture(scope="module")
def response() -> FlightResponse:
    return respond(WORN)


@pytest.fixture(scope="module")
def linear(response: FlightResponse) -> LinearFit:
    model = history_model(WORN, CERTIFIED_PRIOR, declared=False)
    data = as_compared(readings(WORN.flights[:COUNT], WORN.found[:COUNT]), WORN.used_in_fit, CERTIFIED_PRIOR)
    return linear_fit(prepared_fit(model, COUNT), data, response)


def test_between_simulated_drag_values_the_response_agrees_with_the_simulator(
    response: FlightResponse, linear: LinearFit
) -> None:
    at = np.array([[0.0] * len(linear.model.terms)])
    for offset, most in ((DRAG_OFFSETS[0], 1e-4), (-0.2, 3e-3), (0.3, 3e-3)):
        bends = {"drag": np.full((1, COUNT + 1), REFERENCE_LOG_DRAG + offset)}
        bends["opening"] = np.full((1, COUNT + 1), REFERENCE_OPENING)
        flown = shown(_coarse(linear), at, bends)["apogee"][0]
        assert moved_at(response, offset)[""][:, 0] == pytest.approx(np.log(flown), abs=most)


@pytest.mark.parametrize("elsewhere", [(), (TermName("thrust", "motor", "AeroTech F39T"),)])
def test_plans_on_new_motors_share_the_terms_of_one(elsewhere: tuple[TermName, ...]) -> None:
    """A motor flown by other rockets keeps its own terms."""
    named = [catalogue().resolve(name) for name in ("F39-6T", "E15-4W", "F24-4W", "E16-4W", "D12-5")]
    plans = [WORN.flights[-1].with_changes(motor=found.motor.name) for found in named]
    flights, found = (*WORN.flights[:COUNT], *plans), (*WORN.found[:COUNT], *named)
    shared = SharedPrior(elsewhere, np.zeros(len(elsewhere)), 0.01 * np.eye(len(elsewhere))) if elsewhere else None
    history = history_of(flights, found, COUNT, [*range(COUNT), *[COUNT] * len(plans)])
    model = history_model(history, learned(), shared, declared=False)
    thrust = [term for term in model.terms if term.name.quantity == "thrust" and term.weight[COUNT:].any()]
    acting = np.array([term.weight[COUNT:] for term in thrust if term.name.level == "motor"])
    own, new = [[0, 0, 1, 0, 0]], [[1, 1, 0, 1, 1]]
    expected = [*own, *([[1, 0, 0, 0, 0], [0, 1, 0, 1, 1]] if elsewhere else new)]
    assert sorted(acting.tolist()) == sorted(expected)
    assert model.found == found


def _coarse(linear: LinearFit) -> Model:
    return replace(linear.model, coarse=True)


def test_the_drag_slope_agrees_with_finite_differences(response: FlightResponse) -> None:
    step = 1e-4
    higher, lower = (moved_at(response, 0.1 + side * step)[""][:, :3] for side in (1, -1))
    assert moved_at(response, 0.1)["drag"][:, :3] == pytest.approx((higher - lower) / (2 * step), abs=1e-6)


def _without_bounds(candidate: Candidate) -> Candidate:
    terms = tuple(replace(term, low=-np.inf, high=np.inf) for term in candidate.terms)
    return replace(candidate, terms=terms)


def test_the_evidence_agrees_with_a_fit_that_includes_the_effect(linear: LinearFit) -> None:
    found = [
        _without_bounds(one)
        for one in quick_candidates(linear.model)
        if one.place.effect in ("wear", "mass_offset", "thrust_curve", "") and not one.place.since
    ]
    trials = weigh(linear, found)
    flown = slice(COUNT)
    for row, number in enumerate(trials.candidate):
        wider = linear.fit.model.with_terms(*(_part(term, flown) for term in found[number].terms))
        wide = linear.model.with_terms(*found[number].terms)
        near = part_of(tangent(wide, linear.moved, reference(wide), linear.offset), flown)
        gained = solve(wider, linear.fit.data, near).log_evidence - linear.fit.log_evidence
        assert trials.log_bayes[row] == pytest.approx(gained, abs=0.01), found[number].place


def _part(term: Term, rows: slice) -> Term:
    return replace(term, weight=term.weight[rows])


def test_the_evidence_beside_an_accepted_effect_is_that_of_both_minus_that_of_one(linear: LinearFit) -> None:
    found = [
        _without_bounds(one)
        for one in quick_candidates(linear.model)
        if str(one.place) in ("wear", "mass_offset", "altimeter_scale")
    ]
    best = int(np.argmax(linear.fit.log_weight))
    single = replace(linear.fit.model.hyperprior.scatter, grid=(float(linear.fit.model.hyperprior.scales()[0][best]),))
    reading = replace(linear.fit.model.hyperprior.reading, grid=(float(linear.fit.model.hyperprior.scales()[1][best]),))
    prior = replace(linear.fit.model.hyperprior, scatter=single, reading=reading)
    model = replace(linear.model, hyperprior=prior)
    past = replace(linear.fit.model, hyperprior=prior)
    fixed = replace(linear, model=model, fit=solve(past, linear.fit.data, linear.fit.tangent))
    trials = weigh(fixed, found)
    beside = conditional(trials, [0, 1])
    flown = slice(COUNT)

    def evidence(rows: list[int]) -> float:
        terms = [term for row in rows for term in found[trials.candidate[row]].terms]
        wide = model.with_terms(*terms)
        near = part_of(tangent(wide, fixed.moved, reference(wide), fixed.offset), flown)
        return solve(past.with_terms(*(_part(term, flown) for term in terms)), fixed.fit.data, near).log_evidence

    assert beside[0, 1] == pytest.approx(evidence([0, 1]) - evidence([1]), abs=0.01)
    assert beside[1, 1] == pytest.approx(evidence([1]) - fixed.fit.log_evidence, abs=0.01)


def test_evidence_from_a_single_flight_is_not_robust(linear: LinearFit) -> None:
    trials = weigh(linear, quick_candidates(linear.model))
    assert (trials.robust <= trials.log_bayes + 1e-12).all()
    days = [row for row, number in enumerate(trials.candidate) if trials.family[row] == ""]
    assert (trials.robust[days] < trials.log_bayes[days] - 0.01).any()


def test_only_effects_that_are_declared_act_on_forecasts_by_default() -> None:
    """Recorded wind acts, and the temperature does not, because the altimeter is assumed not to correct for it."""
    flights = [flight.with_changes(wind=3.0, temperature=300.0) for flight in WORN.flights]
    known = {id(effect): name for name, effect in effects().items()}
    acting = {known[id(term.bends)] for term in declared_terms(flights)}
    assert acting == {name for name, effect in effects().items() if effect.declared}
    assert not declared_terms(WORN.flights)
