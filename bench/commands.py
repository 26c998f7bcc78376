"""Code shared by the benches of the whole product: options, and running its commands as a user does. Nothing of the
product is imported."""

import argparse
import json
import shlex
import subprocess
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import Any


class CommandFailed(Exception):
    """A command of the product ended with an error."""


def sets_parser(description: str | None) -> argparse.ArgumentParser:
    """A command line with a folder of sets and the command of the product."""
    parser = argparse.ArgumentParser(description=(description or "").partition("\n")[0])
    parser.add_argument("sets", type=Path)
    parser.add_argument("--command", type=shlex.split, default=[sys.executable, "-m", "fieldkit.cli.main"])
    parser.add_argument("--limit", type=int, help="only so many of the sets")
    return parser


def read_labels(sets: Path, limit: int | None = None) -> list[dict[str, Any]]:
    """The labels of the first sets of a folder."""
    labels: list[dict[str, Any]] = json.loads((sets / "labels.json").read_text())
    return labels[:limit]


def run(command: Sequence[str], folder: Path, *arguments: str, timeout: float | None = None) -> Any:
    """The JSON output of a command on the ledger of a folder. Raises CommandFailed, subprocess.TimeoutExpired."""
    whole = [*command, "--ledger", str(folder / "ledger.db"), *arguments, "--json"]
    done = subprocess.run(whole, capture_output=True, text=True, timeout=timeout)
    if done.returncode:
        raise CommandFailed(f"{shlex.join(whole[-6:])}: {done.stderr.strip()[-300:]}")
    return json.loads(done.stdout)
