"""The trained networks at work: readouts in, a posterior of Cd and thrust out, on onnxruntime."""
