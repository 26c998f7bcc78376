"""Validation of the ensembles: comparison with exact posteriors, calibration, scores."""
