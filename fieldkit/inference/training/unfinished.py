"""The state of an unfinished training as a sequence of arrays, so that reading it runs no code.

The first contains the bytes of a JSON document with everything except tensors, and the names of the tensors.
"""

import io
import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
import torch
from torch import nn
from torch.optim.lr_scheduler import OneCycleLR

from fieldkit.files import replace


def save_state(
    file: Path,
    members: nn.Module,
    optimizer: torch.optim.Optimizer,
    rate: OneCycleLR,
    losses: list[float],
    best: Mapping[str, torch.Tensor],
) -> None:
    """Save members, optimizer, rate and losses, and the members of the best epoch. Raises FieldkitError."""
    own = optimizer.state_dict()
    arrays = {f"members/{name}": value for name, value in members.state_dict().items()}
    arrays |= {f"best/{name}": value for name, value in best.items()}
    arrays |= {f"optimizer/{i}/{name}": value for i, entry in own["state"].items() for name, value in entry.items()}
    numbers = {"losses": losses, "rate": rate.state_dict(), "groups": own["param_groups"], "names": list(arrays)}
    content = io.BytesIO()
    for array in (np.frombuffer(json.dumps(numbers).encode(), np.uint8), *(x.cpu().numpy() for x in arrays.values())):
        np.lib.format.write_array(content, np.asarray(array), allow_pickle=False)
    file.parent.mkdir(parents=True, exist_ok=True)
    replace(file, content.getvalue())


def load_state(
    file: Path, members: nn.Module, optimizer: torch.optim.Optimizer, rate: OneCycleLR
) -> tuple[list[float], dict[str, torch.Tensor]]:
    """Restore members, optimizer and rate from a file. Returns the losses so far and the members of the best epoch."""
    content = io.BytesIO(file.read_bytes())

    def following() -> Any:
        return np.lib.format.read_array(content, allow_pickle=False)

    numbers = json.loads(following().tobytes())
    arrays = {name: torch.from_numpy(following()) for name in numbers["names"]}
    members.load_state_dict(_below(arrays, "members"))
    state: dict[int, dict[str, Any]] = {}
    for name, value in _below(arrays, "optimizer").items():
        number, _, key = name.partition("/")
        state.setdefault(int(number), {})[key] = value
    optimizer.load_state_dict({"state": state, "param_groups": numbers["groups"]})
    rate.load_state_dict(numbers["rate"])
    return numbers["losses"], _below(arrays, "best")


def _below(arrays: Mapping[str, torch.Tensor], first: str) -> dict[str, torch.Tensor]:
    return {name.removeprefix(f"{first}/"): value for name, value in arrays.items() if name.startswith(f"{first}/")}
