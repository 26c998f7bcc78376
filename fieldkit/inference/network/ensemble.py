"""Running a trained ensemble: one ONNX graph and its card.

Only this file imports onnxruntime, and only when an ensemble is loaded.
"""

import hashlib
import json
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from fieldkit.errors import DamagedModel
from fieldkit.plugins import trained_folder
from fieldkit.shapes import Array, Float

CARD = "card.json"
GRAPH = "ensemble.onnx"
ENDS = ("mean", "spread")
"""Outputs of a graph."""
LARGEST_CARD = 1 << 20
LARGEST_GRAPH = 32 << 20
"""Maximum file size. [bytes]"""


@dataclass(frozen=True, slots=True)
class Ensemble:
    """A trained ensemble, ready to run; `features` and `outputs` name its columns, in order."""

    name: str
    features: tuple[str, ...]
    outputs: tuple[str, ...]
    card: Mapping[str, Any]
    session: Any

    def __call__(
        self, features: Float[Array, "flight feature"]
    ) -> tuple[Float[Array, "flight output"], Float[Array, "flight output"]]:
        """Mean and standard deviation over the members."""
        mean, spread = self.session.run(("mean", "spread"), {"features": np.asarray(features, np.float64)})
        return mean, spread


def load(name: str) -> Ensemble:
    """A shipped ensemble by its name. Raises DamagedModel if it cannot be loaded."""
    return load_folder(trained_folder(name))


def load_folder(folder: Path) -> Ensemble:
    """The ensemble in a folder. Raises DamagedModel if it does not match its card."""
    card = read_card(folder)
    graph = _read(folder / GRAPH, LARGEST_GRAPH)
    digest = hashlib.sha256(graph).hexdigest()
    if digest != card["digests"][GRAPH]:
        raise DamagedModel(
            f"{folder / GRAPH}: found sha256 {digest[:12]}..., "
            f"its card says {str(card['digests'][GRAPH])[:12]}...; install it or train it again"
        )
    return from_parts(graph, card, folder)


def from_parts(graph: bytes, card: Mapping[str, Any], folder: Path) -> Ensemble:
    """An ensemble from its graph and card; `folder` is named in messages. Raises DamagedModel if they do not match."""
    session = _session(graph, folder)
    features, outputs = tuple(card["features"]), tuple(card["outputs"])
    found = [(one.name, one.shape[1:]) for one in (*session.get_inputs(), *session.get_outputs())]
    if found != [("features", [len(features)]), *((end, [len(outputs)]) for end in ENDS)]:
        raise DamagedModel(f"{folder / GRAPH}: found {found}, expected the features and outputs of its card")
    return Ensemble(card["name"], features, outputs, card, session)


def read_card(folder: Path) -> Mapping[str, Any]:
    """The card of a folder, without running the graph. Raises DamagedModel if the card cannot be read."""
    path = folder / CARD
    try:
        card = json.loads(_read(path, LARGEST_CARD))
    except (ValueError, RecursionError) as error:
        raise DamagedModel(f"{path}: found no JSON ({error}), expected the card of an ensemble") from error
    digests = card.get("digests") if isinstance(card, dict) else None
    right = (
        isinstance(digests, dict)
        and isinstance(digests.get(GRAPH), str)
        and isinstance(card.get("name"), str)
        and all(_is_texts(card.get(key)) for key in ("features", "outputs"))
    )
    if not right:
        raise DamagedModel(f"{path}: found no name, features, outputs and digest of {GRAPH}, expected all four")
    return dict(card)


def _is_texts(value: object) -> bool:
    return isinstance(value, list) and all(isinstance(one, str) for one in value)


def _read(path: Path, largest: int) -> bytes:
    try:
        with path.open("rb") as file:
            content = file.read(largest + 1)
    except OSError as error:
        raise DamagedModel(f"{path}: cannot be read ({error.strerror}), expected a part of an ensemble") from error
    if len(content) > largest:
        raise DamagedModel(f"{path}: found more than {largest} bytes, expected at most that")
    return content


def _session(graph: bytes, folder: Path) -> Any:
    """A session on one thread: a flight takes a tenth of a millisecond, less than starting a second thread."""
    import onnxruntime  # takes 0.02 s to import

    options = onnxruntime.SessionOptions()
    options.intra_op_num_threads = 1
    options.inter_op_num_threads = 1
    options.log_severity_level = 3
    try:
        return onnxruntime.InferenceSession(graph, options, providers=["CPUExecutionProvider"])
    except Exception as error:  # the errors of onnxruntime share no other base class
        reason = str(error).splitlines()[0]
        raise DamagedModel(f"{folder / GRAPH}: onnxruntime cannot run it ({reason})") from error
