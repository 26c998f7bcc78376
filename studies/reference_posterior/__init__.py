"""An exact sampler of the posterior that the fit approximates, without linearization and with all tails and scales."""
