"""Evaluation of forecasts: rivals of the model, and forecasts forward in time."""
