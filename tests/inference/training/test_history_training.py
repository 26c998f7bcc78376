"""Training of the history network: the same answer in torch, ONNX and numpy, resumed runs, and the command."""

import json
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

from fieldkit.inference.network.history_parts import LEVELS, OVERALL_OUTPUTS, PARAMETERS, answer, monotone

CHECK_SHAPES = False

torch = pytest.importorskip("torch")
pytest.importorskip("onnx")
pytestmark = pytest.mark.train


def test_quantiles_in_torch_agree_with_numpy() -> None:
    from fieldkit.inference.training.history_members import quantiles

    raw = np.random.default_rng(0).normal(size=(4, 3, len(LEVELS)))
    assert quantiles(torch.from_numpy(raw)).numpy() == pytest.approx(monotone(raw))


def test_members_agree_with_their_exported_graph() -> None:
    from fieldkit.inference.network.ensemble import from_parts
    from fieldkit.inference.training.history_members import HistoryMembers
    from fieldkit.inference.training.member_graphs import history_graph

    torch.manual_seed(0)
    rng = np.random.default_rng(0)
    members = HistoryMembers(4, 3, 2)
    mean, sd = rng.normal(size=10), rng.uniform(0.5, 2.0, 10)
    outputs = 3 + OVERALL_OUTPUTS + len(LEVELS) + len(PARAMETERS)
    card = {"name": "tiny", "features": list("abcdefghij"), "outputs": ["x"], "parts": [5, outputs]}
    ensemble = from_parts(history_graph(members, mean, sd), card, Path("tiny"))
    features = rng.normal(size=(7, 10))
    scaled = torch.from_numpy((((features - mean) / sd).clip(-8, 8)).astype(np.float32))
    with torch.no_grad():
        printed = members(scaled).numpy().swapaxes(0, 1)
    assert ensemble.members(features) == pytest.approx(printed, abs=1e-5)
    assert answer(ensemble.members(features), 3).inclusion.shape == (7, 3)


def test_effects_share_one_function_except_for_their_levels() -> None:
    """Exchanging the features of two effects exchanges their probabilities before training."""
    from fieldkit.inference.training.history_members import HistoryMembers

    torch.manual_seed(0)
    members = HistoryMembers(4, 3, 2)
    features = torch.randn(6, 10)
    traded = features[:, [0, 1, 2, 3, 6, 7, 4, 5, 8, 9]]
    assert torch.allclose(members(features)[..., [1, 0, 2]], members(traded)[..., :3], atol=1e-6)


def test_columns_of_every_effect_have_one_scale() -> None:
    """One function takes them, so that the same evidence must have the same value for every effect; columns of effects
    that cannot act are zero and do not count."""
    from fieldkit.inference.history.columns import OF_HISTORY, PER_EFFECT
    from fieldkit.inference.history.features import effect_names
    from fieldkit.inference.history.shards import TRUTHS, HistoryTable
    from fieldkit.inference.training.history import feature_moments

    rng = np.random.default_rng(0)
    effects, acts = len(effect_names()), PER_EFFECT.index("acts")
    each = rng.normal(np.arange(effects)[:, None], 2.0, (200, effects, len(PER_EFFECT)))
    each[..., acts] = rng.uniform(size=(200, effects)) < 0.5
    each *= each[..., acts : acts + 1]
    features = np.concatenate([rng.normal(3.0, 2.0, (200, len(OF_HISTORY))), each.reshape(200, -1)], axis=1)
    mean, sd = feature_moments(HistoryTable(features, np.zeros((200, effects)), np.zeros((200, len(TRUTHS)))))
    assert mean[: len(OF_HISTORY)] == pytest.approx(features[:, : len(OF_HISTORY)].mean(axis=0))
    for own, numpy_of in ((mean, np.mean), (sd, np.std)):
        columns = own[len(OF_HISTORY) :].reshape(effects, len(PER_EFFECT))
        assert np.ptp(columns, axis=0) == pytest.approx(np.zeros(len(PER_EFFECT)))
        assert columns[0, 0] == pytest.approx(numpy_of(each[each[..., acts] > 0.5][:, 0]), abs=2e-3)


@pytest.fixture
def small(monkeypatch: pytest.MonkeyPatch) -> None:
    from fieldkit.inference.history import shards
    from fieldkit.inference.training import history

    monkeypatch.setattr(shards, "ROCKETS_PER_SHARD", 10)
    monkeypatch.setitem(history.PLANS, "quick", history.HistoryPlan(epochs=6, batch=16))
    monkeypatch.setattr(history, "HELD_OUT_ROCKETS", 4)


@pytest.mark.thorough
def test_the_command_trains_a_network_that_answers(
    small: None, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    from fieldkit.cli.main import main
    from fieldkit.inference.network.ensemble import load_folder
    from fieldkit.inference.network.history import checked, quick_answer
    from fieldkit.selection.quick_candidates import quick_candidates
    from tests.inference.history.histories import history

    out = tmp_path / "history"
    options = ("--recipe", "history", "--schedule", "quick", "--seed", "3", "--n-train", "20")
    capsys.readouterr()
    assert main(["train", *options, "--out", str(out), "--json"]) == 0
    printed = json.loads(capsys.readouterr().out)
    assert printed["recipe"] == "history"
    assert printed["n_train"] == 20
    assert not (out / "parts").exists()
    card = json.loads((out / "card.json").read_text())
    assert card["seed"] == 3
    assert len(card["loss"]) == 6
    assert card["test"]["histories"] > 0
    ensemble = checked(load_folder(out))
    assert 0 < quick_answer(history(5), quick_candidates, ensemble=ensemble).none < 1


def test_the_time_of_an_interrupted_run_counts(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    from fieldkit.inference.training import history

    seconds = iter([100.0, 160.0, 500.0, 530.0])
    monkeypatch.setattr(history, "time", SimpleNamespace(perf_counter=lambda: next(seconds)))
    history.Stopwatch(tmp_path / "parts" / "seconds").save()
    assert history.Stopwatch(tmp_path / "parts" / "seconds").seconds == pytest.approx(90.0)


@pytest.mark.thorough
def test_interrupted_training_resumes(small: None, tmp_path: Path) -> None:
    from concurrent.futures import ThreadPoolExecutor

    from fieldkit.inference.history.shards import simulate_table
    from fieldkit.inference.training.history import HistoryPlan, fit_history, split
    from fieldkit.selection.prior import inclusion_probabilities
    from fieldkit.selection.quick_candidates import quick_candidates

    with ThreadPoolExecutor(1) as pool:
        train, validation, _ = split(simulate_table(tmp_path, 1, 20, quick_candidates, inclusion_probabilities(), pool))
    plan, state, seen = HistoryPlan(epochs=6, batch=8), tmp_path / "state.npy", []

    def stop(epoch: int, epochs: int, loss: float) -> None:
        seen.append(epoch)
        if len(seen) == 5:
            raise KeyboardInterrupt

    torch.manual_seed(0)
    with pytest.raises(KeyboardInterrupt):
        fit_history(train, validation, plan, state, stop)
    torch.manual_seed(1)
    *_, losses = fit_history(train, validation, plan, state, lambda epoch, *_: seen.append(epoch))
    assert seen == [1, 2, 3, 4, 5, 6]
    assert len(losses) == 6
