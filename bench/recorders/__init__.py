"""Simulated recorders: what sixty kinds of loggers write of flights that are known, and how well they are read."""
