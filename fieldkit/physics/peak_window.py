"""The averaging window of a peak acceleration, apart from the simulator, which takes long to import."""

PEAK_WINDOW = 0.05
"""Averaging window of the peak acceleration in a log: an igniter's spike is shorter. [s]"""
