"""Screening of places: linear readouts agree with fits."""

from dataclasses import replace
from datetime import datetime
from itertools import combinations, product

import numpy as np
import pytest

from fieldkit.inference.laplace.fit import fit
from fieldkit.inference.laplace.linearization import tangents
from fieldkit.inference.laplace.posterior import probable_scales, solve
from fieldkit.model.readout_data import observe
from fieldkit.physics.effect import effects
from fieldkit.physics.history import history_of
from fieldkit.selection import screen
from fieldkit.selection.candidates import Candidate, effect_candidates
from fieldkit.selection.extended_model import rocket_model
from fieldkit.selection.pair_screen import pair_weights
from fieldkit.selection.prior import log_prior_odds
from fieldkit.selection.screen import MAX_PLACES, screened
from fieldkit.selection.trial import by_effect, try_all
from tests.selection.test_verdict import measured, season

pytestmark = pytest.mark.fast

CHECK_SHAPES = False
LINEAR = ("altimeter_scale", "mass_offset", "motor_thrust", "wear", "base_drag")


def families() -> tuple[object, dict[str, list[Candidate]]]:
    model = measured(season())
    plain = fit(model, observe(model.history.using([True] * 16)), outlier_flights=True)
    every = by_effect(list(effect_candidates(model, np.ones(16, bool))))
    return plain, {name: every[name] for name in LINEAR}


def test_the_closed_form_agrees_with_the_fit_and_keeps_the_prior_of_an_effect(monkeypatch: pytest.MonkeyPatch) -> None:
    plain, some = families()
    kept = screened(some, plain).families
    for name, found in kept.items():
        assert 1 <= len(found) <= MAX_PLACES
        assert sum(np.exp(one.log_fraction) for one in found) <= 1.0 + 1e-9 or len(some[name]) > len(found)
    monkeypatch.setattr(screen, "PLACE_WINDOW", np.inf)
    monkeypatch.setattr(screen, "MAX_PLACES", 1000)
    trials = try_all(plain.model, plain.data, screened(some, plain), plain)
    for name in LINEAR:
        own = [trial for trial in trials if trial.candidate.effect == name]
        fitted = float(np.logaddexp.reduce([t.fit.log_evidence + t.candidate.log_fraction for t in own]))
        chosen = {one.place: one.log_fraction for one in kept[name]}
        few = [t.fit.log_evidence + chosen[t.candidate.place] for t in own if t.candidate.place in chosen]
        assert float(np.logaddexp.reduce(few)) == pytest.approx(fitted, abs=0.4)


def test_the_closed_form_of_a_pair_is_the_linear_model_with_both_effects() -> None:
    plain, some = families()
    worthy = screened(some, plain)
    pair = {name: [worthy.families[name][0]] for name in ("mass_offset", "motor_thrust")}
    ones = [one for (one,) in pair.values()]
    steps = [worthy.steps[one.place, one.starts[0]] for one in ones]
    near = replace(
        plain.tangent,
        at=np.concatenate([plain.tangent.at, *(step.at[-1:] for step in steps)]),
        values=sum(step.values for step in steps) - plain.tangent.values,
        slope=np.concatenate([plain.tangent.slope, *(step.slope[..., -1:] for step in steps)], axis=-1),
    )
    both = solve(plain.model.with_terms(*(one.terms[0] for one in ones)), plain.data, near, plain.flight_weight)
    odds = log_prior_odds(pair) + sum(one.log_fraction for one in ones)
    (found,) = pair_weights(pair, worthy.columns, plain).values()
    assert found == pytest.approx(both.log_evidence - plain.log_evidence + odds, abs=0.01)


def test_the_weight_of_a_pair_is_summed_over_places_and_is_that_of_the_best_start() -> None:
    plain, some = families()
    names = ("mass_offset", "motor_thrust", "wear")
    columns = screened(some, plain).columns
    whole = pair_weights({name: some[name] for name in names}, columns, plain)
    assert whole.keys() == {frozenset(two) for two in combinations(names, 2)}
    for two in whole:
        kinds = [[replace(one, starts=(start,)) for one in some[name] for start in one.starts] for name in sorted(two)]
        parts: dict[tuple[str, ...], float] = {}
        for one, other in product(*kinds):
            (weight,) = pair_weights({"mass_offset": [one], "wear": [other]}, columns, plain).values()
            key = (str(one.place), str(other.place))
            parts[key] = max(weight, parts.get(key, -np.inf))
        odds = log_prior_odds(two) - log_prior_odds(("mass_offset", "wear"))
        assert whole[two] == pytest.approx(np.logaddexp.reduce(list(parts.values())) + odds)


def test_an_effect_with_too_low_a_screening_weight_is_not_fitted() -> None:
    plain, some = families()
    assert list(screened(some, plain, {name: 50.0 for name in LINEAR if name != "wear"}).families) == ["wear"]


def test_the_first_step_of_a_fit_agrees_with_simulating_its_start() -> None:
    plain, some = families()
    worthy = screened({"base_drag": some["base_drag"]}, plain)
    ((place, start), step) = next(iter(worthy.steps.items()))
    (one,) = [one for one in some["base_drag"] if one.place == place]
    model = plain.model.with_terms(*one.terms)
    lane = (tuple(range(len(model.terms))), np.array([*plain.tangent.at, start]))
    (flown,) = tangents(model, [lane], plain.tangent.scatter_slope[..., -1])
    seen = plain.data.seen
    assert np.nanmax(np.abs(step.values - flown.values)[seen]) < 0.02
    own = flown.slope[seen][:, -1]
    assert step.slope[seen][:, -1] == pytest.approx(own, abs=0.05 * np.abs(own).max())
    assert list(step.at) == list(flown.at)


def test_every_place_of_an_effect_that_needs_a_blank_column_is_screened_on_its_own_flights(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(screen, "PLACE_WINDOW", np.inf)
    monkeypatch.setattr(screen, "MAX_PLACES", 1000)
    base = season()
    flights = [
        flight.with_changes(date_time=datetime(2026, 5, 1 + 7 * (row // 6)), site="AB"[row % 2])
        for row, flight in enumerate(base.flights)
    ]
    model = measured(rocket_model(history_of(flights, base.found)))
    plain = fit(model, observe(model.history.using([True] * 16)), outlier_flights=True)
    air = [one for one in effect_candidates(model, np.ones(16, bool)) if one.effect == "air_density"]
    assert {str(one.place) for one in air} >= {"blank_elevation of A", "blank_elevation of B", "weather of each day"}
    steps = screened({"air_density": air}, plain).steps
    for one in air:
        step, own = steps[one.place, one.starts[0]], len(one.terms)
        wide = plain.model.with_terms(*one.terms)
        (flown,) = tangents(wide, [(tuple(range(len(wide.terms))), step.at)], plain.tangent.scatter_slope[..., -1])
        assert (step.slope[:, 0, -own:] != 0).any(axis=0).all()
        np.testing.assert_allclose(step.slope[:, 0, -own:], flown.slope[:, 0, -own:], rtol=0.1, atol=1e-9)


def test_every_effect_has_a_known_family() -> None:
    from fieldkit.selection.prior import FAMILIES, inclusion_probabilities

    assert {effect.family for effect in effects().values()} == set(FAMILIES)
    assert min(inclusion_probabilities().values()) > 0.01


def test_a_fit_without_finite_evidence_keeps_every_scale() -> None:
    plain, _ = families()
    lost = replace(plain, log_weight=np.full(len(plain.log_weight), np.nan))
    assert len(probable_scales(lost)) == len(plain.log_weight) > len(probable_scales(plain))
