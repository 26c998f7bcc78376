"""The history network as one ONNX graph: features in, the parts of every member out."""

from typing import Any

import numpy as np
from onnx import TensorProto, checker, helper, numpy_helper
from torch import Tensor

from fieldkit.inference.training.history_members import HistoryMembers
from fieldkit.shapes import Array, Float

MAX_FEATURE_SDS = 8.0
"""Features are limited to this many standard deviations from their mean. [1]"""


class _Graph:
    """The nodes and constants of a graph under construction."""

    def __init__(self) -> None:
        self.constants: list[Any] = []
        self.nodes: list[Any] = []

    def constant(self, name: str, values: Any) -> str:
        self.constants.append(numpy_helper.from_array(np.ascontiguousarray(values), name))
        return name

    def weight(self, name: str, values: Tensor) -> str:
        return self.constant(name, values.detach().cpu().numpy().astype(np.float32))

    def node(self, kind: str, inputs: list[str], output: str, **settings: Any) -> str:
        self.nodes.append(helper.make_node(kind, inputs, [output], **settings))
        return output

    def silu(self, value: str) -> str:
        gate = self.node("Sigmoid", [value], f"{value}_gate")
        return self.node("Mul", [value, gate], f"{value}_silu")


def history_graph(members: HistoryMembers, mean: Float[Array, "feature"], sd: Float[Array, "feature"]) -> bytes:
    """The graph: `features` [history feature] in float64 in, `parts` [history member part] out; scaling in float64."""
    graph = _Graph()
    constant, weight, node = graph.constant, graph.weight, graph.node
    value = node("Sub", ["features", constant("mean", mean.astype(np.float64))], "centered")
    value = node("Div", [value, constant("sd", sd.astype(np.float64))], "scaled")
    limits = [
        constant(name, np.array(limit, np.float64))
        for name, limit in (("low", -MAX_FEATURE_SDS), ("high", MAX_FEATURE_SDS))
    ]
    value = node("Clip", [value, *limits], "limited")
    whole = node("Cast", [value], "small", to=TensorProto.FLOAT)
    split = constant("split", np.array([members.of_history, members.effects * members.per_effect], np.int64))
    graph.nodes.append(helper.make_node("Split", [whole, split], ["of_history", "flat"], axis=1))
    shape = constant("shape", np.array([-1, members.effects, members.per_effect], np.int64))
    each = node("Reshape", ["flat", shape], "each")
    own = node("MatMul", [each, weight("own", members.own)], "own_product")
    beside = node("MatMul", ["of_history", weight("beside", members.beside)], "beside_product")
    beside = node("Unsqueeze", [beside, constant("axis", np.array([2], np.int64))], "beside_each")
    hidden = node("Add", [own, beside], "joined")
    hidden = graph.silu(node("Add", [hidden, weight("which", members.which)], "first"))
    hidden = node("MatMul", [hidden, weight("second_weight", members.second)], "second_product")
    hidden = graph.silu(node("Add", [hidden, weight("second_bias", members.second_bias)], "second"))
    last = node("MatMul", [hidden, weight("last", members.last)], "last_product")
    skip = node("MatMul", [each, weight("skip", members.skip)], "skip_product")
    logits = node("Add", [last, skip], "logit_column")
    logits = node("Squeeze", [logits, constant("last_axis", np.array([3], np.int64))], "logit_row")
    logits = node("Add", [logits, weight("level", members.level)], "logits")
    rest = whole
    for number, (own_weight, bias) in enumerate(zip(members.weights, members.biases, strict=True)):
        rest = node("MatMul", [rest, weight(f"weight_{number}", own_weight)], f"product_{number}")
        rest = node("Add", [rest, weight(f"bias_{number}", bias)], f"sum_{number}")
        if number < len(members.weights) - 1:
            rest = graph.silu(rest)
    both = node("Concat", [logits, rest], "both", axis=2)
    value = node("Transpose", [both], "by_history", perm=[1, 0, 2])
    node("Cast", [value], "parts", to=TensorProto.DOUBLE)
    size = [members.own.shape[0], members.effects + members.biases[-1].shape[-1]]
    built = helper.make_graph(
        graph.nodes,
        "history",
        [helper.make_tensor_value_info("features", TensorProto.DOUBLE, ["history", len(mean)])],
        [helper.make_tensor_value_info("parts", TensorProto.DOUBLE, ["history", *size])],
        graph.constants,
    )
    model = helper.make_model(built, opset_imports=[helper.make_opsetid("", 17)], ir_version=9)
    checker.check_model(model)
    return bytes(model.SerializeToString(deterministic=True))
