"""The check of a fit's terms: right models pass as often as chance says, and a contradiction that only unusual values
explain is found."""

from collections.abc import Iterator
from dataclasses import replace

import numpy as np
import pytest
from scipy.stats import kstest

from fieldkit.flight import Flight
from fieldkit.inference.laplace.fit import fit
from fieldkit.inference.laplace.posterior import Fit, prior_precision
from fieldkit.model.readout_data import observe
from fieldkit.model.term_names import TermName
from fieldkit.motors import catalogue
from fieldkit.physics.history import history_of
from fieldkit.selection.diagnose import diagnose
from fieldkit.selection.extended_model import rocket_model
from fieldkit.selection.unexplained import leftover
from fieldkit.selection.usual_values import in_words, unusual_terms
from tests.seasons import season

DRAWS = 400


def fitted() -> Fit:
    """A fit to twelve flights as usual ones are."""
    pairs = season(np.random.default_rng(3), ("apogee", "top_speed", "burn_time", "coast_to_apogee"), scatter=0.03)
    history = history_of([flight for flight, _ in pairs], [motor for _, motor in pairs])
    model = replace(rocket_model(history), coarse=True)
    return fit(model, observe(history))


def drawn(known: Fit, rng: np.random.Generator) -> Iterator[Fit]:
    """The same fit to histories drawn from its prior, linear around its point."""
    best, evidence, solution = int(np.argmax(known.log_weight)), known.evidence, known.solution
    assert solution is not None
    covariance, precision = known.covariance[best], prior_precision(known.model)[0][best]
    slope, noise = evidence.slope, np.linalg.cholesky(evidence.noise()[best])
    for _ in range(DRAWS):
        truth = np.linalg.inv(np.linalg.cholesky(precision)).T @ rng.normal(size=len(precision))
        miss = slope @ truth + np.einsum("fop,fp->fo", noise, rng.normal(size=noise.shape[:2]))
        score = np.einsum("fot,fop,fp->t", slope, evidence.sharpness[best], miss)
        mean = known.mean.copy()
        mean[best] = [term.mean for term in known.model.terms] + covariance @ score
        yield replace(known, solution=replace(solution, mean=mean))


@pytest.mark.fast
def test_p_values_are_uniform_for_histories_of_the_prior() -> None:
    p = [unusual_terms(one)[0] for one in drawn(fitted(), np.random.default_rng(11))]
    assert kstest(p, "uniform").pvalue > 0.01
    assert np.mean(np.array(p) < 0.05) == pytest.approx(0.05, abs=0.03)


@pytest.mark.fast
def test_terms_that_are_far_from_usual_are_named() -> None:
    known = fitted()
    assert unusual_terms(known)[0] > 0.05
    solution, names = known.solution, known.model.names
    assert solution is not None
    mean = solution.mean.copy()
    drag = next(i for i, name in enumerate(names) if (name.quantity, name.level) == ("drag", "rocket"))
    mean[:, drag] += 6 * known.model.terms[drag].sd
    p, words = unusual_terms(replace(known, solution=replace(solution, mean=mean)))
    assert p < 0.001
    assert words == "an unusual drag"


def test_readouts_that_contradict_each_other_get_no_name() -> None:
    """A top speed with which a rocket without drag would hardly reach the apogee: friction on the rail of six times the
    weight would explain that."""
    rng = np.random.default_rng(4)
    scale = rng.normal(1, 0.06, size=12)
    motor = catalogue().resolve("F24-4W")
    flights = [
        Flight(
            str(i), "Big", "A", "F24-4W", dry_mass=0.31, diameter=0.054, wind=float(rng.uniform(0, 6)),
            apogee=240 * k, top_speed=58 * k, burn_time=2.1, peak_accel=7.9 * 9.80665, avg_accel=2.8 * k * 9.80665,
            coast_to_apogee=5.4 * k, apogee_to_eject=float(rng.uniform(-0.5, 0.6)),
        )
        for i, k in enumerate(scale.tolist())
    ]  # fmt: skip
    history = history_of(flights, [motor] * len(flights), used_in_fit=[True] * len(flights))
    found = diagnose(rocket_model(history), observe(history))
    assert found.effect == "unexplained"
    assert found.fits.pattern.startswith("an unusual")
    assert found.fits.p < 0.01
    assert leftover(found).in_words == "misses follow nothing that was recorded"


@pytest.mark.fast
@pytest.mark.parametrize(
    ("name", "words"),
    [
        (TermName("stretch", "motor", "AeroTech F24W"), "an unusual length of the burn of AeroTech F24W"),
        (TermName("early_ejection_seconds", "effect", ("", "3")), "an unusual early ejection"),
        (TermName("drag 2", "pattern", "hour"), "an unusual drag"),
        (TermName("coast_to_apogee"), "an unusual coast to apogee"),
    ],
)
def test_a_term_is_in_a_flyers_words(name: TermName, words: str) -> None:
    assert f"an unusual {in_words(name)}" == words
