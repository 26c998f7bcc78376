"""The makers of motors, and motor names without them. This module needs no thrust curves, so that the app can show its
first rows without them."""

from collections.abc import Mapping
from types import MappingProxyType

MAKERS: Mapping[str, tuple[str, ...]] = MappingProxyType(
    {
        "AeroTech": ("AEROTECH", "AERO TECH", "AERO-TECH", "AT", "RCS"),
        "Cesaroni": ("CESARONI TECHNOLOGY", "CESARONI", "CTI"),
        "Estes": ("ESTES INDUSTRIES", "ESTES"),
        "Quest": ("QUEST AEROSPACE", "QUEST", "Q-JET", "QJET"),
        "Loki": ("LOKI RESEARCH", "LOKI"),
        "AMW": ("ANIMAL MOTOR WORKS", "AMW"),
        "KBA": ("KOSDON BY AEROTECH", "KBA"),
        "Kosdon": ("KOSDON TRM", "KOSDON"),
        "Apogee": ("APOGEE COMPONENTS", "APOGEE"),
        "Alpha": ("ALPHA HYBRIDS", "ALPHA"),
        "Contrail": ("CONTRAIL ROCKETS", "CONTRAIL"),
        "Ellis": ("ELLIS MOUNTAIN", "ELLIS"),
        "Gorilla": ("GORILLA ROCKET MOTORS", "GORILLA"),
        "Hypertek": ("HYPERTEK",),
        "Klima": ("RAKETENMODELLBAU KLIMA", "KLIMA"),
        "PML": ("PUBLIC MISSILES, LTD.", "PUBLIC MISSILES", "PML"),
        "PP": ("PROPULSION POLYMERS", "PP"),
        "RATT": ("R.A.T.T. WORKS", "RATT WORKS", "RATT"),
        "Roadrunner": ("ROADRUNNER ROCKETRY", "ROADRUNNER"),
        "RV": ("ROCKETVISION FLIGHT-STAR", "ROCKETVISION", "RV"),
        "SCR": ("SOUTHERN CROSS ROCKETRY", "SCR"),
        "SkyR": ("SKY RIPPER SYSTEMS", "SKY RIPPER", "SKYR"),
        "TSP": ("PIOTR TENDERA ROCKET MOTORS", "TSP"),
        "WCH": ("WEST COAST HYBRIDS", "WCH"),
    }
)
"""Makers as the catalog names them, and other names that flyers use."""


def motor_name(name: str, width: int) -> str:
    """A motor as typed, without its manufacturer if it has more characters than `width`: `F24W-4` for `AeroTech
    F24W-4`."""
    maker, _, rest = name.partition(" ")
    return rest if rest and len(name) > width and maker in MAKERS else name
