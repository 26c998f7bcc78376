"""The records everything shares: a flight, its columns, and the time series of a log.

`COLUMNS` is the one list of what is known of a flight as numbers. The flight table, the prompts, the
ledger, the exports and the JSON are all read off it. Values are SI inside a `Flight`; a column's name
carries the unit that flyers see.
"""

import re
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field, fields, replace
from datetime import datetime
from types import MappingProxyType

from fieldkit import units
from fieldkit.errors import BadValue
from fieldkit.shapes import Array, Float


@dataclass(frozen=True, slots=True)
class Column:
    """One number of a flight: how it is named at the edge, what it means, what is plausible.

    `name` is the field of `Flight`; `low` and `high` bound what is taken without a question, in SI.
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
        """The column's name at the edge, unit and all: `apogee_m`."""
        return f"{self.name}_{self.suffix}"

    @property
    def sd_header(self) -> str:
        """The extra column that holds the standard deviation of a measured readout: `apogee_sd_m`."""
        return f"{self.name}_sd_{self.suffix}"

    @property
    def stated_header(self) -> str:
        """The extra column that holds what the device itself stated: `stated_apogee_m`."""
        return f"stated_{self.header}"

    def parse(self, text: str, unit: str | None = None) -> float:
        """The SI value of a text; a number without a unit is in `unit`, or this column's own."""
        return units.parse(text, self.quantity, unit or self.unit)

    def render(self, value: float) -> str:
        """The number at the edge, in this column's unit."""
        return units.render(value, self.quantity, self.unit)


def _column(name: str, quantity: str, unit: str, title: str, low: float, high: float, text: str) -> Column:
    suffix = {"m/s": "mps", "°": "deg", "%": "pct"}.get(unit, unit)
    scale = units.unit(quantity, unit)
    return Column(name, quantity, unit, suffix, title, text, scale.to_si(low), scale.to_si(high))


SETUP = (
    _column(
        "dry_mass",
        "mass",
        "g",
        "Dry mass",
        5,
        50000,
        "Weighed at the pad with recovery and payload, no motor.",
    ),
    _column("diameter", "length", "mm", "Diameter", 8, 400, "Largest body diameter: the reference area of Cd."),
    _column("delay", "time", "s", "Ejection delay", 0, 20, "From burnout to the ejection charge."),
)
CONDITIONS = (
    _column("site_elevation", "length", "m", "Site elevation", -430, 5000, "Pad above sea level."),
    _column("temperature", "temperature", "c", "Temperature", -40, 50, "Air at the pad."),
    _column(
        "pressure",
        "pressure",
        "hpa",
        "Pressure",
        800,
        1060,
        "Reduced to sea level (QNH), as weather reports say.",
    ),
    _column("humidity", "fraction", "%", "Humidity", 0, 100, "Relative humidity at the pad."),
    _column("wind", "speed", "m/s", "Wind", 0, 20, "Mean wind at the pad."),
    _column("rail_length", "length", "m", "Rail length", 0.3, 10, "Of the rod or rail the rocket is guided by."),
    _column("rail_angle", "angle", "deg", "Rail angle", 0, 30, "Tilt of the rod or rail from vertical."),
)
READOUTS = (
    _column("apogee", "length", "m", "Apogee", 5, 10000, "Highest point above the pad."),
    _column("top_speed", "speed", "m/s", "Top speed", 3, 700, "Highest speed, reached as thrust ends."),
    _column("burn_time", "time", "s", "Burn time", 0.1, 15, "From lift-off to top speed."),
    _column(
        "peak_accel",
        "acceleration",
        "g",
        "Peak acceleration",
        0.5,
        60,
        "Strongest acceleration under thrust.",
    ),
    _column(
        "avg_accel",
        "acceleration",
        "g",
        "Average acceleration",
        0.1,
        40,
        "Top speed over burn time, net of gravity.",
    ),
    _column("coast_to_apogee", "time", "s", "Coast to apogee", 0.1, 60, "From top speed to apogee."),
    _column(
        "apogee_to_eject",
        "time",
        "s",
        "Apogee to ejection",
        -10,
        20,
        "Negative when ejection came before apogee.",
    ),
    _column("eject_altitude", "length", "m", "Ejection altitude", 0, 10000, "Height above the pad at ejection."),
    _column("descent_speed", "speed", "m/s", "Descent speed", 0.5, 60, "Under the parachute or streamer."),
    _column("duration", "time", "s", "Duration", 1, 1200, "From lift-off to landing."),
)
"""The ten readouts, in the order in which the AltimeterTwo shows them."""

