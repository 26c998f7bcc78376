"""Typing in a flight on a screen."""
