"""All members of the history network as one: every layer is one batched product.

One part sees the history and one effect, with the same weights for every effect except a bias, and outputs its
inclusion. Another part sees everything and gives the other outputs.
"""

from itertools import pairwise
from typing import Any

import numpy as np
import torch
from torch import Tensor, nn

from fieldkit.inference.history.shards import HistoryTable
from fieldkit.inference.network.history_parts import (
    LEVELS,
    LOG_SD_RANGE,
    MEDIAN,
    OVERALL_OUTPUTS,
    PARAMETERS,
    quantile_steps,
)
from fieldkit.shapes import Array, Float

MEMBERS = 5
EFFECT_UNITS = 64
UNITS = 96
"""Units of each hidden layer of the part that sees one effect, and of the other part. [1]"""
FIRST_LOGIT = -2.5
"""Log odds of an effect before training, near those of the prior. [1]"""
FORECAST_WEIGHT, PARAMETER_WEIGHT = 2.0, 0.5
"""Weights of the losses of the forecast (pinball) and of drag and thrust relative to that of inclusion. [1]"""
CERTIFIED_FORECASTS = 0.05
"""Relative weight of forecast, drag and thrust for rockets from the hyperprior for effects; those from the learned
hyperprior, which is used in forecasts, have weight 1. It is not zero because a rocket may differ from the rockets that
the hyperprior was learned from. [1]"""
MAX_FEATURE_SDS = 8.0
"""Features are clipped to this many standard deviations from their mean. [1]"""
MAX_TARGET_SDS = 8.0
"""Targets are limited to this many standard deviations of the linear fit. [1]"""


def scaled_features(
    features: Float[Array, "row feature"], mean: Float[Array, "feature"], sd: Float[Array, "feature"]
) -> Float[Any, "row feature"]:
    """Features as the members and the exported graph take them. [1]"""
    return ((features - mean) / sd).clip(-MAX_FEATURE_SDS, MAX_FEATURE_SDS).astype(np.float32)


class HistoryMembers(nn.Module):  # type: ignore[misc]
    """Members that each map standardized features to their parts; the first axis is the member."""

    def __init__(self, of_history: int, effects: int, per_effect: int, members: int = MEMBERS) -> None:
        super().__init__()
        self.of_history, self.effects, self.per_effect = of_history, effects, per_effect
        rest = OVERALL_OUTPUTS + len(LEVELS) + len(PARAMETERS)

        def weight(*shape: int, inputs: int, gain: float = 1.0) -> nn.Parameter:
            return nn.Parameter(torch.randn(*shape) * gain * (1.5 / inputs) ** 0.5)

        both = of_history + per_effect
        self.own = weight(members, 1, per_effect, EFFECT_UNITS, inputs=both)
        self.beside = weight(members, of_history, EFFECT_UNITS, inputs=both)
        self.which = nn.Parameter(torch.zeros(members, 1, effects, EFFECT_UNITS))
        self.second = weight(members, 1, EFFECT_UNITS, EFFECT_UNITS, inputs=EFFECT_UNITS)
        self.second_bias = nn.Parameter(torch.zeros(members, 1, 1, EFFECT_UNITS))
        self.last = weight(members, 1, EFFECT_UNITS, 1, inputs=EFFECT_UNITS, gain=0.1)
        self.skip = nn.Parameter(torch.zeros(members, 1, per_effect, 1))
        self.level = nn.Parameter(torch.full((members, 1, effects), FIRST_LOGIT))
        sizes = (of_history + effects * per_effect, UNITS, UNITS, rest)
        self.weights = nn.ParameterList(
            weight(members, a, b, inputs=a, gain=0.1 if i == 2 else 1.0) for i, (a, b) in enumerate(pairwise(sizes))
        )
        self.biases = nn.ParameterList(nn.Parameter(torch.zeros(members, 1, b)) for b in sizes[1:])

    def forward(self, features: Tensor) -> Tensor:
        """Parts [member history part] of features [history feature] or [member history feature]."""
        values = features.expand(self.beside.shape[0], *features.shape[-2:])
        whole = values[..., : self.of_history]
        each = values[..., self.of_history :].unflatten(-1, (self.effects, self.per_effect))
        hidden = each @ self.own + (whole @ self.beside)[:, :, None] + self.which
        hidden = nn.functional.silu(hidden)
        hidden = nn.functional.silu(hidden @ self.second + self.second_bias)
        logits = (hidden @ self.last + each @ self.skip)[..., 0] + self.level
        for number, (weight, bias) in enumerate(zip(self.weights, self.biases, strict=True)):
            values = values @ weight + bias
            if number < len(self.weights) - 1:
                values = nn.functional.silu(values)
        return torch.cat([logits, values], dim=-1)


