"""A network over the flights of a history: a few layers of attention, with outputs for every flight, every effect and
the plan. With `closed` it also sees the closed forms, and corrects their log odds and forecast."""

import time
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import torch
from torch import Tensor, nn

from fieldkit.model.causes import NAMES
from studies.quick_network.inputs import PER_EFFECT
from studies.quick_network.tables import WorldTable

WIDTH, HEADS, LAYERS = 96, 4, 3
"""Size of the network. [1]"""
BATCH, RATE, DECAY = 256, 1.5e-3, 0.05
"""Training: histories of a batch, peak learning rate, weight decay. [1]"""
CLOSED_FORMS_OF_HISTORY = 6
"""Closed-form inputs of the history that are not of one effect."""
CAUSE_WEIGHT, FORECAST_WEIGHT = 4.0, 1.0
"""Weights of the losses of causes and of the forecast relative to that of effects. [1]"""
TAIL = 4.0
"""Degrees of freedom of the forecast. [1]"""


class FlightsNetwork(nn.Module):  # type: ignore[misc]
    """Log odds of causes [history flight cause] with that of none last, of effects, nothing and something unexplained
    [history effect + 2], and mean and log standard deviation of the plan's log apogee."""

    def __init__(self, raw: int, closed: int, effects: int, use_closed: bool) -> None:
        super().__init__()
        self.use_closed, self.effects = use_closed, effects
        self.enter = nn.Linear(raw + (closed if use_closed else 0), WIDTH)
        layer = nn.TransformerEncoderLayer(WIDTH, HEADS, 2 * WIDTH, 0.05, "gelu", batch_first=True, norm_first=True)
        self.layers = nn.TransformerEncoder(layer, LAYERS, enable_nested_tensor=False)
        self.of_flight = nn.Sequential(nn.Linear(WIDTH, WIDTH), nn.GELU(), nn.Linear(WIDTH, len(NAMES) + 1))
        per, few = (PER_EFFECT, CLOSED_FORMS_OF_HISTORY) if use_closed else (0, 0)
        self.of_effect = nn.Sequential(nn.Linear(2 * WIDTH + per + few, WIDTH), nn.GELU(), nn.Linear(WIDTH, WIDTH))
        self.which = nn.Parameter(torch.randn(effects + 2, WIDTH) * 0.1)
        self.by_effect = nn.Sequential(nn.GELU(), nn.Linear(WIDTH, WIDTH), nn.GELU(), nn.Linear(WIDTH, 1))
        self.of_plan = nn.Sequential(nn.Linear(2 * WIDTH + few, WIDTH), nn.GELU(), nn.Linear(WIDTH, 2))
        for last in (self.of_flight[-1], self.by_effect[-1], self.of_plan[-1]):
            nn.init.normal_(last.weight, std=0.01)
            nn.init.zeros_(last.bias)
        self.trust_causes = nn.Parameter(torch.ones(len(NAMES) + 1))
        self.trust_effects = nn.Parameter(torch.ones(effects + 2))
        self.level = nn.Parameter(torch.full((effects + 2,), -2.5))

    def forward(
        self, flights: Tensor, mask: Tensor, closed_flights: Tensor, closed: Tensor, odds: Tensor, chance: Tensor
    ) -> tuple[Tensor, Tensor, Tensor]:
        tokens = torch.cat([flights, closed_flights], -1) if self.use_closed else flights
        hidden = self.layers(self.enter(tokens), src_key_padding_mask=mask < 0.5)
        pooled = (hidden * mask[..., None]).sum(1) / mask.sum(1, keepdim=True)
        plan = hidden[torch.arange(len(hidden), device=hidden.device), mask.sum(1).long() - 1]
        both = torch.cat([pooled, plan], -1)
        causes, effects = self.of_flight(hidden), self.level.expand(len(hidden), -1)
        few, shared = closed[:, :CLOSED_FORMS_OF_HISTORY], both[:, None].expand(-1, self.effects + 2, -1)
        if self.use_closed:
            causes = causes + self.trust_causes * torch.log(chance.clamp(min=1e-6))
            each = closed[:, CLOSED_FORMS_OF_HISTORY:].unflatten(-1, (self.effects, PER_EFFECT))
            each = torch.cat([each, torch.zeros_like(each[:, :2])], 1)
            shared = torch.cat([shared, each, few[:, None].expand(-1, self.effects + 2, -1)], -1)
            effects = 0.0 * effects + self.trust_effects * odds.clamp(-15, 15)
            both = torch.cat([both, few], -1)
        effects = effects + self.by_effect(self.of_effect(shared) + self.which)[..., 0]
        return causes, effects, self.of_plan(both)