COLUMNS = SETUP + CONDITIONS + READOUTS
BY_NAME: Mapping[str, Column] = MappingProxyType({column.name: column for column in COLUMNS})

TAGS: Mapping[str, str] = MappingProxyType(
    {
        "weak_launch": "The motor pushed less than it should: slow off the pad.",
        "off_axis": "The rocket flew clearly off the vertical.",
        "extra_drag": "Something stuck out or came loose: more drag than this rocket has.",
        "early_ejection": "The ejection charge fired well before apogee.",
        "altimeter_fault": "The altimeter's figures are not to be believed.",
        "damaged": "The rocket broke in flight.",
        "cato": "The motor failed.",
        "staged": "A flight with more than one stage burning.",
        "cluster": "A flight on several motors at once.",
    }
)
"""Tags that mark a flight as an anomaly: it stays in the ledger and does not teach the model."""
CHECKED = "checked"
KNOWN_TAGS: Mapping[str, str] = MappingProxyType(
    {**TAGS, CHECKED: "No anomaly: every readout was looked at and is right, however little one fits the others."}
)
"""Every tag that means something to fieldkit."""


@dataclass(frozen=True, slots=True)
class Flight:
    """One flight as its flyer knows it, in SI units; None is "not recorded", never zero.

    `rocket` and `flight_id` together name it. `motor` is as printed, with the delay if it has one;
    `extra` keeps the columns of a flight table that fieldkit does not know.
    """

    flight_id: str = ""
    rocket: str = ""
    config: str = ""
    motor: str = ""
    date_time: datetime | None = None
    site: str = ""
    tags: tuple[str, ...] = ()
    notes: str = ""
    log: str = ""
    dry_mass: float | None = None
    diameter: float | None = None
    delay: float | None = None
    site_elevation: float | None = None
    temperature: float | None = None
    pressure: float | None = None
    humidity: float | None = None
    wind: float | None = None
    rail_length: float | None = None
    rail_angle: float | None = None
    apogee: float | None = None
    top_speed: float | None = None
    burn_time: float | None = None
    peak_accel: float | None = None
    avg_accel: float | None = None
    coast_to_apogee: float | None = None
    apogee_to_eject: float | None = None
    eject_altitude: float | None = None
    descent_speed: float | None = None
    duration: float | None = None
    extra: Mapping[str, str] = field(default_factory=dict)

    @property
    def clean(self) -> bool:
        """Whether the flight carries no anomaly tag, so that it may teach the model."""
        return not any(tag in TAGS for tag in self.tags)

    def number(self, name: str) -> float | None:
        """The SI value of one of `COLUMNS`, or None where it was not recorded."""
        value: float | None = getattr(self, name)
        return value

    def readouts(self) -> dict[str, float]:
        """The recorded readouts by name, in SI."""
        return {c.name: v for c in READOUTS if (v := self.number(c.name)) is not None}

    def with_changes(self, **changes: object) -> "Flight":
        """The same flight with some fields changed."""
        return replace(self, **changes)  # type: ignore[arg-type]


MOTOR_TEMPERATURE = "motor_temperature_c"
"""Extra column of a planned flight: how warm the motor is, for a safety check alone."""
FIELDS = tuple(f.name for f in fields(Flight))
TEXT_COLUMNS = ("flight_id", "date_time", "rocket", "config", "motor", "site", "tags", "notes", "log")
"""The columns of a flight table that are not numbers."""


def read_tags(text: str) -> tuple[str, ...]:
    """Tags apart by `;`, `|` or `,`, each once; `Weak launch` is `weak_launch`, others stay as spelt."""
    tags = [tag.strip() for tag in re.split(r"[;|,]", text) if tag.strip()]
    known = [re.sub(r"[\s-]+", "_", tag.lower()) for tag in tags]
    return tuple(dict.fromkeys(k if k in KNOWN_TAGS else tag for k, tag in zip(known, tags, strict=True)))


