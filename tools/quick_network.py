"""`python -m tools.quick_network [FOLDER --bench SETS --beside LINES --flyers JOURNAL CONTEST REFERENCE]`.

With the folder of `python -m studies.quick_network train`, sets of `python -m bench.make`, the lines of
`python -m tools.quick_beside_fit` and tables of flights, it measures and writes `docs/measured/quick_network.json`.
Without them it writes `docs/measured/quick_network.md` from that file.
"""

import argparse
import json
from pathlib import Path
from typing import Any

from studies.quick_network.__main__ import KINDS, MEMBERS
from studies.quick_network.network import FlightsNetwork, restore
from studies.quick_network.page import page
from tools.markdown import MEASURED as FOLDER
from tools.quick_measurements import beside_fit, forward_in_time, on_bench

MEASURED, PAGE = FOLDER / "quick_network.json", FOLDER / "quick_network.md"


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folder", type=Path, nargs="?")
    parser.add_argument("--bench", type=Path)
    parser.add_argument("--beside", type=Path)
    parser.add_argument("--flyers", type=Path, nargs=3)
    given = parser.parse_args()
    if given.folder:
        document = measure(given.folder, given.bench, given.beside, given.flyers)
        MEASURED.write_text(json.dumps(document, indent=1) + "\n", encoding="utf-8")
    else:
        found = json.loads(MEASURED.read_text(encoding="utf-8"))
        PAGE.write_text("\n".join(page(found)).rstrip() + "\n", encoding="utf-8")


def measure(folder: Path, bench: Path, beside: Path, flyers: list[Path]) -> dict[str, Any]:
    """All measurements of the page."""
    training = json.loads((folder / "training.json").read_text())
    held_out = json.loads((folder / "held_out.json").read_text())
    raw, closed, effects = training["sizes"]
    networks: dict[str, list[FlightsNetwork]] = {}
    for name, use_closed in KINDS.items():
        networks[name] = [FlightsNetwork(raw, closed, effects, use_closed) for _ in range(MEMBERS)]
        for member, network in enumerate(networks[name]):
            restore(network, folder / f"{name}_{member}.pt")
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