class HistoryTargets:
    """Training targets as tensors: presence, and the truth relative to the linear fit."""

    def __init__(self, table: HistoryTable, acts: np.ndarray[tuple[int, int], np.dtype[np.bool_]]) -> None:
        nothing = (table.effects.sum(axis=1) + table.truth("unexplained") == 0).astype(float)
        present = np.column_stack([table.effects, nothing, table.truth("unexplained")])
        counts = np.column_stack([acts, np.ones((len(acts), OVERALL_OUTPUTS))]).astype(float)
        counts *= table.truth("selects")[:, None]
        self.present, self.counts = _tensor(present), _tensor(counts)
        self.apogee = _tensor(standardized(table, "log_apogee", "mean", "sd"))
        self.parameters = _tensor(
            np.column_stack(
                [standardized(table, f"log_{name}", f"{name}_mean", f"{name}_sd") for name in ("cd", "alpha")]
            )
        )
        self.weight = _tensor(np.where(table.truth("selects") > 0, CERTIFIED_FORECASTS, 1.0))
        self.coupling = _tensor(np.arctanh(np.clip(table.truth("correlation"), -0.99, 0.99)))

    def rows(self, which: Tensor) -> "HistoryTargets":
        """The selected histories, by an index of any shape."""
        part = object.__new__(HistoryTargets)
        for name, values in vars(self).items():
            setattr(part, name, values[which])
        return part

    def to(self, device: str) -> "HistoryTargets":
        """These targets, moved to a device."""
        for name, values in list(vars(self).items()):
            setattr(self, name, values.to(device))
        return self


def standardized(table: HistoryTable, truth: str, mean: str, sd: str) -> np.ndarray[tuple[int], np.dtype[np.float64]]:
    """The truth relative to the linear fit, in its standard deviations, limited; one entry per history. [1]"""
    z = (table.truth(truth) - table.truth(mean)) / table.truth(sd)
    return np.asarray(np.clip(z, -MAX_TARGET_SDS, MAX_TARGET_SDS))


def _tensor(values: object) -> Tensor:
    return torch.from_numpy(np.asarray(values, np.float32))


def loss(parts: Tensor, targets: HistoryTargets) -> Tensor:
    """Cross entropy of inclusion [nat], plus weighted, the pinball loss of the standardized forecast [1] and the
    negative log density of drag and thrust [nat]."""
    effects = parts.shape[-1] - OVERALL_OUTPUTS - len(LEVELS) - len(PARAMETERS)
    first = effects + OVERALL_OUTPUTS
    entropy = nn.functional.binary_cross_entropy_with_logits(parts[..., :first], targets.present, reduction="none")
    inclusion = (entropy * targets.counts).sum() / targets.counts[..., -1].sum().clamp(min=1.0)
    found = quantiles(parts[..., first : first + len(LEVELS)])
    levels = torch.tensor(LEVELS, device=parts.device)
    miss = targets.apogee[..., None] - found
    pinball = torch.maximum(levels * miss, (levels - 1) * miss).mean(-1)
    density = _density(parts[..., first + len(LEVELS) :], targets)
    weight = targets.weight / targets.weight.mean()
    return inclusion + (weight * (FORECAST_WEIGHT * pinball + PARAMETER_WEIGHT * density)).mean()


def quantiles(raw: Tensor) -> Tensor:
    """As `history_parts.monotone`, as tensors."""
    offsets = torch.tensor(quantile_steps(), dtype=raw.dtype, device=raw.device)
    middle = raw[..., MEDIAN : MEDIAN + 1]
    inner = torch.cat([raw[..., :MEDIAN], raw[..., MEDIAN + 1 :]], dim=-1) + offsets
    steps = nn.functional.softplus(inner)
    below = middle - steps[..., :MEDIAN].flip(-1).cumsum(-1).flip(-1)
    above = middle + steps[..., MEDIAN:].cumsum(-1)
    return torch.cat([below, middle, above], dim=-1)


def _density(parts: Tensor, targets: HistoryTargets) -> Tensor:
    """Negative log density of log Cd and log alpha in a normal distribution, of each history, without its constant; the
    squared distance is limited."""
    log_sd = parts[..., 2:4].clamp(*LOG_SD_RANGE)
    z = (targets.parameters - parts[..., :2]) * torch.exp(-log_sd)
    rho = torch.tanh(targets.coupling + parts[..., 4]).clamp(-0.995, 0.995)
    square = (z[..., 0] ** 2 + z[..., 1] ** 2 - 2 * rho * z[..., 0] * z[..., 1]) / (1 - rho**2)
    return log_sd.sum(-1) + 0.5 * torch.log(1 - rho**2) + 0.5 * square.clamp(max=200.0)
