"""Recovery, wind aloft and rail direction of a flight, and the extra columns of a flight table that state them.

They are stored as text, like all columns that only some flights have, with the unit in the column's name;
`fieldkit.flight.typed_columns` types them once.
"""

import math
from dataclasses import dataclass
from typing import Literal

Device = Literal["parachute", "streamer"]
DEVICES: tuple[Device, ...] = ("parachute", "streamer")
RECOVERY_COLUMNS = {
    "drogue_speed": (
        "speed",
        "mps",
        "Descent speed under the drogue, near the ground: 20m/s, 45mph; implies drogue and main.",
    ),
    "main_altitude": ("length", "m", "Height above the pad at which the main opens: 150m, 500ft."),
    "main_speed": (
        "speed",
        "mps",
        "Descent speed under the parachute, the main if there are two, near the ground: 5m/s, 12mph.",
    ),
    "parachute_diameter": (
        "length",
        "mm",
        "Diameter of the parachute laid flat, the main if there are two: 450mm, 18in.",
    ),
    "opening_time": ("time", "s", "Time from the charge to an open parachute; default: half a second."),
    "wind_aloft": (
        "speed",
        "mps",
        "Wind speed aloft, the same as --wind for one that does not grow with height: 10m/s, 20mph.",
    ),
    "wind_aloft_height": ("length", "m", "Height of the wind aloft above the pad: 300m, 1000ft."),
    "wind_aloft_turn": ("angle", "deg", "Degrees clockwise from the wind at the pad to the wind aloft."),
}
"""Recovery columns that are numbers: quantity, external unit, and meaning."""
LIMITS = {
    "drogue_speed": (0.1, 1000.0),
    "main_altitude": (1.0, 200_000.0),
    "main_speed": (0.1, 1000.0),
    "parachute_diameter": (0.01, 100.0),
    "opening_time": (0.0, 600.0),
    "wind_aloft": (0.0, 150.0),
    "wind_aloft_height": (1.0, 50_000.0),
    "wind_aloft_turn": (-2 * math.pi, 2 * math.pi),
}
"""Lowest and highest possible number of each recovery column, in SI."""
IN_EVERY_FIT = ("opening_time", "wind_aloft", "wind_aloft_height", "wind_aloft_turn")
"""Recovery columns that change the simulated apogee of a past flight."""
UNCERTAIN_WEATHER = {"temperature": 15.0, "pressure": 3000.0, "wind": 5.0}
"""Conditions whose recorded standard deviation is used, with the largest: about that of the weather of a year. [K, Pa,
m/s]"""
MAX_STABILITY = 100.0
"""Upper limit on a static margin: many times the length of the longest rocket. [body diameters]"""
STABILITY = "stability_cal"
"""The column for a rocket's static margin, as a design program states it. [body diameters]"""
STABILITY_SOURCE = "stability_by"
"""The column of a plan whose margin is that of its design: the design's file."""
RECOVERY_TEXTS = {
    "recovery": "parachute or streamer.",
    "rail_direction": "Direction of the rail relative to the wind: into, away, across, or degrees from upwind.",
    STABILITY: "Static margin on the pad in body diameters: 2.5; the larger, the sooner it weathercocks.",
}
"""Recovery columns that are text, with their meaning."""
RECOVERY_NAMES = (*RECOVERY_COLUMNS, *RECOVERY_TEXTS)
DIRECTIONS = {"into": 0.0, "away": 180.0, "across": 90.0}
"""Directions of a rail by name. [deg]"""
DESCENT_SPEED = 5.0
"""Default descent speed under a parachute. [m/s]"""
OPENING_TIME = 0.5
"""Default time from the charge to an open parachute, an assumption. [s]"""


def recovery_header(name: str) -> str:
    """External name of an extra number or text column: `main_altitude_m`."""
    return f"{name}_{RECOVERY_COLUMNS[name][1]}" if name in RECOVERY_COLUMNS else name


@dataclass(frozen=True, slots=True)
class Recovery:
    """What opens when; None if not recorded.

    `drogue_speed` is the descent speed under a drogue near the ground [m/s], `main_altitude` the height above the pad
    at which the main opens [m]; without it, the only device opens at the charge. `opening_time` is the time from the
    charge to an open device [s]. `main_speed` is the descent speed near the ground under the main or only device [m/s],
    `parachute_diameter` its diameter laid flat [m].
    """

    device: Device = "parachute"
    drogue_speed: float | None = None
    main_altitude: float | None = None
    opening_time: float = OPENING_TIME
    main_speed: float | None = None
    parachute_diameter: float | None = None

    @property
    def dual(self) -> bool:
        """Whether a drogue opens first and a main lower down."""
        return self.main_altitude is not None
