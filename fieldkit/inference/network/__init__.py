"""Inference with the trained networks on onnxruntime: readouts in, a posterior of Cd and thrust out."""
