"""The shipped ensemble: its answers, and refusals."""

import hashlib
import json
import shutil
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from pytest_benchmark.fixture import BenchmarkFixture

from fieldkit.errors import DamagedModel, FieldkitError, ImpossibleFlight, UnknownMotor
from fieldkit.flight import Flight
from fieldkit.inference import training
from fieldkit.inference.network import ensemble
from fieldkit.inference.network.ensemble import CARD, GRAPH, Ensemble, load, load_folder, read_card
from fieldkit.inference.network.posterior import infer_paper
from fieldkit.inference.validation.score import score
from fieldkit.model.features import PAPER_FEATURES, paper_features
from fieldkit.model.paper_prior_predictive import ALPHA_RANGE, CD_RANGE, paper_draws
from fieldkit.physics import paper
from fieldkit.plugins import trained, trained_folder

ROOT = Path(__file__).parents[3]


@pytest.fixture(scope="module")
def shipped() -> Ensemble:
    return load("paper")


@pytest.fixture
def copy(tmp_path: Path) -> Path:
    """A copy of the shipped folder, to be damaged."""
    return Path(shutil.copytree(trained_folder("paper"), tmp_path / "paper"))


def recard(folder: Path, **changes: object) -> None:
    card = json.loads((folder / CARD).read_text())
    (folder / CARD).write_text(json.dumps(card | changes))


@pytest.mark.parametrize("name", trained())
def test_every_trained_folder_matches_its_card(name: str) -> None:
    found = load(name)
    assert found.name == name
    assert found.card["command"].startswith("fieldkit train ")
    assert set(found.card) >= {"priors", "seed", "n_train", "features", "effects", "test", "digests"}


def test_a_flight_is_answered_the_same_alone_and_among_others(shipped: Ensemble) -> None:
    features = paper_draws(np.random.default_rng(5), 200).features
    mean, spread = shipped(features)
    one_by_one = [shipped(row[None]) for row in features]
    np.testing.assert_allclose(np.concatenate([m for m, _ in one_by_one]), mean, atol=1e-6)
    np.testing.assert_allclose(np.concatenate([s for _, s in one_by_one]), spread, atol=1e-6)


def test_flights_do_not_depend_on_their_order(shipped: Ensemble) -> None:
    features = paper_draws(np.random.default_rng(6), 50).features
    np.testing.assert_allclose(shipped(features[::-1])[0][::-1], shipped(features)[0], atol=1e-6)


def test_no_flights_give_no_answers(shipped: Ensemble) -> None:
    mean, spread = shipped(np.empty((0, 5)))
    assert mean.shape == spread.shape == (0, 2)


def test_absurd_features_give_answers_within_the_prior_ranges(shipped: Ensemble) -> None:
    absurd = np.random.default_rng(7).normal(0, 1e6, size=(300, 5))
    mean, _ = shipped(absurd)
    assert ((mean >= (0.2, 0.5)) & (mean <= (1.5, 1.5))).all()


@pytest.mark.parametrize("motor", range(3))
@pytest.mark.parametrize("dry_mass", paper.DRY_MASS.values())
def test_a_higher_apogee_means_less_drag_and_more_thrust(shipped: Ensemble, motor: int, dry_mass: float) -> None:
    cd, alpha = np.array([CD_RANGE[::-1], ALPHA_RANGE])
    low, high = paper_apogees(motor, dry_mass, cd, alpha)
    apogee = np.linspace(low, high, 6)
    mean, _ = shipped(paper_features(apogee, np.full(6, motor), np.full(6, dry_mass)))
    assert (np.diff(mean[:, 0]) < 0).all()
    assert (np.diff(mean[:, 1]) > -0.02).all()
    assert mean[-1, 1] > mean[0, 1] + 0.3


def paper_apogees(motor: int, dry_mass: float, cd: np.ndarray, alpha: np.ndarray) -> np.ndarray:
    from fieldkit.physics.flight import apogees

    return apogees(paper.paper_setup(np.array(motor), np.array(dry_mass), cd, alpha))


def test_the_errors_in_the_card_agree_with_new_flights(shipped: Ensemble) -> None:
    fresh = paper_draws(np.random.default_rng(8), 1500)
    found, carded = score(shipped, fresh.features, fresh.truth), shipped.card["test"]
    for name in ("cd", "alpha"):
        tolerance = 4 * (found[name]["standard_error"] + carded[name]["standard_error"])
        assert found[name]["mae"] == pytest.approx(carded[name]["mae"], abs=tolerance)
        for level in ("one_sd", "50", "90"):
            assert found[name]["coverage"][level] == pytest.approx(carded[name]["coverage"][level], abs=0.04)


