"""The loop's report: figures with intervals, forward in time, informative tests, and a page that escapes names."""

import math
import re
from base64 import b64decode
from dataclasses import replace
from pathlib import Path
from xml.etree import ElementTree

import numpy as np
import pytest

from fieldkit.errors import BadValue, FieldkitError
from fieldkit.flight import Flight
from fieldkit.forecast.assumed import Assumed
from fieldkit.forecast.predict import predict
from fieldkit.inference.laplace.posterior import Solution
from fieldkit.ledger import Ledger
from fieldkit.model.readout_data import observe
from fieldkit.motors import catalogue
from fieldkit.physics.history import history_of
from fieldkit.presentation.json_documents import loop_document
from fieldkit.presentation.loop_text import BARS, MIN_CHANCE_LISTED, misses, misses_drawn, report
from fieldkit.presentation.report.book import FlightReport
from fieldkit.presentation.report.loop.page import check_page, page, write_page
from fieldkit.presentation.report.paper import pages
from fieldkit.presentation.report.style import styled
from fieldkit.presentation.report.write import write_report
from fieldkit.scoring.bootstrap import gain, judge
from fieldkit.scoring.score import Forecasts
from fieldkit.selection.averaged import MIN_EARLIER_FLIGHTS, ahead
from fieldkit.selection.candidates import Place
from fieldkit.selection.diagnose import Diagnosis, diagnose
from fieldkit.selection.extended_model import rocket_model
from fieldkit.selection.fingerprint import marks
from fieldkit.selection.hypotheses import Hypothesis, SetPosterior
from fieldkit.selection.next_experiment import BALLAST, Advice, Explanation, divergence, informative_readouts, options
from fieldkit.selection.unexplained import Leftover, leftover
from fieldkit.selection.verdict import LoopVerdict
from fieldkit.services import close_loop, forecasts, model_versions
from fieldkit.services.findings import Findings, distinct, findings
from tests.commands import Run
from tests.presentation.report.pages import Page

CHECK_SHAPES = False

HOSTILE = "<script>alert('x')</script> & $\\frac{1}{0}$"
"""A flight id, rocket, motor name or site from a file."""


def windy() -> list[Flight]:
    """Twelve flights on two motors that lose height to the wind, simulated by the model with rounded readings."""
    from fieldkit.physics.flight import fly
    from fieldkit.physics.history import field_setup

    rng = np.random.default_rng(5)
    wind = rng.uniform(0.5, 8.0, 12)
    names = ["F24-4W", "F39-6T"]
    plans = [
        Flight(
            f"{HOSTILE} {n}", HOSTILE, "A", names[n % 2], site=HOSTILE, dry_mass=0.322, diameter=0.066, wind=float(w)
        )
        for n, w in enumerate(wind)
    ]
    found = [catalogue().resolve(plan.motor) for plan in plans]
    setup = field_setup(plans, found, np.full(12, 0.6 * np.pi / 4 * 0.066**2), 1 + 0.02 * rng.normal(size=12))
    shown = fly(setup.with_changes(wind=0.9 * wind)).readouts()
    kept = ("apogee", "top_speed", "coast_to_apogee")
    return [
        plan.with_changes(**{name: round(float(shown[name][n]), 1) for name in kept}) for n, plan in enumerate(plans)
    ]


@pytest.fixture(scope="module")
def diagnosis() -> Diagnosis:
    flights = windy()
    model = rocket_model(history_of(flights, [catalogue().resolve(flight.motor) for flight in flights]))
    return diagnose(model, observe(model.history.using([True] * len(flights))))


@pytest.fixture(scope="module")
def found(diagnosis: Diagnosis) -> Findings:
    return findings(HOSTILE, diagnosis)


# Errors and their intervals


def normal(mean: np.ndarray, sd: float = 0.1) -> Forecasts:
    return Forecasts(mean[None], np.full((1, len(mean)), sd), np.ones((1, len(mean))))


def test_the_interval_of_an_error_has_its_stated_coverage() -> None:
    rng = np.random.default_rng(2)
    inside = 0
    for _ in range(150):
        truth = rng.normal(0.02, 0.1, 25) + 5.0
        low, high = judge(normal(np.full(25, 5.0)), truth, np.ones(25, bool)).bias
        inside += low < np.exp(5.0) * (1 - np.exp(0.02 + 0.005)) < high
    assert 0.8 < inside / 150 < 0.96


