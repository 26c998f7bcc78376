"""The generative model: priors, random effects, observation noise, and the data it is compared with."""
