"""A rocket and its configurations: what is weighed, measured or designed once, and flown again and again."""

from fieldkit.rocket.rocket import Configuration, Rocket

__all__ = ["Configuration", "Rocket"]
