"""The reproduction of the reference paper: each figure of the report compared with the published one."""

import json
import re
import sys
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from fieldkit.cli.main import main
from fieldkit.errors import ImpossibleFlight, UnknownMotor
from fieldkit.flight import Flight
from fieldkit.model.paper_prior_predictive import ALPHA_RANGE, CD_RANGE, paper_draws
from fieldkit.physics import paper
from fieldkit.physics.single import paper_flight
from fieldkit.reference.exact import bayes_limit, lowest, reconstructions
from fieldkit.reference.flights import Reference, certified, heights, normalised, reference
from fieldkit.reference.report import PaperReport, leave_one_out, pass_forecasts, report, rules, scatter
from fieldkit.reference.text import findings

CHECK_SHAPES = False


@pytest.fixture(scope="module")
def flights() -> Reference:
    return reference()


@pytest.fixture(scope="module")
def found() -> PaperReport:
    return report()


@pytest.mark.fast
def test_the_published_parameters_give_the_published_apogees(flights: Reference) -> None:
    here = heights(flights, flights.published_cd, flights.published_alpha, paper.paper_burns())
    assert len(here) == 12
    np.testing.assert_allclose(here, flights.published_apogee, atol=0.7)


def test_eight_of_the_twelve_flights_are_valid(flights: Reference) -> None:
    assert [flight.flight_id for flight in flights.part(flights.valid).flights] == [*"12349", "10", "11", "12"]


@pytest.mark.thorough
def test_the_published_errors_follow_from_the_published_apogees(found: PaperReport) -> None:
    own = found.published["reconstruction"]
    assert (round(own["mae_m"], 1), round(own["rmse_m"], 1), round(own["bias_m"], 1)) == (12.3, 14.0, 12.3)


def test_the_ensemble_is_as_good_as_the_published_one_on_simulated_flights(found: PaperReport) -> None:
    assert found.synthetic["cd_mae"] == pytest.approx(0.088, abs=0.003)
    assert found.synthetic["alpha_mae"] == pytest.approx(0.071, abs=0.003)


def test_no_ensemble_beats_the_bayes_limit_except_by_chance(found: PaperReport) -> None:
    for name in ("cd", "alpha"):
        slack = 4 * found.synthetic[f"{name}_standard_error"]
        assert found.synthetic[f"{name}_mae"] > found.bayes_limit[f"{name}_mae"] - slack


def test_the_bayes_limit_is_near_the_published_errors() -> None:
    limit = bayes_limit()
    assert limit["cd_mae"] == pytest.approx(0.0878, abs=2e-4)
    assert limit["alpha_mae"] == pytest.approx(0.0707, abs=2e-4)


def test_the_bayes_limit_does_not_depend_on_its_grid() -> None:
    coarse, fine = bayes_limit(count=60, step=2.5), bayes_limit()
    assert coarse == pytest.approx(fine, abs=2e-4)


def test_the_spread_of_the_ensemble_covers_almost_nothing(found: PaperReport) -> None:
    assert 0.01 < found.synthetic["cd_coverage_one_sd"] < 0.10
    assert 0.01 < found.synthetic["alpha_coverage_one_sd"] < 0.10


def test_reconstructions_have_the_errors_typical_of_this_method(found: PaperReport) -> None:
    assert 3 < found.reconstruction["mae_m"] < 18
    assert found.reconstruction["bias_m"] == pytest.approx(found.reconstruction["mae_m"], abs=1)
    for one in found.flights:
        assert one["cd"] == pytest.approx(one["published_cd"], abs=0.08)
        assert one["alpha"] == pytest.approx(one["published_alpha"], abs=0.05)


def test_the_openrocket_column_has_larger_errors_than_stated(found: PaperReport) -> None:
    assert found.openrocket["mae_m"] == pytest.approx(43.6, abs=0.05)
    assert found.openrocket["rmse_m"] == pytest.approx(46.8, abs=0.05)


def test_the_published_profile_delivers_too_much_impulse(found: PaperReport) -> None:
    motors = found.thrust_profile["motors"]
    assert [round(motor["delivered_ns"], 1) for motor in motors] == [41.3, 64.5, 61.0]
    assert [round(motor["certified_ns"], 1) for motor in motors] == [39.4, 47.3, 49.7]


def test_the_profile_causes_the_bias(found: PaperReport) -> None:
    bias = found.thrust_profile["exact_posterior_bias_m"]
    assert bias["published"] == pytest.approx(14.3, abs=0.2)
    assert bias["impulse_normalised"] == pytest.approx(0.7, abs=0.1)
    assert bias["certified"] == pytest.approx(0.7, abs=0.1)
    assert bias["certified_with_casing"] == pytest.approx(0.8, abs=0.1)
    assert found.thrust_profile["below_lowest_apogee_of_prior"] == {
        "published": 5,
        "impulse_normalised": 0,
        "certified": 0,
        "certified_with_casing": 0,
    }


