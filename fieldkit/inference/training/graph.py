"""An ensemble as one ONNX graph: whitening, all members, mean and spread.

Features are float64 and are whitened in float64; the members compute in float32; mean and spread are float64. Batch
normalization, which is linear after training, is folded into the linear layers.
"""

import numpy as np
import onnx
from onnx import TensorProto, helper, numpy_helper

from fieldkit.inference.training.network import EPSILON, Network
from fieldkit.shapes import Array, Float

OPSET = 17
"""The operator set that every supported version of onnxruntime has."""
IR_VERSION = 9


def graph(network: Network, mean: Float[Array, "feature"], scale: Float[Array, "feature"], doc: str) -> bytes:
    """The serialized graph: `features` [flight feature] to `mean` and `spread` [flight output]."""
    weights: dict[str, np.ndarray] = {"feature_mean": mean, "feature_scale": scale}
    nodes = [
        helper.make_node("Sub", ["features", "feature_mean"], ["centred"]),
        helper.make_node("Div", ["centred", "feature_scale"], ["whitened"]),
        helper.make_node("Cast", ["whitened"], ["single"], to=TensorProto.FLOAT),
        helper.make_node("Unsqueeze", ["single", "first_axis"], ["hidden_0"]),
    ]
    weights["first_axis"] = np.array([0], dtype=np.int64)
    layers = _folded(network)
    for number, (weight, bias) in enumerate(layers):
        weights |= {f"weight_{number}": weight, f"bias_{number}": bias}
        nodes += [
            helper.make_node("MatMul", [f"hidden_{number}", f"weight_{number}"], [f"product_{number}"]),
            helper.make_node("Add", [f"product_{number}", f"bias_{number}"], [f"sum_{number}"]),
        ]
        if number < len(layers) - 1:
            nodes.append(helper.make_node("Relu", [f"sum_{number}"], [f"hidden_{number + 1}"]))
    low, high = (side.numpy().reshape(-1).astype(np.float64) for side in (network.low, network.high))
    weights |= {"low": low, "width": high - low}
    nodes += [
        helper.make_node("Sigmoid", [f"sum_{len(layers) - 1}"], ["share"]),
        helper.make_node("Cast", ["share"], ["double"], to=TensorProto.DOUBLE),
        helper.make_node("Mul", ["double", "width"], ["stretched"]),
        helper.make_node("Add", ["stretched", "low"], ["members"]),
        helper.make_node("ReduceMean", ["members"], ["mean"], axes=[0], keepdims=0),
        helper.make_node("Sub", ["members", "mean"], ["apart"]),
        helper.make_node("Mul", ["apart", "apart"], ["square"]),
        helper.make_node("ReduceMean", ["square"], ["variance"], axes=[0], keepdims=0),
        helper.make_node("Sqrt", ["variance"], ["spread"]),
    ]
    both = [
        helper.make_tensor_value_info(name, TensorProto.DOUBLE, ["flight", len(low)]) for name in ("mean", "spread")
    ]
    model = helper.make_model(
        helper.make_graph(
            nodes,
            "ensemble",
            [helper.make_tensor_value_info("features", TensorProto.DOUBLE, ["flight", len(mean)])],
            both,
            [numpy_helper.from_array(values, name) for name, values in weights.items()],
        ),
        producer_name="fieldkit",
        doc_string=doc,
        opset_imports=[helper.make_opsetid("", OPSET)],
        ir_version=IR_VERSION,
    )
    onnx.checker.check_model(model, full_check=True)
    return bytes(model.SerializeToString(deterministic=True))


def _folded(network: Network) -> list[tuple[np.ndarray, np.ndarray]]:
    """Weights [member in out] and biases [member 1 out] in float32.

    Each batch norm directly follows a linear layer and is folded into its weights.
    """
    layers = []
    for number, linear in enumerate(network.linears):
        weight = linear.weight.detach().double().numpy()
        bias = linear.bias.detach().double().numpy()
        if number < len(network.norms):
            norm, shape = network.norms[number], bias.shape
            scale, shift, mean, variance = (
                values.detach().double().numpy().reshape(shape)
                for values in (norm.scale, norm.shift, norm.mean, norm.variance)
            )
            gain = scale / np.sqrt(variance + EPSILON)
            weight, bias = weight * gain, (bias - mean) * gain + shift
        layers.append(
            (
                np.ascontiguousarray(weight.transpose(0, 2, 1), dtype=np.float32),
                np.ascontiguousarray(bias.transpose(0, 2, 1), dtype=np.float32),
            )
        )
    return layers
