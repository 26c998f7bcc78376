"""Entering a flight on a screen."""
