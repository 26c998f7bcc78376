"""Simulated recorders: the logs that sixty kinds of loggers write of known flights, and how well they are read."""
