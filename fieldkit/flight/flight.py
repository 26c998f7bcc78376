"""One flight, as its flyer knows it."""

from collections.abc import Mapping
from dataclasses import dataclass, field, fields, replace
from datetime import datetime

from fieldkit.flight.columns import READOUTS
from fieldkit.flight.tags import TAGS


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


FIELDS = tuple(f.name for f in fields(Flight))
