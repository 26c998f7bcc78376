"""An exact sampler of the posterior that the fit approximates: the simulator as it is, every tail and scale as stated."""
