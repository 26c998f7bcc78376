"""The missing force: thrust and drag in a measured climb that the model lacks."""
