"""`python -m studies.quick_network simulate|train FOLDER`: the histories, and the networks trained on them.

`python -m tools.quick_network` scores them beside the closed forms, the fit and the loop, and writes the page.
"""

import argparse
import json
import time
from pathlib import Path

import numpy as np
import torch

from studies.quick_network.network import FlightsNetwork, export, train
from studies.quick_network.scores import scores
from studies.quick_network.tables import load, simulate

MEMBERS = 3
"""Networks of each kind, whose answers are averaged."""
HELD_OUT, VALIDATION = 0.12, 0.06
"""Fractions of the histories for the scores, and for choosing the epoch. [1]"""
KINDS = {"whole": True, "raw": False}
"""The networks, and whether they see the closed forms."""


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("what", choices=("simulate", "train"))
    parser.add_argument("folder", type=Path)
    parser.add_argument("--processes", type=int, default=2)
    parser.add_argument("--seconds", type=float, default=3600.0)
    parser.add_argument("--seed", type=int, default=1)
    given = parser.parse_args()
    if given.what == "simulate":
        began = time.monotonic()
        count = simulate(given.folder / "shards", given.seed, given.processes, given.seconds)
        print(f"{count} histories in {time.monotonic() - began:.0f} s with {given.processes} processes", flush=True)
    else:
        train_all(given.folder, given.seconds, given.seed)


def train_all(folder: Path, seconds: float, seed: int) -> None:
    """Train the networks on the shards of a folder, and write them and their scores there."""
    whole = load(folder / "shards")
    order = np.random.default_rng(seed).permutation(len(whole.about) // 3)
    rows = (order[:, None] * 3 + np.arange(3)).ravel()  # histories of one rocket stay together, nearly
    ends = np.round(np.array([HELD_OUT, HELD_OUT + VALIDATION]) * len(rows)).astype(int)
    held_out, validation, training = (whole.rows(part) for part in np.split(rows, ends))
    print(f"{len(training.about)} histories for training, {len(held_out.about)} held out", flush=True)
    found: dict[str, list[FlightsNetwork]] = {}
    for name, use_closed in KINDS.items():
        found[name] = []
        for member in range(MEMBERS):
            network, _ = train(training, validation, use_closed, seconds / (2 * MEMBERS), member)
            torch.save(network.state_dict(), folder / f"{name}_{member}.pt")
            found[name].append(network)
        result = scores(found, held_out)
        (folder / "held_out.json").write_text(json.dumps(result, indent=1), encoding="utf-8")
        print(json.dumps(result, indent=1), flush=True)
    device = torch.cuda.get_device_name() if torch.cuda.is_available() else "one CPU core"
    about = {"histories": len(training.about), "seconds": round(seconds), "device": device}
    about["sizes"] = [whole.flights.shape[-1], whole.closed_flights.shape[-1], whole.present.shape[1]]
    (folder / "training.json").write_text(json.dumps(about), encoding="utf-8")
    for name, networks in found.items():
        for member, network in enumerate(networks):
            export(network, held_out, folder / f"{name}_{member}.onnx")


if __name__ == "__main__":
    main()
