"""The numbers recorded for a flight: each column's name, unit, meaning and plausible range."""

from collections.abc import Mapping
from dataclasses import dataclass
from types import MappingProxyType

from fieldkit import units


@dataclass(frozen=True, slots=True)
class Column:
    """One number of a flight: its external name, its meaning, and its plausible range.

    `name` is the field of `Flight`, or the extra column for one of `TWO_DEVICES`. `unit` is that of the external
    number, and `suffix` is how a header spells it; values between `low` and `high` are accepted without a question, in
    SI.
    """

    name: str
    quantity: str
    unit: str
    suffix: str
    title: str
    help: str
    low: float
    high: float

    @property
    def header(self) -> str:
        """The column's external name with its unit: `apogee_m`."""
        return f"{self.name}_{self.suffix}"

    @property
    def sd_header(self) -> str:
        """The column for the standard deviation of a readout: `apogee_sd_m`."""
        return f"{self.name}_sd_{self.suffix}"

    @property
    def source_header(self) -> str:
        """The column for the source of a readout: `apogee_source`."""
        return f"{self.name}_source"

    @property
    def stated_header(self) -> str:
        """The extra column for the value that the device itself stated: `stated_apogee_m`."""
        return f"stated_{self.header}"

    def parse(self, text: str, unit: str | None = None) -> float:
        """Parse a text to an SI value; a number without a unit is in `unit`, or else the column's own. Raises
        BadValue."""
        return units.parse(text, self.quantity, unit or self.unit)

    def render(self, value: float) -> str:
        """The number in this column's unit, as text."""
        return units.render(value, self.quantity, self.unit)


def _column(name: str, quantity: str, unit: str, title: str, usual: tuple[float, float], text: str) -> Column:
    """A column whose usual range is given in its `unit`."""
    suffix = {"m/s": "mps", "°": "deg", "%": "pct", "1/km": "pkm"}.get(unit, unit)
    scale = units.unit(quantity, unit)
    return Column(name, quantity, unit, suffix, title, text, *map(scale.to_si, usual))


SETUP = (
    _column("dry_mass", "mass", "g", "Dry mass", (5, 50000), "Weighed at the pad with recovery and payload, no motor."),
    _column("diameter", "length", "mm", "Diameter", (8, 400), "Largest body diameter: the reference area of Cd."),
    _column("delay", "time", "s", "Ejection delay", (0, 20), "Time from burnout to the ejection charge."),
)

CONDITIONS = (
    _column("site_elevation", "length", "m", "Site elevation", (-430, 5000), "Elevation of the pad above sea level."),
    _column("temperature", "temperature", "c", "Temperature", (-40, 50), "Air temperature at the pad."),
    _column(
        "pressure",
        "pressure",
        "hpa",
        "Pressure",
        (800, 1060),
        "Air pressure reduced to sea level (QNH), as in weather reports.",
    ),
    _column("humidity", "fraction", "%", "Humidity", (0, 100), "Relative humidity at the pad."),
    _column("wind", "speed", "m/s", "Wind", (0, 20), "Mean wind at the pad."),
    _column("rail_length", "length", "m", "Rail length", (0.3, 10), "Length of the launch rod or rail."),
    _column(
        "rail_angle", "angle", "deg", "Rail angle", (-30, 30), "Angle of the rod or rail from vertical, into the wind."
    ),
)

READOUTS = (
    _column("apogee", "length", "m", "Apogee", (5, 10000), "Highest point above the pad."),
    _column("top_speed", "speed", "m/s", "Top speed", (3, 700), "Highest speed, reached as thrust ends."),
    _column("burn_time", "time", "s", "Burn time", (0.1, 15), "Time from lift-off to top speed."),
    _column("peak_accel", "acceleration", "g", "Peak acceleration", (0.5, 60), "Strongest acceleration under thrust."),
    _column(
        "avg_accel", "acceleration", "g", "Average acceleration", (0.1, 40), "Top speed over burn time, net of gravity."
    ),
    _column("coast_to_apogee", "time", "s", "Coast to apogee", (0.1, 60), "Time from top speed to apogee."),
    _column(
        "apogee_to_eject",
        "time",
        "s",
        "Apogee to ejection",
        (-10, 20),
        "Time from apogee to ejection; negative if before apogee.",
    ),
    _column("eject_altitude", "length", "m", "Ejection altitude", (0, 10000), "Height above the pad at ejection."),
    _column("descent_speed", "speed", "m/s", "Descent speed", (0.5, 60), "Speed under the parachute or streamer."),
    _column("duration", "time", "s", "Duration", (1, 1200), "Time from lift-off to landing."),
)
"""The ten readouts, in the order in which the AltimeterTwo displays them."""

LOGGED = (
    _column(
        "coast_drag",
        "per length",
        "1/km",
        "Drag in the coast",
        (0.02, 50),
        "Air density at the pad times Cd times frontal area over twice the mass after burnout.",
    ),
    _column(
        "burn_impulse", "speed", "m/s", "Impulse over mass", (5, 2000), "Thrust over mass, integrated over the burn."
    ),
)
"""Quantities that are computed only from the samples of a log (`fieldkit.analysis.drag_and_impulse`)."""

TWO_DEVICES = (
    _column(
        "drogue_speed", "speed", "m/s", "Drogue speed", (5, 60), "Descent speed under the drogue, near the ground."
    ),
    _column("main_altitude", "length", "m", "Main opens", (30, 1500), "Height above the pad at which the main opens."),
)
"""Figures that a log shows of a descent on a drogue and a main: extra columns of a flight (`fieldkit.flight.recovery`),
with a standard deviation if they were measured."""

MOTOR_TEMPERATURE = "motor_temperature_c"
"""Extra column of a planned flight: motor temperature, used only in a safety check."""
WEATHER = ("wind", "temperature", "pressure", "humidity")
"""Names of the conditions that belong to the day, not to the rocket or the site."""
COLUMNS = SETUP + CONDITIONS + READOUTS
"""The columns of the flight table that every flight has."""
MEASURED = READOUTS + LOGGED
"""The readouts and the quantities computed from a log; each may have a standard deviation and a source."""
LOG_FIGURES = MEASURED + TWO_DEVICES
"""Everything that a log may show."""
BY_NAME: Mapping[str, Column] = MappingProxyType({column.name: column for column in COLUMNS + LOGGED})
"""The columns that are fields of `Flight`."""
FIGURES_BY_NAME: Mapping[str, Column] = MappingProxyType({column.name: column for column in LOG_FIGURES})
"""Everything that a log may show, by name."""
