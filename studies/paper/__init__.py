"""The reference paper put to the test on its own twelve flights: every figure is computed when asked for."""
