"""Training an ensemble on few flights: the exported network is the trained one."""

import hashlib
import json
from pathlib import Path

import numpy as np
import pytest

pytest.importorskip("torch", reason="training needs the extra train")
pytestmark = pytest.mark.train

import torch  # noqa: E402

from fieldkit.cli.main import main  # noqa: E402
from fieldkit.errors import BadValue  # noqa: E402
from fieldkit.inference.network.ensemble import CARD, GRAPH, from_parts, load_folder  # noqa: E402
from fieldkit.inference.training.fit import SCHEDULES, Schedule, fit, one_thread, outputs  # noqa: E402
from fieldkit.inference.training.graph import graph  # noqa: E402
from fieldkit.inference.training.network import Network, network  # noqa: E402
from fieldkit.inference.training.paper import train_paper  # noqa: E402
from fieldkit.inference.validation.score import score  # noqa: E402

RANGES = np.array([[0.2, 1.5], [0.5, 1.5]])
TWO_EPOCHS = Schedule("two", epochs=2, rate=1e-2, one_cycle=True)


def toy(count: int, seed: int = 3) -> tuple[torch.Tensor, torch.Tensor]:
    """Features and two truths that follow from them."""
    x = np.random.default_rng(seed).normal(size=(count, 5))
    truth = np.stack([0.85 + 0.3 * np.tanh(x[:, 0]), 1 + 0.2 * np.tanh(x[:, 1])], axis=-1)
    return torch.tensor(x, dtype=torch.float32), torch.tensor(truth, dtype=torch.float32)


def trained(seed: int = 0, members: int = 3, schedule: Schedule = TWO_EPOCHS) -> Network:
    with one_thread(seed):
        model = network(members, (5, 16, 8), RANGES, 0.1)
        fit(model, *toy(600), toy(100, seed=4), schedule)
    return model


def test_onnxruntime_agrees_with_torch(tmp_path: Path) -> None:
    model, mean, scale = trained(), np.array([300.0, 1.0, 0.4, 45.0, 1.5]), np.array([100.0, 0.8, 0.06, 4.0, 0.4])
    features = mean + scale * np.random.default_rng(1).normal(size=(400, 5))
    card = {"name": "toy", "features": ["a", "b", "c", "d", "e"], "outputs": ["cd", "alpha"]}
    found, spread = from_parts(graph(model, mean, scale, ""), card, tmp_path)(features)
    expected = outputs(model, torch.tensor((features - mean) / scale, dtype=torch.float32)).double().numpy()
    np.testing.assert_allclose(found, expected.mean(axis=0), atol=1e-5)
    np.testing.assert_allclose(spread, expected.std(axis=0), atol=1e-5)


def test_training_learns() -> None:
    x, truth = toy(300, seed=5)
    found = outputs(trained(schedule=Schedule("ten", epochs=10, rate=1e-2, one_cycle=True)), x).mean(dim=0)
    assert float((found - truth).abs().mean()) < 0.5 * float((truth - truth.mean(dim=0)).abs().mean())


def test_members_are_independent() -> None:
    model, (x, _) = trained(), toy(50, seed=6)
    before = outputs(model, x).clone()
    with torch.no_grad():
        for linear in model.linears:
            linear.weight[1] += 1.0
    after = outputs(model, x)
    assert torch.equal(before[0], after[0])
    assert torch.equal(before[2], after[2])
    assert not torch.equal(before[1], after[1])