def test_an_interval_is_the_same_at_every_call_and_narrows_with_flights() -> None:
    truth = 5.0 + np.random.default_rng(3).normal(0, 0.1, 80)
    few, many = (judge(normal(np.full(n, 5.0)), truth[:n], np.ones(n, bool)) for n in (10, 80))
    assert few == judge(normal(np.full(10, 5.0)), truth[:10], np.ones(10, bool))
    assert many.mae[1] - many.mae[0] < few.mae[1] - few.mae[0]
    assert many.mae[0] < many.score.mae < many.mae[1]


def test_a_gain_compares_the_same_flights() -> None:
    truth = 5.0 + np.random.default_rng(4).normal(0, 0.1, 30)
    better, (low, _) = gain(normal(np.full(30, 5.0)), normal(truth), truth, np.ones(30, bool))
    assert better > low > 0
    assert gain(normal(truth), normal(truth), truth, np.ones(30, bool)) == (0.0, (0.0, 0.0))


def test_no_flights_have_no_errors() -> None:
    judged = judge(normal(np.full(3, 5.0)), np.full(3, 5.0), np.zeros(3, bool))
    assert judged.flights == 0
    assert np.isnan(judged.mae[0])


# Forward in time


@pytest.mark.thorough
def test_a_flight_is_forecast_from_earlier_flights(found: Findings) -> None:
    assert found.ahead.seen.tolist() == [False] * MIN_EARLIER_FLIGHTS + [True] * (12 - MIN_EARLIER_FLIGHTS)
    assert found.forward.before.flights == 12 - MIN_EARLIER_FLIGHTS
    assert not any(found.ahead.chosen[:MIN_EARLIER_FLIGHTS])


def test_later_flights_change_no_earlier_choice(diagnosis: Diagnosis, found: Findings) -> None:
    """The last flight's apogee is absurd, which must not change any earlier forecast."""

    def spoilt(one: Hypothesis) -> Hypothesis:
        fit, miss = one.fit, one.fit.evidence.miss.copy()
        miss[-1] += 1.0
        solution = Solution(replace(fit.evidence, miss=miss), fit.mean, fit.posterior)
        return replace(one, fit=replace(fit, solution=solution))

    later = ahead(SetPosterior(tuple(spoilt(one) for one in diagnosis.posterior.hypotheses)))
    assert later.chosen == found.ahead.chosen
    np.testing.assert_allclose(later.after.apogee, found.ahead.after.apogee)


def test_the_effect_is_found_on_the_way_and_helps(found: Findings) -> None:
    assert found.diagnosis.effect == "wind"
    assert found.ahead.chosen[-1] == "wind"
    assert found.forward.after.score.mae < found.forward.before.score.mae


# The verdict in plain words


def test_a_verdict_states_effect_evidence_probability_next_test_and_consequence(found: Findings) -> None:
    document, text, written = loop_document(found), "\n".join(report(found)), page(found)
    verdict = document["verdict"]
    one = verdict["next_flight"]
    assert one["change_m"] == pytest.approx(one["after_m"] - one["before_m"])
    assert one["change_percent"] == pytest.approx(100 * one["change_m"] / one["before_m"])
    assert f"{abs(one['change_percent']):.1f}%)" in text
    for words in (verdict["odds"], *verdict["accepting"]):
        assert words in text
        assert words.split(":")[0][1:] in written
    assert verdict["accepting"][0].startswith("forecasts average over: ")
    assert "--decline wind" in verdict["accepting"][-1]
    assert len(verdict["tell_apart"]) == len(found.tests)
    assert all(test.in_words in text for test in found.tests)


def test_errors_before_and_after_are_plotted_and_decrease(found: Findings) -> None:
    rows = misses(found)
    before, after = ([abs(row[f"{when}_m"]) for row in rows] for when in ("before", "after"))
    assert np.mean(before) == pytest.approx(found.left_out.before.score.mae)
    assert np.mean(after) == pytest.approx(found.left_out.after.score.mae)
    title, one, other, _ = misses_drawn(found)
    assert f"{max(before + after):.0f} m" in title
    drawn = [[BARS.index(bar) for bar in line.split()[1]] for line in (one, other)]
    assert len(drawn[0]) == len(drawn[1]) == len(rows)
    assert sum(drawn[1]) < sum(drawn[0])