def restore(network: FlightsNetwork, path: Path) -> None:
    """Load the weights that a training saved, for answers."""
    network.load_state_dict(torch.load(path, weights_only=True))
    network.eval()


@dataclass(frozen=True, slots=True)
class TensorBatch:
    """A table as tensors of inputs and targets."""

    inputs: tuple[Tensor, ...]
    causes: Tensor
    judged: Tensor
    present: Tensor
    counts: Tensor
    z: Tensor
    scale: Tensor

    def rows(self, which: Tensor) -> "TensorBatch":
        return TensorBatch(
            tuple(one[which].float() for one in self.inputs),
            *(getattr(self, name)[which] for name in TensorBatch.__slots__ if name != "inputs"),
        )


def tensors(table: WorldTable, use_closed: bool, device: str) -> TensorBatch:
    """The table as tensors; the forecast is relative to the linear pass, or to the simulation without closed forms."""

    def tensor(values: Any, kind: Any = torch.float32) -> Tensor:
        return torch.from_numpy(np.ascontiguousarray(values)).to(device=device, dtype=kind)

    nothing = (table.present.sum(axis=1) + table.column("unexplained") == 0).astype(float)
    odds = np.column_stack([table.odds, table.column("none_odds"), table.column("pattern_odds")])
    middle, sd = (table.column("mean"), table.column("sd")) if use_closed else (table.column("reference"), 0.3)
    half = torch.float16 if device == "cuda" else torch.float32
    return TensorBatch(
        (
            tensor(table.flights, half),
            tensor(table.mask, half),
            tensor(table.closed_flights, half),
            tensor(table.closed, half),
            tensor(odds),
            tensor(np.where(table.cause_chance.sum(-1, keepdims=True) > 0, table.cause_chance, 1.0), torch.float32),
        ),
        tensor(table.causes, torch.int64),
        tensor(table.judged),
        tensor(np.column_stack([table.present, nothing, table.column("unexplained")])),
        tensor(np.column_stack([table.acts, np.ones((len(table.acts), 2))])),
        tensor(np.clip((table.column("log_apogee") - middle) / sd, -15, 15)),
        tensor(np.broadcast_to(sd, len(middle))),
    )


def loss(network: FlightsNetwork, batch: TensorBatch) -> Tensor:
    """Cross entropy of effects and of causes, and the negative log density of the plan's apogee (Student t). [nat]"""
    causes, effects, plan = network(*batch.inputs)
    entropy = nn.functional.binary_cross_entropy_with_logits(effects, batch.present, reduction="none")
    of_effects = (entropy * batch.counts).sum() / len(effects)
    flat = nn.functional.cross_entropy(causes.flatten(0, 1), batch.causes.flatten(), reduction="none")
    of_causes = (flat * batch.judged.flatten()).sum() / batch.judged.sum().clamp(min=1.0)
    log_sd = plan[:, 1].clamp(-3, 3)
    square = ((batch.z - plan[:, 0]) * torch.exp(-log_sd)) ** 2
    of_plan = (log_sd + (TAIL + 1) / 2 * torch.log1p(square / TAIL)).mean()
    return of_effects + CAUSE_WEIGHT * of_causes + FORECAST_WEIGHT * of_plan