def test_a_member_of_the_batched_model_is_torchs_own_network() -> None:
    model, (x, _) = trained(members=2), toy(40, seed=7)
    layers: list[torch.nn.Module] = []
    for number, (linear, norm) in enumerate(zip(model.linears, (*model.norms, None), strict=True)):
        out, inputs = linear.weight.shape[1:]
        layer = torch.nn.Linear(inputs, out)
        layer.load_state_dict({"weight": linear.weight[1].detach(), "bias": linear.bias[1, :, 0].detach()})
        layers.append(layer)
        if norm is not None:
            own = torch.nn.BatchNorm1d(out)
            part = slice(out, 2 * out)
            own.load_state_dict(
                {
                    "weight": norm.scale[part].detach(),
                    "bias": norm.shift[part].detach(),
                    "running_mean": norm.mean[part],
                    "running_var": norm.variance[part],
                    "num_batches_tracked": torch.tensor(number),
                }
            )
            layers += [own, torch.nn.ReLU(), torch.nn.Dropout(0.1)]
    plain = torch.nn.Sequential(*layers).eval()
    low, width = torch.tensor([0.2, 0.5]), torch.tensor([1.3, 1.0])
    with torch.no_grad():
        expected = low + width * torch.sigmoid(plain(x))
    assert torch.allclose(outputs(model, x)[1], expected, atol=1e-6)


def test_the_published_schedule_halves_its_rate_on_a_plateau() -> None:
    plan = SCHEDULES["published"]
    assert (plan.epochs, plan.rate, plan.one_cycle, plan.patience) == (100, 1e-3, False, 10)
    losses: list[float] = []
    with one_thread(0):
        model = network(2, (5, 8), RANGES, 0.1)
        fit(
            model, *toy(300), toy(50, seed=4), Schedule("short", 3, 1e-3, False), lambda e, n, loss: losses.append(loss)
        )
    assert len(losses) == 3
    assert losses[-1] < losses[0]


def test_training_leaves_torch_as_it_was() -> None:
    threads, state = torch.get_num_threads(), torch.get_rng_state()
    trained()
    assert torch.get_num_threads() == threads
    assert torch.equal(torch.get_rng_state(), state)


@pytest.mark.thorough
def test_the_same_seed_trains_the_same_ensemble_and_its_card_shows_how(tmp_path: Path) -> None:
    steps: list[int] = []
    first = train_paper(
        tmp_path / "a", evaluate=score, seed=7, n_train=512, progress=lambda epoch, *_: steps.append(epoch)
    )
    train_paper(tmp_path / "b", evaluate=score, seed=7, n_train=512)
    train_paper(tmp_path / "c", evaluate=score, seed=8, n_train=512)
    a, b, c = (hashlib.sha256((tmp_path / name / GRAPH).read_bytes()).hexdigest() for name in "abc")
    assert a == b != c
    assert steps == list(range(1, 11))
    assert set(first) == {"recipe", "cd_mae", "alpha_mae", "n_train", "seconds", "files"}
    assert [Path(file).name for file in first["files"]] == [GRAPH, CARD]
    card = json.loads((tmp_path / "a" / CARD).read_text())
    assert card["digests"] == {GRAPH: a}
    assert (card["seed"], card["n_train"], card["training"]["schedule"]) == (7, 512, "quick")
    assert load_folder(tmp_path / "a").card["test"]["cd"]["mae"] == first["cd_mae"] < 0.13


def test_an_ensemble_is_never_overwritten(tmp_path: Path) -> None:
    (tmp_path / CARD).write_text("{}")
    with pytest.raises(BadValue, match="found an existing ensemble"):
        train_paper(tmp_path, evaluate=score)
    assert (tmp_path / CARD).read_text() == "{}"


@pytest.mark.parametrize("wrong", [{"schedule": "slow"}, {"n_train": 10}])
def test_an_impossible_recipe_is_refused(tmp_path: Path, wrong: dict[str, object]) -> None:
    with pytest.raises(BadValue, match="found"):
        train_paper(tmp_path / "out", evaluate=score, **wrong)  # type: ignore[arg-type]
    assert not (tmp_path / "out").exists()


def test_the_command_trains_and_reports_the_folder(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    out = tmp_path / "mine"
    assert main(["train", "--out", str(out), "--n-train", "256", "--seed", "3", "--json"]) == 0
    summary = json.loads(capsys.readouterr().out)
    assert (summary["recipe"], summary["n_train"]) == ("paper", 256)
    assert all(Path(file).exists() for file in summary["files"])
    assert main(["train", "--out", str(out)]) == 1
    assert "found an existing ensemble" in capsys.readouterr().err