def test_nothing_is_plotted_if_forecasts_do_not_change(found: Findings) -> None:
    plain = replace(found, diagnosis=replace(found.diagnosis, averaged=((1.0, ()),)))
    assert list(misses_drawn(plain)) == []
    assert (
        list(misses_drawn(replace(found, diagnosis=replace(found.diagnosis, verdict=LoopVerdict("none", 0.9, "")))))
        == []
    )
    assert loop_document(plain)["verdict"]["accepting"] == ["forecasts use no correction"]


# The fingerprint


def test_the_fingerprint_of_the_true_effect_agrees_with_the_residuals(diagnosis: Diagnosis) -> None:
    rows = {mark.readout: mark for mark in marks(diagnosis, diagnosis.accepted[0])}
    assert len(rows) == 10
    for name in ("apogee", "coast_to_apogee"):
        assert rows[name].expected < -2 * rows[name].sd
        assert rows[name].found == pytest.approx(rows[name].expected, abs=3 * rows[name].sd)
    assert np.isnan(rows["duration"].found)


# Informative tests


def explanations(diagnosis: Diagnosis) -> tuple[Explanation, Explanation]:
    wind, tilt = (
        next(item.best for item in diagnosis.ranking if item.effect == name) for name in ("wind", "launch_angle")
    )
    return Explanation((wind.candidate.place,), wind.fit), Explanation((tilt.candidate.place,), tilt.fit)


def test_wind_is_distinguished_from_a_tilted_rail_by_measuring_the_rail_or_flying_in_wind(diagnosis: Diagnosis) -> None:
    advice = informative_readouts(diagnosis.model, *explanations(diagnosis))
    assert advice == sorted(advice, key=lambda one: -one.expected)
    flights = [one for one in advice if one.readouts]
    calm, gusty = (
        next(one.expected for one in flights if "F24" in one.what and words in one.what)
        for words in ("calm air", "wind")
    )
    assert gusty != pytest.approx(calm)
    assert any("rail" in one.what and not one.readouts for one in advice)
    assert all(one.expected >= 0 for one in advice)


def test_planned_flights_use_existing_motors_and_configurations(diagnosis: Diagnosis) -> None:
    plans = list(options(diagnosis.model))
    assert {plan.motor for _, plan, _ in plans} == {"F24-4W", "F39-6T"}
    assert max(plan.dry_mass or 0 for _, plan, _ in plans) == pytest.approx(BALLAST * 0.322)
    assert all(not plan.tags for _, plan, _ in plans)


def test_the_divergence_is_that_of_normal_distributions() -> None:
    one, other = (np.array([0.0]), np.array([[1.0]])), (np.array([2.0]), np.array([[1.0]]))
    assert divergence(one, other, [0]) == pytest.approx(2.0)
    assert divergence(one, one, [0]) == 0.0
    wide = (np.array([0.0]), np.array([[100.0]]))
    assert 0 < divergence(one, wide, [0]) < 4


# Unexplained patterns


def test_draws_are_widened_about_their_median() -> None:
    flights = windy()[:4]
    known = [(flight, catalogue().resolve(flight.motor)) for flight in flights]
    (narrow,) = predict(known, [(flights[0].with_changes(apogee=None), known[0][1])], draws=300)
    wide = narrow.corrected(1.5, 20)
    assert np.median(wide.apogee) == pytest.approx(np.median(narrow.apogee))
    np.testing.assert_allclose(np.log(wide.apogee).std(), 1.5 * np.log(narrow.apogee).std(), rtol=0.02)
    np.testing.assert_array_equal(narrow.corrected(1.0, 20).apogee, narrow.apogee)


def test_the_pattern_of_the_residuals_is_described(diagnosis: Diagnosis) -> None:
    pattern = leftover(diagnosis)
    for system, unit, scale in (("SI", "m/s", 1.0), ("US", "mph", 0.44704)):
        words = re.fullmatch(
            rf"the \d+ flights with wind above (\S+) {unit} fly \d+% lower than the others \(± \d+%\)",
            pattern.words(system),
        )
        assert words
        assert float(words[1]) * scale == pytest.approx(pattern.bound, abs=0.3)


