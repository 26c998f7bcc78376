"""The family of hyperpriors from exact documents to loose ones."""

from dataclasses import replace

import numpy as np
import pytest

from fieldkit.flight import Flight
from fieldkit.inference.laplace.posterior import term_sds
from fieldkit.model.certified_prior import CERTIFIED_PRIOR
from fieldkit.model.documents import CERTIFIED_SCALE, SEARCH_PRIOR
from fieldkit.model.hyperprior import START
from fieldkit.model.rocket_model import base_model
from fieldkit.model.scale import HALF_CAUCHY, Scale
from fieldkit.model.term_names import TermName
from fieldkit.motors import catalogue
from fieldkit.physics.history import history_of

CHECK_SHAPES = False


def sds_at(scale: float) -> dict[TermName, float]:
    """Standard deviations of the terms of a model of two flights, at one distance from documents."""
    motor = catalogue().resolve("F24")
    flights = [Flight(flight_id=str(i), rocket="A", config="A", motor="F24", dry_mass=0.3) for i in range(2)]
    one = replace(START, documents=Scale((scale,), 1.0, 1.0, spread=HALF_CAUCHY))
    model = base_model(history_of(flights, [motor, motor]), one)
    return dict(zip(model.names, term_sds(model)[0].tolist(), strict=True))


def test_the_family_goes_from_exact_documents_through_the_expert_priors() -> None:
    exact, start = sds_at(CERTIFIED_SCALE), sds_at(1.0)
    motor = next(name for name in exact if (name.quantity, name.level) == ("thrust", "motor"))
    assert exact[motor] == pytest.approx(CERTIFIED_PRIOR.sd("thrust", "motor"))
    assert start[motor] == pytest.approx(START.sd("thrust", "motor"))
    assert exact[TermName("mass")] == pytest.approx(CERTIFIED_PRIOR.sd("mass", "rocket"))
    assert exact[TermName("apogee")] == pytest.approx(CERTIFIED_SCALE * START.sd("apogee", "rocket")), (
        "no discrepancy is left"
    )
    assert exact[TermName("drag")] == start[TermName("drag")], "no document states the drag of a rocket"


def test_a_half_cauchy_scale_has_a_heavy_tail_and_keeps_its_grid_over_the_prior() -> None:
    scale = Scale((0.1, 1.0, 10.0), 1.0, 1.0, spread=HALF_CAUCHY)
    density = np.exp(scale.log_density)
    assert density[0] == pytest.approx(density[2]), "in the logarithm it is even"
    assert density[1] / density[0] == pytest.approx(5.05), "x / (1 + x^2)"
    assert scale.refined().grid[0] < 0.15
    assert scale.refined().grid[-1] > 2


def test_a_grid_over_the_whole_prior_of_a_heavy_tailed_scale_has_the_weight_one() -> None:
    for scale in (START.scatter, START.motors, Scale((0.1, 4.0), 1.0, 1.0, spread=HALF_CAUCHY)):
        assert scale is not None
        fine = replace(scale, points=300).between(*scale.range)
        assert np.exp(fine.log_prior).sum() == pytest.approx(1.0, abs=1e-3)


def test_the_search_prior_rests_on_no_flight() -> None:
    assert SEARCH_PRIOR.means == START.means
    assert SEARCH_PRIOR.sd("mass", "rocket") == pytest.approx(np.hypot(0.05, 0.05)), "a lone rocket has its fleet's"
