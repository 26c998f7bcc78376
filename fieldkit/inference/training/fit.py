"""Fitting a batched network to simulated flights on one thread, reproducible for a seed."""

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass

import torch
from torch import Tensor
from torch.optim.lr_scheduler import OneCycleLR, ReduceLROnPlateau

from fieldkit.inference.training.network import Network

TrainingProgress = Callable[[int, int, float], None]
"""Callback after each epoch: its number from 1, the number of epochs, and the loss, on validation flights if the recipe
has them."""

BATCH = 256
WEIGHT_DECAY = 1e-4


@dataclass(frozen=True, slots=True)
class Schedule:
    """A schedule: epochs and learning rate, in one cycle up and down, or constant and halved on each plateau."""

    name: str
    epochs: int
    rate: float
    one_cycle: bool
    patience: int = 10


SCHEDULES = {
    "quick": Schedule("quick", epochs=10, rate=1e-2, one_cycle=True),
    "published": Schedule("published", epochs=100, rate=1e-3, one_cycle=False),
}
"""`published` is the paper's schedule; `quick` reaches the same errors in 10% of the time."""


@contextmanager
def one_thread(seed: int) -> Iterator[None]:
    """Run torch seeded on one thread and restore its state afterward; on a busy machine a second thread slows it."""
    threads = torch.get_num_threads()
    torch.set_num_threads(1)
    try:
        with torch.random.fork_rng(devices=[]):
            torch.manual_seed(seed)
            yield
    finally:
        torch.set_num_threads(threads)


def fit(
    network: Network,
    x: Tensor,
    truth: Tensor,
    validation: tuple[Tensor, Tensor],
    schedule: Schedule,
    progress: TrainingProgress | None = None,
) -> None:
    """Train every member on its own bootstrap sample of whitened features [flight feature] and truths.

    AdamW on squared errors. All members share the rate, which follows their mean validation loss.
    """
    members, count = network.linears[0].weight.shape[0], len(x)
    bootstrap = torch.randint(count, (members, count))
    optimiser = torch.optim.AdamW(network.parameters(), lr=schedule.rate, weight_decay=WEIGHT_DECAY)
    steps = -(-count // BATCH)
    cycle = OneCycleLR(optimiser, schedule.rate, total_steps=schedule.epochs * steps) if schedule.one_cycle else None
    plateau = ReduceLROnPlateau(optimiser, factor=0.5, patience=schedule.patience)
    for epoch in range(1, schedule.epochs + 1):
        order = bootstrap.gather(1, torch.rand(members, count).argsort(dim=1))
        for rows in order.split(BATCH, dim=1):
            optimiser.zero_grad()
            found = network(x[rows].transpose(1, 2), training=True)
            loss = (found - truth[rows].transpose(1, 2)).square().mean(dim=(1, 2)).sum()
            loss.backward()
            optimiser.step()
            if cycle:
                cycle.step()
        loss_there = float((outputs(network, validation[0]) - validation[1]).square().mean())
        if not cycle:
            plateau.step(loss_there)
        if progress:
            progress(epoch, schedule.epochs, loss_there)


def outputs(network: Network, x: Tensor) -> Tensor:
    """Outputs of every member [member flight output] for whitened features [flight feature]."""
    with torch.no_grad():
        members = network.linears[0].weight.shape[0]
        return network(x.T.expand(members, -1, -1), training=False).transpose(1, 2)
