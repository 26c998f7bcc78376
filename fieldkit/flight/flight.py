"""The record of one flight."""

from collections.abc import Container, Iterable, Mapping
from dataclasses import dataclass, field, fields, replace
from datetime import datetime
from typing import Any

from fieldkit.flight.columns import MEASURED, Column
from fieldkit.flight.log_origin import LogOrigin, log_origin
from fieldkit.flight.readout import Readout
from fieldkit.flight.tags import TAGS
from fieldkit.flight.typed_columns import NO_COLUMNS, TypedColumns, typed_columns

_NONE_RECORDED: Mapping[str, Any] = {}
"""What most flights have in `sd`, `source` and `extra`: the same for all, as a table may have 100,000 flights."""


@dataclass(frozen=True, slots=True)
class Flight:
    """One flight as recorded, in SI units; None means "not recorded", never zero.

    `rocket` and `flight_id` together identify it. `motor` is as printed, with the delay if it has one. `sd` and
    `source` map readout names to the standard deviation and the origin (one of `SOURCES`), if recorded. `extra`
    contains the text of all other columns of a flight table: those that only some flights have, such as the recovery
    (`fieldkit.flight.recovery`), and those that fieldkit does not know; `columns` has the former typed, whenever a
    flight gets its texts.
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
    coast_drag: float | None = None
    burn_impulse: float | None = None
    sd: Mapping[str, float] = field(default_factory=lambda: _NONE_RECORDED)
    source: Mapping[str, str] = field(default_factory=lambda: _NONE_RECORDED)
    extra: Mapping[str, str] = field(default_factory=lambda: _NONE_RECORDED)
    columns: TypedColumns = field(default=NO_COLUMNS, compare=False, repr=False)

    def __post_init__(self) -> None:
        if self.columns.texts is not self.extra:  # not typed yet: its further columns are new
            object.__setattr__(self, "columns", typed_columns(self.extra))

    @property
    def clean(self) -> bool:
        """Whether the flight has no anomaly tag and is therefore used in the fit."""
        return not any(tag in TAGS for tag in self.tags)

    def number(self, name: str) -> float | None:
        """The SI value of one of `COLUMNS` or `LOGGED`, or None if it was not recorded."""
        value: float | None = getattr(self, name)
        return value

    def text(self, header: str) -> str:
        """The text of a further column, empty if it was not recorded."""
        return self.extra.get(header, "")

    @property
    def has_log(self) -> bool:
        """Whether it was imported from a log, or names one."""
        return bool(self.log or self.origin.format)

    @property
    def origin(self) -> LogOrigin:
        """The files it was read from and the device that wrote them, as far as they are recorded."""
        return log_origin(self.extra)

    def as_stated(self, column: Column) -> str:
        """The value of a readout that the device itself stated, as text in the column's unit; empty if it did not."""
        return self.text(column.stated_header)

    def readouts(self) -> dict[str, float]:
        """The recorded readouts by name, in SI, including those computed from a log."""
        return {c.name: v for c in MEASURED if (v := self.number(c.name)) is not None}

    def readout(self, name: str) -> Readout | None:
        """A readout with its uncertainty and source; None if it was not recorded. [SI]"""
        value = self.number(name)
        return None if value is None else Readout(value, self.sd.get(name), self.source.get(name, ""))

    def with_changes(self, **changes: object) -> "Flight":
        """A copy of the flight with some fields changed.

        A readout whose value changes loses its standard deviation and its source, unless `changes` includes `sd` or
        `source`, which then replaces that of all readouts.
        """
        changed = {c.name for c in MEASURED if c.name in changes and changes[c.name] != self.number(c.name)}
        for part in ("sd", "source"):
            recorded: Mapping[str, object] = getattr(self, part)
            if part not in changes and changed & recorded.keys():
                changes[part] = {name: value for name, value in recorded.items() if name not in changed}
        return replace(self, **changes)  # type: ignore[arg-type]

    def with_columns(self, **texts: str) -> "Flight":
        """A copy of the flight with these texts in further columns."""
        return replace(self, extra={**self.extra, **texts})

    def without_columns(self, headers: Container[str]) -> "Flight":
        """A copy of the flight without these further columns."""
        return replace(self, extra={name: text for name, text in self.extra.items() if name not in headers})

    def unflown(self, **changes: object) -> "Flight":
        """A copy of the flight as planned, without its readouts, with other fields changed."""
        return self.with_changes(**dict.fromkeys(self.readouts()) | changes)

    def with_defaults(self, **known: float | None) -> "Flight":
        """A copy of the flight with these numbers where it has none."""
        return self.with_changes(**{name: value for name, value in known.items() if self.number(name) is None})

    def with_source(self, names: Iterable[str], source: str) -> "Flight":
        """A copy of the flight with a source for those readouts among `names` that have none."""
        added = {name: source for name in names if self.number(name) is not None and name not in self.source}
        return replace(self, source={**self.source, **added}) if added else self


FIELDS = tuple(f.name for f in fields(Flight) if f.compare)
