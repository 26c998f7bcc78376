"""Learning the hyperprior recovers simulated standard deviations and never lowers the evidence."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from fieldkit.flight import Flight
from fieldkit.inference.laplace.learning import MEAN_SD, evidence, learn_hyperprior, mean_sds
from fieldkit.model.hyperprior import START, Hyperprior
from fieldkit.model.rocket_model import base_model
from fieldkit.model.scale import Scale
from fieldkit.model.shared_prior import SharedPrior
from fieldkit.model.simulated_readouts import shown
from fieldkit.model.term_names import TermName, fleet_term
from fieldkit.motors import Found, catalogue
from fieldkit.physics.history import history_of

CHECK_SHAPES = False
ROCKETS, FLIGHTS = 8, 4
MOTORS = ("F24", "F39", "E35")
COARSE = replace(START, scatter=Scale((0.5, 1.0, 2.0), 1.0, 0.7), reading=Scale((1.0,), 1.0, 0.7))
"""Few scales, for speed; rockets have equal scatter here."""


def fleet(rocket_sd: float, flight_sd: float, seed: int = 3) -> list[list[tuple[Flight, Found]]]:
    """Rockets with these standard deviations of log drag and of their flights' log apogees."""
    rng = np.random.default_rng(seed)
    found = []
    for number in range(ROCKETS):
        plans = [
            Flight(f"{i}", f"R{number}", "A", MOTORS[i % 3], dry_mass=0.32, diameter=0.066) for i in range(FLIGHTS)
        ]
        motors = [catalogue().resolve(plan.motor) for plan in plans]
        model = base_model(history_of(plans, motors), START)
        truth = np.array([[term.mean for term in model.terms]])
        truth[0, model.names.index(TermName("drag"))] += rocket_sd * rng.normal()
        shows = shown(model, truth, {})["apogee"][0] * np.exp(flight_sd * rng.normal(size=FLIGHTS))
        found.append(
            [(one.with_changes(apogee=float(x)), motor) for one, x, motor in zip(plans, shows, motors, strict=True)]
        )
    return found


@cache
def learned(rocket_sd: float, flight_sd: float) -> Hyperprior:
    return learn_hyperprior([fleet(rocket_sd, flight_sd)], COARSE, rounds=1, steps=12)


@pytest.mark.usefixtures("shapes_checked")
def test_a_step_of_learning_has_the_annotated_shapes() -> None:
    assert learn_hyperprior([fleet(0.3, 0.05)[:2]], COARSE, rounds=1, steps=1).sds


@pytest.mark.thorough
def test_larger_scatter_of_flights_is_learned() -> None:
    calm, wild = learned(0.3, 0.02), learned(0.3, 0.15)
    assert calm.sd("apogee", "flight") < START.sd("apogee", "flight") < wild.sd("apogee", "flight")
    assert wild.sd("apogee", "flight") == pytest.approx(0.15, rel=0.4)


@pytest.mark.thorough
def test_larger_differences_between_rockets_are_learned() -> None:
    assert learned(0.05, 0.03).sd("drag", "rocket") < 0.75 * learned(0.6, 0.03).sd("drag", "rocket")


def test_learning_increases_the_likelihood_of_the_flights() -> None:
    flights = [fleet(0.3, 0.15)]
    assert evidence(flights, learned(0.3, 0.15)) > evidence(flights, COARSE) + 1.0


def test_effects_absent_at_the_start_stay_absent() -> None:
    assert set(learned(0.3, 0.02).sds) == set(START.sds)
    assert learned(0.3, 0.02).reading.log_sd == START.reading.log_sd


def fleets_known_to(variance: float, flyers: int) -> list[SharedPrior]:
    quantities = [quantity for quantity in START.means if START.sd(quantity, "fleet")]
    names = tuple(fleet_term(quantity) for quantity in quantities)
    between = np.array([START.sd(quantity, "fleet") ** 2 for quantity in quantities])
    return [SharedPrior(names, np.zeros(len(names)), np.diag(variance * between))] * flyers


def test_the_uncertainty_of_an_unobserved_mean_does_not_change() -> None:
    for sd in mean_sds(fleets_known_to(1.0, 3), START).values():
        assert sd == pytest.approx(MEAN_SD)


@pytest.mark.parametrize("flyers", [1, 3, 1000])
def test_the_uncertainty_of_a_mean_follows_from_the_agreement_of_flyers(flyers: int) -> None:
    """Of n draws from a normal distribution, and a normal prior."""
    for quantity, sd in mean_sds(fleets_known_to(0.0, flyers), START).items():
        between = START.sd(quantity, "fleet")
        assert sd == pytest.approx((flyers / between**2 + 1 / MEAN_SD**2) ** -0.5)


def test_a_new_flyer_may_differ_by_both() -> None:
    card = replace(START, mean_sds={"top_speed": 0.12})
    assert card.fleet_sd("top_speed") == pytest.approx(np.hypot(START.sd("top_speed", "fleet"), 0.12))
    assert card.fleet_sd("burn_time") == START.sd("burn_time", "fleet")
    assert card.fleet_sd("delay") == 0.0


def test_a_learned_card_states_the_uncertainty_of_each_mean() -> None:
    found = learned(0.3, 0.02)
    assert set(found.mean_sds) == set(found.means) == {"drag", "mass", "apogee"}
    assert found.mean_sds["drag"] < MEAN_SD
