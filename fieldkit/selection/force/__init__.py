"""The missing force: what a measured climb says of thrust and drag that the model does not."""
