"""Validation of the ensembles on simulations with known truth: errors, calibration, scores."""
