"""Scores of forecasts: proper scores and bootstrap intervals, of draws and outcomes alone."""