def train(
    table: WorldTable, validation: WorldTable, use_closed: bool, seconds: float, seed: int
) -> tuple[FlightsNetwork, list[float]]:
    """A network trained by AdamW with one cycle of the rate for some seconds, at its best validation loss."""
    device = "cuda" if torch.cuda.is_available() else "cpu"
    torch.manual_seed(seed)
    data, unseen = tensors(table, use_closed, device), tensors(validation, use_closed, device)
    sizes = table.flights.shape[-1], table.closed_flights.shape[-1], table.present.shape[1]
    network = FlightsNetwork(*sizes, use_closed).to(device)
    optimizer = torch.optim.AdamW(network.parameters(), lr=RATE, weight_decay=DECAY)
    began, losses, best = time.monotonic(), list[float](), {}
    while (done := (time.monotonic() - began) / seconds) < 1:
        network.train()
        order = torch.randperm(len(table.about), device=device)
        for first in range(0, len(order) - BATCH + 1, BATCH):
            done = min((time.monotonic() - began) / seconds, 1.0)
            rate = RATE * min(done / 0.1 + 0.02, 1.0) * (0.5 + 0.5 * np.cos(np.pi * done))
            for group in optimizer.param_groups:
                group["lr"] = rate
            optimizer.zero_grad()
            loss(network, data.rows(order[first : first + BATCH])).backward()
            nn.utils.clip_grad_norm_(network.parameters(), 2.0)
            optimizer.step()
            if done >= 1:
                break
        network.eval()
        with torch.no_grad():
            parts = torch.arange(len(validation.about), device=device).split(1024)
            losses.append(
                float(sum(loss(network, unseen.rows(part)) * len(part) for part in parts)) / len(validation.about)
            )
        if losses[-1] == min(losses):
            best = {name: value.detach().cpu().clone() for name, value in network.state_dict().items()}
        print(f"{'whole' if use_closed else 'raw'} seed {seed} epoch {len(losses)}: {losses[-1]:.4f}", flush=True)
    network.load_state_dict(best)
    return network.cpu().eval(), losses


def answers(networks: list[FlightsNetwork], table: WorldTable) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """Probabilities of causes [history flight cause] and of effects, nothing and something unexplained, and the mean
    and standard deviation of the plan's log apogee; averaged over networks."""
    own = tensors(table, networks[0].use_closed, "cpu")
    with torch.no_grad():
        found = []
        for part in torch.arange(len(table.about)).split(512):
            batch = own.rows(part)
            each = [network(*batch.inputs) for network in networks]
            causes = torch.stack([torch.softmax(one[0], -1) for one in each]).mean(0)
            effects = torch.stack([torch.sigmoid(one[1]) for one in each]).mean(0)
            means = torch.stack([one[2][:, 0] for one in each])
            sds = torch.stack([torch.exp(one[2][:, 1].clamp(-3, 3)) for one in each])
            sd = torch.sqrt((sds**2).mean(0) + means.var(0, unbiased=False))
            found.append((causes, effects, means.mean(0) * batch.scale, sd * batch.scale))
    causes, effects, mean, sd = (torch.cat(column).numpy() for column in zip(*found, strict=True))
    middle = table.column("mean") if networks[0].use_closed else table.column("reference")
    return causes, effects, middle + mean, sd


def export(network: FlightsNetwork, table: WorldTable, path: Path) -> None:
    """The network as ONNX."""
    batch = tensors(table.rows(slice(4)), network.use_closed, "cpu").rows(torch.arange(4))
    names = ["flights", "mask", "closed_flights", "closed", "odds", "chance"]
    axes = {name: {0: "history"} for name in names}
    torch.onnx.export(network, batch.inputs, str(path), input_names=names, dynamic_axes=axes, dynamo=False)
