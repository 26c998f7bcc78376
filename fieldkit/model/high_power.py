"""Designed rockets on high-power motors, which depart less from their simulation than model rockets do."""

from collections.abc import Container
from dataclasses import replace

import numpy as np

from fieldkit.model.rocket_model import Model
from fieldkit.motors import Found

HIGH_POWER_IMPULSE = 160.0
"""Total impulse above which a motor is high power (NFPA 1125). [N s]"""
CLOSER_AT_HIGH_POWER = ("mass", "thrust", "apogee")
"""Quantities whose random effects `Hyperprior.high_power` scales."""


def closer_to_designs(model: Model, designed: Container[str]) -> Model:
    """The model with smaller random effects of mass, thrust and apogee for flights on high-power motors of the
    configurations that have a design.

    Their motors are certified by test and the rockets weighed as flown. Source: the flights given to `fieldkit learn
    --high-power`, all forecast with design programs. High-power flights without a design, such as the journal's,
    scatter like those of model rockets.
    """
    closer = [
        is_high_power(found) and flight.config in designed
        for flight, found in zip(model.flights, model.found, strict=True)
    ]
    scale = np.where(closer, model.hyperprior.high_power, 1.0)
    terms = tuple(
        replace(term, weight=term.weight * scale) if term.bends in CLOSER_AT_HIGH_POWER else term
        for term in model.terms
    )
    return replace(model, terms=terms, departure=tuple(scale.tolist()))


def is_high_power(found: Found) -> bool:
    """Whether a motor, or one of a cluster or of stages, is high power."""
    return max(one.total_impulse for one in found.motor.parts or (found.motor,)) > HIGH_POWER_IMPULSE