def test_quadrature_has_converged(flights: Reference) -> None:
    valid = flights.part(flights.valid)
    for curves in (paper.paper_burns(), certified()):
        coarse, fine = (reconstructions(valid, curves, count=count) for count in (30, 60))
        np.testing.assert_allclose(coarse, fine, atol=0.05)


def test_the_exact_posterior_reproduces_an_apogee_within_the_priors_range(flights: Reference) -> None:
    curves = normalised()
    reachable = flights.part(flights.apogee > lowest(flights, curves) + 20)
    assert len(reachable) >= 5
    assert np.abs(reconstructions(reachable, curves) - reachable.apogee).max() < 5


def test_scaled_profiles_deliver_the_declared_impulse(flights: Reference) -> None:
    ratio = [motor.delivered_impulse / motor.total_impulse for motor in paper.MOTORS]
    weaker = heights(flights, np.full(12, 0.6), 1 / np.array(ratio)[flights.motor], paper.paper_burns())
    np.testing.assert_allclose(heights(flights, np.full(12, 0.6), np.ones(12), normalised()), weaker, rtol=1e-9)


MAE = {
    "motor_mean": (13.4, 0.05),
    "motor_and_config_mean": (16.2, 0.05),
    "alpha_certified": (17.2, 0.3),
    "hierarchical_certified": (20.0, 1.0),
    "cd_and_alpha_certified": (20.8, 0.4),
    "published_carried_over": (25.2, 0.1),
    "nominal_casing": (56.0, 0.5),
    "nominal_certified": (74.0, 0.5),
    "nominal_paper": (145.0, 0.5),
}
"""Each rule's mean absolute error, and its tolerance for the choice of integrator and priors. [m]"""


def test_every_rule_has_its_known_error(found: PaperReport) -> None:
    assert {rule["rule"] for rule in found.rules} == set(MAE)
    for rule in found.rules:
        expected, tolerance = MAE[rule["rule"]]
        assert rule["mae_m"] == pytest.approx(expected, abs=tolerance), rule["rule"]
    assert {rule["rule"]: rule["n"] for rule in found.rules if rule["n"] != 8} == {"motor_and_config_mean": 6}
    assert all(3.8 < rule["standard_error_m"] < 6.2 for rule in found.rules[:6])


def test_no_rule_uses_the_flight_it_forecasts(flights: Reference) -> None:
    arrays = {name: getattr(flights, name).copy() for name in Reference.__slots__ if name != "flights"}
    for name in ("apogee", "published_cd", "published_alpha"):
        arrays[name][1] *= 0.8
    changed = Reference(flights=flights.flights, **arrays)
    row = np.array([1])
    for before, after in zip(rules(flights), rules(changed), strict=True):
        assert leave_one_out(flights, before.forecast, row) == leave_one_out(changed, after.forecast, row)


def test_flights_of_one_setup_scatter_by_sixteen_meters(flights: Reference) -> None:
    found = scatter(flights)
    assert found["sd_m"] == pytest.approx(16.0, abs=0.05)
    assert found["degrees_of_freedom"] == 4
    assert found["perfect_mae_m"] < 15 < found["two_peers_mae_m"]


def test_simulated_flights_follow_the_prior() -> None:
    draws = paper_draws(np.random.default_rng(2), 4000)
    for column, (low, high) in enumerate((CD_RANGE, ALPHA_RANGE)):
        values = draws.truth[:, column]
        assert low <= values.min() < low + 0.01 * (high - low)
        assert high - 0.01 * (high - low) < values.max() <= high
    exact = heights_of(draws.motor, draws.dry_mass, draws.truth)
    assert (draws.apogee - exact).std() == pytest.approx(3.0, rel=0.05)
    assert np.bincount(draws.motor) == pytest.approx([4000 / 3] * 3, rel=0.1)


def heights_of(motor: np.ndarray, dry_mass: np.ndarray, truth: np.ndarray) -> np.ndarray:
    from fieldkit.physics.flight import apogees

    return apogees(paper.paper_setup(motor, dry_mass, truth[:, 0], truth[:, 1]))


def test_findings_quote_the_figures(found: PaperReport) -> None:
    printed = " ".join(findings(found))
    for figure in ("12.3", "43.6", "19.9", "41.3, 64.5 and 61.0", "39.4, 47.3 and 49.7", "5 of the 8", "16.0"):
        assert figure in printed


Run = Callable[..., str]


