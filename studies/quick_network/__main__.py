"""`python -m studies.quick_network simulate|train|measure FOLDER`, and `page`: the histories, the networks trained on
them, their scores beside the closed forms, the fit and the loop, and the page of the comparison.

`measure FOLDER --bench SETS --beside LINES --flyers JOURNAL CONTEST REFERENCE` writes
`docs/measured/quick_network.json` from the networks in a folder, sets of `python -m bench.make`, the lines of
`studies.quick_network.beside_fit` and tables of flights. Without FOLDER, `page` writes `docs/quick-answers.md` from it.
"""

import argparse
import json
import time
from pathlib import Path
from typing import Any

import numpy as np
import torch

from studies.quick_network.measure import beside_fit, forward_in_time, on_bench
from studies.quick_network.network import FlightsNetwork, export, train
from studies.quick_network.page import page
from studies.quick_network.scores import scores
from studies.quick_network.tables import load, simulate

MEMBERS = 3
"""Networks of each kind, whose answers are averaged."""
HELD_OUT, VALIDATION = 0.12, 0.06
"""Fractions of the histories for the scores, and for choosing the epoch. [1]"""
KINDS = {"whole": True, "raw": False}
"""The networks, and whether they see the closed forms."""
ROOT = Path(__file__).parents[2]
MEASURED, PAGE = ROOT / "docs" / "measured" / "quick_network.json", ROOT / "docs" / "quick-answers.md"


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("what", choices=("simulate", "train", "measure", "page"))
    parser.add_argument("folder", type=Path, nargs="?")
    parser.add_argument("--processes", type=int, default=2)
    parser.add_argument("--seconds", type=float, default=3600.0)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--bench", type=Path)
    parser.add_argument("--beside", type=Path)
    parser.add_argument("--flyers", type=Path, nargs=3)
    given = parser.parse_args()
    if given.what == "page":
        found = json.loads(MEASURED.read_text(encoding="utf-8"))
        PAGE.write_text("\n".join(page(found)).rstrip() + "\n", encoding="utf-8")
    elif given.what == "simulate":
        began = time.monotonic()
        count = simulate(given.folder / "shards", given.seed, given.processes, given.seconds)
        print(f"{count} histories in {time.monotonic() - began:.0f} s with {given.processes} processes", flush=True)
    elif given.what == "train":
        train_all(given.folder, given.seconds, given.seed)
    else:
        document = measure(given.folder, given.bench, given.beside, given.flyers)
        MEASURED.write_text(json.dumps(document, indent=1) + "\n", encoding="utf-8")


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


def measure(folder: Path, bench: Path, beside: Path, flyers: list[Path]) -> dict[str, Any]:
    """All measurements of the page."""
    training = json.loads((folder / "training.json").read_text())
    held_out = json.loads((folder / "held_out.json").read_text())
    raw, closed, effects = training["sizes"]
    networks: dict[str, list[FlightsNetwork]] = {}
    for name, use_closed in KINDS.items():
        networks[name] = [FlightsNetwork(raw, closed, effects, use_closed) for _ in range(MEMBERS)]
        for member, network in enumerate(networks[name]):
            network.load_state_dict(torch.load(folder / f"{name}_{member}.pt", weights_only=True))
            network.eval()
    lines = [json.loads(line) for path in sorted(beside.glob("*.jsonl")) for line in path.read_text().splitlines()]
    loops = {line["set"]: line["loop"] for line in lines if line["kind"] == "bench"}
    names = ("journal", "contest", "reference")
    return {
        "training": training,
        "held_out": held_out,
        "beside_fit": beside_fit(lines),
        "bench": on_bench(bench, loops, networks, held_out["pooling_weights"]),
        "real": {name: forward_in_time(path, networks) for name, path in zip(names, flyers, strict=True)},
    }


if __name__ == "__main__":
    main()
