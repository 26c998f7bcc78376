"""Members as one ONNX graph: features in, all outputs of each member out."""

from typing import Any

import numpy as np
from onnx import TensorProto, checker, helper, numpy_helper

from fieldkit.inference.training.density import LAYERS, MAX_FEATURE_SDS, Members
from fieldkit.shapes import Array, Float


def density_graph(members: Members, mean: Float[Array, "feature"], sd: Float[Array, "feature"]) -> bytes:
    """The graph: `features` [flight feature] in float64 in, `parts` [flight member part] out.

    Features are scaled in the graph in float64; the members run in float32.
    """
    constants: list[Any] = []
    nodes: list[Any] = []

    def constant(name: str, values: Any) -> str:
        constants.append(numpy_helper.from_array(np.ascontiguousarray(values), name))
        return name

    def node(kind: str, inputs: list[str], output: str, **settings: Any) -> str:
        nodes.append(helper.make_node(kind, inputs, [output], **settings))
        return output

    value = node("Sub", ["features", constant("mean", mean.astype(np.float64))], "centred")
    value = node("Div", [value, constant("sd", sd.astype(np.float64))], "scaled")
    limits = [
        constant(name, np.array(limit, np.float64))
        for name, limit in (("least", -MAX_FEATURE_SDS), ("most", MAX_FEATURE_SDS))
    ]
    value = node("Clip", [value, *limits], "clipped")
    value = node("Cast", [value], "small", to=TensorProto.FLOAT)
    for number in range(LAYERS + 1):
        weight = members.weights[number].detach().numpy().astype(np.float32)
        bias = members.biases[number].detach().numpy().astype(np.float32)
        value = node("MatMul", [value, constant(f"weight_{number}", weight)], f"product_{number}")
        value = node("Add", [value, constant(f"bias_{number}", bias)], f"sum_{number}")
        if number < LAYERS:
            gate = node("Sigmoid", [value], f"gate_{number}")
            value = node("Mul", [value, gate], f"silu_{number}")
    value = node("Transpose", [value], "turned", perm=[1, 0, 2])
    node("Cast", [value], "parts", to=TensorProto.DOUBLE)
    size = [members.weights[0].shape[0], members.weights[-1].shape[2]]
    whole = helper.make_graph(
        nodes,
        "members",
        [helper.make_tensor_value_info("features", TensorProto.DOUBLE, ["flight", len(mean)])],
        [helper.make_tensor_value_info("parts", TensorProto.DOUBLE, ["flight", *size])],
        constants,
    )
    model = helper.make_model(whole, opset_imports=[helper.make_opsetid("", 17)], ir_version=9)
    checker.check_model(model)
    return bytes(model.SerializeToString(deterministic=True))