@pytest.fixture
def run(capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> Run:
    """Runs a command line and returns what it printed."""
    monkeypatch.setenv("COLUMNS", "80")
    monkeypatch.setenv("FIELDKIT_HOME", str(tmp_path))

    def run(*arguments: object, status: int = 0) -> str:
        assert main([*map(str, arguments)]) == status
        printed = capsys.readouterr()
        return printed.err if status else printed.out

    return run


@pytest.fixture
def computed(found: PaperReport, monkeypatch: pytest.MonkeyPatch) -> None:
    """The report as already computed."""
    monkeypatch.setattr("fieldkit.reference.report.report", lambda: found)


@pytest.mark.usefixtures("computed")
def test_the_report_fits_eighty_columns(run: Run) -> None:
    lines = run("paper").splitlines()
    assert max(map(len, lines)) <= 80
    assert not any("…" in line for line in lines)


@pytest.mark.usefixtures("computed")
def test_the_report_is_in_the_units_of_the_user(run: Run, tmp_path: Path) -> None:
    (tmp_path / "settings.json").write_text('{"units": "US"}')
    text = run("paper")
    assert not re.search(r"\d m\b|\[m\]", text)
    assert "923" in text  # the apogee of flight 2 [ft]
    assert "40 ft" in text  # its published error, 12.3 m


@pytest.mark.usefixtures("computed")
def test_the_report_as_json_has_the_promised_keys(run: Run) -> None:
    document = json.loads(run("paper", "--json"))
    assert len(document["flights"]) == 12
    assert {"mae_m", "rmse_m", "bias_m", "published", "next_flight", "rules", "findings"} <= set(document)


@pytest.mark.parametrize(
    "command",
    [
        ("study", "reference"),
        ("study", "rockets"),
    ],
)
def test_if_the_studies_are_missing_their_commands_say_what_to_install(
    run: Run, command: tuple[str, ...], monkeypatch: pytest.MonkeyPatch
) -> None:
    for name in [name for name in sys.modules if name.split(".")[0] == "studies"]:
        monkeypatch.delitem(sys.modules, name)
    monkeypatch.setitem(sys.modules, "studies", None)  # as in a plain wheel: the import finds nothing
    (line,) = run(*command, status=1).splitlines()
    assert line.endswith("the studies are not in the installed program; from a checkout of fieldkit: pip install -e .")


SIMULATE = ("simulate", "--motor", "E35-5W", "--dry-mass-g", 448, "--diameter-mm", 66, "--cd", 0.659, "--alpha", 0.887)


def test_simulate_reproduces_the_papers_first_flight(run: Run) -> None:
    document = json.loads(run(*SIMULATE, "--physics", "paper", "--json"))
    assert document["apogee_m"] == pytest.approx(170.8, abs=0.7)
    assert set(document) >= {"top_speed_mps", "burn_time_s", "coast_to_apogee_s"}


def test_simulate_uses_the_conditions_of_the_field(run: Run) -> None:
    calm = json.loads(run(*SIMULATE, "--json"))
    windy = json.loads(run(*SIMULATE, "--wind", "15mph", "--json"))
    high = json.loads(run(*SIMULATE, "--site-elevation-m", 1500, "--json"))
    assert windy["apogee_m"] < calm["apogee_m"] < high["apogee_m"]
    assert set(calm) >= {"apogee_to_eject_s", "eject_altitude_m", "duration_s"}


@pytest.mark.parametrize(
    ("more", "status", "words"),
    [
        (("--physics", "paper", "--wind-mps", "3"), 1, "the paper's physics takes motor, dry mass and diameter"),
        (("--lift-off-mass", "385g"), 2, "both or none of --dry-mass and --lift-off-mass"),
        (("--dry-mass-g", "99999"), 1, "does not lift"),
        (("--dry-mass-g", "x"), 1, "expected a number"),
        (("--motor", "Q0"), 1, "found a class above O"),
        (("--cd", "nan"), 2, "--cd"),
    ],
)
def test_simulate_reports_wrong_input(run: Run, more: tuple[str, ...], status: int, words: str) -> None:
    assert words in " ".join(run(*SIMULATE, *more, status=status).split())


def test_the_papers_physics_has_only_its_own_motors() -> None:
    plan = Flight(motor="C6-5", dry_mass=0.322, diameter=0.066)
    with pytest.raises(UnknownMotor, match="the paper flew no motor"):
        paper_flight(plan, 0.6, 1.0)
    with pytest.raises(ImpossibleFlight, match="no diameter"):
        paper_flight(plan.with_changes(diameter=None), 0.6, 1.0)


def test_the_linear_pass_forecasts_each_flight_without_its_own_apogee(flights: Reference) -> None:
    """Changing a flight's apogee changes the others' forecasts, but not its own."""
    before = pass_forecasts(flights)
    own = list(flights.flights)
    own[1] = own[1].with_changes(apogee=1.1 * float(flights.apogee[1]))
    after = pass_forecasts(replace(flights, flights=tuple(own)))
    assert after[1] == before[1]
    assert after[2].apogee[1] > before[2].apogee[1]


def test_the_report_has_the_network_and_the_linear_pass_side_by_side(found: PaperReport) -> None:
    printed = [one["linear_pass"] for one in found.flights]
    assert [one["flight_id"] for one in printed] == [one["flight_id"] for one in found.flights]
    for one in printed:
        low, middle, high = (one["apogee_m"][key] for key in ("p05", "p50", "p95"))
        assert 0 < low < middle < high
    miss = np.array([one["linear_pass"]["apogee_m"]["p50"] - one["apogee_m"] for one in found.flights if one["valid"]])
    assert found.linear_pass["mae_m"] == pytest.approx(np.abs(miss).mean())
