"""Networks side by side: the members of an ensemble as one batched model.

Activations are [member, channel, flight], so that one batched product serves all members, and batch normalization over
flights runs on members times channels at once.
"""

from collections.abc import Iterator
from dataclasses import dataclass

import torch
from torch import Tensor
from torch.nn.functional import batch_norm, dropout, relu

from fieldkit.shapes import Array, Float


@dataclass(frozen=True, slots=True)
class Linear:
    """A linear layer of every member: weight [member out in], bias [member out 1]."""

    weight: Tensor
    bias: Tensor


@dataclass(frozen=True, slots=True)
class Norm:
    """Batch normalization of every member; all four arrays are [member*channel]."""

    scale: Tensor
    shift: Tensor
    mean: Tensor
    variance: Tensor


EPSILON = 1e-5
"""Added to the variance in batch normalization. [1]"""


@dataclass(frozen=True, slots=True)
class Network:
    """Hidden layers (linear, batch norm, ReLU, dropout), a linear layer, and outputs squashed to ranges."""

    linears: tuple[Linear, ...]
    norms: tuple[Norm, ...]
    drop: float
    low: Tensor
    high: Tensor

    def parameters(self) -> Iterator[Tensor]:
        """The parameters to train."""
        for linear in self.linears:
            yield from (linear.weight, linear.bias)
        for norm in self.norms:
            yield from (norm.scale, norm.shift)

    def __call__(self, x: Tensor, *, training: bool) -> Tensor:
        """Outputs [member output flight] of whitened features [member feature flight]."""
        members = x.shape[0]
        for linear, norm in zip(self.linears, self.norms, strict=False):
            x = torch.baddbmm(linear.bias, linear.weight, x)
            shape = x.shape
            x = x.view(1, members * shape[1], shape[2])
            x = batch_norm(x, norm.mean, norm.variance, norm.scale, norm.shift, training, 0.1, EPSILON)
            x = dropout(relu(x, inplace=True), self.drop, training).view(shape)
        last = self.linears[-1]
        squashed = torch.sigmoid(torch.baddbmm(last.bias, last.weight, x))
        return self.low + (self.high - self.low) * squashed


def network(members: int, widths: tuple[int, ...], ranges: Float[Array, "output 2"], drop: float) -> Network:
    """An untrained network; `widths` runs from the number of features to the last hidden layer.

    `ranges` are the bounds of each output, in its unit; `drop` is the fraction of activations dropped in training [1].
    Weights and biases start uniform within one over the root of the number of inputs, as in torch's layers.
    """

    def uniform(*shape: int, inputs: int) -> Tensor:
        values = (2 * torch.rand(shape) - 1) * inputs**-0.5
        return values.requires_grad_()

    pairs = zip(widths, (*widths[1:], len(ranges)), strict=True)
    low, high = torch.tensor(ranges, dtype=torch.float32).T[:, None, :, None]
    return Network(
        linears=tuple(
            Linear(uniform(members, out, inputs, inputs=inputs), uniform(members, out, 1, inputs=inputs))
            for inputs, out in pairs
        ),
        norms=tuple(_fresh_norm(members * width) for width in widths[1:]),
        drop=drop,
        low=low,
        high=high,
    )


def _fresh_norm(channels: int) -> Norm:
    return Norm(
        scale=torch.ones(channels, requires_grad=True),
        shift=torch.zeros(channels, requires_grad=True),
        mean=torch.zeros(channels),
        variance=torch.ones(channels),
    )
