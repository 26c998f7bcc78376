"""A test of the reference paper on its twelve flights; every figure is computed on request."""
