"""The search: a set's weight covers all places of its effects, the evidence of probable sets is accurate, and strengths
stay within their bounds."""

from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from scipy.stats import truncnorm

from fieldkit.inference.laplace.fit import fit
from fieldkit.model.certified_prior import CERTIFIED_PRIOR
from fieldkit.model.readout_data import OBSERVED_READOUTS, observe
from fieldkit.model.rocket_model import Term, strength_term
from fieldkit.model.term_names import TermName
from fieldkit.physics.effect import effects
from fieldkit.physics.history import history_of
from fieldkit.selection import search
from fieldkit.selection.candidates import Candidate, Place, effect_candidates, effect_terms
from fieldkit.selection.extended_model import rocket_model
from fieldkit.selection.hypotheses import Hypothesis, SetPosterior
from fieldkit.selection.pair_screen import pair_weights
from fieldkit.selection.screen import MAX_PLACES
from fieldkit.selection.search import checked, explore
from fieldkit.selection.trial import Trial, by_effect, strength_moments
from tests.seasons import season
from tests.selection.test_verdict import measured
from tests.selection.test_verdict import season as two_configurations

pytestmark = pytest.mark.fast

CHECK_SHAPES = False
MOTORS = ("E35", "F24", "F39")


def candidate(effect: str, where: str = "", count: int = 1) -> Candidate:
    """An effect in one of `count` places of equal prior probability."""
    place = Place(effect, where)
    term = Term(place.term_name(), effects()[effect], 0.0, 1.0, np.ones(4))
    return Candidate(place, (term,), log_fraction=float(-np.log(count)))


def fitted(log_evidence: float) -> Any:
    return SimpleNamespace(log_evidence=log_evidence, model=None)


def test_a_set_of_three_keeps_the_weight_of_all_places_of_its_effects(monkeypatch: pytest.MonkeyPatch) -> None:
    """If the evidence is the same in each of three equally probable places, places do not change the odds of a set."""
    monkeypatch.setattr(search, "screened", lambda families, near, worth: families)
    monkeypatch.setattr(
        search,
        "try_all",
        lambda model, data, families, near: [Trial(c, fitted(0.0)) for own in families.values() for c in own],
    )
    found = [Hypothesis((), fitted(0.0))]
    anywhere = [candidate("motor_thrust", motor, len(MOTORS)) for motor in MOTORS]
    others = {"wear": [candidate("wear")], "mass_offset": [candidate("mass_offset")], "motor_thrust": anywhere}
    for name in ("motor_thrust", "wear", "mass_offset"):
        (found,) = search._expanded(found, SimpleNamespace(), {name: others[name]}, -np.inf).values()
    odds = np.logaddexp.reduce([one.log_weight for one in found])
    assert odds == pytest.approx(search.log_prior_odds(["motor_thrust", "wear", "mass_offset"]))


def test_the_evidence_of_a_probable_set_does_not_depend_on_the_grid_of_its_fit() -> None:
    """Two grids of the scatter with the same ends, one without a value near the most probable one."""
    pairs = season(np.random.default_rng(7), OBSERVED_READOUTS[:6])
    flights, motors = [flight for flight, _ in pairs], [motor for _, motor in pairs]
    data = observe(history_of(flights, motors, used_in_fit=[True] * len(flights)))
    usual = rocket_model(history_of(flights, motors))
    linear, found = [], []
    for grid in ((0.5, 1.0, 6.5), (0.5, 4.0, 6.5)):
        own = replace(CERTIFIED_PRIOR, scatter=replace(CERTIFIED_PRIOR.scatter, grid=grid))
        one = Hypothesis((), fit(replace(usual, hyperprior=own), data, outlier_flights=True))
        linear.append(one.log_evidence)
        found.append(checked(SetPosterior((one,))).hypotheses[0].log_evidence)
    assert abs(linear[0] - linear[1]) > 0.4
    assert found[0] == pytest.approx(found[1], abs=0.1)


def test_the_correction_of_a_set_far_from_the_flights_is_not_used_for_others(monkeypatch: pytest.MonkeyPatch) -> None:
    """The linear fits of the plain model and of one effect alone have errors of 15 and 4 nats, those of better sets
    1."""
    off = {"": 15.0, "wear": 4.0, "wear+wind": 1.0, "mass_offset+wear": 1.0}
    linear = {"": -150.0, "wear": -5.0, "wear+wind": 0.0, "mass_offset+wear": -1.0, "wear+tip_off": -5.5, "wind": -9.0}

    def hypothesis(name: str) -> Hypothesis:
        own = SimpleNamespace(log_evidence=linear[name], model=None, name=name)
        own.unsolved = lambda: own
        return Hypothesis(tuple(candidate(effect) for effect in name.split("+") if effect), own)

    monkeypatch.setattr(search, "around_mode", lambda fit: fit)
    monkeypatch.setattr(
        search, "sampled", lambda fit, rng, **_: SimpleNamespace(log_evidence=fit.log_evidence + off[fit.name])
    )
    found = checked(SetPosterior(tuple(hypothesis(name) for name in linear)), window=5.2)
    assert [one.correction for one in found.hypotheses] == [15.0, 4.0, 1.0, 1.0, 2.0, 1.0]


