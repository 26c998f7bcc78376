"""Putting a trained ensemble into a folder of its own."""

import hashlib
import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from fieldkit.errors import BadValue
from fieldkit.inference.network.ensemble import CARD, GRAPH


def claim(out: Path) -> None:
    """Make the folder. Raises BadValue where it holds an ensemble already: one is never overwritten."""
    if (out / CARD).exists():
        raise BadValue(f"{out}: found an ensemble there already, expected a new or empty folder")
    try:
        out.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise BadValue(f"{out}: cannot be made ({error.strerror}), expected a folder to write to") from error


def ship(out: Path, graph: bytes, card: Mapping[str, Any]) -> list[str]:
    """Write graph and card, the card last because it vouches for the rest; the paths written."""
    digests = {GRAPH: hashlib.sha256(graph).hexdigest()}
    (out / GRAPH).write_bytes(graph)
    text = json.dumps({**card, "digests": digests}, indent=2, allow_nan=False)
    (out / CARD).write_text(text + "\n", encoding="utf-8")
    return [str(out / GRAPH), str(out / CARD)]
