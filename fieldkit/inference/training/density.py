"""All members of a density ensemble as one network: every layer is one batched product.

Five small networks trained side by side cost a thread little more than one, and become one ONNX graph.
"""

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from itertools import pairwise
from typing import Any

import numpy as np
import torch
from torch import Tensor, nn
from torch.optim.lr_scheduler import OneCycleLR

from fieldkit.inference.network.mixture import COMPONENTS, GUARD_SHARPEST, LOG_PRECISION_RANGE, WIDTH
from fieldkit.inference.training.fit import TrainingProgress
from fieldkit.shapes import Array, Float

MEMBERS = 5
HIDDEN_UNITS = 128
LAYERS = 3
GUARD_WEIGHT = 0.1
"""Weight of the loss of the predicted readouts relative to that of the posterior. [1]"""
MAX_FEATURE_SDS = 8.0
"""Features are clipped to this many standard deviations from their mean. [1]"""
MAX_GRADIENT_NORM = 5.0
"""Maximum norm of the gradient in a step."""
FeatureScale = np.ndarray[Any, np.dtype[np.float64]]
"""One number per feature."""


def scaled_features(
    features: Float[Any, "row feature"], mean: FeatureScale, sd: FeatureScale
) -> Float[Any, "row feature"]:
    """Features as the members and the exported graph take them. [1]"""
    return ((features - mean) / sd).clip(-MAX_FEATURE_SDS, MAX_FEATURE_SDS).astype(np.float32)


class DensityMembers(nn.Module):  # type: ignore[misc]
    """Members that each map standardized features to their outputs; the first axis is the member.

    A member's outputs are the mixture's (see `fieldkit.inference.network.mixture`), then for each readout the mean
    and the log precision of its prediction from the other readouts, which detects outliers.
    """

    def __init__(self, inputs: int, seen: int, members: int = MEMBERS, hidden: int = HIDDEN_UNITS) -> None:
        super().__init__()
        sizes = [inputs, *[hidden] * LAYERS, WIDTH + 2 * seen]
        self.seen = seen
        self.weights = nn.ParameterList(
            nn.Parameter(torch.randn(members, a, b) * (1.5 / a) ** 0.5) for a, b in pairwise(sizes)
        )
        self.biases = nn.ParameterList(nn.Parameter(torch.zeros(members, 1, b)) for b in sizes[1:])
        with torch.no_grad():
            self.weights[-1] *= 0.1
            self.biases[-1][..., COMPONENTS : 3 * COMPONENTS] = torch.randn(members, 1, 2 * COMPONENTS)

    def forward(self, features: Tensor) -> Tensor:
        """Outputs [member flight output] of features [member flight feature]."""
        values = features
        for number, (weight, bias) in enumerate(zip(self.weights, self.biases, strict=True)):
            values = torch.baddbmm(bias, values, weight)
            if number < LAYERS:
                values = nn.functional.silu(values)
        return values


def log_density(outputs: Tensor, target: Tensor) -> Tensor:
    """Log density of the logits [... 2] under each member's mixture. [nat]"""
    parts = outputs[..., :WIDTH].unflatten(-1, (6, COMPONENTS)).unbind(-2)
    sharp_x, sharp_y = (part.clamp(*LOG_PRECISION_RANGE) for part in parts[3:5])
    z_x = (target[..., :1] - parts[1]) * sharp_x.exp()
    z_y = (target[..., 1:] - parts[2]) * sharp_y.exp() - parts[5] * z_x
    log_parts = parts[0].log_softmax(-1) + sharp_x + sharp_y - 0.5 * (z_x.square() + z_y.square())
    return log_parts.logsumexp(-1) - float(np.log(2 * np.pi))


def guard_loss(outputs: Tensor, shown: Tensor) -> Tensor:
    """Negative log density of the recorded readouts as predicted, in nats per readout, up to a constant; 0 for missing
    ones."""
    mean, sharp = outputs[..., WIDTH:].chunk(2, -1)
    sharp = sharp.clamp(*GUARD_SHARPEST)
    there = shown.isfinite()
    z = (torch.where(there, shown, 0.0) - mean) * sharp.exp()
    return torch.where(there, 0.5 * z.square() - sharp, 0.0).mean()


@dataclass(frozen=True, slots=True)
class Batch:
    """Training data of the members: features, logits of the truth, readouts to predict; float32."""

    features: np.ndarray[Any, np.dtype[np.float32]]
    target: np.ndarray[Any, np.dtype[np.float32]]
    shown: np.ndarray[Any, np.dtype[np.float32]]


@dataclass(frozen=True, slots=True)
class TrainingPlan:
    """Schedule: passes over new observations of the same flights, batch size, peak learning rate."""

    epochs: int
    batch: int = 2048
    rate: float = 3e-3


def fit(
    observe: Callable[[], Batch], plan: TrainingPlan, progress: TrainingProgress | None = None
) -> tuple[DensityMembers, FeatureScale, FeatureScale]:
    """Members trained by one cycle of Adam, and the mean and standard deviation that scale their features.

    `observe()` returns new observations of the same flights. Each member sees them in a different order. `progress`
    receives the training loss of an epoch's last 100 batches.
    """
    batch = observe()
    count = len(batch.features)
    mean, sd = batch.features.mean(axis=0, dtype=np.float64), batch.features.std(axis=0, dtype=np.float64) + 1e-6
    members = DensityMembers(batch.features.shape[1], batch.shown.shape[1])
    optimiser = torch.optim.Adam(members.parameters(), lr=plan.rate)
    rate = OneCycleLR(optimiser, plan.rate, total_steps=plan.epochs * (count // plan.batch), pct_start=0.15)
    for epoch in range(1, plan.epochs + 1):
        batch = observe() if epoch > 1 else batch
        scaled = scaled_features(batch.features, mean, sd)
        tensors = [torch.from_numpy(array) for array in (scaled, batch.target, batch.shown)]
        losses = []
        for rows in _orders(count, plan.batch):
            features, target, shown = (tensor[rows] for tensor in tensors)
            found = members(features)
            loss = -log_density(found, target).mean()
            optimiser.zero_grad()
            (loss + GUARD_WEIGHT * guard_loss(found, shown)).backward()
            nn.utils.clip_grad_norm_(members.parameters(), MAX_GRADIENT_NORM)
            optimiser.step()
            rate.step()
            losses.append(loss.item())
        if progress:
            progress(epoch, plan.epochs, float(np.mean(losses[-100:])))
    return members, mean, sd


def member_outputs(
    members: DensityMembers, mean: FeatureScale, sd: FeatureScale, features: Float[Array, "flight feature"]
) -> Float[Array, "flight member part"]:
    """The outputs of trained members, as `fieldkit.inference.network.mixture` reads them. [1]"""
    scaled = scaled_features(features, mean, sd)
    with torch.no_grad():
        found: Array = members(torch.from_numpy(scaled).expand(len(members.weights[0]), -1, -1)).numpy()
    return found.swapaxes(0, 1).astype(float)


def _orders(count: int, batch: int) -> Iterator[Tensor]:
    """Rows of each batch [member row]: one shuffle, with a different starting point for every member."""
    order = torch.randperm(count)
    starts = [member * (count // MEMBERS) for member in range(MEMBERS)]
    for first in range(0, count - batch + 1, batch):
        yield torch.stack([order[(torch.arange(first, first + batch) + start) % count] for start in starts])
