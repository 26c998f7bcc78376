"""Fill in the weather of flights, flown or planned, from saved weather files."""

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from dataclasses import replace as other
from datetime import UTC, datetime, time, timedelta, timezone, tzinfo
from typing import TYPE_CHECKING
from zoneinfo import ZoneInfo, ZoneInfoNotFoundError

import numpy as np

from fieldkit.errors import BadValue, NoFlights, unknown
from fieldkit.flight import BY_NAME, Flight
from fieldkit.importing.weather import (
    MAST,
    QUANTITIES,
    SavedWeather,
    WeatherAtTime,
    WindAloft,
    weather_at,
    weather_of_day,
)
from fieldkit.physics.atmosphere import wind_at
from fieldkit.services.sites import sites
from fieldkit.units import UNITS

if TYPE_CHECKING:
    from fieldkit.ledger import Ledger

SOURCE = "weather_source"
"""The column that names the file and the hour from which a flight has its weather."""
USUAL_HEIGHT = 300.0
"""Height of the wind aloft for a flight without an apogee. [m]"""
_OFFSET = re.compile(r"([+-]?)(\d{1,2})(?::?([0-5]\d))?")


@dataclass(frozen=True, slots=True)
class NamedWeather:
    """The weather of a file, with the file's name."""

    file: str
    weather: SavedWeather


@dataclass(frozen=True, slots=True)
class FilledIn:
    """What was found for a flight: the values filled in with their standard deviations by column [SI], the wind aloft,
    and the complete flight; `reason` says why nothing was."""

    before: Flight
    after: Flight
    values: Mapping[str, tuple[float, float]] = field(default_factory=dict)
    aloft: WindAloft | None = None
    reason: str = ""

    @property
    def changed(self) -> bool:
        """Whether anything was filled in."""
        return self.after != self.before


def read_zone(text: str) -> tzinfo:
    """The time zone of the flights: `America/Chicago`, or hours ahead of UTC such as `-5` or `+5:30`. Raises
    BadValue."""
    if found := _OFFSET.fullmatch(text.strip()):
        ahead = timedelta(hours=int(found[2]), minutes=int(found[3] or 0))
        if ahead <= timedelta(hours=14):
            return timezone(-ahead if found[1] == "-" else ahead)
    try:
        return ZoneInfo(text.strip())
    except (ZoneInfoNotFoundError, ValueError, OSError) as error:
        raise BadValue(
            f"found the time zone {text[:40]!r}, expected one such as America/Chicago, -5 or +5:30"
        ) from error


def filled(flight: Flight, sources: Sequence[NamedWeather], zone: tzinfo | None, *, replace: bool = False) -> FilledIn:
    """A flight with the weather at its lift-off where it has none, or everywhere if `replace`.

    The wind, reported at 10 m, is reduced to the pad by the profile that every flight is simulated with. A flight with
    a date and no time has the mean of that day's hours. `zone` is that of the flights; None if the files are in local
    time. Raises BadValue for a file in UTC without it.
    """
    if flight.date_time is None:
        return FilledIn(flight, flight, reason="it has no date")
    values: dict[str, tuple[float, float]] = {}
    used: dict[str, None] = {}
    winds: tuple[WindAloft, ...] = ()
    ground: float | None = None
    for one in sources:
        then = _then(flight.date_time, one, zone)
        fresh = {name: pair for name, pair in then.values.items() if name not in values}
        values |= fresh
        if ground is None:
            ground = then.direction
        if then.aloft and not winds:
            winds = then.aloft
            used[one.file] = None
        used |= dict.fromkeys([one.file] if fresh else [])
    if not values and not winds:
        return FilledIn(flight, flight, reason="no report within three hours of it")
    if "wind" in values:
        slower = 1 / float(wind_at(np.array(MAST), np.array(1.0)))
        values["wind"] = values["wind"][0] * slower, values["wind"][1] * slower
    taken = {name: pair for name, pair in values.items() if replace or flight.number(name) is None}
    units = {name: UNITS[BY_NAME[name].quantity][BY_NAME[name].unit] for name in taken}
    extra = {BY_NAME[name].sd_header: f"{units[name].difference_from_si(sd):.2g}" for name, (_, sd) in taken.items()}
    known = replace or "wind_aloft" not in flight.columns.headers
    aloft = min(winds, key=lambda one: abs(one.height - (flight.apogee or USUAL_HEIGHT))) if winds and known else None
    if aloft is not None:
        extra |= _aloft_texts(aloft, ground)
    if not extra:
        return FilledIn(flight, flight, reason="its weather is recorded")
    extra[SOURCE] = f"{', '.join(used)} at {flight.date_time:%Y-%m-%d %H:%M}"
    changed = flight.with_changes(**{name: value for name, (value, _) in taken.items()}).with_columns(**extra)
    return FilledIn(flight, changed, taken, aloft)


