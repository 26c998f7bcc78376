"""`python -m studies.quick_network simulate|train FOLDER`: the histories, and the networks trained on them."""

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


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
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
        return
    whole = load(given.folder / "shards")
    order = np.random.default_rng(given.seed).permutation(len(whole.about) // 3)
    rows = (order[:, None] * 3 + np.arange(3)).ravel()  # histories of one rocket stay together, nearly
    ends = np.round(np.array([HELD_OUT, HELD_OUT + VALIDATION]) * len(rows)).astype(int)
    held_out, validation, training = (whole.rows(part) for part in np.split(rows, ends))
    print(f"{len(training.about)} histories for training, {len(held_out.about)} held out", flush=True)
    found: dict[str, list[FlightsNetwork]] = {}
    for name, use_closed in (("whole", True), ("raw", False)):
        found[name] = []
        for seed in range(MEMBERS):
            network, _ = train(training, validation, use_closed, given.seconds / (2 * MEMBERS), seed)
            torch.save(network.state_dict(), given.folder / f"{name}_{seed}.pt")
            found[name].append(network)
        result = scores(found, held_out)
        (given.folder / "held_out.json").write_text(json.dumps(result, indent=1), encoding="utf-8")
        print(json.dumps(result, indent=1), flush=True)
    for name, networks in found.items():
        for seed, network in enumerate(networks):
            export(network, held_out, given.folder / f"{name}_{seed}.onnx")


if __name__ == "__main__":
    main()
