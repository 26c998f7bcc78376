"""The flight simulator: pure functions of arrays, one entry per draw, SI units throughout."""