def _then(moment: datetime, one: NamedWeather, zone: tzinfo | None) -> WeatherAtTime:
    """The weather of a file at a local moment."""
    if one.weather.utc and zone is None:
        raise BadValue(f"{one.file}: found times in UTC, expected the zone of the flights: --timezone America/Chicago")
    if moment.time() == time():
        day = weather_of_day(one.weather, moment) if not one.weather.utc else None
        return day or weather_of_day(_shifted(one.weather, moment, zone), moment)
    at = moment.replace(tzinfo=zone).astimezone(UTC).replace(tzinfo=None) if one.weather.utc and zone else moment
    return weather_at(one.weather, at)


def _shifted(weather: SavedWeather, moment: datetime, zone: tzinfo | None) -> SavedWeather:
    """Weather in UTC on the local clock of a day."""
    assert zone is not None
    ahead = moment.replace(hour=12, tzinfo=zone).utcoffset() or timedelta()
    return other(weather, reports=tuple(other(one, time=one.time + ahead) for one in weather.reports), utc=False)


def _aloft_texts(aloft: WindAloft, ground: float | None) -> dict[str, str]:
    """The wind aloft as columns of a flight; its turn is known if both directions are."""
    turn = None if aloft.direction is None or ground is None else (aloft.direction - ground + 180) % 360 - 180
    texts = {"wind_aloft_mps": f"{aloft.speed:.1f}", "wind_aloft_height_m": f"{aloft.height:.0f}"}
    return texts | ({} if turn is None else {"wind_aloft_turn_deg": f"{turn:.0f}"})


def flights_to_fill(ledger: "Ledger", site: str | None, rocket: str | None = None) -> list[Flight]:
    """The flights at one site, of one rocket or of all, whose weather a file can have. A file holds the weather of one
    place: raises BadValue for flights at several sites and no `site`, NoFlights for a site or a rocket that the ledger
    does not know."""
    places = dict.fromkeys([*ledger.names("site"), *(one.name for one in sites(ledger))])
    for kind, name, known in (("site", site, list(places)), ("rocket", rocket, ledger.names("rocket"))):
        if name is not None and name.casefold() not in map(str.casefold, known):
            raise NoFlights(unknown(kind, name, known))
    flights = [one for one in ledger.flights(rocket) if site is None or one.site.casefold() == site.casefold()]
    places = dict.fromkeys(one.site for one in flights)
    if site is None and len(places) > 1:
        shown = ", ".join(name or "no site" for name in list(places)[:5])
        raise BadValue(f"found flights at {shown}, expected --site with that of the file")
    return flights


def fill_ledger(
    ledger: "Ledger",
    flights: Sequence[Flight],
    sources: Sequence[NamedWeather],
    zone: tzinfo | None,
    *,
    replace: bool = False,
    dry_run: bool = False,
) -> list[FilledIn]:
    """Fill in the weather of flights of the ledger, as one change that can be undone; returns what was found for each.
    Raises BadValue as `filled`."""
    found = [filled(one, sources, zone, replace=replace) for one in flights]
    changed = [one for one in found if one.changed]
    if changed and not dry_run:
        ids = ledger.ids([one.before for one in changed])
        names = (*QUANTITIES, "extra")
        ledger.edit_each(
            {id: {name: getattr(one.after, name) for name in names} for id, one in zip(ids, changed, strict=True)},
            "weather",
            f"from {', '.join(one.file for one in sources)}",
        )
    return found
