"""An exact sampler of the posterior that the fit approximates: no linear model, every tail and scale as stated."""
