"""Slope and center of pressure of the normal force on a rocket.

Source: J. S. Barrowman, The Practical Calculation of the Aerodynamic Characteristics of Slender
Finned Vehicles, 1967.
"""

import math

from bench.world import Airframe

NOSE_SLOPE = 2.0
"""Slope of the normal force of any slender nose. [1/rad]"""
OGIVE_CENTRE = 0.466
"""Center of pressure of an ogive as a fraction of its length. [1]"""
GYRATION = 0.27
"""Radius of gyration of a rocket without its motor, as a fraction of its length. [1]"""


def fin_slope(frame: Airframe) -> float:
    """Slope of the normal force of all fins, including interference from the body. [1/rad]"""
    midchord = math.hypot(frame.span, frame.sweep + (frame.tip - frame.root) / 2)
    radius = frame.diameter / 2
    slender = 1 + math.hypot(1, 2 * midchord / (frame.root + frame.tip))
    interference = 1 + radius / (frame.span + radius)
    return interference * 4 * frame.fins * (frame.span / frame.diameter) ** 2 / slender


def fin_centre(frame: Airframe) -> float:
    """Center of pressure of the fins, from the tip of the nose. [m]"""
    chords = frame.root + frame.tip
    back = frame.sweep / 3 * (frame.root + 2 * frame.tip) / chords
    return frame.length - frame.root + back + (chords - frame.root * frame.tip / chords) / 6


def centre_of_pressure(frame: Airframe) -> float:
    """Center of pressure of the rocket, from the tip of the nose. [m]"""
    fins = fin_slope(frame)
    return (NOSE_SLOPE * OGIVE_CENTRE * frame.nose + fins * fin_centre(frame)) / (NOSE_SLOPE + fins)


def cg_for_margin(frame: Airframe, dry_mass: float, motor_mass: float, motor_length: float, margin: float) -> float:
    """Center of mass without the motor that gives a static margin in calibers on the pad. [m]"""
    loaded = centre_of_pressure(frame) - margin * frame.diameter
    motor = frame.length - motor_length / 2
    return (loaded * (dry_mass + motor_mass) - motor_mass * motor) / dry_mass
