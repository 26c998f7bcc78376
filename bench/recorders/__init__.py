"""Simulated recorders: the logs that many kinds of loggers write of known flights, and how well they are read."""
