"""All members of a density ensemble as one network: every layer is one batched product.

Five small networks trained side by side cost a thread little more than one, and become one ONNX graph.
"""

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np
import torch
from torch import Tensor, nn

from fieldkit.inference.mixture import COMPONENTS, SHARPEST, WIDTH

MEMBERS = 5
HIDDEN = 128
LAYERS = 3
GUARD_SHARE = 0.05
"""Weight of the guard's loss against the posterior's. [1]"""
GUARD_SHARPEST = (-4.0, 6.0)
"""Bounds of the logarithm of the guard's precision."""


class Members(nn.Module):
    """Members that each map standardised features to their outputs; the first axis is the member.

    A member's outputs are the mixture's (see `fieldkit.inference.mixture`), then for each readout the mean
    and the log precision with which the guard foretells it.
    """

    def __init__(self, inputs: int, seen: int, members: int = MEMBERS, hidden: int = HIDDEN) -> None:
        super().__init__()
        sizes = [inputs, *[hidden] * LAYERS, WIDTH + 2 * seen]
        self.seen = seen
        self.weights = nn.ParameterList(
            nn.Parameter(torch.randn(members, a, b) * (1.5 / a) ** 0.5)
            for a, b in zip(sizes[:-1], sizes[1:], strict=True)
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
    """Log density of the logits [... 2] under each member's mixture."""
    parts = outputs[..., :WIDTH].unflatten(-1, (6, COMPONENTS)).unbind(-2)
    sharp_x, sharp_y = (part.clamp(*SHARPEST) for part in parts[3:5])
    z_x = (target[..., :1] - parts[1]) * sharp_x.exp()
    z_y = (target[..., 1:] - parts[2]) * sharp_y.exp() - parts[5] * z_x
    log_parts = parts[0].log_softmax(-1) + sharp_x + sharp_y - 0.5 * (z_x.square() + z_y.square())
    return log_parts.logsumexp(-1) - float(np.log(2 * np.pi))


def guard_loss(outputs: Tensor, shown: Tensor) -> Tensor:
    """How badly the readouts that there are were foretold, in nats a readout."""
    mean, sharp = outputs[..., WIDTH:].chunk(2, -1)
    sharp = sharp.clamp(*GUARD_SHARPEST)
    there = shown.isfinite()
    z = (torch.where(there, shown, 0.0) - mean) * sharp.exp()
    return torch.where(there, 0.5 * z.square() - sharp, 0.0).mean()


@dataclass(frozen=True, slots=True)
class Batch:
    """What members learn from: features, logits of the truth, readouts as the guard sees them; float32."""

    features: np.ndarray[Any, np.dtype[np.float32]]
    target: np.ndarray[Any, np.dtype[np.float32]]
    shown: np.ndarray[Any, np.dtype[np.float32]]


@dataclass(frozen=True, slots=True)
class Schedule:
    """How long and how fast: passes over fresh observations of the same flights, batch, peak rate."""

    epochs: int = 10
    batch: int = 2048
    rate: float = 3e-3


def train(
    epoch: Callable[[int], Batch],
    schedule: Schedule,
    seed: int,
    report: Callable[[str], None],
) -> tuple[Members, np.ndarray[Any, Any], np.ndarray[Any, Any]]:
    """Members trained on one thread, and the mean and standard deviation that their features are scaled by.

    `epoch(number)` gives the flights as observed afresh. Each member sees them in another order.
    """
    torch.set_num_threads(1)
    torch.manual_seed(seed)
    first = epoch(0)
    mean, sd = first.features.mean(axis=0), first.features.std(axis=0) + 1e-6
    members = Members(first.features.shape[1], first.shown.shape[1])
    steps = schedule.epochs * (len(first.features) // schedule.batch)
    optimiser = torch.optim.Adam(members.parameters(), lr=schedule.rate)
    rate = torch.optim.lr_scheduler.OneCycleLR(optimiser, schedule.rate, total_steps=steps, pct_start=0.15)
    for number in range(schedule.epochs):
        batch = first if number == 0 else epoch(number)
        tensors = [torch.from_numpy(a) for a in ((batch.features - mean) / sd, batch.target, batch.shown)]
        losses = []
        for rows in _orders(len(batch.features), schedule.batch):
            features, target, shown = (tensor[rows] for tensor in tensors)
            outputs = members(features.clamp(-8, 8))
            posterior = -log_density(outputs, target).mean()
            loss = posterior + GUARD_SHARE * guard_loss(outputs, shown)
            optimiser.zero_grad()
            loss.backward()
            nn.utils.clip_grad_norm_(members.parameters(), 1.0 * len(rows))
            optimiser.step()
            rate.step()
            losses.append(posterior.item())
        report(f"epoch {number + 1} of {schedule.epochs}: {np.mean(losses[-200:]):.4f} nats a flight")
    return members, mean, sd


def _orders(count: int, batch: int) -> Iterator[Tensor]:
    """Rows of each batch [member row]: one shuffle, which every member enters at another place."""
    order = torch.randperm(count)
    starts = [member * (count // MEMBERS) for member in range(MEMBERS)]
    for first in range(0, count - batch + 1, batch):
        yield torch.stack([order[(torch.arange(first, first + batch) + start) % count] for start in starts])