@pytest.mark.parametrize(
    ("header", "value", "words"),
    [
        ("temperature_c", 288.15, "temperature above 15 °C"),
        ("pressure_hpa", 101_300.0, "pressure above 1013 hPa"),
        ("rail_angle_deg", math.radians(5), "rail angle above 5°"),
        ("expected_top_speed_mps", 100.0, "expected top speed above 100 m/s"),
        ("flight_number", 12.0, "the flight number above 12"),
    ],
)
def test_a_bound_has_the_unit_of_its_column(header: str, value: float, words: str) -> None:
    found = Leftover("", np.ones(3, bool), 0.05, 0.01, column=header, bound=value)
    assert found.in_words == f"the 3 flights with {words} fly 5% higher than the others (± 1%)"


def test_only_tests_that_may_decide_are_suggested() -> None:
    strong, weak = (
        Advice("fly it", motor, ("apogee",), nats, 1.0, 2.0) for motor, nats in (("F24", 1.0), ("F39", 0.6))
    )
    assert distinct([strong, weak]) == (strong,)


@pytest.mark.parametrize(
    ("nats", "evidence"), [(1.0, "gives a hint"), (2.0, "shows which is likelier"), (3.5, "all but decides")]
)
def test_a_proposed_flight_states_its_evidence_in_words(nats: float, evidence: str) -> None:
    test = Advice("fly the F24", "F24", ("apogee",), nats, 210.0, 240.0)
    assert test.words() == f"fly the F24 and record apogee (apogee 210 or 240 m): {evidence}"
    assert test.odds == {1.0: "2.7 to 1", 2.0: "7 to 1", 3.5: "33 to 1"}[nats]


