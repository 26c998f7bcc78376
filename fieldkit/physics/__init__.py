"""The flight simulator: pure functions of arrays, one entry a draw, SI units throughout."""