def test_two_effects_that_hide_each_other_are_found_without_all_places_of_long_histories(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """A rocket wears while its days become calmer: neither effect alone improves the model. The number of pairs of all
    places would be the square of the number of flights."""
    places: list[int] = []

    def paired(families: Any, columns: Any, near: Any) -> Any:
        places.extend(len(family) for family in families.values())
        return pair_weights(families, columns, near)

    monkeypatch.setattr(search, "pair_weights", paired)
    calmer = two_configurations(wind=[8.0 - 0.5 * number for number in range(16)])
    true = (("wear", 0.02), ("wind", 0.5))
    terms = (replace(effect_terms(Place(name), calmer)[0], mean=strength) for name, strength in true)
    flown = measured(calmer.with_terms(*terms), seed=4)
    model, every = replace(rocket_model(flown.history), coarse=True), np.ones(16, bool)
    known = by_effect(list(effect_candidates(model, every)))
    tried = {name: known[name] for name in ("wear", "wind", "motor_thrust")}
    found = explore(model, observe(flown.history.using(every)), tried)
    assert found.sets[frozenset({"wear"})] < found.nothing > found.sets[frozenset({"wind"})]
    assert found.sets[frozenset({"wear", "wind"})] > 0.8
    assert max(places) <= MAX_PLACES < max(len(family) for family in tried.values())
    assert [one.members for one in found.hypotheses if one.fit.solution] == [frozenset()], "others take little memory"


def test_a_pair_is_tried_by_itself_only_if_it_is_probable_and_neither_effect_is_extended() -> None:
    sets = {frozenset[str](): [Hypothesis((), fitted(0.0))]}
    weights = {"wear": -2.6, "wind": -3.5, "motor_thrust": 0.5}
    for name, weight in weights.items():
        sets[frozenset({name})] = [Hypothesis((candidate(name),), fitted(weight))]
    couples = {
        ("wear", "wind"): -2.0,
        ("motor_thrust", "wear"): -2.0,
        ("wind", "tip_off"): -2.0,
        ("wear", "flutter"): -9.0,
    }
    extended = {frozenset({"motor_thrust"})}
    found = search._hidden(sets, {frozenset(pair): weight for pair, weight in couples.items()}, extended)
    assert found == {frozenset({"wear"}): ["wind"], frozenset({"wind"}): ["tip_off"]}


def test_a_pair_tried_by_itself_comes_last_and_excludes_no_other_set(monkeypatch: pytest.MonkeyPatch) -> None:
    """A pair that is better than every effect alone, but not than the sets that the best effect leads to."""
    alone = {"mach_drag": 30.0, "flutter": 20.0, "air_density": 19.0}
    trials = [Trial(candidate(name), fitted(evidence)) for name, evidence in alone.items()]
    couples = {frozenset({"flutter", "air_density"}): 40.0}
    pair = Hypothesis((candidate("mach_drag"), candidate("air_density")), fitted(60.0))
    parents = []

    def expanded(some: Any, data: Any, others: Any, best: float) -> Any:
        parents.append(some[0].members)
        return {pair.members: [pair]} if some[0].members == {"mach_drag"} else {}

    monkeypatch.setattr(search, "_singles", lambda *given: (fitted(0.0), trials, couples))
    monkeypatch.setattr(search, "_expanded", expanded)
    monkeypatch.setattr(search, "checked", lambda posterior, on_progress: posterior)
    found = explore(SimpleNamespace(), SimpleNamespace(), {name: [candidate(name)] for name in alone})
    assert parents == [{"mach_drag"}, {"mach_drag", "air_density"}]
    assert found.sets[pair.members] > 0.99


@pytest.mark.parametrize("effect", ["wear", "launch_angle", "early_ejection_seconds", "motor_thrust"])
@pytest.mark.parametrize("beyond", [-3.0, 0.0, 40.0])
def test_a_strength_has_the_moments_of_its_truncated_posterior(effect: str, beyond: float) -> None:
    """Compared with draws by inversion, for a normal posterior whose mean is below, at or far above the lower bound."""
    bends = effects()[effect]
    term = strength_term(TermName(effect, "effect"), bends, np.ones(4))
    sd = (bends.prior.high - bends.prior.low) / 100
    mean = bends.prior.low + beyond * sd
    ends = (bends.prior.low - mean) / sd, (bends.prior.high - mean) / sd
    drawn = bends.strength(truncnorm.rvs(*ends, loc=mean, scale=sd, size=40_000, random_state=1))
    middle, spread = strength_moments(term, mean, sd)
    assert middle == pytest.approx(drawn.mean(), abs=4 * drawn.std() / 200)
    assert spread == pytest.approx(drawn.std(), rel=0.03)