def test_a_model_version_keeps_its_average(
    diagnosis: Diagnosis, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    motors = catalogue()
    wind, wear = (Place("wind"),), (Place("wear"),)
    both = replace(diagnosis, averaged=((0.7, wind), (0.3, wear)))
    with Ledger.open(tmp_path / "ledger.db") as ledger:
        ledger.add(windy())
        for averaged, versions in ((both.averaged, 1), (((0.703, wind), (0.297, wear)), 1), (((1.0, ()),), 1)):
            monkeypatch.setattr(close_loop, "diagnose", lambda *_, now=averaged: replace(both, averaged=now))
            close_loop.adopt(ledger, HOSTILE, close_loop.diagnosis_of(ledger, motors, HOSTILE))
            assert len(ledger.versions(HOSTILE)) == versions
            assert forecasts.accepted_average(ledger, HOSTILE, "before") == ()
        assert model_versions.version_average(ledger.versions(HOSTILE)[0].payload) == both.averaged
        assert forecasts.accepted_average(ledger, HOSTILE) == ()
    assert model_versions.version_average({"effects": [{"effect": "wind"}]}) == ((1.0, wind),)
    with pytest.raises(BadValue, match="cannot read"):
        model_versions.version_average({"effect": "wind"})


def test_a_forecast_averaged_over_sets_is_their_mixture() -> None:
    flights = windy()
    known = [(flight, catalogue().resolve(flight.motor)) for flight in flights]
    plan = [(flights[0].with_changes(apogee=None, top_speed=None, coast_to_apogee=None, wind=9.0), known[0][1])]
    sets = ((), (Place("wear", since=flights[0].flight_id),), (Place("mass_offset"), Place("wear")))
    by_set = [predict(known, plan, Assumed(((1.0, own),), declared=False), draws=1500)[0].apogee for own in sets]
    averaged = tuple(zip((0.2, 0.5, 0.3), sets, strict=True))
    (mixed,) = predict(known, plan, Assumed(averaged, declared=False), draws=3000)
    expected = 0.2 * by_set[0].mean() + 0.5 * by_set[1].mean() + 0.3 * by_set[2].mean()
    assert len(mixed.apogee) == 3000
    assert mixed.apogee.mean() == pytest.approx(expected, rel=0.01)


# The page


@pytest.fixture(scope="module")
def html(found: Findings) -> Page:
    return Page(page(found))


def test_names_from_files_are_text_on_the_page(html: Page) -> None:
    assert "script" not in html.tags
    words = " ".join(html.text)
    assert words.count(HOSTILE) >= 12


def test_the_page_is_self_contained(html: Page) -> None:
    assert len(html.sources) == 4
    for source in html.sources:
        head, _, data = source.partition(",")
        assert head == "data:image/svg+xml;base64"
        picture = ElementTree.fromstring(b64decode(data))
        assert picture.tag.endswith("svg")
        assert not [one for one in picture.iter() if one.tag.endswith(("script", "foreignObject"))]


def test_the_page_has_the_same_content_as_the_terminal(html: Page, found: Findings) -> None:
    words = " ".join(" ".join(html.text).split())
    assert f"{found.left_out.before.score.mae:.1f} m" in words
    assert "weathercocking" in words
    for heading in (
        "Errors on held-out flights",
        "Forward in time",
        "The fingerprint",
        "Probabilities",
        "Flights used",
    ):
        assert heading in words


@pytest.mark.thorough
def test_flights_that_were_left_out_are_named_in_every_medium(found: Findings) -> None:
    from fieldkit.presentation.json_documents import loop_document
    from fieldkit.tui.loop.loop_words import verdict

    line = "flight 10 of <Astra> is excluded from every fit: no motor lifts 32 kg"
    one = replace(found, excluded=(line,))
    assert line in "\n".join(report(one))
    assert line in str(verdict(one, "SI"))
    assert loop_document(one)["implausible"] == [line]
    words = " ".join(" ".join(Page(page(one)).text).split())
    assert "Implausible flights" in words
    assert "is excluded from every fit: no motor lifts 32 kg." in words
    assert "<Astra>" not in page(one)
    assert "Implausible flights" not in page(found)


def test_the_verdict_comes_first_and_the_residuals_on_request(found: Findings) -> None:
    short, whole = list(report(found)), list(report(found, details=True))
    assert short[1].startswith(f"  verdict: {found.diagnosis.effect}: ")
    ranked = [item for item in found.diagnosis.ranking if item.effect]
    listed = [item for item in ranked if item.probability >= MIN_CHANCE_LISTED]
    assert 0 < len(listed) < len(ranked)
    assert short[-1].strip() == f"{len(ranked) - len(listed)} effects with a chance below 1%; --details lists all"
    assert all(any(str(item.best.candidate.place) in line for line in whole) for item in ranked)
    assert any("miss / expected scatter" in line for line in whole)
    assert not any("miss / expected scatter" in line for line in short)


def test_the_report_fits_a_terminal(found: Findings) -> None:
    lines = list(report(found, details=True))
    table = [line for line in lines if "left out, " in line or "forward in time, " in line]
    assert len(table) == 4
    assert max(map(len, table)) <= 80


def test_the_loop_is_in_a_rockets_report(found: Findings, tmp_path: Path) -> None:
    made = FlightReport("Astra", "", (), (found,), summary=True)
    with styled():
        assert len(list(pages(made))) == 2
    assert any("weathercock" in line or "wind" in line for line in made.findings)
    (written,) = write_report(made, tmp_path / "astra.html")
    one = Page(written.read_text(encoding="utf-8"))
    assert "script" not in one.tags
    assert len(one.sources) == 4


@pytest.mark.thorough
def test_the_format_of_a_page_follows_from_its_file_name(found: Findings, tmp_path: Path) -> None:
    write_page(found, tmp_path / "page.png")
    assert (tmp_path / "page.png").read_bytes().startswith(b"\x89PNG")
    with pytest.raises(FieldkitError, match="cannot be written"):
        write_page(found, tmp_path / "nowhere" / "page.html")
    with pytest.raises(BadValue, match=r"found 'page\.pdf'"):
        check_page(tmp_path / "page.pdf")


@pytest.mark.slow
def test_the_command_writes_the_page_and_the_document(tmp_path: Path, run: Run) -> None:
    target = tmp_path / "astra.html"
    table = Path(__file__).parents[3] / "fieldkit" / "data" / "reference_flights.csv"
    run("import", table)
    assert "astra.doc" in run("loop", "--report", tmp_path / "astra.doc", status=1).err
    document = run("loop", "--report", target, "--json").document
    assert document["verdict"]["goes_with"] is None or document["verdict"]["effect"] == "unexplained"
    assert document["before"]["interval90"]["mae_m"][0] < document["before"]["mae_m"]
    assert document["forward"]["n_flights"] == 4
    assert len(document["fingerprints"][0]["readouts"]) == 10
    assert target.read_text(encoding="utf-8").startswith("<!doctype html>")