def test_the_score_recognizes_a_calibrated_spread() -> None:
    rng = np.random.default_rng(9)
    truth = rng.normal(size=(4000, 2))

    class Honest:
        outputs = ("cd", "alpha")

        def __call__(self, features: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
            return truth + rng.normal(size=truth.shape), np.ones(truth.shape)

    coverage = score(Honest(), truth, truth)["cd"]["coverage"]  # type: ignore[arg-type]
    assert coverage["one_sd"] == pytest.approx(0.683, abs=0.03)
    assert coverage["50"] == pytest.approx(0.5, abs=0.03)
    assert coverage["90"] == pytest.approx(0.9, abs=0.02)


def test_features_include_the_declared_figures_of_the_motor() -> None:
    found = paper_features(np.array([281.3]), np.array([1]), np.array([0.322]))
    assert dict(zip(PAPER_FEATURES, found[0], strict=True)) == {
        "apogee_m": 281.3,
        "motor_index": 1.0,
        "dry_mass_kg": 0.322,
        "total_impulse_ns": 47.3,
        "burn_time_s": 2.1,
    }


def test_a_graph_that_does_not_match_its_card_is_refused(copy: Path) -> None:
    graph = bytearray((copy / GRAPH).read_bytes())
    graph[len(graph) // 2] ^= 1
    (copy / GRAPH).write_bytes(graph)
    with pytest.raises(DamagedModel, match=r"ensemble\.onnx: found sha256 .* its card says"):
        load_folder(copy)


def test_a_graph_that_onnxruntime_cannot_run_is_refused(copy: Path) -> None:
    (copy / GRAPH).write_bytes(b"no graph")
    recard(copy, digests={GRAPH: hashlib.sha256(b"no graph").hexdigest()})
    with pytest.raises(DamagedModel, match="onnxruntime cannot run it") as caught:
        load_folder(copy)
    assert "\n" not in str(caught.value)


def test_a_card_with_other_features_is_refused(copy: Path) -> None:
    recard(copy, features=["apogee_m"])
    with pytest.raises(DamagedModel, match="expected the features and outputs of its card"):
        load_folder(copy)


def test_a_graph_too_large_is_not_read(copy: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(ensemble, "LARGEST_GRAPH", 1000)
    with pytest.raises(DamagedModel, match="found more than 1000 bytes"):
        load_folder(copy)


@pytest.mark.parametrize("text", ["", "[]", "{", '{"name": 1}', '{"digests": {}}', "\x00", "[" * 5000])
def test_a_card_that_is_invalid_is_refused(copy: Path, text: str) -> None:
    (copy / CARD).write_text(text)
    with pytest.raises(DamagedModel, match=r"card\.json: found no"):
        read_card(copy)


@pytest.mark.parametrize("missing", [CARD, GRAPH])
def test_a_missing_file_is_named(copy: Path, missing: str) -> None:
    (copy / missing).unlink()
    with pytest.raises(DamagedModel, match=missing):
        load_folder(copy)


ASTRA = Flight(flight_id="2", rocket="Astra", config="A", motor="F24-4W", dry_mass=0.322, apogee=281.3)


def test_inference_answers_each_flight() -> None:
    found = infer_paper([ASTRA, ASTRA.with_changes(apogee=246.6, dry_mass=None)])
    assert found.model == "paper"
    assert len(found.cd) == len(found.alpha_sd) == 2
    assert found.cd[0] < found.cd[1]
    assert found.alpha[0] > found.alpha[1]


@pytest.mark.parametrize(
    ("changes", "error", "words"),
    [
        ({"motor": "C6-5"}, UnknownMotor, "the paper flew no motor 'C6-5', only E35-5W, F24-4W, F39"),
        ({"dry_mass": 0.4}, ImpossibleFlight, "found a mass of 400 g, .* 322 g"),
        ({"dry_mass": None, "config": "C"}, ImpossibleFlight, "found no dry mass"),
        ({"apogee": None}, ImpossibleFlight, "no apogee"),
    ],
)
def test_a_flight_outside_of_the_papers_problem_is_refused(
    changes: dict[str, object], error: type[FieldkitError], words: str
) -> None:
    with pytest.raises(error, match=words):
        infer_paper([ASTRA, ASTRA.with_changes(**changes)])


def test_inference_imports_onnxruntime_late_and_never_torch() -> None:
    code = (
        "import sys, fieldkit.inference.network.posterior as p, fieldkit.flight as f;"
        "print('onnxruntime' in sys.modules);"
        "p.infer_paper([f.Flight(motor='F39', config='B', apogee=190.0)]); print('torch' in sys.modules)"
    )
    found = subprocess.run([sys.executable, "-c", code], cwd=ROOT, capture_output=True, text=True, check=True)
    assert found.stdout.split() == ["False", "False"]


def test_training_without_its_extra_says_what_to_install(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(training, "EXTRA", ("no_such_library",))
    with pytest.raises(FieldkitError, match=r"no_such_library: pip install 'fieldkit\[train\]'"):
        training.trainer("paper", tmp_path / "out")


def test_loading_is_fast(benchmark: BenchmarkFixture) -> None:
    benchmark(load, "paper")


def test_one_flight_is_inferred_fast(benchmark: BenchmarkFixture, shipped: Ensemble) -> None:
    benchmark(shipped, paper_draws(np.random.default_rng(1), 1).features)
