"""Training of density ensembles: the loss, the export, and the same answer twice."""

from pathlib import Path

import numpy as np
import pytest

import fieldkit.inference.validation.field
from fieldkit.inference.network.mixture import WIDTH, logits, mixture

CHECK_SHAPES = False

torch = pytest.importorskip("torch")
pytest.importorskip("onnx")
pytestmark = pytest.mark.train


def no_evaluation(ensemble: object, rng: object) -> dict[str, object]:
    raise AssertionError("an ensemble was trained")


@pytest.fixture
def tiny(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> tuple[Path, str]:
    """The folder of an ensemble trained for a moment by the command, and what the command printed."""
    from fieldkit.cli.main import main
    from fieldkit.inference.training import density, field

    monkeypatch.setattr(fieldkit.inference.validation.field, "FLIGHTS", 100)
    monkeypatch.setattr(field, "LIMIT_FLIGHTS", 400)
    monkeypatch.setitem(field.PLANS, "quick", density.TrainingPlan(epochs=2, batch=256))
    out = tmp_path / "field"
    options = ("--recipe", "field", "--schedule", "quick", "--seed", "3", "--n-train", "1000", "--report")
    options += ("--effects", "mass_offset, wind")
    assert main(["train", *options, "--out", str(out)]) == 0
    return out, capsys.readouterr().out


def test_the_loss_agrees_with_the_density_from_numpy() -> None:
    from fieldkit.inference.training.density import log_density

    rng = np.random.default_rng(1)
    outputs = rng.normal(size=(7, 1, WIDTH))
    low, high = np.zeros((7, 2)), np.ones((7, 2))
    values = rng.uniform(size=(7, 2))
    line = logits(values, low, high)
    own = log_density(torch.from_numpy(outputs[:, 0]), torch.from_numpy(line)).numpy()
    stretch = np.log(values * (1 - values)).sum(axis=1)
    assert mixture(outputs, low, high).log_density(values) == pytest.approx(own - stretch)


def test_the_loss_agrees_with_torchs_distributions() -> None:
    from torch.distributions import Categorical, MixtureSameFamily, MultivariateNormal

    from fieldkit.inference.network.mixture import COMPONENTS
    from fieldkit.inference.training.density import log_density

    torch.manual_seed(2)
    outputs, target = torch.randn(5, WIDTH, dtype=torch.float64), torch.randn(5, 2, dtype=torch.float64)
    weight, x, y, sharp_x, sharp_y, slope = outputs.unflatten(-1, (6, COMPONENTS)).unbind(-2)
    scale = torch.zeros(5, COMPONENTS, 2, 2, dtype=torch.float64)
    scale[..., 0, 0], scale[..., 1, 1] = torch.exp(-sharp_x), torch.exp(-sharp_y)
    scale[..., 1, 0] = slope * torch.exp(-sharp_y)
    parts = MultivariateNormal(torch.stack([x, y], -1), scale_tril=scale)
    whole = MixtureSameFamily(Categorical(logits=weight), parts)
    assert torch.allclose(log_density(outputs, target), whole.log_prob(target))


def test_the_exported_graph_agrees_with_the_network(tmp_path: Path) -> None:
    from fieldkit.inference.network.ensemble import from_parts
    from fieldkit.inference.training.density import DensityMembers
    from fieldkit.inference.training.member_graphs import density_graph

    torch.manual_seed(4)
    members, rng = DensityMembers(6, 2), np.random.default_rng(5)
    features = rng.normal(size=(9, 6))
    mean, sd = features.mean(axis=0), features.std(axis=0)
    content = density_graph(members, mean, sd)
    card = {"name": "one", "features": list("abcdef"), "outputs": ["x", "y"], "parts": [5, WIDTH + 4]}
    found = from_parts(content, card, tmp_path).members(features)
    scaled = torch.from_numpy((features - mean) / sd).float().expand(5, -1, -1)
    assert found == pytest.approx(members(scaled).detach().numpy().swapaxes(0, 1), abs=1e-4)


@pytest.mark.thorough
def test_a_trained_folder_can_be_used_and_is_not_overwritten(tiny: tuple[Path, str]) -> None:
    from fieldkit.errors import BadValue
    from fieldkit.inference.network.ensemble import load_folder
    from fieldkit.inference.training.field import train_field

    folder, printed = tiny
    assert "motors of Quest, never seen" in printed
    assert printed.count("all ten") == 3
    ensemble = load_folder(folder)
    assert ensemble.members(np.zeros((2, len(ensemble.features)))).shape == (2, *ensemble.card["parts"])
    assert set(ensemble.card["guard"]) == set(ensemble.card["guarded"])
    assert ensemble.card["effects"] == list(ensemble.card["effect_priors"]) == ["mass_offset", "wind"]
    assert "--effects mass_offset,wind" in ensemble.card["command"]
    with pytest.raises(BadValue, match="an existing ensemble"):
        train_field(folder, evaluate=no_evaluation)


def test_an_unknown_effect_stops_before_anything_is_simulated(tmp_path: Path) -> None:
    from fieldkit.errors import BadValue
    from fieldkit.inference.training.field import train_field

    with pytest.raises(BadValue, match="no effect 'gusts'"):
        train_field(tmp_path / "field", evaluate=no_evaluation, effects=["gusts"])
    assert not (tmp_path / "field").exists()
