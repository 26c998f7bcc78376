"""Thrust curves as recorded, for comparisons with programs that fly them instead of the catalog's reshaped ones."""

import json
from dataclasses import replace
from pathlib import Path

import numpy as np

from fieldkit.motors import Found, Motor
from fieldkit.motors.motor import normalised

CURVES = {
    label: np.array(text.split(), float).reshape(-1, 2).T
    for label, text in json.loads((Path(__file__).parent / "motors" / "recorded_curves.json").read_text())[
        "curves"
    ].items()
}
"""Times [s] and thrusts [N] by maker and designation."""


def recorded(found: Found) -> Found:
    """A motor with its recorded curve, scaled to the certified impulse."""
    motor: Motor = found.motor
    if not motor.curve:
        return found
    time, thrust = CURVES[f"{motor.maker} {motor.designation}"]
    return replace(
        found, motor=replace(motor, time=time, thrust=normalised(time, thrust, motor.total_impulse), curve="")
    )