def read_date(text: str) -> datetime | None:
    """Local lift-off time, None for an empty text. Raises BadValue.

    An offset from UTC is left off, for the clock at the field is what is meant.
    """
    try:
        return datetime.fromisoformat(text).replace(tzinfo=None) if text else None
    except ValueError:
        found = f"found {text[:40]!r}, expected a date such as 2026-05-01 or 2026-05-01T10:30"
        raise BadValue(found) from None


def table_row(flight: Flight) -> dict[str, str]:
    """A flight as a row of the flight table: header to text, an empty text for "not recorded"."""
    row = {name: str(getattr(flight, name)) for name in TEXT_COLUMNS if name not in ("date_time", "tags")}
    row["date_time"] = flight.date_time.isoformat() if flight.date_time else ""
    row["tags"] = ";".join(flight.tags)
    for column in COLUMNS:
        value = flight.number(column.name)
        row[column.header] = "" if value is None else column.render(value)
    return row | dict(flight.extra)


def table_headers(flights: Iterable[Flight]) -> list[str]:
    """The headers of a flight table that holds all of these flights, extra columns last."""
    extra = dict.fromkeys(name for flight in flights for name in flight.extra)
    known = [*TEXT_COLUMNS[:5], *(c.header for c in SETUP), "site", *(c.header for c in CONDITIONS)]
    return [*known, *(c.header for c in READOUTS), "tags", "notes", "log", *extra]


@dataclass(frozen=True, slots=True, eq=False)
class Series:
    """Channels of a log on one clock, in SI; a channel that was not recorded is None, a lost sample nan.

    `time` [s] is the log's own, never runs backwards, and has its zero where the logger put it: at its launch
    detection, or at its first sample. Heights are above the pad unless the name says `msl`, up is positive, and
    what a logger worked out by itself (`speed` by whatever means, `inertial_*` from its accelerometer, `gps_*`)
    stays apart from what its barometer says (`pressure`, `altitude`). `felt` is the specific force along the
    rocket's axis, one g at rest with the nose up; `acceleration` the same net of gravity, zero at rest.
    """

    time: Float[Array, "time"]
    altitude: Float[Array, "time"] | None = None
    """By the barometer, above the pad. [m]"""
    altitude_msl: Float[Array, "time"] | None = None
    """By the barometer, above sea level. [m]"""
    pressure: Float[Array, "time"] | None = None
    """Static, inside the airframe. [Pa]"""
    speed: Float[Array, "time"] | None = None
    """Vertical, as the logger gives it. [m/s]"""
    acceleration: Float[Array, "time"] | None = None
    """Along the axis, net of gravity. [m/s^2]"""
    felt: Float[Array, "time"] | None = None
    """Along the axis, as an accelerometer feels it. [m/s^2]"""
    felt_total: Float[Array, "time"] | None = None
    """Magnitude over all axes, as accelerometers feel it. [m/s^2]"""
    inertial_altitude: Float[Array, "time"] | None = None
    """Integrated from acceleration by the logger, above the pad. [m]"""
    inertial_speed: Float[Array, "time"] | None = None
    """Integrated from acceleration by the logger. [m/s]"""
    gps_altitude_msl: Float[Array, "time"] | None = None
    """Above sea level. [m]"""
    gps_speed: Float[Array, "time"] | None = None
    """Vertical, by satellite. [m/s]"""
    latitude: Float[Array, "time"] | None = None
    """North positive. [deg]"""
    longitude: Float[Array, "time"] | None = None
    """East positive. [deg]"""
    tilt: Float[Array, "time"] | None = None
    """Of the axis from the vertical. [rad]"""
    temperature: Float[Array, "time"] | None = None
    """Of the sensor. [K]"""
    voltage: Float[Array, "time"] | None = None
    """Of the battery. [V]"""
    thrust: Float[Array, "time"] | None = None
    """In simulations. [N]"""
    drag: Float[Array, "time"] | None = None
    """In simulations. [N]"""
    mass: Float[Array, "time"] | None = None
    """In simulations. [kg]"""
