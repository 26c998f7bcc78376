"""Validation of posteriors: comparison with exact ones, calibration, scores."""
