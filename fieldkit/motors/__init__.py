"""The motors of fieldkit: certified thrust curves, a forgiving search, the flyer's own files."""

from fieldkit.motors.catalogue import Catalogue, catalogue
from fieldkit.motors.motor import PLUGGED_DELAY, Motor, describe
from fieldkit.motors.names import is_cluster
from fieldkit.motors.search import Found

__all__ = ["PLUGGED_DELAY", "Catalogue", "Found", "Motor", "catalogue", "describe", "is_cluster"]
