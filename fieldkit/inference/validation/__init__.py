"""Posteriors checked: against integrated ones, for calibration, and by scores."""
