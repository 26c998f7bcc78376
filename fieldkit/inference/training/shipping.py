"""Writing a trained ensemble into a new folder."""

import hashlib
import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from fieldkit.errors import BadValue
from fieldkit.files import check_target, write_all
from fieldkit.inference.network.ensemble import CARD, GRAPH


def claim(out: Path) -> None:
    """Make the folder.

    Raises BadValue if it already contains an ensemble, which is never overwritten, or if it cannot be made, and
    FieldkitError if the graph cannot be written there.
    """
    if any((out / name).exists() for name in (CARD, GRAPH)):
        raise BadValue(f"{out}: found an existing ensemble, expected a new or empty folder")
    check_target(out / GRAPH)
    try:
        out.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise BadValue(f"{out}: cannot be made ({error.strerror}), expected a folder to write to") from error


def ship(out: Path, graph: bytes, card: Mapping[str, Any]) -> list[str]:
    """Write graph and card, the card last because it has the digests of the rest. Returns the paths. Raises
    FieldkitError if a file cannot be written.
    """
    digests = {GRAPH: hashlib.sha256(graph).hexdigest()}
    text = json.dumps({**card, "digests": digests}, indent=2, allow_nan=False)
    write_all({out / GRAPH: graph, out / CARD: f"{text}\n".encode()})
    return [str(out / GRAPH), str(out / CARD)]
