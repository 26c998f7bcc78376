"""Members as one ONNX graph: features in, all outputs of each member out.

Features are scaled in the graph in float64; the members run in float32.
"""

from typing import Any

import numpy as np
from onnx import TensorProto, checker, helper, numpy_helper
from torch import Tensor

from fieldkit.inference.training.history_members import MAX_FEATURE_SDS, HistoryMembers
from fieldkit.shapes import Array, Float


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

    def scaled(self, mean: Float[Array, "feature"], sd: Float[Array, "feature"]) -> str:
        """The features as the members take them."""
        value = self.node("Sub", ["features", self.constant("mean", mean.astype(np.float64))], "centered")
        value = self.node("Div", [value, self.constant("sd", sd.astype(np.float64))], "scaled")
        low, high = (
            self.constant(name, np.array(limit, np.float64))
            for name, limit in (("low", -MAX_FEATURE_SDS), ("high", MAX_FEATURE_SDS))
        )
        value = self.node("Clip", [value, low, high], "limited")
        return self.node("Cast", [value], "small", to=TensorProto.FLOAT)

    def layers(self, value: str, members: HistoryMembers) -> str:
        """The outputs of linear layers with a SiLU between them."""
        layers = list(zip(members.weights, members.biases, strict=True))
        for number, (weight, bias) in enumerate(layers):
            value = self.node("MatMul", [value, self.weight(f"weight_{number}", weight)], f"product_{number}")
            value = self.node("Add", [value, self.weight(f"bias_{number}", bias)], f"sum_{number}")
            if number < len(layers) - 1:
                value = self.silu(value)
        return value

    def built(self, value: str, name: str, axis: str, features: int, size: tuple[int, int]) -> bytes:
        """The graph: `features` in, `parts` [`axis` member part] out, from those of each member."""
        value = self.node("Transpose", [value], f"by_{axis}", perm=[1, 0, 2])
        self.node("Cast", [value], "parts", to=TensorProto.DOUBLE)
        whole = helper.make_graph(
            self.nodes,
            name,
            [helper.make_tensor_value_info("features", TensorProto.DOUBLE, [axis, features])],
            [helper.make_tensor_value_info("parts", TensorProto.DOUBLE, [axis, *size])],
            self.constants,
        )
        model = helper.make_model(whole, opset_imports=[helper.make_opsetid("", 17)], ir_version=9)
        checker.check_model(model)
        return bytes(model.SerializeToString(deterministic=True))


def history_graph(members: HistoryMembers, mean: Float[Array, "feature"], sd: Float[Array, "feature"]) -> bytes:
    """The graph: `features` [history feature] in float64 in, `parts` [history member part] out."""
    graph = _Graph()
    constant, weight, node = graph.constant, graph.weight, graph.node
    whole = graph.scaled(mean, sd)
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
    both = node("Concat", [logits, graph.layers(whole, members)], "both", axis=2)
    size = members.own.shape[0], members.effects + members.biases[-1].shape[-1]
    return graph.built(both, "history", "history", len(mean), size)
